"""Closures: joints and couplings outside the tree, as constraint rows between its frames."""

from __future__ import annotations

from dataclasses import dataclass

from jousto.robots.description import Frame

Place = tuple[int, Frame]
"""Index of a body, -1 for the ground, and a frame on it."""


@dataclass(frozen=True, eq=False)
class Measured:
    """Scalar coordinate between two frames, or a coordinate of the tree.

    Parameters
    ----------
    name : str
        Name of the coordinate.
    kind : {"angle", "along", "distance"}
        Kind, as of `Coordinate`.
    column : int
        Index of the axis of frame a for a displacement.
    a, b : Place or None
        The frames; None for a coordinate of the tree.
    """

    name: str
    kind: str
    column: int = 2
    a: Place | None = None
    b: Place | None = None


@dataclass(frozen=True, eq=False)
class Sum:
    """Constraint row ``sum factor s = offset`` of coordinates s."""

    terms: tuple[Measured, ...]
    factors: tuple[float, ...]
    offset: float


@dataclass(frozen=True, eq=False)
class Closure:
    """Joint or coupling outside the tree, with its constraint rows between frames a and b."""

    name: str
    a: Place | None = None
    b: Place | None = None
    coincident: bool = False
    perpendicular: tuple[tuple[int, int], ...] = ()
    lines: tuple[Sum, ...] = ()


@dataclass(frozen=True, eq=False)
class Bound:
    """Limits of a coordinate outside the tree."""

    of: Measured
    lower: float
    upper: float
