"""Declarations of the laws of the engine: units and effects; the formulas are in C."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

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
        Its name in the header of the engine, ``jousto.h``, blanks for underscores.
    units : mapping of str to Unit
        Numbers that a running program may change, by their names in the header.
    notes : mapping of str to str
        What descriptions add to them.
    constants : tuple of str
        Its other numbers, which stay.
    states : mapping of str to Unit
        Names of its first-order states.
    grows, signs : tuple of str
        States that are never negative, and those that are -1, 0 or 1.
    reference, signal : Unit
        Units of the functions of time that it follows, and that act in it.
    between : bool
        Whether it acts on two bodies, equal and opposite, by how they stand and move: it may be
        stiff, so that steps must see it.
    fast : mapping of str to tuple of str
        What messages about its speed call it, and the numbers of which one is not zero then, or
        the functions (``spring``, ``damper``) of which one is there; none for always.
    yields : bool
        Whether its force depends on the motion before: its states change at the ends of steps.
    side_by_side : bool
        Whether machines with it may step together; the file of its formula is compiled for
        vectors (``CMakeLists.txt``).
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
        """Add the law to the declared laws, and return it."""
        LAWS[self.name] = self
        return self

    def with_numbers(self, numbers: Any) -> EngineLaw:
        """Return the law for given numbers (their names), on which the units may depend."""
        return self


def law_of(name: str) -> EngineLaw:
    """Return the declared law of a name."""
    return LAWS.get(name) or EngineLaw(name)


def unit_along(unit: Unit, angular: bool) -> str:
    """Return a unit for an angular coordinate, or for a length."""
    if isinstance(unit, Along):
        return unit.angle if angular else unit.length
    return str(unit)
