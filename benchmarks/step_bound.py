"""Operations of the longest step beside the median step, of machines whose joints stick and slip.

    step_bound.py [short]

Each step is counted by the engine with a scalar that counts (flops.py): the result does not depend
on the computer. With ``events="located"`` a step is repeated until it ends at a transition; with
``events="step"`` its work is bounded.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

import jousto as jo
from flops import Counter
from friction import pendulum

STEPS = 10_000
LAW = jo.mechanism.StickSlip()


def belt() -> jo.Mechanism:
    """A block that a spring holds on a moving belt: it sticks and slips for ever."""
    speed, origin, x = 0.1, jo.ground["origin"], (1, 0, 0)
    band = jo.RigidBody("band", 1.0, (1, 1, 1), velocity=(speed, 0, 0))
    block = jo.RigidBody("block", 1.0, (1, 1, 1), velocity=(speed, 0, 0))
    frame = jo.Prismatic("frame", origin, band["origin"], axis=x)
    contact = jo.Prismatic("contact", band["origin"], block["origin"], axis=x)
    way = jo.Displacement(origin, block["origin"], "x")
    return jo.Mechanism(
        *(band, block, frame, contact, jo.Gravity((0, 0, -9.81))),
        jo.Drive("motor", frame.displacement, jo.Ramp(-1, 99, -speed, 99 * speed)),
        jo.Spring("spring", way, 100.0, free=0.0),
        jo.Friction("rub", contact, 0.2, 0.4, law=LAW),
    )


def cases() -> dict[str, Callable[[], Any]]:
    """Return what compiles each machine."""
    return {
        "block on a belt": lambda: jo.compile(belt()),
        "chain of 5 links, joints": lambda: jo.compile(pendulum(5, LAW), core="joint"),
        "chain of 5 links, bodies": lambda: jo.compile(pendulum(5, LAW), core="maximal"),
    }


def main() -> None:
    """Count and print."""
    warnings.simplefilter("ignore")
    short = "short" in sys.argv
    counter, steps = Counter(), STEPS // 50 if short else STEPS
    print(f"operations of {steps} steps of 1 ms{'':13s}{'located':>32s}{'at step ends':>32s}")
    print(f"{'':40s}" + 2 * f"{'median':>10s}{'worst':>12s}{'ratio':>10s}")
    for name, compiled in list(cases().items())[: 1 if short else None]:
        for method in (jo.RK4, jo.ROS2, jo.GeneralizedAlpha):
            print(f"{name + ', ' + method.__name__:40s}", end="")
            for events in ("located", "step"):
                count = counter.each_step(compiled(), method(1e-3, events=events), steps)
                median, worst = np.median(count), count[1:].max()
                print(f"{median:10.0f}{worst:12.0f}{worst / median:10.2f}", end="")
            print(flush=True)


if __name__ == "__main__":
    main()
