"""A wheelset hunts above its critical speed, from flange to flange, and not below it.

A wheelset with conical wheels runs between the springs of a bogie at a constant speed. Below the
critical speed a small motion decays, above it it grows until the flanges stop it. That speed is
the one of the linear theory with creep forces, gravitational stiffness and gyroscopic moments.

Sources: A. H. Wickens, Fundamentals of Rail Vehicle Dynamics (2003), chapter 2; J. J. Kalker,
Three-Dimensional Elastic Bodies in Rolling Contact (1990).
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

import jousto as jo
from jousto.mechanism import RailContact, RailContactSensor
from jousto.output.style import COLORS, STYLE

G = 9.81
RADIUS, HALF, CONE, PLAY = 0.46, 0.75, 0.05, 7e-3  # m; half the distance of the rails; 1; m
MASS, BOX, LOAD = 1500.0, 100.0, 60e3  # kg of wheelset and box, kg of the box, N on the box
ROLL, SPIN, YAW = 800.0, 120.0, 800.0  # kg m2, about x, y, z
K_Y, K_YAW = 2e6, 1e6  # N/m, N m, of the springs
MU = 0.3


def vehicle(speed: float, aside: float) -> tuple[jo.Mechanism, RailContact]:
    """Return the wheelset under its bogie, displaced aside, and its left contact."""
    at = (0, aside, RADIUS + 0.2e-3)
    ahead = {"position": at, "velocity": (speed, 0, 0)}
    axle = jo.RigidBody(
        *("axle", MASS - BOX, (ROLL - 20, SPIN, YAW - 20)),
        angular_velocity=(0, speed / RADIUS, 0),
        **ahead,
    )
    box = jo.RigidBody("box", BOX, (20, 20, 20), **ahead)
    frame = jo.RigidBody("frame", 1e6, (1e6,) * 3, position=(0, 0, RADIUS), velocity=(speed, 0, 0))
    track = jo.Prismatic("track", jo.ground.at((0, 0, RADIUS)), frame["origin"], axis=(1, 0, 0))
    bearing = jo.Revolute("bearing", box["origin"], axle["origin"], axis=(0, 1, 0))
    springs = jo.Bushing("springs", frame["origin"], box["origin"], (0, K_Y, 0, 0, 1e6, K_YAW))
    wheels = [
        RailContact(
            *(name, jo.ground.at((0, y, 0)), axle.at((0, y, 0)), RADIUS, -CONE * np.sign(y)),
            mu=MU,
            play=PLAY,
            damping=1.0,
            axle=(0, 1, 0),
        )
        for name, y in (("left", HALF), ("right", -HALF))
    ]
    sensors = [
        RailContactSensor(f"{w.name} {p}", w, p) for w in wheels for p in ("tread", "flange")
    ]
    load = jo.Force("load", box["origin"], (0, 0, -LOAD))
    place = jo.PositionSensor("place", axle["origin"])
    bodies = axle, box, frame, track, bearing
    return (
        jo.Mechanism(*bodies, springs, *wheels, *sensors, load, place, jo.Gravity((0, 0, -G))),
        wheels[0],
    )


def system_matrix(speed: float, wheel: RailContact) -> NDArray[np.float64]:
    """Return the matrix of (y, yaw, y', yaw') of small motions, contacts at b on both sides."""
    patch, weight = wheel.tread_patch, MASS * G + LOAD
    C, shear = patch.coefficients, wheel.E / (2 * (1 + wheel.nu))
    ab = patch.scale.a * patch.scale.b * (weight / 2) ** (2 / 3)
    r, b = RADIUS + CONE**2 * wheel.head, HALF - CONE * wheel.head
    k = CONE / (HALF - CONE * (RADIUS + wheel.head))  # roll over displacement
    # the cones spin on the rails, which takes a share e of the friction: slopes of the saturation
    e = shear * ab**1.5 * C.C23 * CONE / r / (MU * weight / 2)
    f11 = shear * ab * C.C11 * (1 - e / 3 + e * e / 27)
    slope = 1 - 2 * e / 3 + e * e / 9
    f22, f23 = shear * ab * C.C22 * slope, shear * ab**1.5 * C.C23 * slope
    side, gyro = 1 + r * k, SPIN * speed / r * k
    gravity = weight * (2 * k + k * k * (RADIUS + wheel.head))
    A = np.zeros((4, 4))
    A[0, 2] = A[1, 3] = 1.0
    A[2] = -gravity - K_Y, 2 * f22 * side, -2 * f22 * side**2 / speed, gyro - 2 * f23 * side / speed
    A[3, :2] = -2 * f11 * b * k * HALF / r, weight * CONE * b - 2 * f23 - K_YAW
    A[3, 2:] = 2 * f23 * side / speed - gyro, -2 * f11 * b * b / speed
    return A / np.array([[1.0], [1.0], [MASS + ROLL * k * k], [YAW]])


def run_at(speed: float, aside: float, time: float) -> jo.Solution:
    """Return a run of the wheelset at a speed."""
    mechanism, _ = vehicle(speed, aside)
    return jo.simulate(jo.compile(mechanism), time, solver=jo.RK4(2e-4), output_step=5e-3)


def growth_of(run: jo.Solution) -> float:
    """Return the growth rate of a small motion, 1/s: a fit of two exponentials."""
    y = run["place"][run.time > 0.3, 1]
    p, q = np.linalg.lstsq(np.stack([y[4:-4], y[:-8]], axis=1), y[8:], rcond=None)[0]
    return float(np.log(np.abs(np.roots([1, -p, -q])).max()) / (4 * 5e-3))


def draw(runs: dict[str, jo.Solution], path: Path) -> None:
    """Draw the motion across the track, and the forces of the flanges."""
    with plt.rc_context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
        for color, (label, run) in zip(COLORS, runs.items(), strict=False):
            left.plot(run.time, 1e3 * run["place"][:, 1], color=color, label=label)
        last = list(runs.values())[-1]
        for color, side in zip(COLORS, ("left flange", "right flange"), strict=False):
            right.plot(last.time, 1e-3 * last[side][:, 0], color=color, label=side)
        left.hlines([1e3 * PLAY, -1e3 * PLAY], 0.0, 4.0, color="0.6", lw=0.8)
        left.set(xlabel="time (s)", ylabel="across (mm)", title="The wheelset")
        right.set(xlabel="time (s)", ylabel="kN", title="Load of the flanges above it")
        left.legend()
        right.legend()
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Run below and above the critical speed; return 0 if theory and runs agree."""
    out.mkdir(parents=True, exist_ok=True)
    _, wheel = vehicle(10.0, 0.0)
    growth = lambda v: np.linalg.eigvals(system_matrix(v, wheel)).real.max()  # noqa: E731
    want = brentq(growth, 20.0, 150.0)  # m/s, from which on a motion grows
    speeds = [0.95 * want, 1.05 * want]
    rates = [growth_of(run_at(v, 1e-5, 1.5)) for v in speeds]
    found = float(np.interp(0.0, rates, speeds))
    print(f"critical speed {3.6 * found:.1f} km/h, linear theory {3.6 * want:.1f} km/h")

    runs = {
        f"{3.6 * share * want:.0f} km/h": run_at(share * want, 3e-3, 4.0) for share in (0.85, 1.3)
    }
    calm, hunting = runs.values()
    late = hunting.time > 3.0
    y = np.abs(hunting["place"][late, 1])
    hit = max(hunting[f"{side} flange"][late, 0].max() for side in ("left", "right"))
    print(f"hunts by {1e3 * y.max():.1f} mm, play {1e3 * PLAY:.0f} mm, flange {1e-3 * hit:.0f} kN")
    rest = np.abs(calm["place"][calm.time > 3.0, 1]).max()
    print(f"below it {1e3 * rest:.3f} mm are left of 3 mm")
    draw(runs, out / "wheelset_hunting.png")
    good = abs(found / want - 1) < 0.01 and PLAY < y.max() < 1.2 * PLAY and hit > 0 and rest < 2e-4
    print("it hunts as it should" if good else "THE WHEELSET IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
