"""Which modes describe the elastic motion: the options of `reduce`."""

from __future__ import annotations

import operator
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.errors import Problems
from jousto.reduction.modes.residuals import read_residuals


@explained
@dataclass(frozen=True, repr=False)
class CraigBampton:
    """Fixed-interface modes plus constraint modes of the interface nodes.

    ``T = [E 0; Phi_C Phi_N]`` (Rantalainen 2007, eqs. 3.24-3.31), then orthonormalised and freed
    of the rigid-body modes (eqs. 3.32-3.36). One interface node of six degrees of freedom adds
    six constraint modes; the six rigid-body modes are taken away, so that
    ``n = modes + 6 * len(interfaces) - 6``. Of these, motions that move no mass
    stand at 10,000 times the lowest frequency, as the static shapes that they are.

    Residual vectors ``(K_II^-1 - Phi_N W^-2 Phi_N^T) f`` add what the fixed-interface modes leave
    out of a static response: one more mode for each load or stress component.

    Parameters
    ----------
    interfaces : tuple of str
        Where joints and forces act: interfaces of the part, or node sets, of which every node is
        an interface node then. All interfaces of the part if none is named.
    modes : int, optional
        Number of fixed-interface modes, the lowest are taken; 0 is static condensation.
    frequency_limit : float, optional
        Highest fixed-interface frequency kept, Hz. With `modes` as well, both limits hold.
    residuals : sequence of (ndof,) or (ndof, m) arrays and str
        Nodal load patterns in the part's degrees of freedom, any unit: the static response to them
        is exact. Names of stress sites: their static stress is exact under all loads.
    inertia_relief : bool
        Whether the response to the six rigid accelerations is added too: weight and slow
        acceleration then act on the part as on its mesh.

    Raises
    ------
    InputError
        Neither limit given, or a limit or residual that cannot be used.

    Examples
    --------
    >>> CraigBampton(interfaces=("start",), modes=4)
    CraigBampton(interfaces=('start',), modes=4, frequency_limit=None)
    """

    interfaces: tuple[str, ...] = ()
    modes: int | None = None
    frequency_limit: float | None = None
    residuals: tuple[Any, ...] = ()
    inertia_relief: bool = False

    def __post_init__(self) -> None:
        problems = Problems()
        names = _names("CraigBampton", self.interfaces, problems)
        _check_limits("CraigBampton", self.modes, self.frequency_limit, problems)
        residuals = read_residuals("CraigBampton", self.residuals, problems)
        problems.raise_if_any()
        object.__setattr__(self, "interfaces", names)
        object.__setattr__(self, "residuals", residuals)

    def __repr__(self) -> str:
        more = f", residuals={self.residuals}" if self.residuals else ""
        more += ", inertia_relief=True" if self.inertia_relief else ""
        return (
            f"CraigBampton(interfaces={self.interfaces}, modes={self.modes}, "
            f"frequency_limit={self.frequency_limit}{more})"
        )


@explained
@dataclass(frozen=True, repr=False)
class FreeFree:
    """Free-free elastic modes of the whole part: no interface, mean-axis frame.

    Good for a part that nothing holds; near a joint they converge slower than `CraigBampton`,
    unless attachment modes are added: what the modes leave out of the response to unit forces and
    moments on the interfaces of the accelerated part (MacNeal 1971, Rubin 1975).

    Parameters
    ----------
    modes : int, optional
        Number of elastic modes, the lowest are taken. The rigid-body modes do not count.
    frequency_limit : float, optional
        Highest frequency kept, Hz. With `modes` as well, both limits hold.
    interfaces : tuple of str
        Interfaces or node sets that get attachment modes.
    residuals : sequence of (ndof,) or (ndof, m) arrays and str
        Load patterns and stress sites as in `CraigBampton`.

    Raises
    ------
    InputError
        Neither limit given, or a limit or residual that cannot be used.

    Examples
    --------
    >>> FreeFree(frequency_limit=500.0)
    FreeFree(modes=None, frequency_limit=500.0)
    """

    modes: int | None = None
    frequency_limit: float | None = None
    interfaces: tuple[str, ...] = ()
    residuals: tuple[Any, ...] = ()

    def __post_init__(self) -> None:
        problems = Problems()
        names = _names("FreeFree", self.interfaces, problems)
        _check_limits("FreeFree", self.modes, self.frequency_limit, problems)
        residuals = read_residuals("FreeFree", self.residuals, problems)
        if self.modes == 0 and not residuals and not names:
            problems.add("FreeFree", "modes is 0, must be at least 1")
        problems.raise_if_any()
        object.__setattr__(self, "interfaces", names)
        object.__setattr__(self, "residuals", residuals)

    def __repr__(self) -> str:
        more = f", interfaces={self.interfaces}" if self.interfaces else ""
        more += f", residuals={self.residuals}" if self.residuals else ""
        return f"FreeFree(modes={self.modes}, frequency_limit={self.frequency_limit}{more})"


Method = CraigBampton | FreeFree


def _names(where: str, given: Any, problems: Problems) -> tuple[str, ...]:
    names = (given,) if isinstance(given, str) else tuple(given)
    for name in names:
        if not isinstance(name, str):
            problems.add(where, f"interface {name!r} is not the name of an interface or node set")
        elif names.count(name) > 1:
            problems.add(where, f"interface '{name}' is named more than once")
            break
    return names


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
