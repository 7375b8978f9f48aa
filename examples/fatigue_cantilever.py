"""Life of a bracket: two events, ten thousand lifts and fifty stops, with the cycles between them.

The force at the tip is slow, so that the stress at the root is ``F L / W`` and its cycles can be
counted in the force itself. Stops press downwards, lifts upwards: together they make cycles that
neither event has alone.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import jousto as jo

LENGTH, WIDTH, HEIGHT = 1.2, 0.04, 0.06  # m
W = WIDTH * HEIGHT**2 / 6  # m3, section modulus
TIME = np.linspace(0.0, 4.0, 401)
RISE = np.clip(TIME, 0.0, 1.0)
RAMP = RISE**3 * (10 - 15 * RISE + 6 * RISE**2)  # smooth: a kink would make it ring

LIFT = 1800.0 * RAMP * (1.0 + 0.4 * np.sin(2 * np.pi * TIME))  # N, upwards, with a swinging load
STOP = -4200.0 * RAMP * np.exp(-((TIME - 2.0) ** 2) / 0.08)  # N, once
LIFTS, STOPS = 10_000, 50

# a machined bar of S355, least tensile strength 470 MPa, k = 5 on below the knee as 2 k - 1
CURVE = jo.fatigue.estimate_sn("S355", rule="haibach").with_factors(
    jo.fatigue.roughness_factor(25e-6, 470e6),
    jo.fatigue.size_factor(0.808 * np.sqrt(WIDTH * HEIGHT)),
)
MEAN = jo.fatigue.FKM.of("steel", S_u=470e6)


def bracket(force: np.ndarray, name: str) -> jo.Solution:
    """A bar along x, held at its start, with a force along z at its end."""
    part = jo.Part.beam(
        length=LENGTH,
        section=jo.Rectangle(WIDTH, HEIGHT),
        elements=6,
        material=jo.material("S355"),
    )
    reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=4))
    bar = jo.FlexibleBody("bar", reduced, damping=0.05)
    mechanism = jo.Mechanism(
        bar,
        jo.Fixed("wall", jo.ground["origin"], bar["start"]),
        jo.Force("load", bar["end"], (0.0, 0.0, 1.0), signal=jo.Table(TIME, force)),
        name=name,
    )
    return jo.simulate(jo.compile(mechanism), TIME[-1], solver=jo.ROS2(1e-3), output_step=5e-3)


def main(out: Path) -> int:
    """Simulate both events, count and draw; return 0 if damage is that of the force alone."""
    out.mkdir(parents=True, exist_ok=True)
    runs = {"lift": bracket(LIFT, "lift"), "stop": bracket(STOP, "stop")}
    repeats = {"lift": LIFTS, "stop": STOPS}
    print(CURVE)

    good = True
    for transitions in ("separate", "worst"):
        duty = jo.fatigue.DutyCycle(
            [(jo.stress_field(run, "bar"), repeats[name], name) for name, run in runs.items()],
            transitions=transitions,
        )
        found = jo.damage_field(duty, CURVE, criterion="s11", residue="repeat", mean=MEAN)
        # the upper side at the root: F upwards presses it together
        by_hand = jo.fatigue.DutyCycle(
            [(-LIFT * LENGTH / W, LIFTS), (-STOP * LENGTH / W, STOPS)], transitions=transitions
        ).cycles(residue="repeat")
        exact = jo.fatigue.damage(by_hand, CURVE, MEAN)
        D, _, safety = found.at("e1.a.top")
        good &= abs(D / exact - 1.0) < 0.01
        print(f"events {transitions:9s} damage at the root {D:.4e}, by hand {exact:.4e}")
        print(f"{'':16s} worst at {found.worst(1)[0]}, safety {found.safety.min():.2f} in stress")

    print(found)
    jo.plot(found, runs["lift"], view="xz", path=out / "fatigue_damage.png")
    jo.plot(found.cycles(duty), CURVE, mean=MEAN, path=out / "fatigue_cycles.png")
    print("the damage is that of the force" if good else "THE DAMAGE IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
