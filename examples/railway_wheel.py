"""A rail wheel carries its load along a rail: contact pressure, stress below it, and life.

A wheel of 0.46 m radius rolls on a rail head of 0.3 m radius at 30 m/s. The frame of the vehicle
stands on it with a spring and a damper and bounces after a bump, so that the wheel carries a load
that changes from turn to turn. The contact is elliptic: its stiffness, its pressure and its half
axes follow from Hertz's theory. Every turn, each point of the tread passes the contact once; the
criterion of Findley gives the damage below the surface, that of Dang Van whether it is safe from
fatigue at all.

Sources: K. L. Johnson, Contact Mechanics (1985), chapter 4; S. Timoshenko and J. N. Goodier, Theory
of Elasticity, section on the pressure between two bodies in contact, which treats a wheel on a
rail.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.fatigue import DangVan, Findley, hertz_point, rolling_life, rolling_passes
from jousto.mechanism import Contact, ContactPressureSensor, HalfSpace, PowerLaw, Torus
from jousto.mechanism.contacts.hertz import point_scale
from jousto.output.style import STYLE

G = 9.81
RADIUS, HEAD = 0.46, 0.3  # m, of the wheel and of the head of the rail
WHEEL, BOX, FRAME = 500.0, 60.0, 7600.0  # kg
WEIGHT = (WHEEL + BOX + FRAME) * G
SPEED, BUMP = 30.0, 0.4  # m/s, of the vehicle, and of the frame upwards after the bump
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
MODULUS = STEEL.E / (2 * (1 - STEEL.nu**2))  # E* of steel on steel, Pa
FATIGUE = jo.SN(S_D=330e6, N_D=2e6, k=9)


def vehicle() -> jo.Mechanism:
    """Return the wheel on its rail under a frame on a spring."""
    # the stiffness of the elliptic contact: its approach under 1 N is that of Hertz
    scale = point_scale(MODULUS, (RADIUS, HEAD))
    law = PowerLaw(scale.approach**-1.5, 1.5, restitution=0.5)
    at = (0, 0, RADIUS - scale.approach * WEIGHT ** (2 / 3))
    ahead = {"position": at, "velocity": (SPEED, 0, 0)}
    carriage = jo.RigidBody("carriage", 1.0, (1, 1, 1), **ahead)
    box = jo.RigidBody("box", BOX, (2, 2, 2), **ahead)
    spin = (0, SPEED / RADIUS, 0)
    wheel = jo.RigidBody("wheel", WHEEL, (35, 60, 35), angular_velocity=spin, **ahead)
    frame = jo.RigidBody("frame", FRAME, (900,) * 3, position=at, velocity=(SPEED, 0, BUMP))
    track = jo.Prismatic("track", jo.ground.at(at), carriage["origin"], axis=(1, 0, 0))
    guides = [
        jo.Prismatic(f"guide of {one.name}", carriage["origin"], one["origin"], axis=(0, 0, 1))
        for one in (frame, box)
    ]
    axle = jo.Revolute("axle", box["origin"], wheel["origin"], axis=(0, 1, 0))
    rise = jo.Displacement(box["origin"], frame["origin"], axis="z")
    spring = jo.Spring("spring", rise, stiffness=1.2e6, damping=2e4, free=FRAME * G / 1.2e6)
    # a torus on a plane has the relative radii of the wheel on its rail; its axis is z of the rim
    rim = wheel.at((0, 0, 0), axes=[(1, 0, 0), (0, 0, -1), (0, 1, 0)])
    tread = Torus(RADIUS - HEAD, HEAD)
    rail = jo.ground["origin"], HalfSpace()
    contact = Contact("contact", *rail, rim, tread, law, mu_kinetic=0.3, mu_static=0.35)
    sensors = [
        jo.ForceSensor("force", contact),
        ContactPressureSensor("pressure", contact, modulus=MODULUS),
        jo.CoordinateSensor("turn", axle.angle),
    ]
    bodies = carriage, frame, box, wheel, track, *guides, axle
    return jo.Mechanism(*bodies, spring, contact, *sensors, jo.Gravity((0, 0, -G)))


def draw(run: jo.Solution, life: jo.fatigue.RollingLife, path: Path) -> None:
    """Draw the load and the pressure over time, and the damage over the depth."""
    with plt.rc_context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
        left.plot(run.time, 1e-3 * run["force"][:, 2], label="wheel load (kN)")
        left.plot(run.time, 1e-7 * run["pressure"][:, 0], label="largest pressure (10 MPa)")
        left.set(xlabel="time (s)")
        left.legend()
        right.plot(1e3 * life.depth, life.damage / life.passes)
        right.set(xlabel="depth (mm)", ylabel="damage of a turn", xlim=(0, 12))
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Roll for 3 s; return 0 if load, pressure and rolling are those of theory."""
    out.mkdir(parents=True, exist_ok=True)
    run = jo.simulate(jo.compile(vehicle()), 3.0, solver=jo.ROS2(1e-3), output_step=1e-3)
    N, pressure = run["force"][:, 2], run["pressure"]
    angle = run["turn"][:, 0]

    # every turn is one pass of a point of the tread, under the pressure of its instant
    passes = rolling_passes(angle, pressure[:, 0], at=np.pi)
    still = hertz_point(WEIGHT, radii=(RADIUS, np.inf), other=(np.inf, HEAD), material=STEEL)
    shear, below = still.largest_shear()
    life = rolling_life(still, None, Findley(0.25), FATIGUE, pressures=passes)
    criterion = DangVan.of(torsion=245e6, bending=400e6)
    safe = rolling_life(still, None, criterion, pressures=passes)

    print(still)
    print(f"largest shear stress {1e-6 * shear:.0f} MPa at a depth of {1e3 * below:.2f} mm")
    print(f"wheel load {1e-3 * N.min():.1f} to {1e-3 * N.max():.1f} kN in {len(passes)} turns")
    print(f"pressure {1e-6 * pressure[:, 0].min():.0f} to {1e-6 * pressure[:, 0].max():.0f} MPa")
    print(life)
    print(f"{life.life * 2 * np.pi * RADIUS / 1e3:.0f} km; Dang Van: safety {safe.safety:.2f}")
    draw(run, life, out / "railway_wheel.png")

    want = np.array([still.p0, still.a, still.b]) * (N[:, None] / WEIGHT) ** (1 / 3)
    off = np.abs(pressure / want - 1).max()
    rolls = abs(abs(angle[-1] - angle[0]) * RADIUS / (SPEED * run.time[-1]) - 1)
    carries = abs(N[run.time > 1.0].mean() / WEIGHT - 1)
    print(f"off Hertz {off:.1e}, off rolling {rolls:.1e}, mean load off the weight {carries:.1e}")
    good = off < 1e-4 and rolls < 1e-3 and carries < 5e-3
    print("the wheel carries its load" if good else "THE WHEEL IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
