"""Every tableau: its order conditions, its stability, and its order against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import jousto as jo
from jousto.simulation.solvers.base import Staged, solvers
from jousto.simulation.solvers.rosenbrock import Rosenbrock

STAGED = [cls for cls in solvers() if issubclass(cls, Staged)]
ROSENBROCK = [cls for cls in STAGED if issubclass(cls, Rosenbrock)]
NAMES = {"ids": lambda x: getattr(x, "__name__", str(x))}


@pytest.mark.parametrize("cls", STAGED, **NAMES)
def test_conditions_of_the_order(cls):
    """Hairer, Wanner, *Solving Ordinary Differential Equations II* (1996), IV.7: of a W-method.

    Terms with the matrix vanish one by one, since it is not the Jacobian. It has the masses of
    each stage: from order 3 on that takes ``sum b_i c_i g_i = 0``, too.
    """
    x = cls().tableau
    one = np.ones(x.stages)
    c, g = x.A @ one, x.Gamma @ one
    conditions = {
        1: [x.b @ one - 1],
        2: [x.b @ c - 1 / 2, x.b @ g],
        3: [
            *(x.b @ c**2 - 1 / 3, x.b @ x.A @ c - 1 / 6),
            *(x.b @ x.A @ g, x.b @ x.Gamma @ c, x.b @ x.Gamma @ g, x.b @ (c * g)),
        ],
        4: [
            *(x.b @ c**3 - 1 / 4, x.b @ (c * (x.A @ c)) - 1 / 8),
            *(x.b @ x.A @ c**2 - 1 / 12, x.b @ x.A @ x.A @ c - 1 / 24),
        ],
    }
    for order in range(1, cls.order + 1):
        np.testing.assert_allclose(conditions[order], 0.0, atol=1e-15)
    higher = conditions.get(cls.order + 1, [x.b @ c**4 - 1 / 5])
    assert np.abs(higher).max() > 1e-3


@pytest.mark.parametrize("cls", ROSENBROCK, **NAMES)
def test_rosenbrock_methods_damp_all_modes(cls):
    """|R| <= 1 on the imaginary axis, and R = 0 at infinity: L-stable."""
    x = cls().tableau
    one, unit = np.ones(x.stages), np.eye(x.stages)

    def growth(z):
        return abs(1 + z * (x.b @ np.linalg.solve(unit - z * (x.A + x.Gamma), one)))

    assert max(growth(1j * y) for y in np.logspace(-3, 6, 2000)) <= 1.0 + 1e-12
    assert growth(-1e9) < 1e-6


def orders(errors):
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


def pendulum(core):
    rod = jo.RigidBody("rod", 2.0, (0.3, 0.3, 0.3), center=(0.7, 0, 0))
    pivot = jo.Revolute("pivot", jo.ground["origin"], rod["origin"], axis=(0, 0, 1))
    angle = jo.CoordinateSensor("angle", pivot.angle)
    return jo.compile(jo.Mechanism(rod, pivot, angle, jo.Gravity((0, -9.81, 0)), core=core))


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("cls", STAGED, **NAMES)
def test_order_on_a_pendulum(cls, core):
    """From rest at 90 degrees: sin(theta/2) = k sn(K - w t, k), k = sin(45 deg)."""
    inertia, moment = 0.3 + 2.0 * 0.7**2, 2.0 * 9.81 * 0.7
    m, w, end = 0.5, np.sqrt(moment / inertia), 2.0
    found = []
    for n in (100, 200, 400):
        run = jo.simulate(pendulum(core), end, solver=cls(end / n), output_step=0.1)
        theta = 2 * np.arcsin(np.sqrt(m) * ellipj(ellipk(m) - w * run.time, m)[0])
        found.append(np.abs(run["angle"][:, 0] + np.pi / 2 - theta).max())
    assert orders(found)[-1] > cls.order - 0.15, found


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")  # it moves freely
@pytest.mark.parametrize("cls", STAGED, **NAMES)
def test_order_on_a_free_top(cls):
    """A symmetric free body: its angular velocity goes round its axis at (A - C) w3 / A."""
    A, C, w1, w3, end = 1.0, 1.7, 2.0, 3.0, 2.0
    body = jo.RigidBody("top", 1.0, (A, A, C), angular_velocity=(w1, 0, w3))
    model = jo.compile(jo.Mechanism(body))
    found = []
    for n in (50, 100, 200):
        run = jo.simulate(model, end, solver=cls(end / n), output_step=0.1)
        phase = (A - C) / A * w3 * run.time
        exact = np.stack([w1 * np.cos(phase), -w1 * np.sin(phase), np.full(run.nt, w3)], axis=1)
        found.append(np.abs(run.v[:, 3:6] - exact).max())
    assert orders(found)[-1] > cls.order - 0.15, found


def errors(model, cls, end, counts, exact, state=None):
    """Largest errors of the positions and of the energy balance of runs with so many steps."""
    runs = [
        jo.simulate(model, end, solver=cls(end / n), output_step=end / 10, state=state)
        for n in counts
    ]
    return (
        [np.abs(run.q - exact.q).max() for run in runs],
        [np.abs(run.energy.error).max() for run in runs],
    )


def stiff_beam():
    """A flexible rod that swings on a hinge, with modes of 159 Hz to 2.4 kHz."""
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    part = jo.Part.beam(1.0, jo.Rectangle(0.03, 0.04), 8, steel)
    arm = jo.FlexibleBody("arm", jo.reduce(part, jo.CraigBampton(("start",), modes=6)))
    pivot = jo.Revolute("pivot", jo.ground["origin"], arm["start"], (0, 0, 1))
    start = jo.Initial(pivot.angle, rate=2.0)
    return jo.compile(jo.Mechanism(arm, pivot, start, jo.Gravity((0, -9.81, 0))))


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
@pytest.mark.parametrize("cls", ROSENBROCK, **NAMES)
def test_order_with_modes_that_the_step_does_not_resolve(cls):
    """Steps of 2 and 1 ms, ``omega h`` up to 30, from a state in which no mode vibrates."""
    model = stiff_beam()
    state = jo.simulation.vibration_free_state(model)
    exact = jo.simulate(model, 0.5, solver=jo.RK4(1e-5), output_step=0.05, state=state)
    for found in errors(model, cls, 0.5, (250, 500, 1000), exact, state):
        assert orders(found)[-1] > cls.order - 0.15, found


def links(core, rub):
    """Three links in space with springs, dampers and, with `rub`, hinges that slide."""
    before, items = jo.ground["origin"], []
    for k in range(3):
        body = jo.RigidBody(f"l{k}", 1.0, (0.1,) * 3, center=(0.5, 0, 0), position=(k, 0, 0))
        pin = jo.Revolute(f"p{k}", before, body["origin"], (0, 0.6, 0.8) if k % 2 else (0, 0, 1))
        spring = jo.Spring(f"s{k}", pin.angle, stiffness=3e2 * 10**k, damping=3.0)
        items += [body, pin, jo.Initial(pin.angle, rate=4.0 + k), spring]
        if rub:
            law = jo.mechanism.StickSlip()
            items.append(jo.Friction(f"f{k}", pin, 0.1, 0.12, radius=0.05, law=law))
        before = body.at((1, 0, 0))
    return jo.compile(jo.Mechanism(*items, jo.Gravity((0, -9.81, 0)), core=core))


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
@pytest.mark.parametrize("rub", [False, True], ids=["free", "rubbing"])
@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("cls", STAGED, **NAMES)
def test_order_and_energy_balance_with_springs_dampers_and_friction(cls, core, rub):
    """The balance closes with the order of the method: each kind of work is added up with it."""
    model, end = links(core, rub), 0.05
    exact = jo.simulate(model, end, solver=jo.RK4(end / 20000), output_step=end / 10)
    for found in errors(model, cls, end, (100, 200, 400), exact):
        assert orders(found)[-1] > cls.order - 0.2, found
