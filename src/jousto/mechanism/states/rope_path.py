"""Parts of a rope between the sheaves on its path."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.base.fields import Field
from jousto.base.rotations import turn_onto
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.joints.base import aligned
from jousto.mechanism.joints.coordinate import Coordinate, check_coordinate
from jousto.mechanism.joints.rope_span import RopeSpan, misfit, rope_direction, wrap_angle
from jousto.mechanism.states import expression as e

PARALLEL = 0.999
"""Smallest cosine between the axle of a sheave and the axis of its turn."""
AWAY = 1e-9
"""Distance of a hinge from its sheave that counts as rounding, relative to 1 m or the position."""
MOST_WRAP = np.radians(270.0)
"""Angle on a sheave, rad, above which the rope is taken not to touch it, or on its other side."""


class OptionalCoordinate(Field[Coordinate | None, Coordinate | None]):
    """Field of a coordinate, or None."""

    form = "coordinate"
    noun = "Coordinate"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the coordinate or None, or report a value of another type."""
        return None if value is None else check_coordinate(problems, where, self.name, value)


@dataclass(frozen=True, eq=False)
class RopePart:
    """Rope between two sheaves: its span, None if its length is constant, and further length.

    Parameters
    ----------
    span : RopeSpan or None
        Coordinate of its length.
    constant : float
        Length beside the value of the coordinate, m: half the arcs at both ends.
    """

    span: RopeSpan | None
    constant: Any

    @property
    def length(self) -> Any:
        """Length as an expression, m."""
        fixed = e.expression(self.constant)
        return fixed if self.span is None else e.value(self.span) + fixed

    @cached_property
    def initial(self) -> Any:
        """Length at the initial pose, m."""
        return self.constant + (0.0 if self.span is None else self.span.initial)

    @property
    def rate(self) -> Any:
        """Rate of the length as an expression, m/s."""
        return e.expression(0.0) if self.span is None else e.rate(self.span)


class RopePath(NamedTuple):
    """A rope along its sheaves at the initial pose.

    Parameters
    ----------
    path : tuple of Marker
        Markers of the ends and sheaves, with their axles along z.
    parts : tuple of RopePart
        Parts between the markers of the path.
    ways : tuple of array
        Unit vectors (3,) along them, world frame.
    axles : tuple of array
        Unit vectors (3,) along the axles of all sheaves, world frame.
    wraps, arcs : tuple of float
        Angles, rad, and lengths, m, of the rope on all sheaves, 0 at the ends.
    """

    path: tuple[Marker, ...]
    parts: tuple[RopePart, ...]
    ways: tuple[Array, ...]
    axles: tuple[Array, ...]
    wraps: tuple[Any, ...]
    arcs: tuple[Any, ...]


def rope_path(problems: Problems, where: str, rope: Any, path: Sequence[Marker]) -> RopePath | None:
    """Return the parts of a rope with `radii` and `axis` along a path; None if none fits."""
    markers = [
        marker if rope.axis is None else aligned(marker, turn_onto(marker.A, rope.axis))
        for marker in path
    ]
    radii: list[Any] = list(rope.radii)
    spans: list[RopeSpan | None] = []
    directions = []
    for k, (a, b) in enumerate(itertools.pairwise(markers)):
        way = rope_direction(a, b, radii[k], radii[k + 1])
        problem = misfit(a, b, radii[k], radii[k + 1], way)
        if problem:
            problems.add(where, problem, "path")
            return None
        rigid = a.body is b.body and (a.site is None or a.site == b.site)
        name = f"{rope.name}.part{k + 1}"
        spans.append(None if rigid else RopeSpan(a, b, radii[k], radii[k + 1], name=name))
        directions.append(way)

    arcs: list[Any] = [0.0]
    wraps: list[Any] = [0.0]
    for k in range(1, len(spans)):
        marker = markers[k]
        turn = wrap_angle(marker.A[:, 2], directions[k - 1], directions[k], radii[k])
        if np.real(turn) > MOST_WRAP:
            problems.add(
                where,
                f"the rope would wrap {np.degrees(float(np.real(turn))):.0f} degrees around "
                f"{marker.label}, it does not touch this sheave or runs in the other sense: "
                f"change the sign of radii[{k}], or leave the sheave out",
                "radii",
            )
            return None
        wraps.append(turn)
        arcs.append((radii[k] if np.real(radii[k]) > 0 else -radii[k]) * turn)
    arcs.append(0.0)
    made = []
    for k, (span, way) in enumerate(zip(spans, directions, strict=True)):
        constant = 0.5 * (arcs[k] + arcs[k + 1])
        if span is None:
            constant = constant + way @ (markers[k + 1].r - markers[k].r)
        made.append(RopePart(span, constant))
    if all(part.span is None for part in made):
        problems.add(where, "nothing on its path can move", "path")
    axles = tuple(marker.A[:, 2] for marker in markers)
    return RopePath(
        tuple(markers), tuple(made), tuple(directions), axles, (*wraps, 0.0), tuple(arcs)
    )


def bearing(
    problems: Problems, where: str, name: str, turn: Coordinate, sheave: Marker
) -> tuple[Marker, Any]:
    """Return the frame of a sheave that does not turn with it, and 1 or -1.

    The frame is at the other side of its hinge. The number is 1 if a turn of the sheave about its
    axle is positive along the coordinate. Report a coordinate that is not the turn of this sheave.
    """
    n = np.real(sheave.A[:, 2])
    if turn.unit != "rad":
        problems.add(where, f"{name} is in {turn.unit}, must be the angle of a hinge", name)
        return sheave, 1.0
    if sheave.body is turn.b.body:
        sense, held = 1.0, turn.a
    elif sheave.body is turn.a.body:
        sense, held = -1.0, turn.b
    else:
        text = f"{name} does not turn {sheave.label}; give the angle of its hinge"
        problems.add(where, text, name)
        return sheave, 1.0
    cosine = float(np.real(turn.a.A[:, 2]) @ n)
    if abs(cosine) < PARALLEL:
        text = f"{name} turns about another axis than the axle of {sheave.label}; give axis"
        problems.add(where, text, name)
    away = float(np.linalg.norm(np.real(held.r - sheave.r)))
    if away > AWAY * max(1.0, float(np.linalg.norm(np.real(sheave.r)))):
        text = f"{name}: the hinge is {away:g} m from {sheave.label}; put both at the centre"
        problems.add(where, text, name)
    return aligned(held, sheave.A), sense * float(np.sign(cosine))
