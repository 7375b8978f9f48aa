"""Track that bends: a smooth curve through markers, such as nodes of a beam."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property
from math import acos, sin
from typing import Any, ClassVar

import numpy as np

from jousto.base.arrays import Array
from jousto.base.complexstep import floats
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.fields import field
from jousto.base.rotations import Direction
from jousto.mechanism.beams.body import BeamBody
from jousto.mechanism.beams.discretisation import BeamNode
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.bodies.marker import Marker, MarkerField, MarkersField
from jousto.mechanism.forces.base import ForceElement, Packed
from jousto.mechanism.forces.moving import nodes_on

SAME = 1e-9
"""Distance of two markers relative to the length of the track at which they are one place."""
STEEP = 0.1
"""Sine of the angle between track and top below which the track has no top."""


@dataclass(frozen=True, eq=False)
class TrackPiece:
    """Part of a track from one marker to the next.

    Parameters
    ----------
    ends : tuple of two Marker
        Its ends, often nodes of one body.
    length : float
        Length of an arc through both ends with these tangents, m.
    tangents, tops : (2, 3) array
        Unit tangent and direction of the top in the frames of both ends.
    """

    ends: tuple[Marker, Marker]
    length: float
    tangents: Array
    tops: Array


def nodes_along(body: FlexibleBody | BeamBody, start: str, end: str) -> tuple[Marker, ...]:
    """Return the markers of all nodes of a beam from one to another one, for a `TrackContact`.

    Parameters
    ----------
    body : FlexibleBody or BeamBody
        The beam.
    start, end : str
        Names of two nodes.

    Raises
    ------
    InputError
        If the body has no such nodes, or they are the same.
    """
    if not isinstance(body, FlexibleBody | BeamBody):
        raise InputError(
            Problem("nodes_along", f"body is {body!r:.60}, must be a FlexibleBody or BeamBody")
        )
    if start == end:
        raise InputError(Problem("nodes_along", f"start and end are {start!r}, must be two nodes"))
    if isinstance(body, BeamBody):
        a, b = body[start].body, body[end].body
        assert isinstance(a, BeamNode) and isinstance(b, BeamNode)
        way = range(a.place, b.place + 1) if b.place > a.place else range(a.place, b.place - 1, -1)
        return tuple(body.node(i) for i in way)
    return tuple(_between(body[start], body[end]))


def _between(a: Marker, b: Marker) -> list[Marker]:
    """Return the markers of all nodes of a flexible body on the line from a to b, with both."""
    body: Any = a.body
    corners = np.array([a.position_local, b.position_local])
    inner = [k for k in nodes_on(body, corners) if k not in (a.node, b.node)]
    return [a, *(node_marker(body, k) for k in inner), b]


def node_marker(body: Any, node: int) -> Marker:
    """Return the marker at a node of a flexible body."""
    position = np.asarray(body.reduced.nodes)[node]
    return Marker(body, f"node{node + 1}", position, node, np.eye(3))


class OnTrack(ForceElement):
    """Base of forces between a track and a marker on it."""

    together: ClassVar[tuple[str, ...]] = ("track", "b")
    track: MarkersField = field("Markers along the track, in order, on any bodies")
    b: MarkerField = field("Marker on the track: the centre of a wheel, the point that slides")
    up: Direction = field(
        "Direction of the top of the track in the world frame at the initial pose, across the "
        "track; None for z",
        default=None,
        kw_only=True,
    )

    def __repr__(self) -> str:
        return f"<{self.tag} {self.name!r}: {len(self.track)} markers, {self.b.label}>"

    def consistent(self, problems: Problems, where: str) -> None:
        """Report short tracks, the marker's own body as its track, and unknown tangents."""
        if len(self.track) < 2:
            problems.add(where, f"track has {len(self.track)} markers; give two or more", "track")
            return
        for a, b in itertools.pairwise(self.track):
            one, other = a.body, b.body
            if (
                isinstance(one, BeamNode)
                and isinstance(other, BeamNode)
                and one.beam == other.beam
                and abs(one.place - other.place) > 1
            ):
                problems.add(
                    where,
                    f"between {a.label} and {b.label} are {abs(one.place - other.place) - 1} nodes "
                    "of the beam; name every node, or use nodes_along(beam, start, end)",
                    "track",
                )
                return
        for marker in self._markers:
            if marker.body is self.b.body:
                problems.add(where, f"the track and b are both on {marker.label!r}", "b")
                return
            if isinstance(marker.body, FlexibleBody):
                if marker.node is None:
                    problems.add(where, f"{marker.label} is not a node", "track")
                    return
                if marker.body.reduced.rotation(marker.node) is None:
                    problems.add(
                        where,
                        f"body {marker.body.name!r} has no rotations at its nodes, so that the "
                        "track between them is unknown; use a part made of beams",
                        "track",
                    )
                    return
        if not self.pieces:
            problems.add(where, "all markers of the track are at one place", "track")
            return
        for piece in self.pieces:
            for t, top in zip(piece.tangents, piece.tops, strict=True):
                if float(np.linalg.norm(np.cross(t, top))) < STEEP * float(np.linalg.norm(top)):
                    problems.add(
                        where,
                        f"the track is along the direction of its top at {piece.ends[0].label}; "
                        "give up=, a direction across it",
                        "up",
                    )
                    return

    @cached_property
    def _markers(self) -> tuple[Marker, ...]:
        """Markers of the track with all nodes of flexible bodies between them."""
        found: list[Marker] = [self.track[0]]
        for a, b in itertools.pairwise(self.track):
            same = a.body is b.body and isinstance(a.body, FlexibleBody)
            inner = _between(a, b)[1:] if same and None not in (a.node, b.node) else [b]
            found += inner
        return tuple(found)

    @cached_property
    def pieces(self) -> tuple[TrackPiece, ...]:
        """Pieces between markers at different places."""
        markers = self._markers
        r = np.array([floats(marker.r) for marker in markers])
        steps = np.linalg.norm(np.diff(r, axis=0), axis=1)
        apart = steps > SAME * steps.sum()
        # places without those that two bodies share, and the place of each marker
        place = np.concatenate([[0], np.cumsum(apart)])
        points = r[np.concatenate([[True], apart])]
        if len(points) < 2:
            return ()
        tangent = _tangents(points)
        up = np.array([0.0, 0.0, 1.0]) if self.up is None else np.array(floats(self.up))
        made = []
        for i in np.flatnonzero(apart):
            ends = (markers[i], markers[i + 1])
            frames = [floats(marker.A) for marker in ends]
            t = tangent[place[[i, i + 1]]]
            bend = acos(min(1.0, max(-1.0, float(t[0] @ t[1]))))
            length = float(steps[i]) * (1.0 if bend < 1e-6 else 0.5 * bend / sin(0.5 * bend))
            local = [
                np.array([A.T @ x for A, x in zip(frames, v, strict=True)]) for v in (t, (up, up))
            ]
            made.append(TrackPiece(ends, length, *local))
        return tuple(made)

    @property
    def turning(self) -> tuple[tuple[str, Marker], ...]:
        """Markers whose orientation matters."""
        return (("b", self.b), *(("track", marker) for marker in self._markers))

    @property
    def symbol(self) -> str:
        """Symbol of a path."""
        return "moving-load"

    @property
    def drawn_at(self) -> tuple[Marker, ...]:
        """The track."""
        return self._markers

    def _rows(self, builder: Any) -> Packed:
        """Return the pieces as rows of the engine."""
        wheel = builder.markers[builder.marker(self.b, True)].body
        rows, places, coupled = [], [], []
        for piece in self.pieces:
            ends = [builder.marker(marker, True) for marker in piece.ends]
            places += ends
            coupled.append({wheel, *(builder.markers[k].body for k in ends)} - {-1})
            rows.append([*ends, piece.length, *piece.tangents.ravel(), *piece.tops.ravel()])
        return Packed(
            np.array(rows),
            touches=tuple(places),
            coupled=tuple(tuple(sorted(some)) for some in coupled),
        )


def _tangents(points: Array) -> Array:
    """Return unit tangents (k, 3) of a smooth curve through points: those of arcs."""
    chord = np.diff(points, axis=0)
    chord /= np.linalg.norm(chord, axis=1)[:, None]
    middle = chord[:-1] + chord[1:]
    middle /= np.linalg.norm(middle, axis=1)[:, None]
    if not len(middle):
        return np.concatenate([chord, chord])
    first = 2.0 * (chord[0] @ middle[0]) * chord[0] - middle[0]
    last = 2.0 * (chord[-1] @ middle[-1]) * chord[-1] - middle[-1]
    return np.concatenate([[first], middle, [last]])
