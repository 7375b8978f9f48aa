"""A million steps: joints stay closed, energy stays bounded, memory does not grow.

Required: position residual below 1e-10 m and velocity residual below 1e-9 m/s over 1e6 steps with
projection. The energy bounds are those of the method's dissipation, stated at each test.
"""

from __future__ import annotations

import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from verification.mechanisms import SOFT, STEEL, chain, four_bar, march, rod

pytestmark = pytest.mark.slow

MILLION = 1_000_000


def pendulum(material):
    arm = jo.FlexibleBody("arm", rod(material), orientation=jo.Rotate((1, 1, 0), degrees=30.0))
    pivot = jo.Spherical("pivot", jo.ground["origin"], arm["start"])
    return jo.Mechanism(arm, pivot, jo.Gravity((0, -9.81, 0)), jo.PositionSensor("tip", arm["end"]))


CASES = {
    # name: mechanism, solver, energy drift allowed as a share of the exchanged energy
    "soft pendulum, RK4": (partial(pendulum, SOFT), jo.RK4(step=1e-4), 1e-4),
    "steel pendulum, ROS2": (partial(pendulum, STEEL), jo.ROS2(step=1e-3), 0.05),
    "steel chain, RK4": (partial(chain, "spherical", material=STEEL), jo.RK4(step=5e-5), 1e-3),
    # chaotic: starts 1e-12 apart lose 0.5e-6 to 5.8e-6 of it in 50 s, at half the step 4e-8
    "soft four-bar, RK4": (four_bar, jo.RK4(step=5e-5), 2e-5),
    "steel four-bar, ROS2": (partial(four_bar, STEEL), jo.ROS2(step=1e-4), 1e-4),
    # chaotic: it lashes, and what its modes take then above 1/h is damped out
    "steel chain, ROS2": (partial(chain, "revolute", material=STEEL), jo.ROS2(step=1e-4), 0.5),
}


@pytest.mark.parametrize("case", CASES)
def test_a_million_steps(case):
    mechanism, solver, drift = CASES[case]
    run = march(jo.compile(mechanism()), solver, MILLION * solver.step, 1000 * solver.step)
    assert len(run.time) == 1001
    assert run.residuals[:, 0].max() < 1e-10
    assert run.residuals[:, 1].max() < 1e-9
    # RK4 and ROS2 only lose energy in the vibration they cannot resolve; what is exchanged
    # between kinetic and potential energy is the measure
    exchanged = np.ptp(run.energy[:, 2])
    assert np.abs(run.balance).max() < drift * exchanged, run.balance[::100] / exchanged


SCRIPT = """
import resource, sys
sys.path[:0] = {paths!r}
import jousto as jo
from verification.test_long_run import SOFT, pendulum
model = jo.compile(pendulum(SOFT))
jo.simulate(model, 1.0, solver=jo.ROS2(step=1e-3), path="warm.h5")
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
run = jo.simulate(model, {steps} * 1e-3, solver=jo.ROS2(step=1e-3), path="run.h5")
assert run.nt == {steps} + 1
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def peak_memory(steps, folder):
    """Peak resident memory (bytes) of a process that runs and stores this many steps."""
    paths = [str(Path(jo.__file__).parents[1]), str(Path(__file__).parents[1])]
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT.format(paths=paths, steps=steps)],
        cwd=folder,
        check=True,
        capture_output=True,
        text=True,
    )
    return int(done.stdout) * (1 if sys.platform == "darwin" else 1024)


def test_memory_does_not_grow_with_the_length_of_the_run(tmp_path):
    # every step is stored: 1e6 rows of 46 numbers are 370 MB in the file
    pytest.importorskip("resource")
    short, long = (peak_memory(n, tmp_path) for n in (100_000, MILLION))
    # 8 MB: the noise of the allocator; one number per step would be 7 MB
    assert long - short < 8e6, (short, long)
