"""The moving frame comes to the engine with order 2: six machines, reactions and stress too."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.natural.moving_frame import moving_frame
from verification import iftomm, mechanisms

ROBOT = Path(__file__).parents[2] / "examples" / "robot.yaml"
OUTPUTS = 10
Errors = dict[str, list[float]]


def double_pendulum() -> jo.Mechanism:
    """Two bars in space on a ball and a skew hinge."""
    upper = jo.RigidBody(
        "upper",
        2.0,
        (0.01, 0.1, 0.1),
        center=(0.4, 0.02, 0),
        angular_velocity=(0, 1.0, 2.0),
        markers={"elbow": (0.8, 0, 0)},
    )
    lower = jo.RigidBody(
        "lower",
        1.0,
        (0.005, 0.04, 0.04),
        center=(0.3, 0, 0.03),
        position=(0.8, 0, 0),
        velocity=(0, 1.6, -0.8),
        angular_velocity=(0, 1.0, 2.0),
    )
    ball = jo.Spherical("ball", jo.ground["origin"], upper["origin"])
    hinge = jo.Revolute("hinge", upper["elbow"], lower["origin"], axis=(0, 1, 1))
    end = jo.PositionSensor("end", lower.at((0.6, 0, 0)))
    return jo.Mechanism(upper, lower, ball, hinge, jo.Gravity((0, 0, -9.81)), end)


def chain() -> jo.Mechanism:
    """Three soft beams in space on revolute joints, with stress in the first and in the last."""
    machine = mechanisms.chain("revolute")
    first, last = (b for b in machine.bodies if b.name in ("rod 1", "rod 3"))
    assert isinstance(first, jo.FlexibleBody)
    assert isinstance(last, jo.FlexibleBody)
    stresses = (
        jo.StressSensor("stress 1", first, ("e2.a.top", "e2.a.left")),
        jo.StressSensor("stress 3", last, ("e3.a.top", "e3.a.left")),
    )
    return jo.Mechanism(*machine.items, *stresses, name="flexible chain")


# machine, length and longest step, s; the engine's step that is taken for the truth
MACHINES: dict[str, tuple[Callable[[], jo.Mechanism], float, float, float]] = {
    "slider-crank": (iftomm.spatial_slider_crank, 0.4, 8e-3, 1e-4),
    "four-bar": (lambda: iftomm.four_bars(1), 0.4, 8e-3, 1e-4),
    "Bricard": (iftomm.bricard, 0.4, 8e-3, 1e-4),
    "double pendulum": (double_pendulum, 0.4, 8e-3, 1e-4),
    "flexible chain": (chain, 0.02, 2e-4, 1e-5),
    "robot": (lambda: jo.read_model(ROBOT).mechanism, 0.05, 5e-4, 2e-5),
}
LONG = ("flexible chain", "robot", "Bricard", "double pendulum")
RIGID = ("slider-crank", "four-bar", "Bricard", "double pendulum")
HALVINGS = 4


def steps(name: str) -> list[float]:
    """Steps, s, each half of the one before."""
    return [MACHINES[name][2] / 2**k for k in range(HALVINGS)]


@cache
def errors(name: str) -> Errors:
    """Largest difference to the engine of every kind of reading at each step, over its size.

    All joints are read; reactions that are not unique are left out.
    """
    make, t_end, _, least = MACHINES[name]
    bare = make()
    read = {sensor.reading.of for sensor in bare.sensors if sensor.reading.kind == "reaction"}
    more = [jo.ReactionSensor(f"at {j.name}", j) for j in bare.joints if j not in read]
    machine = jo.Mechanism(*bare.items, *more, name=name)
    run = jo.simulate(jo.compile(machine), t_end, solver=jo.RK4(least), output_step=t_end / OUTPUTS)
    kinds = {s.name: s.reading.kind for s in machine.sensors}
    out: Errors = {}
    for h in steps(name):
        other = moving_frame(
            machine, t_end, step=h, output_step=t_end / OUTPUTS, state=run.state(0.0)
        )
        worst: dict[str, float] = {}
        for sensor, kind in kinds.items():
            if "not unique" in run.about(sensor)["description"]:
                continue
            size = float(np.abs(run[sensor]).max())
            off = float(np.abs(other[sensor] - run[sensor]).max()) / size if size > 1e-9 else 0.0
            worst[kind] = max(worst.get(kind, 0.0), off)
        for kind, off in worst.items():
            out.setdefault(kind, []).append(off)
    return out


@pytest.mark.filterwarnings("ignore:.*redundant")
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow) if n in LONG else n for n in MACHINES]
)
def test_differences_fall_with_order_two(name: str) -> None:
    """Over the last two halvings; 0.15 is what terms of higher order leave at these steps."""
    found = errors(name)
    more = {"flexible chain": {"reaction", "stress"}, "robot": {"reaction", "multiplier"}}
    assert set(found) >= {"position"} | more.get(name, set())
    for kind, e in found.items():
        orders = np.log2(np.array(e[:-1]) / e[1:])
        np.testing.assert_allclose(orders[-2:], 2.0, atol=0.15, err_msg=kind)


@pytest.mark.filterwarnings("ignore:.*redundant")
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=pytest.mark.slow) if n in LONG else n
        for n in MACHINES
        if n != "robot"  # it starts from rest: its balance is rounding in so short a time
    ],
)
def test_steps_are_cheap_closed_and_keep_energy(name: str) -> None:
    """Iterations fall with the step, gaps are rounding, and the balance misses h^2."""
    make, t_end, longest, least = MACHINES[name]
    mechanism = make()
    start = jo.simulate(jo.compile(mechanism), least, solver=jo.RK4(least)).state(0.0)
    runs = [moving_frame(mechanism, t_end, step=longest / k, state=start) for k in (1, 2, 4)]
    iterations = [run.iterations[1:].mean() for run in runs]
    assert iterations[2] <= iterations[1] <= iterations[0] < 4.5
    # constraints close to a thousandth of the tolerance of the iteration, of the machine's size
    assert all(run.position_residual.max() < 1e-11 * max(1.0, mechanism.size) for run in runs)
    missed = [np.abs(run.energy.error).max() for run in runs]
    assert np.log2(missed[0] / missed[2]) / 2 == pytest.approx(2.0, abs=0.3)
