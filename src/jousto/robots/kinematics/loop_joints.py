"""Closures: joints that a tree leaves out, as rows between frames of its bodies."""

from __future__ import annotations

from dataclasses import dataclass

from jousto.robots.description import Frame

Place = tuple[int, Frame]
"""Number of a body, -1 for the ground, and a frame on it."""


@dataclass(frozen=True, eq=False)
class Measured:
    """A scalar function of two frames, or a coordinate of the tree if there are none.

    Parameters
    ----------
    name : str
        Its name.
    kind : {"angle", "along", "distance"}
        As of `Coordinate`.
    column : int
        Axis of frame a that a displacement is along.
    a, b : Place or None
        The frames.
    """

    name: str
    kind: str
    column: int = 2
    a: Place | None = None
    b: Place | None = None


@dataclass(frozen=True, eq=False)
class Sum:
    """A row ``sum factor s = offset``."""

    terms: tuple[Measured, ...]
    factors: tuple[float, ...]
    offset: float


@dataclass(frozen=True, eq=False)
class Closure:
    """A joint or coupling that is no joint of the tree: its rows between the frames a and b."""

    name: str
    a: Place | None = None
    b: Place | None = None
    coincident: bool = False
    perpendicular: tuple[tuple[int, int], ...] = ()
    lines: tuple[Sum, ...] = ()


@dataclass(frozen=True, eq=False)
class Bound:
    """Limits of a coordinate that is none of the tree."""

    of: Measured
    lower: float
    upper: float
