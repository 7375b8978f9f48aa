"""Methods with exact beams: order, damping, stiff starts, restarts, determinism, events, friction.

No published numbers: laws of the methods and of the package, which beams must not break.
"""

from __future__ import annotations

import h5py
import numpy as np
import pytest
from scipy.optimize import brentq

import jousto as jo
from verification.mechanisms import orders

O = jo.ground["origin"]
RUBBER = jo.mechanism.BeamSection(
    np.diag([2e4, 8e3, 8e3, 6.0, 8.0, 8.0]), 1.5, 1e-3 * np.diag([2.0, 1, 1])
)
SHARES = {"lumped": 0.0, "half": 0.5, "corrected": "corrected"}


def whip(elements=4, tip_mass=0.3, extra=(), **options):
    """A soft beam that swings in space with a block at its end."""
    beam = jo.BeamBody(
        "beam",
        [(0, 0, 0), (1, 0, 0)],
        RUBBER,
        elements=elements,
        angular_velocity=(2.0, -1.0, 3.0),
        **options,
    )
    block = jo.RigidBody(
        "block",
        tip_mass,
        inertia=(0.002, 0.003, 0.004),
        position=(1, 0, 0),
        velocity=np.cross((2.0, -1.0, 3.0), (1, 0, 0)),
        angular_velocity=(2.0, -1.0, 3.0),
    )
    return jo.Mechanism(
        beam,
        block,
        jo.Spherical("pivot", O, beam["start"]),
        jo.Fixed("weld", beam["end"], block["origin"]),
        jo.Gravity((0, -9.81, 0)),
        jo.PositionSensor("tip", block["origin"]),
        *extra,
    )


METHODS = {
    "RK4": (lambda h: jo.RK4(step=h), (2e-4, 1e-4, 5e-5), 4),
    "ROS2": (lambda h: jo.ROS2(step=h), (2e-3, 1e-3, 5e-4), 2),
    "alpha": (lambda h: jo.GeneralizedAlpha(step=h, rho=0.7), (2e-3, 1e-3, 5e-4), 2),
    "Newmark": (lambda h: jo.simulation.Newmark(step=h), (2e-3, 1e-3, 5e-4), 2),
}


@pytest.mark.parametrize("mass", SHARES)
@pytest.mark.parametrize("method", METHODS)
def test_every_method_keeps_its_order_with_beams(method, mass):
    solver, steps, order = METHODS[method]
    model = jo.compile(
        whip(mass=SHARES[mass], damping=jo.mechanism.BeamDamping(mass=0.2, stiffness=1e-5))
    )
    best = jo.simulate(model, 0.05, solver=jo.RK4(step=2.5e-5))["tip"][-1]
    errors = [
        np.abs(jo.simulate(model, 0.05, solver=solver(h))["tip"][-1] - best).max() for h in steps
    ]
    assert errors[-1] < 1e-4, errors
    assert orders(errors)[-1] > order - 0.3 or errors[-1] < 1e-9, errors


def test_an_adaptive_method_meets_its_tolerance_with_beams():
    model = jo.compile(whip())
    best = jo.simulate(model, 0.1, solver=jo.RK4(step=5e-5))["tip"][-1]
    for tolerance in (1e-5, 1e-8):
        solver = jo.simulation.DormandPrince(output=0.1, tolerance=tolerance)
        found = jo.simulate(model, 0.1, solver=solver)["tip"][-1]
        assert np.abs(found - best).max() < 50 * tolerance


@pytest.mark.parametrize("mass", SHARES)
def test_the_energy_balance_closes_with_both_dampings(mass):
    errors = []
    for h in (2e-3, 1e-3):
        model = jo.compile(
            whip(mass=SHARES[mass], damping=jo.mechanism.BeamDamping(mass=1.5, stiffness=5e-3))
        )
        run = jo.simulate(model, 0.4, solver=jo.GeneralizedAlpha(step=h, rho=1.0))
        lost = run.energy.dissipated
        assert (np.diff(lost) > -1e-9).all()
        assert lost[-1] > 0.1 * run.energy.kinetic[0]
        errors.append(np.abs(run.energy.error).max() / lost[-1])
    assert errors[1] < 5e-3, errors
    assert np.log2(errors[0] / errors[1]) > 1.6, errors


@pytest.mark.filterwarnings("ignore:.*has no joint to another body")
@pytest.mark.parametrize("mass", SHARES)
def test_mass_damping_slows_a_free_flight_as_it_should(mass):
    # -alpha M v on all of the mass: v0 exp(-alpha t), and the spin of a beam about its axis alike
    beam = jo.BeamBody(
        "beam",
        [(0, 0, 0), (1, 0, 0)],
        RUBBER,
        elements=3,
        mass=SHARES[mass],
        damping=jo.mechanism.BeamDamping(mass=2.0),
        velocity=(1.0, -2.0, 0.5),
        angular_velocity=(4.0, 0, 0),
    )
    model = jo.compile(jo.Mechanism(beam))
    run = jo.simulate(model, 0.5, solver=jo.GeneralizedAlpha(step=5e-3, rho=1.0))
    v = run.v[-1].reshape(-1, 6)
    left = np.exp(-2.0 * 0.5)
    np.testing.assert_allclose(v[:, :3], np.tile([left, -2 * left, 0.5 * left], (4, 1)), rtol=1e-4)
    np.testing.assert_allclose(v[:, 3], 4 * left, rtol=1e-4)


@pytest.mark.parametrize("mass", ["lumped", "corrected", "consistent"])
@pytest.mark.parametrize("wave", [1, 2])
def test_damping_has_the_damping_ratio_of_its_formula(mass, wave):
    """alpha/(2 w) + beta w/2 of whatever mass matrix there is, to the accuracy of eigenvalues."""
    beta = 2e-4
    beam = jo.BeamBody(
        "beam",
        [(0, 0, 0), (1, 0, 0)],
        RUBBER,
        elements=8,
        mass=mass,
        bending=mass == "corrected",
        damping=jo.mechanism.BeamDamping(mass=0.8, stiffness=beta),
    )
    model = jo.compile(
        jo.Mechanism(beam, jo.Fixed("wall", O, beam["start"]), jo.Gravity((0, 0, -1e-9)))
    )
    m = jo.modes(model, damped=True)
    w = np.abs(m.eigenvalues)
    k = 2 * (wave - 1)  # pairs
    np.testing.assert_allclose(m.damping[k], 0.8 / (2 * w[k]) + beta * w[k] / 2, rtol=1e-6)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
def test_a_stiff_beam_falls_calmly_at_a_large_step(rho):
    # stretch and shear are a thousand times faster than the step: the first one must not guess
    section = jo.mechanism.BeamSection(
        np.diag([2e5, 2e5, 2e5, 0.5, 1.0, 0.5]), 1.0, 1e-6 * np.diag([2.0, 1, 1])
    )
    tips = []
    for kind, options in ((jo.Fixed, {}), (jo.Revolute, {"axis": (0, 0, 1)})):
        beam = jo.BeamBody("rope", [(0, 0, 0), (1, 0, 0)], section, elements=16, mass=0.5)
        hold = kind("hold", O, beam["start"], **options)
        tip = jo.PositionSensor("tip", beam["end"])
        model = jo.compile(jo.Mechanism(beam, hold, jo.Gravity((0, -9.81, 0)), tip))
        run = jo.simulate(
            model, 0.08, solver=jo.GeneralizedAlpha(step=4e-3, rho=rho, tangent="exact")
        )
        tips.append(run["tip"][-1, 1])
        assert run.work.iterations[-1] / run.work.steps[-1] < 5
    # sixteen elements, of second order, and the period of mode 4 that is eight steps long
    np.testing.assert_allclose(tips, [dropped(True, 0.08), dropped(False, 0.08)], rtol=0.012)


def dropped(clamped, t):
    """Tip of a straight beam, EI = 0.5, m = L = 1, let go at rest: sum over its modes.

    ``w = -g sum phi(1) int phi dx / int phi^2 dx (1 - cos w t) / w^2`` with the modes of a
    clamped-free or a pinned-free beam, which also turns as a whole (Blevins 1979, table 8-1).
    """
    x, g = np.linspace(0.0, 1.0, 20001), 9.81
    tip = 0.0 if clamped else -0.75 * g * t**2
    for k in range(9):
        if clamped:
            b = brentq(lambda b: np.cos(b) * np.cosh(b) + 1.0, k * np.pi + 1.0, k * np.pi + 2.2)
            q = (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b))
            phi = np.cosh(b * x) - np.cos(b * x) - q * (np.sinh(b * x) - np.sin(b * x))
        else:
            b = brentq(lambda b: np.tan(b) - np.tanh(b), (k + 1.1) * np.pi, (k + 1.4) * np.pi)
            phi = np.sin(b * x) / np.sin(b) + np.sinh(b * x) / np.sinh(b)
        w = b**2 * np.sqrt(0.5)
        share = phi[-1] * np.trapezoid(phi, x) / np.trapezoid(phi**2, x)
        tip -= g * share * (1.0 - np.cos(w * t)) / w**2
    return tip


def test_a_step_too_large_for_an_explicit_method_is_told_with_its_remedy():
    model = jo.compile(whip(mass=0.5))
    with (
        pytest.warns(
            jo.JoustoWarning, match=r"Hz \(stiffest body 'beam'\), for which RK4 needs a step below"
        ),
        pytest.raises(jo.SimulationError),
    ):
        jo.simulate(model, 0.1, solver=jo.RK4(step=2e-3))
    # just below the limit that it tells, nothing is said and nothing grows
    jo.simulate(model, 0.05, solver=jo.RK4(step=2e-4))


# -- the package's own promises --------------------------------------------------------------------


def contents(path):
    """Bytes of every dataset that the motion fills."""
    found = {}
    with h5py.File(path) as file:

        def note(name, item):
            if isinstance(item, h5py.Dataset) and name != "model":
                found[name] = np.asarray(item).tobytes()

        file.visititems(note)
    return found


@pytest.mark.parametrize("method", METHODS)
def test_two_runs_give_the_same_bytes(tmp_path, method):
    solver = METHODS[method][0](2.0**-12)
    found = []
    for name in ("a.h5", "b.h5"):
        model = jo.compile(whip(mass=0.5))
        jo.simulate(model, 0.125, solver=solver, path=tmp_path / name)
        found.append(contents(tmp_path / name))
    assert found[0] == found[1]


@pytest.mark.parametrize("method", METHODS)
def test_a_run_goes_on_where_another_one_stopped(method):
    solver = METHODS[method][0](2.0 ** (-12 if method == "RK4" else -10))
    model = jo.compile(whip(damping=jo.mechanism.BeamDamping(stiffness=1e-3)))
    whole = jo.simulate(model, 0.25, solver=solver)
    half = jo.simulate(model, 0.125, solver=solver)
    rest = jo.simulate(model, 0.25, solver=solver, state=half.state())
    # the methods with a memory of their own begin anew: to their error, the others to the bit
    room = 2e-4 if method in ("alpha", "Newmark") else 1e-12
    np.testing.assert_allclose(rest["tip"][-1], whole["tip"][-1], rtol=0, atol=room)
    assert abs(rest.energy.dissipated[-1] - whole.energy.dissipated[-1]) < 10 * room


def test_an_event_at_a_node_stops_the_run_there():
    beam = jo.BeamBody("beam", [(0, 0, 0), (1, 0, 0)], RUBBER, elements=4)
    middle = jo.PositionSensor("middle", beam["node3"])
    event = jo.mechanism.Event("low", middle, -0.05, "falling", stop=True, component="y")
    model = jo.compile(
        jo.Mechanism(
            beam, jo.Fixed("wall", O, beam["start"]), jo.Gravity((0, -9.81, 0)), middle, event
        )
    )
    times = []
    for method in ("RK4", "ROS2", "alpha"):
        run = jo.simulate(model, 1.0, solver=METHODS[method][0](5e-4))
        assert run["middle"][-1, 1] == pytest.approx(-0.05, abs=1e-8)
        times.append(run.time[-1])
    assert np.ptp(times) < 2e-4


def test_a_pin_with_friction_brakes_a_beam_and_the_balance_closes():
    beam = jo.BeamBody(
        "beam", [(0, 0, 0), (1, 0, 0)], RUBBER, elements=4, angular_velocity=(0, 0, 4.0)
    )
    pin = jo.Revolute("pin", O, beam["start"], axis=(0, 0, 1))
    friction = jo.Friction("rub", pin, 0.3, radius=0.05, law=jo.mechanism.Regularised(1e-2))
    model = jo.compile(jo.Mechanism(beam, pin, friction, jo.Gravity((0, -9.81, 0))))
    errors = []
    for h in (1e-3, 5e-4):
        run = jo.simulate(model, 0.4, solver=jo.GeneralizedAlpha(step=h, rho=1.0))
        assert run.energy.friction[-1] > 0.02
        errors.append(np.abs(run.energy.error).max())
    assert errors[1] < 2e-2 * run.energy.friction[-1], errors
    assert np.log2(errors[0] / errors[1]) > 1.4, errors
