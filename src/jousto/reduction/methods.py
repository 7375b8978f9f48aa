"""Which modes describe the elastic motion: the options of `reduce`."""

from __future__ import annotations

import operator
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.errors import Problems


@dataclass(frozen=True)
class CraigBampton:
    """Fixed-interface modes plus constraint modes of the interface nodes.

    ``T = [E 0; Phi_C Phi_N]`` (Rantalainen 2007, eqs. 3.24-3.31), then orthonormalised and freed
    of the rigid-body modes (eqs. 3.32-3.36). One interface node of six degrees of freedom adds
    six constraint modes; the six rigid-body modes are taken away, so that
    ``n = modes + 6 * len(interfaces) - 6``, less the modes that move no mass.

    Parameters
    ----------
    interfaces : tuple of str
        Node sets of the part where joints and forces act. Every node of a set is an interface
        node.
    modes : int, optional
        Number of fixed-interface modes, the lowest are taken; 0 is static condensation.
    frequency_limit : float, optional
        Highest fixed-interface frequency kept, Hz. With `modes` as well, both limits hold.

    Raises
    ------
    InputError
        No interface, neither limit given, or a limit that is not a usable number.

    Examples
    --------
    >>> CraigBampton(interfaces=("start",), modes=4)
    CraigBampton(interfaces=('start',), modes=4, frequency_limit=None)
    """

    interfaces: tuple[str, ...]
    modes: int | None = None
    frequency_limit: float | None = None

    def __post_init__(self) -> None:
        problems = Problems()
        given: Any = self.interfaces
        names = (given,) if isinstance(given, str) else tuple(given)
        if not names:
            problems.add(
                "CraigBampton", "interfaces is empty; name node sets of the part or use FreeFree()"
            )
        for name in names:
            if not isinstance(name, str):
                problems.add("CraigBampton", f"interface {name!r} is not the name of a node set")
            elif names.count(name) > 1:
                problems.add("CraigBampton", f"interface '{name}' is named more than once")
                break
        _check_limits("CraigBampton", self.modes, self.frequency_limit, problems)
        problems.raise_if_any()
        object.__setattr__(self, "interfaces", names)


@dataclass(frozen=True)
class FreeFree:
    """Free-free elastic modes of the whole part: no interface, mean-axis frame.

    Good for a part that nothing holds; near a joint they converge slower than `CraigBampton`.

    Parameters
    ----------
    modes : int, optional
        Number of elastic modes, the lowest are taken. The rigid-body modes do not count.
    frequency_limit : float, optional
        Highest frequency kept, Hz. With `modes` as well, both limits hold.

    Raises
    ------
    InputError
        Neither limit given, or a limit that is not a usable number.

    Examples
    --------
    >>> FreeFree(frequency_limit=500.0)
    FreeFree(modes=None, frequency_limit=500.0)
    """

    modes: int | None = None
    frequency_limit: float | None = None

    def __post_init__(self) -> None:
        problems = Problems()
        _check_limits("FreeFree", self.modes, self.frequency_limit, problems)
        if self.modes == 0:
            problems.add("FreeFree", "modes is 0, must be at least 1")
        problems.raise_if_any()


Method = CraigBampton | FreeFree


def _check_limits(
    where: str, modes: int | None, frequency_limit: float | None, problems: Problems
) -> None:
    if modes is None and frequency_limit is None:
        problems.add(where, "give modes=number or frequency_limit=Hz (or both)")
    if modes is not None:
        try:
            number = operator.index(modes)
        except TypeError:
            number = -1
        if number < 0 or isinstance(modes, bool):
            problems.add(where, f"modes is {modes!r}, must be a whole number, 0 or more")
    if frequency_limit is not None:
        try:
            limit = float(frequency_limit)
        except (TypeError, ValueError):
            limit = np.nan
        if not limit > 0.0:
            problems.add(where, f"frequency_limit is {frequency_limit!r}, must be positive, in Hz")
