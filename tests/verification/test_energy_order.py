"""Energy and state errors fall at the nominal order of the method.

This is the test that finds a wrong sign: position, velocity, acceleration and virtual work that do
not come from one formula leave an energy error that no step size removes (Rantalainen 2007,
chapters 3 and 4; Hairer, Norsett, Wanner, *Solving ODEs I*, II.1 for the observed order).
"""

from __future__ import annotations

from functools import cache, partial

import numpy as np
import pytest

import jousto as jo
from verification.mechanisms import SOFT, STEEL, chain, four_bar, loop, march, orders, rod

T_END = 0.2


def pendulum(material=SOFT):
    arm = jo.FlexibleBody("arm", rod(material), orientation=jo.Rotate((1, 1, 0), degrees=30.0))
    pivot = jo.Spherical("pivot", jo.ground["origin"], arm["start"])
    return jo.Mechanism(arm, pivot, jo.Gravity((0, -9.81, 0)))


MECHANISMS = {
    "pendulum": pendulum,
    "revolute chain": partial(chain, "revolute"),
    "spherical chain": partial(chain, "spherical"),
    "fixed joint": partial(chain, "fixed"),
    "loads": partial(chain, "fixed", loads=True),
    "damped": partial(chain, "revolute", damping=0.02),
    "damped, loads": partial(chain, "spherical", damping=0.02, loads=True),
    "loop": loop,
    "four-bar": partial(four_bar, size=2.4),  # its fastest mode is at 245 Hz
}


@cache
def model(name):
    return jo.compile(MECHANISMS[name]())


@cache
def reference(name):
    # RK4 with a step 4 times below the finest of the tests: its error is 256 times below theirs
    return march(model(name), jo.RK4(step=T_END / 8192), T_END, T_END / 16)


@pytest.mark.parametrize("projection", [True, False], ids=["projected", "not projected"])
@pytest.mark.parametrize(
    ("method", "steps"),
    [(jo.RK4, (1024, 2048)), (jo.ROS2, (4096, 8192))],
    ids=["RK4", "ROS2"],
)
@pytest.mark.parametrize("name", MECHANISMS)
def test_energy_and_state_errors_fall_at_the_order_of_the_method(name, method, steps, projection):
    runs = [
        march(model(name), method(step=T_END / n, projection=projection), T_END, T_END / 16)
        for n in steps
    ]
    exact = reference(name)
    states = [float(np.abs(run.state - exact.state).max()) for run in runs]
    energies = [float(np.abs(run.balance).max()) for run in runs]
    # 0.5: the highest mode (320 Hz) is resolved with 16 steps a period or more, so that the next
    # term of the error expansion is still seen
    assert abs(orders(states)[-1] - method.order) < 0.5, (states, orders(states))
    # RK4 dissipates vibration with order 5, so that its energy may fall faster than its state
    assert orders(energies)[-1] > method.order - 0.3, (energies, orders(energies))
    exchanged = np.ptp(exact.energy[:, :3], axis=0).max()
    assert energies[-1] < 1e-4 * exchanged


def test_the_loop_needs_fill():
    # four bodies in a ring: their joints form a cycle of four, which has one fill block
    assert model("loop").elimination.fill == 1


STEEL_MECHANISMS = {
    "pendulum": partial(pendulum, STEEL),
    "revolute chain": partial(chain, "revolute", material=STEEL),
    "spherical chain": partial(chain, "spherical", material=STEEL),
    "fixed joint": partial(chain, "fixed", material=STEEL),
    "loop": partial(loop, STEEL),
}


@pytest.mark.parametrize("solver", [jo.RK4(step=1e-4), jo.ROS2(step=1e-3)], ids=["RK4", "ROS2"])
@pytest.mark.parametrize("name", STEEL_MECHANISMS)
def test_joints_stay_closed_for_ten_seconds(name, solver):
    # required: 1e-10 m and 1e-9 m/s with projection, at steps a user would take
    steel = jo.compile(STEEL_MECHANISMS[name]())
    run = march(steel, solver, 10.0, 0.1)
    assert len(run.time) == 101
    assert run.residuals[:, 0].max() < 1e-10
    assert run.residuals[:, 1].max() < 1e-9
    # rotation vectors are stepped on the group: the norms stay at round-off
    for body in steel.bodies:
        e = run.q[:, body.iq + 3 : body.iq + 7]
        np.testing.assert_allclose(np.linalg.norm(e, axis=1), 1.0, rtol=0, atol=1e-14)


def test_without_projection_the_joints_drift_apart():
    # the reason for the projection, and the proof that the residual is not zero by construction
    run = march(model("revolute chain"), jo.ROS2(step=1e-3, projection=False), 2.0, 0.1)
    assert run.residuals[-1, 0] > 1e-8


def test_baumgarte_bounds_the_drift():
    # Baumgarte 1972; alpha = beta = 1 / (10 h). Only fifth-order defects per step are fed in
    step = 5e-4
    free = march(model("revolute chain"), jo.RK4(step=step, projection=False), 4.0, 0.1)
    held = march(
        model("revolute chain"),
        jo.RK4(
            step=step, projection=False, baumgarte=jo.simulation.Baumgarte(0.1 / step, 0.1 / step)
        ),
        4.0,
        0.1,
    )
    assert held.residuals[-1, 0] < 0.05 * free.residuals[-1, 0]
    assert held.residuals[:, 1].max() < free.residuals[:, 1].max()


@pytest.mark.parametrize("solver", [jo.RK4(step=1e-4), jo.ROS2(step=1e-4)], ids=["RK4", "ROS2"])
def test_damping_only_takes_energy(solver):
    name = "damped"
    run = march(model(name), solver, 0.5, 0.5 / 500)
    total = run.energy[:, :3].sum(axis=1)
    lost = -np.diff(total)
    scale = np.ptp(total)
    # monotonic up to the method's own error in a millisecond
    assert lost.min() > -1e-5 * scale
    assert np.diff(run.energy[:, 4]).min() >= 0.0
    assert run.energy[-1, 4] > 0.1  # J: something was lost
    assert np.abs(run.balance).max() < 1e-3 * run.energy[-1, 4]


def test_dissipated_energy_is_the_integral_of_the_damping_power():
    # independent of the engine's bookkeeping: int sum_j 2 zeta omega_j p'_j^2 dt by Simpson's rule
    m = model("damped")
    run = march(m, jo.RK4(step=1e-4), 0.2, 1e-4)
    power = np.zeros(len(run.time))
    for body in m.bodies:
        pd = run.v[:, body.iv + 6 : body.iv + 6 + body.n]
        power += pd**2 @ (2 * 0.02 * np.sqrt(body.K))
    weights = np.ones(len(run.time))
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    integral = float(weights @ power) * 1e-4 / 3
    # order 4 of both, 30 points in a period of the highest mode
    np.testing.assert_allclose(run.energy[-1, 4], integral, rtol=1e-4)
