"""Loads along exact beams against closed forms; end moments of elements that bend inside."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.model.native.native import Engine, displaced
from jousto.simulation.modes.spectrum import newton_sparse

STIFF = 1e8  # neither stretch nor shear: 1e-8


def section() -> jo.mechanism.BeamSection:
    stiff = (STIFF, STIFF, STIFF, 1.0, 1.0, 1.0)
    return jo.mechanism.BeamSection(stiff, 1.0, (2e-6, 1e-6, 1e-6))


def straight(points: np.ndarray, **options: object) -> jo.BeamBody:
    nodes = np.column_stack([points, 0 * points, 0 * points])
    return jo.BeamBody("beam", nodes, section(), bending=True, **options)


def even(n: int) -> np.ndarray:
    return np.linspace(0.0, 1.0, n + 1)


def graded(n: int) -> np.ndarray:
    return even(n) ** 1.3


def tip_of(beam: jo.BeamBody, *loads: object) -> float:
    clamp = jo.Fixed("clamp", jo.ground["origin"], beam["start"])
    model = jo.compile(jo.Mechanism(beam, clamp, *loads))
    rest = jo.equilibrium(model)
    return float(rest.q[model.bodies[-1].iq + 2])


@pytest.mark.parametrize("nodes", [even, graded])
@pytest.mark.parametrize("n", [2, 4, 7])
def test_a_cantilever_under_an_even_load_bends_exactly(nodes, n):
    """w = q L^4/(8 EI), whatever the elements; of small loads, 1e-4 of second order."""
    q = 1e-4
    beam = straight(nodes(n))
    assert tip_of(beam, jo.mechanism.LineLoad("load", beam, (0, 0, q))) == pytest.approx(
        q / 8, rel=1e-5
    )


def test_a_load_that_fades_out_converges_with_order_four():
    """w = q L^4/(30 EI) of q at the clamp and none at the tip."""
    errors = []
    for n in (2, 4, 8):
        beam = straight(even(n))
        load = np.zeros((n + 1, 3))
        load[:, 2] = 1e-4 * (1 - even(n))
        errors.append(tip_of(beam, jo.mechanism.LineLoad("load", beam, load)) / (1e-4 / 30) - 1)
    assert abs(errors[0]) < 5e-3
    assert abs(errors[1]) < abs(errors[0]) / 12
    assert abs(errors[2]) < abs(errors[1]) / 12 + 1e-6


def test_a_beam_on_two_supports_under_an_even_load():
    """w = 5 q L^4/(384 EI) in the middle."""
    q = 1e-4
    beam = straight(even(4))
    joints = [
        jo.Spherical("left", jo.ground["origin"], beam["start"]),
        jo.PointOnLine("right", jo.ground.at((1, 0, 0)), beam["end"], axis=(1, 0, 0)),
    ]
    model = jo.compile(jo.Mechanism(beam, *joints, jo.mechanism.LineLoad("load", beam, (0, 0, q))))
    middle = jo.equilibrium(model).q[model.bodies[2].iq + 2]
    assert middle == pytest.approx(5 * q / 384, rel=1e-5)


def test_weight_has_its_end_moments_with_corrected_mass():
    """w = q L^4/(8 EI) of the beam's weight; without them 1/3n^2 more, 2.1 % with four elements."""
    q, n = 1e-4, 4
    weight = jo.Gravity((0, 0, q))
    for mass in (None, "corrected"):
        assert tip_of(straight(even(n), mass=mass), weight) == pytest.approx(q / 8, rel=1e-5)
    for mass in ("lumped", "consistent"):
        found = tip_of(straight(even(n), mass=mass), weight)
        assert found == pytest.approx(q / 8 * (1 + 1 / (3 * n**2)), rel=1e-5)


@pytest.mark.filterwarnings("ignore:.*has no joint to another body")
@pytest.mark.parametrize("mass", ["lumped", "corrected", "consistent"])
def test_a_falling_beam_does_not_bend(mass):
    """Weight is M g whatever M is: bent beams fall as they lie, g t^2/2, to round-off."""
    t = np.linspace(0.0, 1.0, 6)
    nodes = np.column_stack([np.sin(t), 1 - np.cos(t), 0.1 * t])
    beam = jo.BeamBody("beam", nodes, section(), bending=True, mass=mass)
    model = jo.compile(jo.Mechanism(beam, jo.Gravity((3.0, 0.0, -9.81))))
    run = jo.simulate(model, 0.2, solver=jo.GeneralizedAlpha(step=0.02, rho=1.0))
    q = run.q[-1].reshape(-1, 7)
    fallen = np.array([3.0, 0.0, -9.81]) * 0.2**2 / 2
    assert q[:, :3] - nodes == pytest.approx(np.tile(fallen, (6, 1)), abs=1e-9)


@pytest.mark.parametrize("follow", [False, True])
def test_far_bent_beams_converge_with_order_four(follow):
    """q L^3/EI = 8: the end moments turn with the beam. Against 64 elements."""
    tips = []
    for n in (4, 8, 64):
        beam = straight(even(n))
        tips.append(tip_of(beam, jo.mechanism.LineLoad("load", beam, (0, 0, 8.0), follow=follow)))
    assert abs(tips[0] - tips[2]) > 10 * abs(tips[1] - tips[2])
    assert tips[1] == pytest.approx(tips[2], abs=1e-3)


@pytest.mark.parametrize("follow", [False, True])
def test_the_resultant_is_that_of_the_load(follow):
    """Reactions of a clamp: force and moment of any load, curved axis, corner, offset."""
    t = np.linspace(0.0, 1.2, 6)
    nodes = np.vstack([np.column_stack([np.sin(t), 1 - np.cos(t), 0.1 * t]), [(1.2, 1.4, 0.3)]])
    beam = jo.BeamBody(
        "beam", nodes, section(), bending=True, corners=(3,), offset=(0.02, 0.01), mass="corrected"
    )
    load = np.random.default_rng(3).uniform(-1, 1, (7, 3))
    force, moment = np.zeros(3), np.zeros(3)
    for marker, F, _ in jo.mechanism.LineLoad("load", beam, load, follow=follow).loads:
        A = beam.frames[marker.body.place]
        at = nodes[marker.body.place] + A @ marker.position_local
        F = A @ F if follow else F
        force, moment = force + F, moment + np.cross(at, F)
    # straight from the definition; what follows is resolved in the axes of the nearer end
    wanted, turning = np.zeros(3), np.zeros(3)
    arm = np.array([0, 0.02, 0.01])
    for i, L in enumerate(beam.lengths):
        for e in (0, 1):
            R = beam.ends[i, e]
            P = L / 8 * (3 * load[i + e] + load[i + 1 - e])
            P = R @ P if follow else P
            x = nodes[i + e] + beam.frames[i + e] @ arm + (1 - 2 * e) * L / 6 * R[:, 0]
            wanted, turning = wanted + P, turning + np.cross(x, P)
    # dead loads: the integral of what changes along straight lines; following ones turn
    ends = beam.lengths[:, None] / 2 * (load[:-1] + load[1:])
    assert np.allclose(wanted, ends.sum(axis=0), rtol=0.0, atol=1e-12) == (not follow)
    assert force == pytest.approx(wanted, abs=1e-12)
    assert moment == pytest.approx(turning, abs=1e-12)


@pytest.mark.parametrize("follow", [False, True])
def test_tangents_of_line_loads_are_exact(follow):
    """Newton's matrix against the complex step of the residual, bent far, of its largest term."""
    beam = straight(graded(4))
    clamp = jo.Fixed("clamp", jo.ground["origin"], beam["start"])
    load = jo.mechanism.LineLoad("load", beam, (0.5, -1, 8.0), torque=(0.3, 0.1, 0), follow=follow)
    model = jo.compile(jo.Mechanism(beam, clamp, load))
    rest = jo.equilibrium(model)
    engine, twin = Engine(model), Engine(model, complex_scalars=True)
    for e in (engine, twin):
        e.q[:], e.lam[:] = rest.q, rest.lam
    nv = model.nv
    K = newton_sparse(engine, 0.0, 0.0, 1.0)[:nv, :nv].toarray()
    for j in range(nv):
        x = np.zeros(nv, complex)
        x[j] = 1e-30j
        twin.q[:] = displaced(model, rest.q, x)
        assert np.abs(twin.residual().imag / 1e-30 - K[:, j]).max() < 1e-12 * np.abs(K).max()
