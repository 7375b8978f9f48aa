"""Equivalent static loads of a run: at rest they make its deformation and its stress."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla

import jousto as jo
from jousto.design import equivalent_loads
from jousto.recovery.shape import rotation_matrices
from parts.grids import grid

FREE = pytest.mark.filterwarnings("ignore:.*leave out.*", "ignore:.*moves freely.*")
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)


def thrown(part: jo.Part) -> tuple[jo.FlexibleBody, jo.Solution]:
    """A free body that turns, vibrates and is pushed."""
    body = jo.FlexibleBody(
        "bar",
        jo.reduce(part, jo.FreeFree(modes=8)),
        velocity=(1.0, 0.0, 2.0),
        angular_velocity=(3.0, 20.0, -5.0),
        damping=0.01,
    )
    push = jo.Force("push", body["node1"], (0.0, 50.0, 400.0), follow=part.dofs_per_node == 6)
    stress = jo.StressSensor("stress", body, body.reduced.stress.labels)
    model = jo.compile(jo.Mechanism(body, push, stress))
    return body, jo.simulate(model, 0.01, solver=jo.ROS2(1e-5), output_step=1e-3)


def bar() -> jo.Part:
    return jo.Part.beam(1.0, jo.Rectangle(0.02, 0.03), 6, STEEL)


def block() -> jo.Part:
    return jo.Part.solid(grid("hexahedron", (6, 2, 2), (0.6, 0.06, 0.05)), STEEL)


@FREE
@pytest.mark.parametrize("make", [bar, block])
def test_at_rest_they_make_the_deformation_and_stress_of_the_run(make):
    part = make()
    body, run = thrown(part)
    f = equivalent_loads(run, body).reshape(len(run.time), -1).T
    # a free body is in balance, whatever pushes and turns it
    R = part.rigid_modes()
    assert np.all(np.abs(R.T @ f) <= 1e-9 * (np.abs(R).T @ np.abs(f)).max())
    # held at six degrees of freedom: node 1 and as much of others as a solid needs
    held = [0, 1, 2, 3, 4, 5]
    if part.dofs_per_node == 3:
        x, y, z = part.nodes.T
        far = int(np.argmax(x - y - z))
        side = int(np.argmax(y - x - z))
        held = [0, 1, 2, 3 * far + 1, 3 * far + 2, 3 * side + 2]
    free = np.setdiff1d(np.arange(part.K.shape[0]), held)
    z = np.zeros(f.shape)
    K = sp.csc_array(part.K)
    z[free] = spla.splu(K[free][:, free]).solve(f[free])
    # no reactions
    np.testing.assert_allclose((K @ z)[held], f[held], atol=1e-8 * np.abs(f).max())
    found = part.stress.evaluate(z)
    labels = list(body.reduced.stress.labels)
    stress = run["stress"].reshape(len(run.time), len(labels), 6)
    np.testing.assert_allclose(found.transpose(2, 0, 1), stress, atol=1e-7 * np.abs(stress).max())
    assert np.abs(stress).max() > 1e5
    # between stored instants they are those of the line between these
    nodal = f.T.reshape(len(run.time), len(part.nodes), -1)
    between = 0.25 * nodal[3] + 0.75 * nodal[4]
    at = 0.25 * run.time[3] + 0.75 * run.time[4]
    scale = np.abs(nodal).max()
    np.testing.assert_allclose(equivalent_loads(run, body, at)[0], between, atol=1e-9 * scale)


def test_they_are_the_loads_where_nothing_moves():
    part = bar()
    body = jo.FlexibleBody("bar", jo.reduce(part, jo.CraigBampton(["start", "end"], modes=2)))
    wall = jo.Fixed("wall", jo.ground["origin"], body["start"])
    pull = jo.Force("pull", body["end"], (0, 0, -100.0))
    model = jo.compile(jo.Mechanism(body, wall, pull))
    run = jo.simulate(model, 1e-3, state=jo.equilibrium(model))
    f = equivalent_loads(run, body, [0.0, 5e-4])
    assert f.shape == (2, 7, 6)
    # the frame of the body follows its mean turning; the loads are in its axes
    A = rotation_matrices(run.coordinates("bar")[0, 3:7])
    world = f[0].reshape(7, 2, 3) @ A.T
    expected = np.zeros((7, 2, 3))
    expected[0] = (0, 0, 100.0), (0, -100.0, 0)
    expected[6, 0, 2] = -100.0
    turn = np.arccos(A[0, 0])
    assert 1e-3 < turn < 5e-3
    np.testing.assert_allclose(world, expected, atol=100.0 * turn**2)


@FREE
def test_what_does_not_fit_is_refused():
    part = bar()
    body, run = thrown(part)
    other = jo.FlexibleBody("bar", jo.reduce(part, jo.FreeFree(modes=3)))
    with pytest.raises(jo.InputError, match="has 3 modes, that of the run 8"):
        equivalent_loads(run, other)
    with pytest.raises(jo.InputError, match="was not reduced from part"):
        equivalent_loads(run, body, part=jo.Part.beam(2.0, jo.Circle(0.01), 6, STEEL))
    with pytest.raises(jo.InputError, match="outside the run"):
        equivalent_loads(run, body, 7.0)
    with pytest.raises(jo.InputError, match="must be a FlexibleBody"):
        equivalent_loads(run, "bar")
