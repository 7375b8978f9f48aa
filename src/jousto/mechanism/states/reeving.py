"""Rope over fixed and moving sheaves, with a winch."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import Problems, warn
from jousto.base.fields import field, kept
from jousto.base.numbers import DefaultNumber, DefaultValues, Number, Values
from jousto.base.rotations import Direction, exp_rotation
from jousto.mechanism.bodies.marker import Marker, MarkersField
from jousto.mechanism.joints.rope_span import wrap_angle
from jousto.mechanism.signals.base import OptionalSignal
from jousto.mechanism.states import expression as e
from jousto.mechanism.states.block import Block, Equations
from jousto.mechanism.states.rope_path import OptionalCoordinate, rope_path

TOO_SHORT = 0.05
"""Strain at the start that is probably a mistake; a rope of steel breaks at 0.02."""
ARC = np.radians(30.0)
"""Angle between points of pictures on a sheave, rad."""


class Reeving(Block, tag="reeving"):
    """Rope that runs over sheaves: a hoist, a block and tackle, a steering rope.

    The rope goes through the markers of `path` in order, from a drum or a fixed end over sheaves on
    any bodies, which may move, to its other end. Between sheaves it follows their common tangents
    in space (`RopeSpan`). With the length l of the whole rope along the sheaves and its unstretched
    length l0 the tension is ``T = EA (l / l0 - 1) + c (l' - l0' l / l0)``, never negative: a rope
    does not push. Every sheave, drum and end receives the force and moment of the rope, so that
    momentum and angular momentum are exact. The sheaves and the rope have no mass.

    A sheave with an efficiency below 1 holds the rope back: the tension grows by ``1 / efficiency``
    in the sense in which the rope runs, ``efficiency^(-tanh(u / slow))`` at the speed u. For a rope
    that slips over a bollard by the angle a (Euler, Eytelwein) it is ``exp(-mu a)``.

    Outputs: `tension` at the start, N, `tension_end` at the end, `length` l and `unstretched` l0,
    m, and `strain`, ``l / l0 - 1``, negative while the rope is slack; the state `paid_out`, m, is
    the rope that the winch has paid out.

    Examples
    --------
    >>> from jousto import RigidBody, ground
    >>> load = RigidBody("load", 100.0, (1, 1, 1), position=(0.2, -5, 0))
    >>> left, right = ground.at((0, 0, 0)), ground.at((0.4, 0, 0))
    >>> rope = Reeving("rope", (left, load["origin"], right), (0, 0.2, 0), stiffness=1e6)
    >>> print(rope["tension"], f"{rope.initial_length:.4f} m")
    rope.tension 10.6283 m
    """

    kind = "reeving"
    symbol = "cable"
    together = ("path", "radii", "efficiencies")
    outputs = ("tension", "tension_end", "length", "unstretched", "strain")
    path: MarkersField = field("Markers along the rope: an end or drum, sheaves, the other end")
    radii: Values = field(
        "Radius of the sheave at each marker, negative for the other sense; 0 for an end. Positive "
        "where the rope runs about the axle, the z axis of the marker, by the right hand",
        unit="m",
        shape=(None,),
    )
    stiffness: Number = field("EA, tension over strain", unit="N", above=0, kw_only=True)
    damping: Number = field(
        "c, tension over the rate of the stretch", unit="N s/m", least=0, default=0.0, kw_only=True
    )
    length: DefaultNumber = field(
        "Unstretched length at the start; None for the length at the initial pose",
        unit="m",
        above=0,
        default=None,
        kw_only=True,
    )
    axis: Direction = field(
        "Direction of all axles in the world frame at the initial pose; None for the z axes of the "
        "markers",
        default=None,
        kw_only=True,
    )
    efficiencies: DefaultValues = field(
        "Tension before over tension after each marker of the path while the rope runs, 1 at both "
        "ends; None for no loss",
        unit="1",
        shape=(None,),
        default=None,
        kw_only=True,
    )
    slow: Number = field(
        "Speed below which the loss at sheaves falls to 0",
        unit="m/s",
        above=0,
        default=1e-3,
        kw_only=True,
    )
    winch: OptionalSignal = field(
        "Speed at which a winch at the start pays out rope; negative hoists. None for no winch",
        unit="m/s",
        default=None,
        kw_only=True,
    )
    drum: OptionalCoordinate = field(
        "Coordinate of a drum at the start, which pays out rope and receives the tension: an "
        "angle, or a displacement",
        default=None,
        kw_only=True,
    )
    drum_radius: Number = field(
        "Rope that the drum pays out over its coordinate; negative for the other sense, 1 for a "
        "displacement",
        unit="m",
        default=0.0,
        kw_only=True,
    )

    parts: Any = kept()
    ways: Any = kept()
    axles: Any = kept()

    def consistent(self, problems: Problems, where: str) -> None:
        """Report paths, radii and efficiencies that do not fit, and sheaves without a rope."""
        count = len(self.path)
        given: Any = self.efficiencies
        if given is None:
            object.__setattr__(self, "efficiencies", np.ones(count))
        for name in ("parts", "ways", "axles"):
            object.__setattr__(self, name, ())
        if count < 2:
            problems.add(where, f"path has {count} markers; give two or more", "path")
            return
        numbers: tuple[tuple[str, Any], ...] = (
            ("radii", self.radii),
            ("efficiencies", self.efficiencies),
        )
        for name, values in numbers:
            if len(values) != count:
                text = f"has {len(values)} {name} for {count} markers of the path"
                problems.add(where, text, name)
                return
        for k, eta in enumerate(np.real(self.efficiencies)):
            inner = 0 < k < count - 1
            if not 0.0 < eta <= 1.0 or (eta != 1.0 and not inner):
                allowed = "above 0 and at most 1" if inner else "1: an end has no loss"
                text = f"efficiencies[{k}] at {self.path[k].label} is {eta:g}, must be {allowed}"
                problems.add(where, text, "efficiencies")
                return
        if (self.drum is None) != (self.drum_radius == 0.0):
            problems.add(where, "drum and drum_radius go together; give both or none", "drum")
        rope = rope_path(problems, where, self, self.path)
        if rope is None:
            return
        for name in ("parts", "ways", "axles"):
            object.__setattr__(self, name, getattr(rope, name))
        length: Any = self.length
        if length is None:
            object.__setattr__(self, "length", self.initial_length)
        elif self.initial_length > (1.0 + TOO_SHORT) * np.real(length):
            warn(
                where,
                f"is {np.real(length):g} m long, its path {np.real(self.initial_length):g} m: it "
                "starts stretched; check length, radii and their signs",
            )

    @property
    def initial_length(self) -> float:
        """Length of the rope along the sheaves at the initial pose, m."""
        total: Any = 0.0
        for part in self.parts:
            total = total + part.initial
        return total  # type: ignore[no-any-return]

    @property
    def starts(self) -> Mapping[str, float]:
        """The rope that the winch has paid out."""
        return {} if self.winch is None else {"paid_out": 0.0}

    def equations(self, x: Mapping[str, e.Expression]) -> Equations:
        """Return tension, its forces along all spans and the drum, and the rate of the winch."""
        made = Equations()
        paid: Any = e.expression(0.0)
        rate: Any = e.expression(0.0)
        if self.winch is not None:
            paid, rate = x["paid_out"], e.expression(self.winch)
            made.rates["paid_out"] = rate
        if self.drum is not None:
            paid = paid + self.drum_radius * e.value(self.drum)
            rate = rate + self.drum_radius * e.rate(self.drum)
            paid = paid - self.drum_radius * self.drum.initial
        lengths, rates = zip(*((part.length, part.rate) for part in self.parts), strict=True)
        length, speed = _sum(lengths), _sum(rates)
        free: Any = self.length + paid
        strain = length / free - 1.0
        pull = self.stiffness * strain
        if self.damping:
            pull = pull + self.damping * (speed - rate * length / free)
        # tension of each part over that of the first, by the losses at the sheaves before it
        shares: list[Any] = [e.expression(1.0)]
        flow = rate
        for part, eta in zip(self.parts[:-1], self.efficiencies[1:-1], strict=True):
            flow = flow - part.rate
            share: Any = shares[-1]
            if eta != 1.0:
                share = share * e.exp(-np.log(eta) * e.tanh(flow / self.slow))
            shares.append(share)
        if any(eta != 1.0 for eta in self.efficiencies):
            # the mean over the length has the stretch of the whole rope
            pull = pull * length / _sum(x * y for x, y in zip(shares, lengths, strict=True))
        first = e.maximum(pull, 0.0)
        for share, part in zip(shares, self.parts, strict=True):
            if part.span is not None:
                made.forces.append((part.span, -(first * share)))
        if self.drum is not None:
            made.forces.append((self.drum, self.drum_radius * first))
        made.outputs = {
            "tension": first,
            "tension_end": first * shares[-1],
            "length": length,
            "unstretched": free,
            "strain": strain,
        }
        return made

    @property
    def drawn_at(self) -> tuple[Marker | tuple[Any, Array], ...]:
        """Points along the rope at the initial pose, each on the body of its sheave."""
        found: list[Marker | tuple[Any, Array]] = []
        for k, marker in enumerate(self.path):
            radius = float(np.real(self.radii[k]))
            ways = [np.real(way) for way in self.ways[max(k - 1, 0) : k + 1]]
            if not radius:
                found.append(marker)
                continue
            n = np.real(self.axles[k])
            turn = float(np.real(wrap_angle(n, ways[0], ways[-1], radius)))
            for share in np.linspace(0.0, turn, 1 + max(1, round(turn / ARC))):
                rim = radius * np.cross(exp_rotation(np.sign(radius) * share * n) @ ways[0], n)
                found.append((marker.body, marker.position_local + marker.carrier.T @ rim))
        return tuple(found)


def _sum(parts: Iterable[Any]) -> Any:
    """Return the sum of expressions."""
    first, *rest = parts
    for part in rest:
        first = first + part
    return first
