"""A ball rolls along a slender beam, and another one strikes a beam twice.

A ball is thrown on a beam of 2 m on a hinge and a roller: it bounces, slips, and rolls. The contact
is on the line through its nodes, with restitution and friction. Friction alone acts along the beam,
so that the ball keeps its angular momentum about the point of contact: from 1 m/s without spin it
comes to 5/7 m/s, rolling.

A steel ball of 30 mm strikes the middle of a beam of 10 x 10 x 200 mm at 0.1 m/s. It parts, and
the beam swings back and strikes it again, harder: Timoshenko's impact (1913). Without rotary
inertia the ball parts after 0.193 ms, and the beam is back after 0.614 ms with up to 137 N.
"""

from __future__ import annotations

import sys
from math import pi
from pathlib import Path

import matplotlib.pyplot as plt

import jousto as jo
from jousto.mechanism import Contact, HalfSpace, Hertz, PowerLaw, Sphere, TrackContact, nodes_along
from jousto.output.style import COLORS, STYLE
from jousto.simulation.results.contacts import RunContacts

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
RADIUS, MASS, SPEED = 0.02, 0.26, 1.0  # m, kg, m/s


def beam_of(
    length: float, section: jo.Rectangle, elements: int, modes: int, *loaded: str
) -> jo.FlexibleBody:
    """A beam whose motion in the plane xz is kept."""
    part = jo.Part.beam(length, section, elements, STEEL, theory=jo.parts.EulerBernoulli())
    interfaces = ("start", *loaded, "end")
    reduced = jo.reduce(part, jo.CraigBampton(interfaces=interfaces, modes=modes))
    return jo.FlexibleBody("beam", reduced.keep(reduced.in_plane("xz")))


def pinned(beam: jo.FlexibleBody, length: float) -> list[object]:
    """The beam on a hinge and a roller."""
    hinge = jo.Revolute("hinge", jo.ground["origin"], beam["start"], (0, 1, 0))
    roller = jo.PointOnPlane("roller", jo.ground.at((length, 0, 0)), beam["end"], (0, 0, 1))
    return [beam, hinge, roller]


def roll() -> jo.Solution:
    """A ball that is thrown along a slender beam."""
    length, r = 2.0, RADIUS
    beam = beam_of(length, jo.Rectangle(0.03, 0.01), 16, 20)
    ball = jo.RigidBody.sphere(
        "ball", radius=r, mass=MASS, position=(0.5, 0, 0.12), velocity=(SPEED, 0, 0)
    )
    touch = TrackContact(
        *("touch", nodes_along(beam, "start", "end"), ball["origin"]),
        PowerLaw(1e6, 1.0, restitution=0.5),
        radius=r,
        mu_kinetic=0.3,
    )
    sensors = (
        jo.PositionSensor("ball", ball["origin"]),
        jo.VelocitySensor("speed", ball["origin"]),
        jo.AngularVelocitySensor("spin", ball["origin"]),
    )
    pull = jo.Force("weight", ball["origin"], (0, 0, -9.81 * MASS))
    model = jo.compile(jo.Mechanism(*pinned(beam, length), ball, touch, pull, *sensors))
    return jo.simulate(model, 1.2, solver=jo.ROS2(1e-4), output_step=2e-3)


def strike() -> RunContacts:
    """Both touches of a ball that drops on a beam, with Hertz's law and no loss."""
    length, r, middle = 0.2, 0.015, "node11"
    beam = beam_of(length, jo.Rectangle(0.01, 0.01), 20, 18, middle)
    ball = jo.RigidBody.sphere(
        *("ball",), radius=r, mass=STEEL.rho * 4 / 3 * pi * r**3,
        position=(length / 2, 0, r), velocity=(0, 0, -0.1),
    )  # fmt: skip
    law = Hertz.between(STEEL, restitution=1.0)
    hit = Contact("hit", beam[middle], HalfSpace(), ball["origin"], Sphere(r), law)
    model = jo.compile(jo.Mechanism(*pinned(beam, length), ball, hit))
    return jo.simulate(model, 8e-4, solver=jo.RK4(1e-6)).contacts


def main(out: Path) -> int:
    """Run, compare and draw; return 0 if the ball rolls at 5/7 of its first speed."""
    out.mkdir(parents=True, exist_ok=True)
    run = roll()
    speed = run["speed"][:, 0]
    rolled = run["spin"][:, 1] * RADIUS
    print(f"speed {speed[-1]:.4f} m/s, rolling {rolled[-1]:.4f} m/s, 5/7: {5 / 7 * SPEED:.4f} m/s")
    first, second = strike()
    print(
        f"parts after {1e3 * first.part:.4f} ms, is struck again after {1e3 * second.touch:.4f} ms"
    )
    with plt.style.context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.2), layout="constrained")
        left.plot(run["ball"][:, 0], 1e3 * run["ball"][:, 2], color=COLORS[0])
        left.set(xlabel="x, m", ylabel="height of the centre, mm")
        right.plot(run.time, speed, color=COLORS[0], label="speed")
        right.plot(run.time, rolled, color=COLORS[1], label="spin times radius")
        right.set(xlabel="t, s", ylabel="m/s")
        right.legend()
        figure.savefig(out / "ball_on_beam.png")
        plt.close(figure)
    return int(
        abs(speed[-1] / (5 / 7 * SPEED) - 1) > 1e-2
        or abs(rolled[-1] / speed[-1] - 1) > 2e-3
        or abs(first.part / 1.9309e-4 - 1) > 0.01
        or abs(second.touch / 6.1431e-4 - 1) > 0.05
    )


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
