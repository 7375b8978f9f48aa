"""The residual of the equations of motion and its derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jousto as jo
from verification.mechanisms import chain, loop

CASES = {
    "revolute": lambda: chain("revolute", damping=0.02, loads=True),
    "spherical": lambda: chain("spherical", loads=True),
    "fixed": lambda: chain("fixed", damping=0.02, loads=True),
    "loop": loop,
}


def bent(case):
    """An engine at a bent, moving state, with consistent accelerations and multipliers."""
    engine = jo.model.Engine(jo.compile(CASES[case]()))
    rng = np.random.default_rng(5)
    for b in engine.model.bodies:
        engine.q[b.iq + 7 : b.iq + 7 + b.n] = (
            0.3 * rng.uniform(0.5, 1.0, b.n) / (1 + np.arange(b.n))
        )
    engine.v += rng.normal(size=engine.model.nv)
    engine.time[0] = 0.1
    engine.accelerations()
    return engine


def moved(model, q, increment):
    """q o exp(increment) by scipy's rotations."""
    out = q.copy()
    for b in model.bodies:
        x = increment[b.iv : b.iv + 6 + b.n]
        out[b.iq : b.iq + 3] += x[:3]
        e = q[b.iq + 3 : b.iq + 7]
        turn = Rotation.from_quat(np.roll(e, -1)) * Rotation.from_rotvec(x[3:6])
        out[b.iq + 3 : b.iq + 7] = np.roll(turn.as_quat(), 1)
        out[b.iq + 7 : b.iq + 7 + b.n] += x[6:]
    return out


@pytest.mark.parametrize("case", CASES)
def test_the_accelerations_leave_no_residual(case):
    engine = bent(case)
    found = engine.residual()
    forces = engine.tangent().M @ engine.a
    assert np.abs(engine.lam).max() > 1.0
    np.testing.assert_allclose(found, 0.0, atol=1e-11 * np.abs(forces).max())


@pytest.mark.parametrize("case", CASES)
def test_derivatives_agree_with_differences(case):
    engine = bent(case)
    engine.a += np.random.default_rng(1).normal(size=engine.model.nv)  # away from equilibrium
    t, q0, d = engine.tangent(), engine.q.copy(), 1e-3
    direction = np.random.default_rng(7).normal(size=engine.model.nv)

    def at(step, place):
        kept = [x.copy() for x in (engine.q, engine.v, engine.a)]
        if place == "q":
            engine.q[:] = moved(engine.model, q0, step * direction)
        else:
            getattr(engine, place)[:] += step * direction
        out = np.concatenate([engine.residual(), engine.constraints()[0]])
        engine.q[:], engine.v[:], engine.a[:] = kept
        return out

    for place, matrix in (("a", t.M), ("v", t.D), ("q", np.vstack([t.K, t.Cq]))):
        near = at(d, place) - at(-d, place)
        far = at(2 * d, place) - at(-2 * d, place)
        found = (8 * near - far) / (12 * d)
        wanted = matrix @ direction
        scale = np.abs(wanted).max()
        np.testing.assert_allclose(found[: len(wanted)], wanted, rtol=0, atol=1e-8 * scale)


@pytest.mark.parametrize("case", CASES)
def test_inertia_and_jacobian_are_those_of_the_engine(case):
    engine = bent(case)
    t = engine.tangent()
    np.testing.assert_allclose(t.M, t.M.T, atol=1e-12 * np.abs(t.M).max())
    for i, b in enumerate(engine.model.bodies):
        local = engine.mass_matrix(i)
        to_local = np.eye(6 + b.n)
        to_local[:3, :3] = (
            Rotation.from_quat(np.roll(engine.q[b.iq + 3 : b.iq + 7], -1)).as_matrix().T
        )
        block = slice(b.iv, b.iv + 6 + b.n)
        wanted = to_local.T @ local @ to_local
        np.testing.assert_allclose(t.M[block, block], wanted, atol=1e-11 * np.abs(wanted).max())
    np.testing.assert_allclose(t.Cq @ engine.v, engine.constraints()[1], atol=1e-11)
    # the multipliers act with the transposed Jacobian
    lam = np.random.default_rng(2).normal(size=engine.model.nrow)
    before = engine.residual()
    engine.lam += lam
    np.testing.assert_allclose(
        engine.residual() - before, t.Cq.T @ lam, atol=1e-10 * np.abs(before).max() + 1e-9
    )
