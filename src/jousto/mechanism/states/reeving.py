"""Rope over fixed and moving sheaves, with a winch."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from jousto.base.errors import Problems, warn
from jousto.base.fields import field, kept
from jousto.base.numbers import DefaultValues, Number
from jousto.base.rotations import turn_onto
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.joints.base import aligned
from jousto.mechanism.joints.coordinate import CoordinatesField
from jousto.mechanism.signals.base import OptionalSignal
from jousto.mechanism.states import expression as e
from jousto.mechanism.states.block import Equations
from jousto.mechanism.states.rope import Rope
from jousto.mechanism.states.rope_path import OptionalCoordinate, bearing, rope_path
from jousto.mechanism.states.rope_sections import add_sections, rims_of, start_states

TOO_SHORT = 0.05
"""Strain at the start that is probably a mistake; a rope of steel breaks at 0.02."""


class Reeving(Rope, tag="reeving"):
    """Rope that runs over sheaves: a hoist, a block and tackle, a steering rope.

    The rope goes through the markers of `path` in order, from a drum or a fixed end over sheaves on
    any bodies, which may move, to its other end. Between sheaves it follows their common tangents
    in space (`RopeSpan`). With the length l of the whole rope along the sheaves and its unstretched
    length l0 the tension is ``T = EA (l / l0 - 1) + c (l' - l0' l / l0)``, never negative: a rope
    does not push. Every sheave, drum and end receives the force and moment of the rope, so that
    momentum and angular momentum are exact.

    With `hinges` some sheaves are bodies that turn with the rope, and with `mass_per_length` rho
    the middle of every part carries its mass ``m = rho l0``, with the speed u along the part in the
    world: ``m u' = T_2 - T_1 + m g . e``. There is then one tension between two such places, and
    the ends of a part receive half its weight; across a part its mass has no inertia.

    A sheave with an efficiency below 1 holds the rope back: the tension grows by ``1 / efficiency``
    in the sense in which the rope runs, ``efficiency^(-tanh(u / slow))`` at the speed u. For a rope
    that slips over a bollard by the angle a (Euler, Eytelwein) it is ``exp(-mu a)``.

    Outputs: `tension` at the start, N, `tension_end` at the end, `length` l and `unstretched` l0,
    m, and `strain`, ``l / l0 - 1``, negative while the rope is slack; with hinges or mass also
    `stored` and `kinetic` energy, J. The state `paid_out`, m, is the rope that the winch has paid
    out; with mass `shift1`, m, is the rope that has passed the middle of the first part, and
    `speed1`, m/s, its speed u.

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
    together = ("path", "radii", "efficiencies", "hinges")
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

    hinges: CoordinatesField = field(
        "Angles of the hinges of sheaves that are bodies on the path and turn with the rope",
        default=(),
        kw_only=True,
    )
    mass_per_length: Number = field(
        "Mass of the rope over its length", unit="kg/m", least=0, default=0.0, kw_only=True
    )

    turning: Any = kept()
    rims: Any = kept()
    moving: Any = kept()

    def consistent(self, problems: Problems, where: str) -> None:
        """Report paths, radii and efficiencies that do not fit, and sheaves without a rope."""
        count = len(self.path)
        given: Any = self.efficiencies
        if given is None:
            object.__setattr__(self, "efficiencies", np.ones(count))
        self.keep_path(None)
        for name, empty in (("turning", {}), ("rims", ()), ("moving", {})):
            object.__setattr__(self, name, empty)
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
        rope = rope_path(problems, where, self, self._held_path(problems, where))
        if rope is None:
            return
        self.keep_path(rope)
        if self.mass_per_length:
            object.__setattr__(self, "rims", rims_of(self))
            object.__setattr__(self, "moving", start_states(self))
        length: Any = self.length
        if length is None:
            object.__setattr__(self, "length", self.initial_length)
        elif self.initial_length > (1.0 + TOO_SHORT) * np.real(length):
            warn(
                where,
                f"is {np.real(length):g} m long, its path {np.real(self.initial_length):g} m: it "
                "starts stretched; check length, radii and their signs",
            )

    def _held_path(self, problems: Problems, where: str) -> list[Marker]:
        """Return the path with the frames that carry the sheaves that turn; keep their turns."""
        path, turning = list(self.path), {}
        for i, hinge in enumerate(self.hinges):
            bodies = hinge.a.body, hinge.b.body
            places = [k for k, x in enumerate(self.path) if x.body in bodies and self.radii[k]]
            places = [k for k in places if 0 < k < len(path) - 1]
            if not places:
                text = f"hinges[{i}], {hinge.name}, turns no sheave of the path; give the angle of "
                problems.add(where, text + "the hinge of a body on the path", "hinges")
            for k in places:
                sheave = self.path[k]
                if self.axis is not None:
                    sheave = aligned(sheave, turn_onto(sheave.A, self.axis))
                path[k], sense = bearing(problems, where, f"hinges[{i}]", hinge, sheave)
                turning[k] = hinge, self.radii[k] * sense
                if self.efficiencies[k] != 1.0:
                    text = (
                        f"efficiencies[{k}] at {sheave.label} is {np.real(self.efficiencies[k]):g}"
                    )
                    text += ", must be 1: the sheave turns; declare friction of its hinge"
                    problems.add(where, text, "efficiencies")
        object.__setattr__(self, "turning", turning)
        return path

    @property
    def initial_length(self) -> float:
        """Length of the rope along the sheaves at the initial pose, m."""
        total: Any = 0.0
        for part in self.parts:
            total = total + part.initial
        return total  # type: ignore[no-any-return]

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs: energies only of a rope with sections."""
        always = ("tension", "tension_end", "length", "unstretched", "strain")
        return (*always, "stored", "kinetic") if self.has_sections else always

    @property
    def has_sections(self) -> bool:
        """Whether the tension differs by inertia along the rope."""
        return bool(self.turning) or bool(self.mass_per_length)

    @property
    def starts(self) -> Mapping[str, float]:
        """The rope that the winch has paid out, and the motion of a heavy rope along its parts."""
        paid: dict[str, float] = {} if self.winch is None else {"paid_out": 0.0}
        return {**paid, **self.moving}

    def equations(self, x: Mapping[str, e.Expression]) -> Equations:
        """Return tensions, forces along all spans and the drum, and the rates of all states."""
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
        if self.has_sections:
            add_sections(made, self, x, paid, rate)
        else:
            self._add_uniform(made, paid, rate)
        return made

    def loss(self, eta: Any, speed: Any) -> Any:
        """Return the tension behind a sheave over that before it at a speed of the rope, m/s."""
        return e.exp(-np.log(eta) * e.tanh(speed / self.slow))

    def _add_uniform(self, made: Equations, paid: Any, rate: Any) -> None:
        """Add the equations of a rope without mass, whose stretch is the same everywhere."""
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
                share = share * self.loss(eta, flow)
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


def _sum(parts: Iterable[Any]) -> Any:
    """Return the sum of expressions."""
    first, *rest = parts
    for part in rest:
        first = first + part
    return first
