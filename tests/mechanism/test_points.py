"""Markers at points of flexible bodies that are no nodes: closed forms, rigid motions, refusals."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from numpy.typing import NDArray

import jousto as jo
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.reduction.interpolated_points import followed
from parts.grids import grid

Array = NDArray[np.float64]
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
SECTION = jo.Rectangle(0.06, 0.04)


def beam(elements: int) -> jo.ReducedPart:
    part = jo.Part.beam(1.0, SECTION, elements, STEEL)
    return jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4))


def block(counts: tuple[int, int, int] = (8, 3, 3)) -> jo.ReducedPart:
    mesh = grid("hexahedron", counts, (0.8, 0.1, 0.1), bend=lambda x: x - (0.0, 0.05, 0.05))
    part = jo.Part.solid(mesh, STEEL)
    return jo.reduce(part, jo.FreeFree(modes=6))


def moved(reduced: jo.ReducedPart, point: object, u: Array, theta: Array | None = None) -> Array:
    """Return what motions of all nodes (nn, 3) make of a point, (6,)."""
    found = followed(reduced, np.asarray(point, dtype=float))
    turn = np.zeros_like(u) if theta is None else theta
    nodal = np.concatenate([u, turn], axis=1)[found.nodes]
    return np.einsum("akb,kb->a", found.weights, nodal)


@pytest.mark.parametrize("x", [0.07, 0.25, 0.61, 0.93])
@pytest.mark.parametrize("y", [0.0, 0.03])
def test_a_short_cantilever_between_its_nodes(x, y):
    """Timoshenko: ``w = F (x^2 (3 - x) / (6 EI) + x / (G A k))``, turned by ``w' - F/(GAk)``."""
    part = jo.Part.beam(1.0, SECTION, 3, STEEL, theory=jo.parts.Timoshenko(0.85, 0.85))
    reduced = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4))
    F, EI = 1000.0, STEEL.E * SECTION.Iy
    shear = F / (0.85 * STEEL.E / 2.6 * SECTION.A)
    f = np.zeros(6 * 4)
    f[6 * 3 + 2] = F
    d = np.zeros(6 * 4)
    d[6:] = spla.spsolve(part.K.tocsc()[6:, 6:], f[6:])
    nodal = d.reshape(4, 6)
    found = moved(reduced, (x, y, 0.02), nodal[:, :3], nodal[:, 3:])
    turn = F * (x - x**2 / 2.0) / EI
    w = F * x**2 * (3.0 - x) / (6.0 * EI) + shear * x
    # the arm (y, 0.02) off the axis turns with the section, about -y
    np.testing.assert_allclose(found, [-0.02 * turn, 0, w, 0, -turn, 0], atol=1e-9 * abs(w))


def test_at_a_node_of_a_beam_it_is_the_node():
    reduced = beam(6)
    for node in range(7):
        motion = followed(reduced, reduced.nodes[node]).motion(reduced)
        scale = np.abs(reduced.modes).max()
        np.testing.assert_allclose(motion[:3], reduced.modes[node], atol=1e-12 * scale)
        turn = reduced.rotation(node)
        np.testing.assert_allclose(motion[3:], turn, atol=1e-12 * np.abs(reduced.rotations).max())


def test_a_file_keeps_what_points_of_beams_need(tmp_path):
    reduced = beam(3)
    reduced.save(tmp_path / "rod.h5")
    again = jo.ReducedPart.load(tmp_path / "rod.h5")
    point = np.array([0.4, 0.01, 0.0])
    np.testing.assert_array_equal(
        followed(again, point).motion(again), followed(reduced, point).motion(reduced)
    )


@pytest.mark.parametrize("point", [(0.31, 0.02, -0.013), (0.4, 0.05, 0.05), (0.012, -0.049, 0.0)])
def test_solids_meet_rigid_motions_and_even_strain(point):
    """Also of a plate of one layer, whose nodes cannot tell a second degree across it."""
    rng = np.random.default_rng(3)
    for counts in ((8, 3, 3), (8, 3, 1)):
        reduced = block(counts)
        a, G = rng.normal(size=3), rng.normal(size=(3, 3))
        found = moved(reduced, point, a + reduced.nodes @ G.T)
        turn = 0.5 * np.array([G[2, 1] - G[1, 2], G[0, 2] - G[2, 0], G[1, 0] - G[0, 1]])
        np.testing.assert_allclose(found, [*(a + G @ point), *turn], atol=1e-10)


def test_forces_reach_the_nodes_with_their_moment():
    """The nodal forces ``W^T f`` have the resultant and the moment of f at the point."""
    reduced, point = block(), np.array([0.33, 0.021, -0.04])
    found = followed(reduced, point)
    load = np.array([3.0, -2.0, 5.0, 0.7, 0.2, -0.4])
    nodal = np.einsum("akb,a->kb", found.weights, load)
    assert not nodal[:, 3:].any()
    arm = reduced.nodes[found.nodes] - point
    np.testing.assert_allclose(nodal[:, :3].sum(axis=0), load[:3], atol=1e-10)
    moment = np.cross(arm, nodal[:, :3]).sum(axis=0)
    np.testing.assert_allclose(moment, load[3:], atol=1e-10)


def test_solids_meet_pure_bending():
    """``u = [x z, -nu y z, (nu (y^2 - z^2) - x^2)/2] / r`` is of the second degree: no error."""
    reduced, nu = block(), 0.3
    x, y, z = reduced.nodes.T
    u = np.stack([x * z, -nu * y * z, 0.5 * (nu * (y * y - z * z) - x * x)], axis=1)
    X, Y, Z = point = (0.35, 0.02, -0.013)
    found = moved(reduced, point, u)
    exact = [X * Z, -nu * Y * Z, 0.5 * (nu * (Y * Y - Z * Z) - X * X), nu * Y, X, 0.0]
    np.testing.assert_allclose(found, exact, atol=1e-10)


def overhang(elements: int, *, node: bool) -> float:
    """Deflection of the end of a beam pinned at x = 0 and held at x = 0.5 under a load there."""
    part = jo.Part.beam(1.0, SECTION, elements, STEEL, theory=jo.parts.EulerBernoulli())
    reduced = jo.reduce(part, jo.FreeFree(modes=min(6 * (elements + 1) - 6, 60)))
    rod = FlexibleBody("rod", reduced)
    middle = rod[f"node{elements // 2 + 1}"] if node else rod.at((0.5, 0, 0))
    mechanism = jo.Mechanism(
        rod,
        jo.Revolute("pin", jo.ground["origin"], rod["start"], axis=(0, 1, 0)),
        jo.PointOnPlane("rest", jo.ground.at((0.5, 0, 0)), middle, normal=(0, 0, 1)),
        jo.Force("load", rod["end"], (0.0, 0.0, -1000.0)),
        jo.PositionSensor("end", rod["end"]),
    )
    model = jo.compile(mechanism)
    state = jo.equilibrium(model)
    return float(jo.simulate(model, 1e-4, state=state)["end"][0][2])


@pytest.mark.filterwarnings("ignore:.*leave out.*")
@pytest.mark.parametrize("n", [3, 5, 9])
def test_a_joint_between_nodes_tends_to_the_joint_at_a_node(n):
    """``w = -F b^2 (a + b) / (3 EI)``, less what an element does not know of a force R inside.

    The shape functions hold what its ends do; R in the middle bends an element of length h by
    ``R h^3 / (192 EI)`` more. With R = 2 F the end of the beam yields less by the share h^3/4.
    """
    exact = -1000.0 * 0.5**2 / (3.0 * STEEL.E * SECTION.Iy)
    assert overhang(n - 1, node=True) == pytest.approx(exact, rel=1e-5)
    assert overhang(n, node=False) / exact - 1.0 == pytest.approx(-0.25 / n**3, rel=0.01, abs=4e-6)


def test_points_outside_are_refused_with_their_distance():
    rod, bar = FlexibleBody("rod", beam(4)), FlexibleBody("bar", block())
    with pytest.raises(
        jo.InputError, match=r"body 'rod': point \(1.2, 0, 0\) lies 0.2 m from the axis"
    ):
        rod.at((1.2, 0, 0))
    with pytest.raises(
        jo.InputError, match=r"body 'bar': point \(0.4, 0.25, 0\) lies 0.2 m outside"
    ):
        bar.at((0.4, 0.25, 0.0))
    with pytest.raises(jo.InputError, match=r"body 'rod': position of the marker has shape \(2,\)"):
        rod.at((1.0, 0.0))
    assert bar.at((0.4, 0.05, 0.0)).label == "bar.at(0.4, 0.05, 0)"  # on the surface
    assert bar.at((0.4, 0.05, 0.0), name="pad").label == "bar.pad"


def test_joints_tell_points_of_a_body_apart():
    rod = FlexibleBody("rod", beam(4))
    a, b = rod.at((0.3, 0, 0)), rod.at((0.6, 0, 0))
    assert a.site != b.site
    assert a.turned(jo.Rotate.euler("ZYX", degrees=(30, 0, 0))).site == rod.at((0.3, 0, 0)).site
    jo.Displacement(a, b, "x")
    with pytest.raises(jo.InputError, match="connects rod.at"):
        jo.Mechanism(rod, jo.Spherical("ball", a, rod.at((0.3, 0, 0))))


@pytest.mark.filterwarnings("ignore:.*leave out.*", "ignore:.*no interface.*")
def test_the_moving_frame_agrees_at_points_between_nodes():
    """A pendulum hung at a point of a solid and pushed at another: two formulations, one motion."""
    bar = FlexibleBody("bar", block((8, 2, 2)))
    mechanism = jo.Mechanism(
        bar,
        jo.Spherical("pivot", jo.ground.at((0.03, 0.01, 0.02)), bar.at((0.03, 0.01, 0.02))),
        jo.Force("push", bar.at((0.71, 0.0, 0.01)), (0.0, 300.0, 0.0)),
        jo.PositionSensor("tip", bar.at((0.77, 0.0, 0.0))),
        jo.Gravity((0, 0, -9.81)),
    )
    assert jo.verify(mechanism, 0.02).different == ()


@pytest.mark.filterwarnings("ignore:.*no interface.*")
def test_stiffening_follows_an_arm():
    """A section turned by theta moves the end of a rigid arm by ``theta x (theta x s) / 2``.

    The rotation vector itself has a second order, too.
    """
    part = jo.Part.beam(1.0, SECTION, 4, STEEL)
    reduced = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2), stiffening=True)
    s, p = np.array([0.0, 0.02, 0.01]), np.random.default_rng(1).normal(size=reduced.n)
    on, off = (FlexibleBody("rod", reduced).at(x) for x in ((0.6, 0, 0), (0.6, *s[1:])))
    assert on.chi is not None and off.chi is not None
    more = np.einsum("aij,i,j->a", off.chi - on.chi, p, p)[:3]
    theta, second = on.Psi @ p, np.einsum("aij,i,j->a", on.chi, p, p)[3:]
    exact = np.cross(theta, np.cross(theta, s)) + np.cross(second, s)
    np.testing.assert_allclose(more, exact, atol=1e-9 * np.abs(exact).max())
