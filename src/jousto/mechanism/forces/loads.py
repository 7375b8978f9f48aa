"""Gravity, point forces and torques."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from numpy.typing import ArrayLike

from jousto.base.described import described
from jousto.base.errors import InputError, Problems
from jousto.base.names import check_name
from jousto.base.numbers import set_fields
from jousto.base.rotations import Array
from jousto.mechanism.bodies.marker import Marker, as_marker
from jousto.mechanism.signals.base import Signal, check_signal


@described
@dataclass(frozen=True, eq=False, init=False)
class Gravity:
    """The acceleration of free fall, the same for all bodies.

    Parameters
    ----------
    acceleration : (3,) array_like
        World frame, m/s2, for example ``(0, -9.81, 0)``.
    """

    acceleration: Array

    def __init__(self, acceleration: ArrayLike) -> None:
        problems = Problems()
        g = problems.array("gravity", "acceleration", acceleration, (3,))
        problems.raise_if_any()
        set_fields(self, acceleration=g)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Force:
    """A force at a marker: ``Q_R = F``, ``Q_w = u~ A^T F``, ``Q_p = Phi^T A^T F``.

    Parameters
    ----------
    name : str
        Name, unique among forces and torques.
    marker : Marker
        Where it acts.
    vector : (3,) array_like
        Force F, N: in the world frame, or in the marker's axes if `follow`.
    follow : bool
        Whether the force turns with the marker.
    signal : Signal or float, optional
        Factor on the force as a function of time, or a constant one; None for 1.
    """

    name: str
    marker: Marker
    vector: Array
    follow: bool
    signal: Signal | None

    def __init__(
        self,
        name: str,
        marker: Marker,
        vector: ArrayLike,
        *,
        follow: bool = False,
        signal: Signal | float | None = None,
    ) -> None:
        init_force(self, "force", name, marker, vector, follow, signal)

    def __repr__(self) -> str:
        return f"<Force {self.name!r}: at {self.marker.label}>"


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Torque:
    """A torque at a marker: ``Q_w = A^T T``, ``Q_p = (T(theta) Psi)^T A^T T``.

    T(theta) is the tangent operator of the marker's elastic rotation theta = Psi p.

    Parameters
    ----------
    name : str
        Name, unique among forces and torques.
    marker : Marker
        Where it acts.
    vector : (3,) array_like
        Torque T, N m: in the world frame, or in the marker's axes if `follow`.
    follow : bool
        Whether the torque turns with the marker.
    signal : Signal or float, optional
        Factor on the torque as a function of time, or a constant one; None for 1.
    """

    name: str
    marker: Marker
    vector: Array
    follow: bool
    signal: Signal | None

    def __init__(
        self,
        name: str,
        marker: Marker,
        vector: ArrayLike,
        *,
        follow: bool = False,
        signal: Signal | float | None = None,
    ) -> None:
        init_force(self, "torque", name, marker, vector, follow, signal)

    def __repr__(self) -> str:
        return f"<Torque {self.name!r}: at {self.marker.label}>"


Load: TypeAlias = Force | Torque
LOADS: tuple[type[Load], ...] = (Force, Torque)


def init_force(
    load: Load,
    kind: str,
    name: str,
    marker: Marker,
    vector: ArrayLike,
    follow: bool,
    signal: Signal | float | None,
) -> None:
    """Check what forces and torques have in common and set the fields."""
    problems = Problems()
    where = check_name(problems, kind, name)
    try:
        as_marker(where, "marker", marker)
    except InputError as error:
        problems.found.extend(error.problems)
    F = problems.array(where, "vector", vector, (3,))
    factor = None if signal is None else check_signal(problems, where, "signal", signal)
    problems.raise_if_any()
    set_fields(load, name=name, marker=marker, vector=F, follow=bool(follow), signal=factor)
