"""Geometric stiffening in the engine: energy of a fast spatial chain, and inertia at a bent state.

The kinetic energy holds ``u = u0 + Phi p + chi(p, p)/2`` to second order in p; markers move by the
same field. Energy is conserved only if velocities, accelerations and virtual work all belong to it.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import jousto as jo
from verification.mechanisms import SOFT, march, orders


@cache
def soft_rod(stiffening: bool) -> jo.ReducedPart:
    part = jo.Part.beam(1.0, jo.Rectangle(0.05, 0.02), 6, SOFT, theory=jo.parts.EulerBernoulli())
    method = jo.CraigBampton(interfaces=("start", "end"), modes=0)
    return jo.reduce(part, method, stiffening=stiffening)


def spinning_chain(stiffening: bool) -> jo.Model:
    """Two soft beams on a spherical and an oblique revolute joint, at 15 rad/s."""
    bodies: list[jo.FlexibleBody] = []
    w = np.array([1.0, -2.0, 15.0])
    for i in range(2):
        x = np.array([float(i), 0.0, 0.0])
        bodies.append(
            jo.FlexibleBody(
                f"rod {i}",
                soft_rod(stiffening),
                position=x,
                velocity=np.cross(w, x),
                angular_velocity=w,
            )
        )
    a, b = bodies
    return jo.compile(
        jo.Mechanism(
            a,
            b,
            jo.Spherical("pivot", jo.ground["origin"], a["start"]),
            jo.Revolute("hinge", a["end"], b["start"], axis=(0.2, 1.0, 0.3)),
            jo.Gravity((0.0, 0.0, -9.81)),
            jo.PositionSensor("tip", b["end"]),
        )
    )


@pytest.mark.filterwarnings("ignore:.*static work")
def test_energy_order_of_a_fast_chain() -> None:
    """The energy error of RK4 falls with the fifth order, to 1e-9 of the kinetic energy."""
    model = spinning_chain(True)
    runs = [march(model, jo.RK4(step=h), 0.1, 0.1) for h in (4e-4, 2e-4, 1e-4)]
    errors = [abs(float(run.balance[-1])) for run in runs]
    assert orders(errors) == pytest.approx(5.0, abs=0.4)
    assert errors[-1] < 1e-9 * runs[-1].energy[0, 0]
    without = march(spinning_chain(False), jo.RK4(step=1e-4), 0.1, 0.1)
    gap = runs[-1].sensors["tip"][-1] - without.sensors["tip"][-1]
    assert np.linalg.norm(gap) > 1e-4  # m: stiffening is there


@pytest.mark.filterwarnings("ignore:.*static work")
def test_inertia_of_a_bent_beam() -> None:
    """J(p) gains ``tr(N) E - N`` with ``N = int u0 chi(p, p)^T dm``; S and B stay as they are."""
    with_, without = spinning_chain(True), spinning_chain(False)
    p = 0.05 * np.random.default_rng(1).standard_normal(soft_rod(True).n)
    matrices = []
    for model in (with_, without):
        engine = jo.model.Engine(model)
        engine.q[7 : 7 + len(p)] = p
        matrices.append(engine.mass_matrix(0))
    change = matrices[0] - matrices[1]
    field = soft_rod(True).stiffening
    assert field is not None
    N = np.einsum("j,k,jkab->ab", p, p, field.second_moment)
    J = np.trace(N) * np.eye(3) - N
    assert change[3:6, 3:6] == pytest.approx(J, abs=1e-12)
    change[3:6, 3:6] = 0.0
    assert np.abs(change).max() == 0.0
    assert np.trace(J) < 0.0  # a bent beam is shorter
