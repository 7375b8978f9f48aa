"""Declarations of the laws of the engine: units and effects; the formulas are in C."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from jousto.base.declare import kinds
from jousto.base.object_repr import described
from jousto.mechanism.joints.coordinate import Along

Unit: TypeAlias = str | Along | tuple[str, ...]
"""SI unit of a number; of one that depends on whether its coordinate is a length or an angle; of
the numbers on the diagonal of a matrix."""

NEVER = 1e300
"""A number as large as this stands for none, such as a limit that no coordinate reaches."""

LAWS: dict[str, EngineLaw] = {}
"""The laws by their names."""


@described
@dataclass(frozen=True, eq=False)
class EngineLaw:
    """Law of the engine: units of its numbers, and its effects on a motion.

    A law without a declaration counts as a load; its numbers are constants of an exported program,
    and machines that contain it do not run in vector lanes.

    Parameters
    ----------
    name : str
        Name of the law in the header of the engine, ``jousto.h``, with blanks instead of
        underscores.
    units : mapping of str to Unit
        Units of the numbers that a running program may change, by their names in the header.
    notes : mapping of str to str
        Notes on these numbers for descriptions.
    constants : tuple of str
        Names of the other numbers, which are constant.
    states : mapping of str to Unit
        Units of the first-order states by name.
    grows, signs : tuple of str
        States that are never negative, and those that are -1, 0 or 1.
    reference, signal : Unit
        Units of the reference signal that the law follows, and of the signal that acts in it.
    between : bool
        Whether equal and opposite forces act on two bodies and depend on their relative motion.
        Such a law may be stiff, so that the choice of the step considers it.
    fast : mapping of str to tuple of str
        Names of the law in messages about fast motions. A name applies if one of the listed numbers
        is nonzero or one of the listed functions (``spring``, ``damper``) exists; with an empty
        list it always applies.
    yields : bool
        Whether the force depends on the previous motion, so that its states change at the ends of
        steps.
    side_by_side : bool
        Whether machines with the law may be integrated side by side in vector lanes; the file with
        its formula is then compiled for vectors (``CMakeLists.txt``).
    """

    name: str
    units: Mapping[str, Unit] = field(default_factory=dict)
    notes: Mapping[str, str] = field(default_factory=dict)
    constants: tuple[str, ...] = ()
    states: Mapping[str, Unit] = field(default_factory=dict)
    grows: tuple[str, ...] = ()
    signs: tuple[str, ...] = ()
    reference: Unit = "1"
    signal: Unit = "1"
    between: bool = False
    fast: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    yields: bool = False
    side_by_side: bool = False

    def _facts(self) -> str:
        return ", ".join((*self.units, *self.states))

    def declared(self) -> EngineLaw:
        """Register the law among the declared laws, and return it."""
        LAWS[self.name] = self
        return self

    def with_numbers(self, numbers: Any) -> EngineLaw:
        """Return the law for the numbers with these names, on which the units may depend."""
        return self


def law_of(name: str) -> EngineLaw:
    """Return the declared law with a name; one without a declaration has no units and effects.

    A model that comes from another process may have forces whose modules are not loaded here.
    """
    if name not in LAWS:
        kinds("forces", "jousto.mechanism.forces")
    return LAWS.get(name) or EngineLaw(name)


def unit_along(unit: Unit, angular: bool) -> str:
    """Return the unit for an angular coordinate, or the one for a length."""
    if isinstance(unit, Along):
        return unit.angle if angular else unit.length
    return str(unit)
