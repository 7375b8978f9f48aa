"""Interfaces of solids: exact stretch, bending and weights, beams against rigid ties, markers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import jousto as jo
from jousto.base.errors import InputError
from jousto.materials.material import Material
from jousto.mesh.cells import Cells
from jousto.mesh.mesh import Mesh
from jousto.mesh.picks import InBox
from jousto.parts.frames.element import EulerBernoulli
from jousto.parts.interface import Interface
from jousto.parts.part import Part
from jousto.reduction.methods import CraigBampton
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.reducer import reduce
from jousto.sections.section import GeneralSection, Rectangle
from parts.grids import grid

Array = NDArray[np.float64]
STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
L, B, H = 0.5, 0.08, 0.06
KINDS = ("tetra", "tetra10", "hexahedron", "hexahedron20", "wedge", "wedge15")


def bar(kind: str, counts: tuple[int, int, int] = (3, 2, 1), ties: Any = "average") -> Part:
    """A bar along x about the x axis, tied at both ends, the faces known."""
    made = grid(kind, counts, (L, B, H))
    cells = tuple(Cells(c.kind, c.nodes, c.ids) for c in made.cells)
    nodes = np.asarray(made.nodes) - [0.0, B / 2, H / 2]
    part = Part.solid(Mesh("bar", nodes, cells), STEEL)
    return part.with_interfaces(
        Interface("a", InBox((0, -1, -1), (0, 1, 1)), kind=ties),
        Interface("b", InBox((L, -1, -1), (L, 1, 1)), kind=ties),
    )


def pulled(reduced: ReducedPart, wrench: Array) -> Array:
    """Displacements (nn, 3) under opposite forces and moments at the two ends, a at rest."""
    a, b = reduced.node("a"), reduced.node("b")
    q = [np.concatenate([reduced.modes[k], np.asarray(reduced.rotation(k))]) for k in (a, b)]
    # the same force line at both ends
    F, M = wrench[:3], wrench[3:]
    other = np.concatenate([-F, -M - np.cross(reduced.nodes[b] - reduced.nodes[a], F)])
    p = (q[1].T @ wrench + q[0].T @ other) / reduced.stiffness
    u = reduced.modes @ p
    at_a = q[0] @ p
    rigid = at_a[:3] + np.cross(at_a[3:], reduced.nodes - reduced.nodes[a])
    return np.asarray(u - rigid)


@pytest.mark.parametrize("kind", KINDS)
def test_averages_keep_stretch_and_contraction_exact(kind: str) -> None:
    """u = F/(E A) [x, -nu y, -nu z]: the ends shrink freely, the traction is even."""
    part = bar(kind)
    assert all(tie.by_area for tie in part.ties)
    reduced = reduce(part, CraigBampton(modes=0))
    assert reduced.n == 6
    F = 1e6
    x = reduced.nodes
    exact = F / (STEEL.E * B * H) * x * [1.0, -STEEL.nu, -STEEL.nu]
    found = pulled(reduced, np.array([F, 0, 0, 0, 0, 0]))
    np.testing.assert_allclose(found, exact, atol=1e-9 * exact.max())
    # a rigid tie holds the end in its shape, so that the bar is stiffer
    stiff = bar(kind, ties="rigid")
    held = pulled(reduce(stiff, CraigBampton(modes=0)), np.array([F, 0, 0, 0, 0, 0]))
    tie = stiff.ties[1]
    q = tie.averaging @ held[tie.nodes].ravel()
    shape = (tie.following @ q) - held[tie.nodes]
    assert np.abs(shape).max() < 1e-12 * exact.max()
    assert held[-1, 0] < 0.999 * exact[-1, 0]


@pytest.mark.parametrize("kind", ["tetra10", "hexahedron20", "wedge15"])
def test_averages_bend_without_disturbance(kind: str) -> None:
    """By a moment: [-x y, (x^2 + nu (y^2 - z^2))/2, nu y z] M/(E I)."""
    part = bar(kind)
    reduced = reduce(part, CraigBampton(modes=0))
    M, I = 1e4, B**3 * H / 12.0
    x, y, z = reduced.nodes.T
    k = M / (STEEL.E * I)
    nu = STEEL.nu
    exact = k * np.stack([-x * y, 0.5 * (x**2 + nu * (y**2 - z**2)), nu * y * z], axis=1)
    # the mean of the end a rests
    tie = part.ties[0]
    q = tie.averaging @ exact[tie.nodes].ravel()
    exact = exact - q[:3] - np.cross(q[3:], reduced.nodes)
    exact[-2:] = [t.averaging[:3] @ exact[t.nodes].ravel() for t in part.ties]
    found = pulled(reduced, np.array([0, 0, 0, 0, 0, M]))
    np.testing.assert_allclose(found, exact, atol=1e-9 * np.abs(exact).max())
    # the slope of the end is M L/(E I)
    turn = np.asarray(reduced.rotation(reduced.node("b")))
    first = np.asarray(reduced.rotation(reduced.node("a")))
    p = (turn - first)[2] * M / reduced.stiffness
    assert ((turn - first) @ p)[2] == pytest.approx(M * L / (STEEL.E * I), rel=1e-9)


def test_equal_weights_disturb_the_end() -> None:
    """Without the faces the nodes share the force evenly, and the end is not plane."""
    part = replace(bar("tetra10"), faces=())
    assert not any(tie.by_area for tie in part.ties)
    found = pulled(reduce(part, CraigBampton(modes=0)), np.array([1e6, 0, 0, 0, 0, 0]))
    exact = 1e6 / (STEEL.E * B * H) * L
    assert np.abs(found[:, 0].max() / exact - 1.0) > 1e-3


@pytest.mark.filterwarnings("ignore:.*is larger than the part")
def test_rigid_tie_is_the_limit_of_stiff_beams() -> None:
    """Three legs of beams meet a plate of rigid arms: beams ever stiffer there come to the tie."""
    feet = np.array([[0.0, 0.0, 0.0], [0.6, 0.0, 0.0], [0.2, 0.5, 0.0]])
    heads = feet + [0.05, -0.02, 0.4]
    hub = np.array([0.3, 0.2, 0.5])
    x = np.concatenate([feet, heads])
    legs = [(0, 3), (1, 4), (2, 5), (0, 1), (1, 2)]
    section = Rectangle(0.02, 0.03)

    def tip(part: Part, name: str) -> Array:
        dofs = np.arange(18, part.K.shape[0])
        if part.ties:
            reduced = reduce(part, CraigBampton(("feet", "hub"), modes=0))
            k = reduced.node("hub")
            nodes = [*range(3), k]
            Y = np.concatenate([reduced.modes, reduced.rotations], axis=1)
            R = np.zeros((len(reduced.nodes), 6, 6))
            R[:, :3, :3] = R[:, 3:, 3:] = np.eye(3)
            for c, e in enumerate(np.eye(3)):
                R[:, :3, 3 + c] = np.cross(e, reduced.nodes)
            Y = np.concatenate([R, Y], axis=2)[nodes]
            A = np.diag(np.r_[np.zeros(6), reduced.stiffness])
            C = Y[:3].reshape(18, -1)
            full = np.block([[A, C.T], [C, np.zeros((18, 18))]])
            f = np.concatenate([Y[3].T, np.zeros((18, 6))])
            s = 1.0 / np.sqrt(np.abs(full).max(axis=1))
            p = s[:, None] * np.linalg.solve(s[:, None] * full * s, s[:, None] * f)
            return np.asarray(Y[3] @ p[: Y.shape[2]])
        K = part.K.toarray()[np.ix_(dofs, dofs)]
        f = np.zeros((len(dofs), 6))
        f[-6:] = np.eye(6)
        return np.asarray(np.linalg.solve(K, f)[-6:])

    tied = Part.frame(
        x,
        legs,
        sections=section,
        materials=STEEL,
        node_sets={"feet": (0, 1, 2)},
        theory=EulerBernoulli(),
    ).with_interfaces(Interface("hub", (3, 4, 5), at=hub))
    truth = tip(tied, "hub")
    errors = []
    for factor in (1e3, 1e5):
        s = section
        stiff = GeneralSection(A=s.A * factor, Iy=s.Iy * factor, Iz=s.Iz * factor, J=s.J * factor)
        arms = Part.frame(
            np.concatenate([x, [hub]]), [*legs, (3, 6), (4, 6), (5, 6)],
            sections=[section] * 5 + [stiff] * 3, materials=STEEL, theory=EulerBernoulli(),
        )  # fmt: skip
        errors.append(np.abs(tip(arms, "") - truth).max() / np.abs(truth).max())
    assert errors[1] < 2e-4
    # first order in the compliance of the arms, and what the next order of the softer ones leaves
    assert errors[0] / errors[1] == pytest.approx(100.0, rel=0.1)


# -- the reduced part -----------------------------------------------------------------------


def test_reference_nodes_are_markers_that_turn(tmp_path: Any) -> None:
    part = bar("hexahedron20")
    reduced = reduce(part, CraigBampton(("a",), modes=3))
    nn = len(part.nodes)
    assert reduced.node("a") == nn and reduced.node("b") == nn + 1
    assert reduced.node_sets["b.nodes"] == tuple(part.ties[1].nodes)
    np.testing.assert_array_equal(np.asarray(reduced.rotation_nodes), [nn, nn + 1])
    assert reduced.rotation(3) is None
    # where the nodes are, in a file as well
    reduced.save(tmp_path / "bar.h5")
    again = ReducedPart.load(tmp_path / "bar.h5")
    np.testing.assert_array_equal(again.rotation_nodes, reduced.rotation_nodes)
    np.testing.assert_array_equal(again.rotations, reduced.rotations)
    # its motion is the average of its nodes
    for tie in part.ties:
        q = tie.averaging @ reduced.modes[tie.nodes].reshape(-1, reduced.n)
        k = reduced.node(tie.name)
        np.testing.assert_allclose(reduced.modes[k], q[:3], atol=1e-12 * np.abs(q).max())
        np.testing.assert_allclose(reduced.rotation(k), q[3:], atol=1e-12 * np.abs(q).max())
    few = reduced.keep([0, 2])
    assert few.rotation(nn) is not None and np.shape(few.rotation(nn)) == (3, 2)


def test_a_file_of_version_1_is_read(tmp_path: Any) -> None:
    import h5py

    from reduction.bodies import bent

    reduce(bent(), CraigBampton(("start",), modes=2)).save(tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        file.attrs["version"] = 1
        assert "rotation_nodes" not in file
    assert ReducedPart.load(tmp_path / "a.h5").n == 2


def test_joints_need_a_node_that_turns() -> None:
    reduced = reduce(bar("hexahedron"), CraigBampton(modes=2))
    body = jo.FlexibleBody("bar", reduced)
    with pytest.raises(InputError, match=r"bar\.node1 has no.*nodes with rotations are 'a', 'b'"):
        jo.Mechanism(body, jo.Fixed("clamp", jo.ground["origin"], body["node1"]))


@pytest.mark.parametrize("ties", ["rigid", "average"])
def test_bar_in_a_mechanism_rests_where_statics_say(ties: Any) -> None:
    """Clamped at one interface, force and torque on the other: a small load, linear statics."""
    part = bar("hexahedron20", ties=ties)
    reduced = reduce(part, CraigBampton(modes=4))
    body = jo.FlexibleBody("bar", reduced)
    F, T = np.array([3.0, 5.0, -2.0]), np.array([0.7, -0.3, 0.5])
    mechanism = jo.Mechanism(
        body,
        jo.Fixed("clamp", jo.ground["origin"], body["a"]),
        jo.Force("F", body["b"], F),
        jo.Torque("T", body["b"], T),
    )
    rest = jo.equilibrium(jo.compile(mechanism))
    p = np.asarray(rest.q)[7:]
    # the modal coordinates balance the loads and the reactions at the clamp, which balance them
    a, b = reduced.node("a"), reduced.node("b")
    q = [np.concatenate([reduced.modes[k], np.asarray(reduced.rotation(k))]) for k in (a, b)]
    other = np.concatenate([-F, -T - np.cross(reduced.nodes[b] - reduced.nodes[a], F)])
    exact = (q[1].T @ np.concatenate([F, T]) + q[0].T @ other) / reduced.stiffness
    np.testing.assert_allclose(p, exact, atol=1e-5 * np.abs(exact).max())


def test_gauge_on_a_solid_is_exact_under_every_load(rng: np.random.Generator) -> None:
    """Both ends held, random loads: the stress at one site is that of the full model."""
    part = bar("hexahedron20", (3, 1, 1), ties="rigid")
    assert part.stress is not None
    site = part.stress.sites[20]
    loads = rng.standard_normal((part.K.shape[0], 3))
    # the full model: tied nodes at rest
    free = np.setdiff1d(np.arange(len(loads)), np.concatenate([t.dofs for t in part.ties]))
    u = np.zeros(loads.shape)
    u[free] = np.linalg.solve(part.K.toarray()[np.ix_(free, free)], loads[free])
    truth = part.stress.evaluate(u)[20]
    errors = []
    for residuals in ((), (site,)):
        reduced = reduce(part, CraigBampton(modes=2, residuals=residuals))
        assert reduced.stress is not None
        X = reduced.modes[: len(part.nodes)].reshape(-1, reduced.n)
        Y = np.concatenate([part.rigid_modes(), X / np.sqrt(reduced.stiffness)], axis=1)
        held = Y[np.concatenate([t.dofs for t in part.ties])]
        _, s, V = np.linalg.svd(held / np.abs(held).max(axis=0))
        Z = V[int(np.sum(s > 1e-9 * s[0])) :].T / np.abs(held).max(axis=0)[:, None]
        p = Z @ np.linalg.solve(Z[6:].T @ Z[6:], Z.T @ (Y.T @ loads))
        found = reduced.stress.modes[20] @ (p[6:] / np.sqrt(reduced.stiffness)[:, None])
        errors.append(np.abs(found - truth).max() / np.abs(truth).max())
    assert errors[0] > 0.1 and errors[1] < 1e-8
