"""Factors that generalised alpha keeps over many steps change its cost, not its result."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import jousto as jo
from natural.gallery import MACHINES
from verification import iftomm
from verification.mechanisms import march, orders

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")

Array = np.ndarray
Loop = tuple[Callable[[], jo.Mechanism], float, float, Any]

# published loops: mechanism, duration and longest step, s
LOOPS: dict[str, Loop] = {
    "Bricard": (iftomm.bricard, 2.0, 4e-3, None),
    "four-bars": (lambda: iftomm.four_bars(2), 1.0, 4e-3, None),
    "spatial slider-crank": (iftomm.spatial_slider_crank, 0.5, 2e-3, None),
    "governor": (iftomm.governor, 0.2, 2e-3, None),
}
# those of the examples, without the two whose friction sticks: a motion with kinks has no order
GALLERY: tuple[Any, ...] = (
    "crane.yaml",
    "crane_live.yaml",
    "four_bar.yaml",
    pytest.param("link_arm.yaml", marks=pytest.mark.slow),  # its meshes take a minute
    "robot.yaml",
    "slider_crank.yaml",
    "crane_boom",
    "crane_drive",
    "lcd_robot, frictionless",
    "portal_frame",
    "robot_arm_life",
    "robot_hose, bare",
    "rod_at_speed",
    "squeezer",
)
FAST = ("crane_boom", "rod_at_speed")  # whose modes ask for shorter steps
# drives with kinks, and modes that the steps do not resolve: the order is that of the exact tangent
ROUGH = ("crane_live.yaml", "crane_drive", "portal_frame")


def loop(name: str) -> Loop:
    if name in LOOPS:
        return LOOPS[name]
    shown = MACHINES[name]
    step = shown.step / 2 if name in FAST else shown.step
    return shown.machine, shown.t_end, step, shown.begin


def motion(model: jo.Model, duration: float, step: float, begin: Any, **options: Any) -> Array:
    """Positions and velocities of all bodies at ten instants, (10, 2, n, 3)."""
    steps = round(duration / 10 / step)
    solver = jo.GeneralizedAlpha(duration / 10 / steps, **options)
    start = {} if begin is None else {"state": begin(model)}
    run = jo.simulate(model, duration, solver=solver, output_step=duration / 10, **start)
    R = [run.q[1:, b.iq : b.iq + 3] for b in model.bodies]
    V = [run.v[1:, b.iv : b.iv + 3] for b in model.bodies]
    return np.stack([np.stack(R, axis=1), np.stack(V, axis=1)], axis=1)


@pytest.mark.parametrize("name", [*LOOPS, *GALLERY])
def test_loops_converge_at_order_2_with_the_error_of_the_exact_tangent(name):
    make, duration, step, begin = loop(name)
    model = jo.compile(make(), core="maximal")
    exact = motion(model, duration, step / 16, begin, tangent="exact", tolerance=1e-12)
    far: dict[str, list[Array]] = {}
    for tangent in ("exact", "modified"):
        runs = [motion(model, duration, step / k, begin, tangent=tangent) for k in (2, 4)]
        far[tangent] = [np.abs(run - exact).max(axis=(0, 2, 3)) for run in runs]
    for part in (0, 1):  # positions, velocities
        errors = {tangent: [float(e[part]) for e in far[tangent]] for tangent in far}
        if name not in ROUGH:  # 2.1 is what order 2 looks like beside a reference of a quarter
            assert orders(errors["modified"])[0] == pytest.approx(2.1, abs=0.25), errors
        np.testing.assert_allclose(errors["modified"], errors["exact"], rtol=0.1)


@pytest.mark.parametrize("rho", [0.8, 1.0])
def test_bricard_keeps_its_energy_as_with_the_exact_tangent(rho):
    model = jo.compile(iftomm.bricard(), core="maximal")
    drift = {}
    for tangent in ("exact", "modified"):
        run = march(model, jo.GeneralizedAlpha(1e-3, rho=rho, tangent=tangent), 5.0, 0.05)
        drift[tangent] = float(np.abs(run.balance).max())
    assert drift["exact"] < 5e-6  # J, of 19 J exchanged
    assert drift["modified"] == pytest.approx(drift["exact"], rel=0.1)


@pytest.mark.parametrize("name", [*LOOPS, "squeezer"])
def test_rows_of_results_leave_the_motion_alone(name):
    """A row has multipliers of least norm from an evaluation of its own."""
    make, duration, step, begin = loop(name)
    model = jo.compile(make(), core="maximal")
    solver = jo.GeneralizedAlpha(step / 4, tolerance=1e-10)
    ends = [
        jo.simulate(model, duration / 5, solver=solver, output_step=rows).q[-1]
        for rows in (None, duration / 5)
    ]
    # Newton's tolerance is 1e-10 of the accelerations of a step
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-10)
