"""Beam elements in motion: what free flight keeps, how Newton's method of a step converges."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jousto as jo
from model.test_beam import bent, element, rotation, stiffness

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")


def flying(share, beta=0.0):
    """Return a free beam whose nodes are mass centres that carry the lumped half of elements."""
    rng = np.random.default_rng(21)
    nodes = [
        jo.RigidBody(f"node{i}", 2.0 + i, (0.3, 0.4, 0.5), position=(i, 0, 0)) for i in range(4)
    ]
    links = [
        element(
            i,
            i + 1,
            B=Rotation.from_rotvec(0.3 * rng.normal(size=(2, 3))).as_matrix(),
            C=stiffness(rng),
            e0=0.1 * rng.normal(size=6),
            beta=beta,
            share=share,
            m=1.7,
            J=(0.2, 0.1, 0.15, 0.01, -0.02, 0.02),
        )
        for i in range(3)
    ]
    return replace(jo.compile(jo.Mechanism(*nodes)), beams=tuple(links))


def momentum(engine):
    """Return linear momentum and that about the origin from the mass matrix of the whole."""
    count = engine.model.nv
    p = engine.newton_matrix(1.0, 0.0, 0.0)[:count, :count] @ engine.v
    linear, angular = np.zeros(3), np.zeros(3)
    for b in engine.model.bodies:
        P = p[b.iv : b.iv + 3]
        A = rotation(engine.q[b.iq + 3 : b.iq + 7])
        linear += P
        angular += np.cross(engine.q[b.iq : b.iq + 3], P) + A @ p[b.iv + 3 : b.iv + 6]
    return linear, angular


def native(engine, method, step, rho=1.0, **options):
    """Return a native solver; generalised alpha with rho = 1 loses no energy by itself."""
    if method != "alpha":
        return engine.native_solver(method, step, False)
    given = {"tolerance": 1e-10, "iterations": 20}
    return engine.native_solver(
        method,
        step,
        True,
        **{**jo.GeneralizedAlpha(step, rho=rho, tangent="exact").options, **given, **options},
    )


METHODS = {"ROS2": "ros2", "alpha": "alpha"}


@pytest.mark.parametrize("share", [0.0, 1.0])
@pytest.mark.parametrize("method", METHODS)
def test_free_flight_keeps_what_it_must_at_the_order_of_the_method(method, share):
    """Linear momentum to round-off, angular momentum and energy at second order."""
    model = flying(share)
    changes = []
    for step in (2e-3, 1e-3):
        engine = bent(model, np.random.default_rng(5), 0.3, 0.1)
        (p, H), E = momentum(engine), engine.energy().sum()
        solver = native(engine, METHODS[method], step)
        for _ in range(round(0.2 / step)):
            engine.step(solver)
        p1, H1 = momentum(engine)
        np.testing.assert_allclose(p1, p, rtol=0, atol=1e-10 * np.abs(p).max())
        changes.append([np.abs(H1 - H).max() / np.abs(H).max(), abs(engine.energy().sum() / E - 1)])
    coarse, fine = np.array(changes)
    assert fine.max() < 0.02
    assert (coarse > 2.8 * fine).all(), (coarse, fine)


@pytest.mark.parametrize(("beta", "share"), [(0.0, 0.0), (2e-3, 0.0), (0.0, 1.0)])
def test_newton_of_a_step_converges_quadratically(beta, share):
    """Errors after 1, 2, .. iterations of a long step: each about the square of the last."""
    model = flying(share, beta)
    ends = []
    for iterations in (1, 2, 3, 4, 5, 9):
        engine = bent(model, np.random.default_rng(5), 0.3, 0.1)
        engine.v *= 3.0
        engine.step(native(engine, "alpha", 0.03, tolerance=0.0, iterations=iterations))
        ends.append(engine.v.copy())
    errors = np.array([np.linalg.norm(v - ends[-1]) for v in ends[:-1]]) / np.linalg.norm(ends[-1])
    assert errors[0] > 1e-3
    assert errors[3] < 1e-9
    assert (errors[1:] < 2.0 * errors[:-1] ** 2 + 1e-13).all(), errors


def test_velocity_dependent_tangents_can_be_left_out():
    """Without K_acc and C_acc of ends off the origins Newton needs more iterations to the same."""
    u = np.array([[0.0, 0.5, 0.2], [0.0, 0.5, 0.2]])
    C = stiffness(np.random.default_rng(4))
    link = element(0, 1, u=u, C=C, share=1.0, m=6.0, J=(0.1, 0.1, 0.1, 0.0, 0.0, 0.0))
    nodes = [jo.RigidBody(f"node{i}", 4.0, (1.5,) * 3, center=(0, 0.4, 0.15)) for i in range(2)]
    model = replace(jo.compile(jo.Mechanism(*nodes)), beams=(link,))
    ends, counts = [], []
    for plain in (0, 1):
        engine = bent(model, np.random.default_rng(5), 0.1, 0.05)
        engine.v[3:6] = engine.v[9:12] = [0.0, 0.0, 25.0]
        solver = native(engine, "alpha", 4e-3, plain_inertia=plain, iterations=60)
        for _ in range(20):
            engine.step(solver)
        ends.append(engine.q.copy())
        counts.append(int(engine.counts.iterations))
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-8)
    assert counts[1] > 1.2 * counts[0]
