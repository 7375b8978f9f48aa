"""A flexible arm with a bucket falls on a bumper: speed, rebound, loss and stress.

The arm of 2 m turns about a hinge, the bucket of 40 kg is welded to its tip, and a ball below its
middle meets a bumper of the frame with a restitution of 0.3. The speed at the first touch is that
of energy; at rest on the bumper the bending stress is that of statics, M / W.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.mechanism import Contact, HalfSpace, PowerLaw, Sphere
from jousto.output.style import COLORS, STYLE

G, LENGTH, MASS, BALL, DROP = 9.81, 2.0, 40.0, 0.03, 0.05  # m, kg, gap at the bumper in m
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
SECTION = jo.Rectangle(0.05, 0.08)
BUMPER = PowerLaw(2e7, restitution=0.3, slowest=0.02)


def arm() -> jo.FlexibleBody:
    """Return the arm along x with interfaces at hinge, middle and tip."""
    part = jo.Part.beam(LENGTH, SECTION, 8, STEEL, theory=jo.parts.EulerBernoulli())
    sites = ("start", "node5", "end")
    reduced = jo.reduce(part, jo.CraigBampton(sites, modes=6))
    return jo.FlexibleBody("arm", reduced, damping=0.02)


def machine() -> jo.Model:
    """Return the arm, level and at rest, with its middle a gap above the bumper."""
    beam = arm()
    bucket = jo.RigidBody("bucket", MASS, (2.0, 2.0, 2.0), position=(LENGTH, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], beam["start"], axis=(0, -1, 0))
    weld = jo.Fixed("weld", beam["end"], bucket["origin"])
    place = (LENGTH / 2, 0, -BALL - DROP)
    stop = Contact("stop", jo.ground.at(place), HalfSpace(), beam["node5"], Sphere(BALL), BUMPER)
    sensors = (
        jo.ForceSensor("force", stop),
        jo.StressSensor("stress", beam, "e5.a.top"),
        jo.CoordinateSensor("angle", hinge.angle),
    )
    items = (beam, bucket, hinge, weld, stop, *sensors)
    return jo.compile(jo.Mechanism(*items, jo.Gravity((0, 0, -G))))


def main(out: Path) -> int:
    """Let it fall and rest; return 0 if the speed and the stress at rest are right."""
    out.mkdir(parents=True, exist_ok=True)
    model = machine()
    run = jo.simulate(model, 3.0, solver=jo.ROS2(1e-4), output_step=1e-3)
    rod = STEEL.rho * 0.05 * 0.08 * LENGTH  # kg
    inertia = rod * LENGTH**2 / 3 + MASS * LENGTH**2 + 2.0
    fall = np.arcsin(2 * DROP / LENGTH)
    rate = np.sqrt(2 * G * np.sin(fall) * (rod * LENGTH / 2 + MASS * LENGTH) / inertia)
    first = run.contacts[0]
    exact = rate * LENGTH / 2 * np.cos(fall)
    print(f"meets the bumper at {first.approach:.4f} m/s, rigid by energy {exact:.4f} m/s")
    print(f"largest force {first.force / 1e3:.1f} kN, depth {1e3 * first.depth:.2f} mm")
    lost, stored = run.energy.dissipated[-1], run.energy.potential[0] - run.energy.potential[-1]
    print(f"{stored:.1f} J fallen, {lost:.1f} J lost")
    # beyond the bumper the arm is a cantilever under its weight and the bucket's
    half = LENGTH / 2
    bends = MASS * G * half + rod / 2 * G * half / 2
    static = bends / (0.05 * 0.08**2 / 6) * np.cos(fall)
    rest = run["stress"][-1, 0]
    peak = np.abs(run["stress"]).max()
    print(
        f"stress at rest {rest / 1e6:.2f} MPa, M / W {static / 1e6:.2f} MPa, peak {peak / 1e6:.0f}"
    )
    with plt.style.context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3), layout="constrained")
        left.plot(run.time, run["force"][:, 2] / 1e3, color=COLORS[0])
        left.set(xlabel="time (s)", ylabel="force of the bumper (kN)")
        right.plot(run.time, run["stress"] / 1e6, color=COLORS[1])
        right.set(xlabel="time (s)", ylabel="bending stress above it (MPa)")
        figure.savefig(out / "bucket_stop.png")
        plt.close(figure)
    return int(abs(first.approach / exact - 1) > 2e-2 or abs(rest / static - 1) > 1e-2)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
