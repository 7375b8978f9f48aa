"""Ropes whose tension differs by inertia: with mass, or over sheaves that turn with them.

A section is the rope between two neighbouring stations. A station is a sheave that turns with the
rope, or the middle of a part of a rope with mass. There is one tension on a section without
losses, and the rope that passes a station leaves one section for the next one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from jousto.base.arrays import Array
from jousto.mechanism.bodies.body import RigidBody, ground
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.joints.coordinate import AXES, Displacement
from jousto.mechanism.states import expression as e
from jousto.mechanism.states.block import Equations


class Reeved(Protocol):
    """What the sections of a rope need of it; see `Reeving`."""

    radii: Any
    stiffness: Any
    damping: Any
    length: Any
    efficiencies: Any
    winch: Any
    drum: Any
    drum_radius: Any
    mass_per_length: Any
    turning: Any
    rims: Any
    route: Any

    @property
    def parts(self) -> tuple[Any, ...]:
        """Parts of the rope between the markers of its path."""

    @property
    def initial_length(self) -> float:
        """Length of the path at the initial pose, m."""

    def loss(self, eta: Any, speed: Any) -> Any:
        """Return the tension behind a sheave over that before it at a speed of the rope, m/s."""


class Middle(NamedTuple):
    """Middle of a part of a rope with mass, which carries the mass of the part.

    Parameters
    ----------
    part : int
        Number of the part.
    shift, speed : Expression
        Unstretched rope that has passed the middle, m, and the speed of the rope along the part in
        the world, m/s.
    way : tuple of Expression
        Direction of the part, world frame.
    ends : tuple of tuple of Expression
        Velocities of the rims at both ends of the part, world frame, m/s.
    """

    part: int
    shift: Any
    speed: Any
    way: tuple[Any, ...]
    ends: tuple[tuple[Any, ...], tuple[Any, ...]]

    def past(self, end: int) -> Any:
        """Return the speed of the rope past the rim at an end, 0 or 1, m/s."""
        return self.speed - dot(self.way, self.ends[end])

    @property
    def flow(self) -> Any:
        """Speed of the rope past the middle of the part, m/s."""
        return 0.5 * (self.past(0) + self.past(1))


class Turning(NamedTuple):
    """Sheave that turns with the rope.

    Parameters
    ----------
    hinge : Coordinate
        Its angle.
    arm : float
        Rope that passes it over this angle, m/rad.
    """

    hinge: Any
    arm: Any

    @property
    def shift(self) -> Any:
        """Unstretched rope that has passed the sheave, m."""
        return self.arm * (e.value(self.hinge) - self.hinge.initial)

    @property
    def flow(self) -> Any:
        """Speed of its rim, m/s."""
        return self.arm * e.rate(self.hinge)


class Piece(NamedTuple):
    """Whole or half of a part of a rope.

    Parameters
    ----------
    part : int
        Number of the part.
    length, rate, initial : Any
        Length, m, its rate, m/s, and its value at the initial pose.
    """

    part: int
    length: Any
    rate: Any
    initial: Any


class Section(NamedTuple):
    """Rope between two stations, or a station and an end.

    Parameters
    ----------
    pieces : list of Piece
        Pieces of this section.
    losses : list of float
        Efficiencies of the sheaves between them.
    """

    pieces: list[Piece]
    losses: list[Any]

    @property
    def initial(self) -> Any:
        """Length at the initial pose, m."""
        return sum(piece.initial for piece in self.pieces)


class Pull(NamedTuple):
    """State of a section.

    Parameters
    ----------
    tension : Expression
        Tension at its first piece, N.
    free, strain : Expression
        Unstretched length, m, and strain, not below 0.
    shares : tuple of Expression
        Tension of each piece over that of the first.
    length : Expression
        Length, m.
    """

    tension: Any
    free: Any
    strain: Any
    shares: tuple[Any, ...]
    length: Any

    def carried(self, EA: Any) -> Any:
        """Force that does work on what passes out of the section unstretched, N.

        ``dE = T dl - (T + T^2 / (2 EA)) dl0`` for the elastic energy ``E = EA (l - l0)^2 / (2 l0)``
        """
        return self.tension + 0.5 * EA * self.strain * self.strain


def add_sections(made: Equations, rope: Reeved, x: Mapping[str, Any], paid: Any, rate: Any) -> None:
    """Add the equations of a rope whose tension differs along it.

    Parameters
    ----------
    made : Equations
        Equations of the rope.
    rope : Reeved
        The rope.
    x : mapping of str to Expression
        Its states.
    paid, rate : Expression
        Unstretched rope that has been paid out at the start, m, and its rate, m/s.
    """
    EA, mu = rope.stiffness, rope.mass_per_length
    middles = [_middle(rope, k, x) for k in range(len(rope.parts))] if mu else []
    sections, stations = _sections(rope, middles)
    shifts = [paid, *(one.shift for one in stations), e.expression(0.0)]

    # strain and tension of every section; what passes a station is stretched by the mean of both
    stretch = rope.length / sum(section.initial for section in sections)
    lengths = [_sum(piece.length for piece in section.pieces) for section in sections]
    frees = [
        section.initial * stretch + shifts[j] - shifts[j + 1] for j, section in enumerate(sections)
    ]
    strains = [e.maximum(l / l0 - 1.0, 0.0) for l, l0 in zip(lengths, frees, strict=True)]
    passed = []
    for j, station in enumerate(stations):
        mean = 1.0 + 0.5 * (strains[j] + strains[j + 1])
        passed.append(station.flow / mean if isinstance(station, Middle) else station.flow)
    flows = [rate, *passed, e.expression(0.0)]
    pulls = []
    for j, section in enumerate(sections):
        change = flows[j] - flows[j + 1]
        pulls.append(_pull(rope, section, lengths[j], frees[j], strains[j], change, flows[j]))

    # forces on sheaves that turn, and on the drum
    for j, station in enumerate(stations):
        if isinstance(station, Turning):
            work = pulls[j + 1].carried(EA) - pulls[j].carried(EA)
            made.forces.append((station.hinge, station.arm * work))
    if rope.drum is not None:
        made.forces.append((rope.drum, rope.drum_radius * pulls[0].carried(EA)))

    # tension at both ends of every part, and the share of each section in it
    ends: list[list[Any]] = [[] for _ in rope.parts]
    content: list[Any] = [e.expression(0.0) for _ in rope.parts]
    for section, pull in zip(sections, pulls, strict=True):
        for piece, share in zip(section.pieces, pull.shares, strict=True):
            ends[piece.part].append(pull.tension * share)
            content[piece.part] = content[piece.part] + pull.free * piece.length / pull.length
    kinetic: Any = e.expression(0.0)
    if mu:
        for j, station in enumerate(stations):
            if isinstance(station, Middle):
                k = station.part
                made.rates[f"shift{k + 1}"] = passed[j]
                kinetic = kinetic + _add_heavy_part(
                    made, rope, middles, k, ends[k], mu * content[k], rate
                )
    else:
        for part, tensions in zip(rope.parts, ends, strict=True):
            if part.span is not None:
                made.forces.append((part.span, -tensions[0]))

    free = _sum(frees)
    length = _sum(lengths)
    made.outputs = {
        "tension": ends[0][0],
        "tension_end": ends[-1][-1],
        "length": length,
        "unstretched": free,
        "strain": length / free - 1.0,
        "stored": _sum(0.5 * EA * pull.strain * pull.strain * pull.free for pull in pulls),
        "kinetic": kinetic,
    }


def _sections(rope: Reeved, middles: list[Middle]) -> tuple[list[Section], list[Any]]:
    """Return the sections of a rope, and the stations between them."""
    sections = [Section([], [])]
    stations: list[Any] = []
    arcs = rope.route.arcs
    last = len(rope.parts) - 1
    for k, part in enumerate(rope.parts):
        if middles:
            lean = 0.25 * (arcs[k] - arcs[k + 1])  # each half has its own arc
            for sign in (1.0, -1.0):
                half = 0.5 * part.initial + sign * lean
                piece = Piece(k, 0.5 * part.length + sign * lean, 0.5 * part.rate, half)
                if sign < 0.0:
                    sections.append(Section([], []))
                    stations.append(middles[k])
                sections[-1].pieces.append(piece)
        else:
            sections[-1].pieces.append(Piece(k, part.length, part.rate, part.initial))
        if k == last:
            break
        if k + 1 in rope.turning:
            sections.append(Section([], []))
            stations.append(Turning(*rope.turning[k + 1]))
        else:
            sections[-1].losses.append(rope.efficiencies[k + 1])
    return sections, stations


def _pull(
    rope: Reeved, section: Section, length: Any, free: Any, strain: Any, change: Any, flow: Any
) -> Pull:
    """Return the tension of a section whose unstretched length changes by `change`, m/s."""
    elastic = rope.stiffness * (length / free - 1.0)
    if rope.damping:
        stretching = _sum(piece.rate for piece in section.pieces) - change * length / free
        part = rope.initial_length / section.initial
        elastic = elastic + rope.damping * part * stretching
    shares = [e.expression(1.0)]
    for piece, eta in zip(section.pieces, section.losses, strict=False):
        flow = flow - piece.rate
        shares.append(shares[-1] if eta == 1.0 else shares[-1] * rope.loss(eta, flow))
    if any(eta != 1.0 for eta in section.losses):
        # the mean over the length has the stretch of the section
        parts = zip(shares, section.pieces, strict=True)
        elastic = elastic * length / _sum(share * piece.length for share, piece in parts)
    tension = e.maximum(elastic, 0.0)
    return Pull(tension, free, strain, tuple(shares), length)


def _add_heavy_part(
    made: Equations,
    rope: Reeved,
    middles: list[Middle],
    k: int,
    pulls: list[Any],
    m: Any,
    rate: Any,
) -> Any:
    """Add the motion of the mass m of a part along itself and its forces; return its energy, J.

    ``m u' = T_2 - T_1 + m g . e``. Both ends of the part receive half of its weight, of which what
    is along the part accelerates the rope instead. Rope of the speed v on a rim with the mass rho
    over its length presses on it with ``T - rho v^2``.
    """  # fmt: skip
    middle, e_k = middles[k], middles[k].way
    weight = m * dot(e_k, e.gravity)
    made.rates[f"speed{k + 1}"] = (pulls[1] - pulls[0] + weight) / m
    on_ends = []
    for end in (0, 1):
        speed = _over_rim(rope, middles, k + end, rate)
        on_ends.append(pulls[end] - rope.mass_per_length * speed * speed)
    span = rope.parts[k].span
    if span is not None:
        made.forces.append((span, -0.5 * (on_ends[0] + on_ends[1])))
    along = -0.5 * (on_ends[1] - on_ends[0] + weight)
    for rim in rope.rims[k]:
        for axis, coordinate in enumerate(rim.coordinates):
            push = along * e_k[axis] + 0.5 * m * e.gravity[axis]
            made.forces.append((coordinate, push))
    return 0.5 * m * middle.speed * middle.speed


def _over_rim(rope: Reeved, middles: list[Middle], i: int, rate: Any) -> Any:
    """Return the speed of the rope over the rim at the marker i of its path, m/s."""
    if i == 0:
        return rate
    if i == len(rope.parts):
        return e.expression(0.0)
    if i in rope.turning:
        return Turning(*rope.turning[i]).flow
    return 0.5 * (middles[i - 1].past(1) + middles[i].past(0))


class Rim(NamedTuple):
    """Point of a sheave at which a part of the rope leaves it at the initial pose.

    Parameters
    ----------
    coordinates : tuple of Displacement
        World coordinates of the point; none of a point on the ground.
    fixed : (3,) array
        What is to be added to them, m: all of a point on the ground.
    velocity : (3,) array
        Velocity at the start, world frame, m/s.
    """

    coordinates: tuple[Displacement, ...]
    fixed: Array
    velocity: Array


def rims_of(rope: Reeved) -> tuple[tuple[Rim, Rim], ...]:
    """Return the points at which both ends of all parts leave their sheaves."""
    parts = range(len(rope.parts))
    return tuple((_rim(rope, k, k), _rim(rope, k, k + 1)) for k in parts)


def _rim(rope: Reeved, k: int, i: int) -> Rim:
    """Return the point at which the part k leaves the sheave at the marker i."""
    marker: Marker = rope.route.path[i]
    arm = rope.radii[i] * np.cross(rope.route.ways[k], rope.route.axles[i])
    if marker.body is ground:
        return Rim((), marker.r + arm, np.zeros(3))
    velocity, fixed = np.zeros(3), arm
    body = marker.body
    if isinstance(body, RigidBody):
        place = marker.position_local + marker.carrier.T @ arm
        marker, fixed = replace(marker, position_local=place), np.zeros(3)
        turn = np.cross(body.angular_velocity, marker.r - body.position)
        velocity = body.velocity + turn
    origin = ground["origin"]
    return Rim(tuple(Displacement(origin, marker, axis) for axis in AXES), fixed, velocity)


def _middle(rope: Reeved, k: int, x: Mapping[str, Any]) -> Middle:
    """Return the middle of a part with its motion."""
    places, velocities = [], []
    for rim in rope.rims[k]:
        still: list[Any] = [e.expression(0.0)] * 3
        values = [e.value(c) for c in rim.coordinates] or still
        rates = [e.rate(c) for c in rim.coordinates] or still
        places.append([value + fixed for value, fixed in zip(values, rim.fixed, strict=True)])
        velocities.append(tuple(rates))
    w = [b - a for a, b in zip(*places, strict=True)]
    size = e.sqrt(_sum(one * one for one in w))
    way = tuple(one / size for one in w)
    shift, speed = x[f"shift{k + 1}"], x[f"speed{k + 1}"]
    return Middle(k, shift, speed, way, (velocities[0], velocities[1]))


def start_states(rope: Reeved) -> dict[str, float]:
    """Return the initial states of a rope with mass that moves with the bodies on its path."""
    made: dict[str, float] = {}
    flow: Any = 0.0 if rope.winch is None else rope.winch(0.0)
    for k, way in enumerate(rope.route.ways):
        first, second = (np.real(way @ rim.velocity) for rim in rope.rims[k])
        # the rope is as long as its path; it passes the middle at the mean of both ends
        made[f"shift{k + 1}"] = 0.0
        made[f"speed{k + 1}"] = float(first + flow)
        flow = flow - (second - first)
    return made


def dot(a: Any, b: Any) -> Any:
    """Return the scalar product of two vectors of expressions."""
    return _sum(x * y for x, y in zip(a, b, strict=True))


def _sum(parts: Any) -> Any:
    """Return the sum of expressions."""
    first, *rest = parts
    for part in rest:
        first = first + part
    return first
