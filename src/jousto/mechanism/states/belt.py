"""Ropes and belts that stick to a sheave by friction, slip on it and creep."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from jousto.base.errors import Problems
from jousto.base.fields import field, kept
from jousto.base.numbers import Number, Whole
from jousto.base.rotations import Direction, turn_onto
from jousto.mechanism.bodies.marker import MarkerField
from jousto.mechanism.joints.base import aligned
from jousto.mechanism.joints.coordinate import Coordinate, CoordinateField
from jousto.mechanism.joints.rope_span import RopeSpan, misfit, rope_direction, wrap_angle
from jousto.mechanism.states import expression as e
from jousto.mechanism.states.block import Block, Equations
from jousto.mechanism.states.rope import Rope
from jousto.mechanism.states.rope_path import OptionalCoordinate, RopePart, bearing, rope_path

TOUCH = 1e-12
"""Share of the length of a rope by which it may be from the limit of friction and slips."""
LARGEST_EXPONENT = 50.0
"""Largest mu times angle; the tension beyond it is 0 within round-off."""


class Side(NamedTuple):
    """One of both sides of a rope: its parts, and the rims that take rope off it.

    Parameters
    ----------
    parts : tuple of RopePart
        Parts of this side.
    turns : tuple of (Coordinate, float)
        Angles of sheaves, and the length that they take off this side over them, m/rad.
    """

    parts: tuple[RopePart, ...]
    turns: tuple[tuple[Coordinate, Any], ...] = ()

    @property
    def length(self) -> Any:
        """Length as an expression, m."""
        return _sum([part.length for part in self.parts])

    @property
    def rate(self) -> Any:
        """Rate of the length, m/s."""
        return _sum([part.rate for part in self.parts])

    @property
    def work_rate(self) -> Any:
        """Speed along which the tension does work on bodies, m/s."""
        return _sum([self.rate, *(arm * e.rate(turn) for turn, arm in self.turns)])


class FrictionLaw(NamedTuple):
    """Law of a rope on sheaves with friction.

    Parameters
    ----------
    stiffness, damping : float
        EA, N, and c, N s/m.
    total : float
        Unstretched length of both sides, m.
    first : float
        That of the first side at the start, m.
    exponent : float
        Friction times angle: the logarithm of the largest ratio of tensions.
    """

    stiffness: Any
    damping: Any
    total: Any
    first: Any
    exponent: Any

    def equations(self, sides: tuple[Side, Side], drives: Any, x: Mapping[str, Any]) -> Equations:
        """Return the equations of a rope that sheaves carry from one side to the other.

        Parameters
        ----------
        sides : tuple of Side
            Both sides.
        drives : sequence of (speed, side, side)
            Speed of the rim of each sheave, m/s, and the sides from and to which a positive one
            carries the rope.
        x : mapping of str to Expression
            States and memories of the block.
        """
        EA, c, S = self.stiffness, self.damping, self.total
        ratio = np.exp(self.exponent)
        l, dl = [side.length for side in sides], [side.rate for side in sides]
        # unstretched length of the first side, between the limits of friction
        held = self.first - x["passed"] + x["slip"]
        high, high_rate = _limit(l[0], l[1], dl[0], dl[1], S, ratio)
        low, low_rate = _limit(l[1], l[0], dl[1], dl[0], S, ratio)
        low, low_rate = S - low, 0.0 - low_rate
        free = e.minimum(e.maximum(held, low), high)
        frees = free, S - free
        elastic = [e.maximum(EA * (a / b - 1.0), 0.0) for a, b in zip(l, frees, strict=True)]
        # a sheave carries the rope at the strain with which it comes onto the rim
        passed: Any = e.expression(0.0)
        for speed, i, k in drives:
            onto = e.where(speed, 1.0 + elastic[i] / EA, 1.0 + elastic[k] / EA)
            carried = speed / onto
            passed = passed + carried if i == 0 else passed - carried
        near = TOUCH * S
        stuck = 0.0 - passed
        sinking = e.where(held - high + near, e.minimum(high_rate, stuck), stuck)
        change = e.where(low - held + near, e.maximum(low_rate, stuck), sinking)
        changes = change, 0.0 - change
        pulls = elastic
        if self.damping:
            pulls = [
                e.maximum(EA * (a / b - 1.0) + c * (da - db * a / b), 0.0)
                for a, b, da, db in zip(l, frees, dl, changes, strict=True)
            ]
        # work on the rope less what it stores becomes heat
        stored: Any = e.expression(0.0)
        heat: Any = e.expression(0.0)
        for side, pull, T, a, da, db in zip(sides, pulls, elastic, frees, dl, changes, strict=True):
            stored = stored + T * T * a / (2.0 * EA)
            heat = heat + pull * side.work_rate - T * da + (T + T * T / (2.0 * EA)) * db
        made = Equations(rates={"passed": passed, "heat": heat})
        for side, pull in zip(sides, pulls, strict=True):
            made.forces.extend((part.span, -pull) for part in side.parts if part.span is not None)
            made.forces.extend((turn, -(arm * pull)) for turn, arm in side.turns)
        made.updates = {"slip": x["slip"] + free - held}
        made.outputs = {"stored": stored, "pulls": pulls}
        return made


def _limit(l: Any, other: Any, dl: Any, dother: Any, S: Any, ratio: Any) -> tuple[Any, Any]:
    """Return the unstretched length x, and its rate, at which the other side has ratio times T.

    ``EA (l2 / (S - x) - 1) = ratio EA (l1 / x - 1)``: the smaller root of a quadratic equation.
    """
    more = ratio - 1.0
    b = more * S + other + ratio * l
    part = more * S - ratio * l
    root = e.sqrt(part * part + other * (other + 2.0 * (more * S + ratio * l)))
    x = 2.0 * ratio * l * S / (b + root)
    return x, (ratio * dl * (S - x) - x * dother) / root


def _sum(parts: list[Any]) -> Any:
    """Return the sum of expressions."""
    first, *rest = parts
    for part in rest:
        first = first + part
    return first


class Gripped(Block):
    """Base of ropes and belts that friction holds on a rim over the angle `wrap`."""

    if TYPE_CHECKING:
        mu: Any
        wrap: Any

    def check_ratio(self, problems: Problems, where: str, remedy: str) -> None:
        """Report a ratio of the tensions beyond all ropes."""
        exponent = np.real(self.mu * self.wrap)
        if exponent > LARGEST_EXPONENT:
            text = f"mu times the angle is {exponent:.0f}, must be at most"
            problems.add(where, f"{text} {LARGEST_EXPONENT:g}{remedy}", "mu")

    @property
    def largest_ratio(self) -> float:
        """Largest ratio of the tensions on both sides of the rim."""
        return float(np.exp(np.real(self.mu * self.wrap)))

    @property
    def starts(self) -> Mapping[str, float]:
        """What the rims have carried, m, and heat, J."""
        return {"passed": 0.0, "heat": 0.0}

    @property
    def memories(self) -> Mapping[str, float]:
        """What has slipped until the last end of a step, m."""
        return {"slip": 0.0}


class Capstan(Gripped, Rope, tag="capstan"):
    """Rope that sticks to one sheave by friction: a bollard, a capstan, a traction sheave.

    The rope runs along `path` as that of a `Reeving`; only at `sheave`, a place in the path from
    0, friction acts. The rope sticks to its rim while the tensions before and behind it are within
    ``T_1 / T_2 <= exp(mu phi)`` (Euler, Eytelwein), phi being the angle at the initial pose and
    `turns` further whole turns, and slips at this ratio; a rope at rest does not creep. A sheave
    that turns, with the angle `turn` of its hinge, carries the rope at the strain with which it
    comes onto the rim: this is the elastic creep of belts. On both sides
    ``T = EA (l / l0 - 1) + c (l' - l0' l / l0)``, never negative; `length` is that without the rope
    on the further turns.

    Outputs: `tension` at the start and `tension_end`, N, `stored`, J; states: `passed`, m, the
    unstretched rope that the sheave has carried along the path, and `heat`, J, of friction, creep
    and damping. The memory `slip`, m, is the rope that has slipped against the path.

    Examples
    --------
    >>> from jousto import RigidBody, ground
    >>> load = RigidBody("load", 100.0, (1, 1, 1), position=(-0.1, -5, 0))
    >>> hand = RigidBody("hand", 10.0, (1, 1, 1), position=(0.1, -5, 0))
    >>> path = load["origin"], ground["origin"], hand["origin"]
    >>> rope = Capstan("rope", path, (0, -0.1, 0), stiffness=1e5, mu=0.2, turns=1)
    >>> print(f"{rope.largest_ratio:.3f}")
    6.586
    """

    kind = "capstan"
    together = ("path", "radii", "sheave", "turn", "turns", "mu", "axis")
    outputs = ("tension", "tension_end", "stored")
    mu: Number = field("Coefficient of friction", unit="1", least=0, kw_only=True)
    turns: Number = field("Further whole turns on the sheave", least=0, default=0.0, kw_only=True)
    sheave: Whole = field(
        "Place of the sheave with friction in the path, from 0", least=1, default=1, kw_only=True
    )
    turn: OptionalCoordinate = field(
        "Angle of the hinge of the sheave; None for a sheave that does not turn",
        default=None,
        kw_only=True,
    )

    wrap: Any = kept()
    sense: Any = kept()

    def consistent(self, problems: Problems, where: str) -> None:
        """Report paths that do not fit, and a sheave with friction that is none."""
        self.keep_path(None)
        object.__setattr__(self, "wrap", 0.0)
        object.__setattr__(self, "sense", 1.0)
        path, k = tuple(self.path), self.sheave
        count = len(path)
        if count < 3:
            problems.add(where, f"path has {count} markers; give three or more", "path")
            return
        if len(self.radii) != count:
            text = f"has {len(self.radii)} radii for {count} markers of the path"
            problems.add(where, text, "radii")
            return
        if not (k < count - 1 and self.radii[k] != 0.0):
            text = f"sheave is {k}, must be a marker between the ends with a radius"
            problems.add(where, text, "sheave")
            return
        if self.turn is not None:
            marker = self.path[k]
            if self.axis is not None:
                marker = aligned(marker, turn_onto(marker.A, self.axis))
            held, sense = bearing(problems, where, "turn", self.turn, marker)
            path = (*path[:k], held, *path[k + 1 :])
            object.__setattr__(self, "sense", sense)
        rope = rope_path(problems, where, self, path)
        if rope is None:
            return
        self.keep_path(rope)
        object.__setattr__(self, "wrap", rope.wraps[k] + 2.0 * np.pi * self.turns)
        self.check_ratio(problems, where, ": fix the rope to the sheave")
        given: Any = self.length
        if given is None:
            object.__setattr__(self, "length", sum(self._initial))

    @property
    def _initial(self) -> tuple[Any, Any]:
        """Lengths of both sides at the initial pose, m."""
        sides = self.parts[: self.sheave], self.parts[self.sheave :]
        first, second = (sum(part.initial for part in side) for side in sides)
        return first, second

    def equations(self, x: Mapping[str, e.Expression]) -> Equations:
        """Return tensions, forces along all spans, heat, and the rope that slips."""
        sheave = self.parts[: self.sheave], self.parts[self.sheave :]
        sides, drives = (Side(sheave[0]), Side(sheave[1])), []
        if self.turn is not None:
            arm = self.radii[self.sheave] * self.sense
            sides = Side(sheave[0], ((self.turn, arm),)), Side(sheave[1], ((self.turn, -arm),))
            drives = [(arm * e.rate(self.turn), 0, 1)]
        first, second = self._initial
        total: Any = self.length
        exponent = self.mu * self.wrap
        law = FrictionLaw(
            self.stiffness, self.damping, total, total * first / (first + second), exponent
        )
        made = law.equations(sides, drives, x)
        made.outputs["tension"], made.outputs["tension_end"] = made.outputs.pop("pulls")
        return made


class BeltDrive(Gripped, tag="belt-drive"):
    """Belt around two pulleys, open or crossed, with creep and slip.

    Both straight parts have ``T = EA (l / l0 - 1) + c (l' - l0' l / l0)``, never negative. Each
    pulley carries the belt at the strain with which it comes onto the rim, so that the driven rim
    is slower than the driving one by ``(T_1 - T_2) / EA``, and the belt slips as a whole on the
    pulley with the smaller angle phi at ``T_1 / T_2 = exp(mu phi)`` (Euler, Eytelwein). The belt
    has no mass: at speeds at which ``m v^2``, with its mass over length m, is not small beside the
    tension, its grip is less.

    Radii are positive where the belt turns about the axle by the right hand on its way from a to b;
    of opposite signs for a crossed belt. Outputs: `tension_ab` of the part from a to b,
    `tension_ba` and `stored`, J; states: `passed`, m, the unstretched belt that has left the part
    from a to b, and `heat`, J. The memory `slip`, m, is the belt that has slipped into it.

    Examples
    --------
    >>> from jousto import Revolute, RigidBody, ground
    >>> wheels = [RigidBody(n, 5.0, (1, 1, 1), position=(x, 0, 0)) for n, x in (("a", 0), ("b", 2))]
    >>> turns = [Revolute(w.name + "x", ground.at(w["origin"].r), w["origin"]) for w in wheels]
    >>> ends = [wheel["origin"] for wheel in wheels]
    >>> belt = BeltDrive(
    ...     "belt", *ends, 0.1, 0.3, turns[0].angle, turns[1].angle, stiffness=1e5, mu=0.3,
    ...     preload=400.0,
    ... )
    >>> print(f"{belt.largest_ratio:.3f}")
    2.417
    """

    kind = "belt drive"
    symbol = "cable"
    together = ("a", "b", "radius_a", "radius_b", "turn_a", "turn_b", "mu", "axis")
    outputs = ("tension_ab", "tension_ba", "stored")
    a: MarkerField = field("Pulley a, its axle along z")
    b: MarkerField = field("Pulley b")
    radius_a: Number = field(
        "Radius of pulley a, with the sign of its sense", unit="m", nonzero=True
    )
    radius_b: Number = field(
        "Radius of pulley b, with the sign of its sense", unit="m", nonzero=True
    )
    turn_a: CoordinateField = field("Angle of the hinge of pulley a")
    turn_b: CoordinateField = field("Angle of the hinge of pulley b")
    stiffness: Number = field("EA, tension over strain", unit="N", above=0, kw_only=True)
    mu: Number = field("Coefficient of friction", unit="1", least=0, kw_only=True)
    preload: Number = field(
        "Tension of both parts at the initial pose", unit="N", least=0, kw_only=True
    )
    damping: Number = field(
        "c, tension over the rate of the stretch", unit="N s/m", least=0, default=0.0, kw_only=True
    )

    axis: Direction = field(
        "Direction of both axles in the world frame at the initial pose; None for the z axes of "
        "the markers",
        default=None,
        kw_only=True,
    )

    parts: Any = kept()
    wrap: Any = kept()
    senses: Any = kept()

    def consistent(self, problems: Problems, where: str) -> None:
        """Report pulleys inside one another and angles that are not those of the pulleys."""
        for name, value in (("parts", ()), ("wrap", 0.0), ("senses", (1.0, 1.0))):
            object.__setattr__(self, name, value)
        if self.a.body is self.b.body:
            problems.add(where, f"both pulleys are on {self.a.body.name!r}; give two bodies", "b")
            return
        pulleys = [
            marker if self.axis is None else aligned(marker, turn_onto(marker.A, self.axis))
            for marker in (self.a, self.b)
        ]
        a, sense_a = bearing(problems, where, "turn_a", self.turn_a, pulleys[0])
        b, sense_b = bearing(problems, where, "turn_b", self.turn_b, pulleys[1])
        object.__setattr__(self, "senses", (sense_a, sense_b))
        ends = (a, self.radius_a), (b, self.radius_b)
        for marker, radius in ends:
            if not radius:
                problems.add(where, f"radius at {marker.label} is 0 m, must not be 0", "radius_a")
                return
        made = []
        for (p, r), (q, s), name in ((*ends, "ab"), (*ends[::-1], "ba")):
            way = rope_direction(p, q, r, s)
            if problem := misfit(p, q, r, s, way):
                problems.add(where, problem, "b")
                return
            rigid = p.body is q.body and (p.site is None or p.site == q.site)
            span = None if rigid else RopeSpan(p, q, r, s, name=f"{self.name}.{name}")
            made.append((span, way, way @ (q.r - p.r) if rigid else 0.0))
        (ab, out, straight), (ba, back, behind) = made
        wraps = (
            wrap_angle(a.A[:, 2], back, out, self.radius_a),
            wrap_angle(b.A[:, 2], out, back, self.radius_b),
        )
        arcs = sum(
            abs(float(np.real(radius))) * wrap
            for (_, radius), wrap in zip(ends, wraps, strict=True)
        )
        parts = RopePart(ab, straight + 0.5 * arcs), RopePart(ba, behind + 0.5 * arcs)
        object.__setattr__(self, "parts", parts)
        object.__setattr__(self, "wrap", min(wraps, key=np.real))
        self.check_ratio(problems, where, "; couple both angles instead")

    def equations(self, x: Mapping[str, e.Expression]) -> Equations:
        """Return tensions, forces along both spans, heat, and the belt that slips."""
        arms = self.radius_a * self.senses[0], self.radius_b * self.senses[1]
        ab, ba = self.parts
        sides = (
            Side((ab,), ((self.turn_a, -arms[0]), (self.turn_b, arms[1]))),
            Side((ba,), ((self.turn_a, arms[0]), (self.turn_b, -arms[1]))),
        )
        drives = (arms[0] * e.rate(self.turn_a), 1, 0), (arms[1] * e.rate(self.turn_b), 0, 1)
        stretch = 1.0 + self.preload / self.stiffness
        total, first = (ab.initial + ba.initial) / stretch, ab.initial / stretch
        exponent = self.mu * self.wrap
        law = FrictionLaw(self.stiffness, self.damping, total, first, exponent)
        made = law.equations(sides, drives, x)
        made.outputs["tension_ab"], made.outputs["tension_ba"] = made.outputs.pop("pulls")
        return made

    @property
    def drawn_at(self) -> tuple[Any, ...]:
        """Both pulleys."""
        return (self.a, self.b)
