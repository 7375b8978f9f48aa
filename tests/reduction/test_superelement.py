"""Superelements against the full model that they were condensed from."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
from numpy.testing import assert_allclose

import jousto as jo
from jousto.base.errors import InputError, JoustoWarning
from jousto.materials.material import Material
from jousto.parts.part import Part
from jousto.sections.section import Tube

# a bent frame without symmetry: no two frequencies are equal
FRAME = Part.frame(
    [(0, 0, 0), (0.3, 0, 0), (0.6, 0.1, 0), (0.9, 0.3, 0.1), (1.0, 0.6, 0.3)],
    [(0, 1), (1, 2), (2, 3), (3, 4)],
    sections=Tube(0.05, 0.004),
    materials=Material(E=210e9, nu=0.3, rho=7850.0),
    node_sets={"foot": (0,), "tip": (4,)},
)
B = np.r_[0:6, 24:30]
I = np.setdiff1d(np.arange(30), B)


def condensed(modes: int, part: Part = FRAME) -> jo.parts.Matrices:
    """Return Craig and Bampton's matrices as another program would write them: B, then q."""
    K, M = part.K.toarray(), part.M.toarray()
    phi_c = -np.linalg.solve(K[np.ix_(I, I)], K[np.ix_(I, B)])
    # in flexibility form, where masses of rotations may be zero
    phi_n = scipy.linalg.eigh(M[np.ix_(I, I)], K[np.ix_(I, I)])[1][:, ::-1]
    T = np.zeros((30, 12 + modes))
    T[B, :12] = np.eye(12)
    T[I, :12] = phi_c
    T[I, 12:] = phi_n[:, :modes]
    dofs = [(n, c) for n in (101, 205) for c in range(1, 7)]
    dofs += [(9001 + j, 0) for j in range(modes)]
    return jo.parts.Matrices(
        name="arm",
        K=T.T @ K @ T,
        M=T.T @ M @ T,
        dofs=np.array(dofs),
        node_ids=np.array([101, 205]),
        nodes=FRAME.nodes[[0, 4]],
        node_sets={"tip": np.array([205])},
    )


@pytest.mark.parametrize("modes", [0, 5])
def test_the_same_as_reducing_the_full_model(modes: int) -> None:
    # B is static condensation and fixed-interface modes, so is CraigBampton
    full = jo.reduce(FRAME, jo.CraigBampton(interfaces=("foot", "tip"), modes=modes))
    reduced = jo.reduction.reduce_superelement(condensed(modes))
    assert reduced.n == full.n == 6 + modes
    assert_allclose(reduced.frequencies, full.frequencies, rtol=1e-9)
    assert reduced.node("tip") == reduced.node("n205") == 1
    # modes up to their sign
    ours, theirs = reduced.modes, full.modes[[0, 4]]
    sign = np.sign(np.sum(ours * theirs, axis=(0, 1)))
    assert_allclose(ours, theirs * sign, atol=1e-7 * np.abs(theirs).max())
    assert reduced.rotations is not None and full.rotations is not None
    turns = full.rotations[[0, 4]] * sign
    assert_allclose(reduced.rotations, turns, atol=1e-7 * np.abs(turns).max())
    # what is exact: mass, its moments, momentum, energy
    a, b = reduced.invariants, full.invariants
    assert a.mass == pytest.approx(b.mass, rel=1e-11)
    assert_allclose(a.I2, b.I2, rtol=1e-10, atol=1e-12)
    J = a.mass * np.abs(FRAME.nodes).max() ** 2
    # (the consistent mass of beams as points in the full model differs in rotary inertia)
    assert_allclose(a.I7, FRAME_INERTIA, atol=1e-9 * J)
    assert_allclose(a.I3, b.I3 * sign, atol=1e-8 * np.abs(b.I3).max() + 1e-9)
    assert_allclose(a.I6, np.eye(reduced.n), atol=1e-9)


def test_ends_that_turn_without_mass_stay_as_soft_as_they_are() -> None:
    part = Part.frame(
        FRAME.nodes,
        [(0, 1), (1, 2), (2, 3), (3, 4)],
        sections=Tube(0.05, 0.004),
        materials=Material(E=210e9, nu=0.3, rho=7850.0),
        node_sets={"foot": (0,), "tip": (4,)},
        lumped=True,
        rotary_inertia=False,
    )
    reduced = jo.reduction.reduce_superelement(condensed(0, part))
    assert reduced.rotations is not None
    X = np.concatenate([reduced.modes, reduced.rotations], axis=1).reshape(12, -1)
    # the response of the free body to every balanced load on both ends
    R = part.rigid_modes()[B]
    F = scipy.linalg.null_space(R.T)
    found = F.T @ X @ (X / reduced.stiffness).T @ F
    K = sp.csr_array(condensed(0, part).K).toarray()
    assert_allclose(found, F.T @ np.linalg.pinv(K, rcond=1e-9) @ F, rtol=1e-6, atol=1e-12)


def inertia_about_origin() -> np.ndarray:
    R = FRAME.rigid_modes()
    return np.asarray(R.T @ (FRAME.M @ R))[3:, 3:]


FRAME_INERTIA = inertia_about_origin()


def test_limits() -> None:
    matrices = condensed(5)
    every = jo.reduction.reduce_superelement(matrices)
    some = jo.reduction.reduce_superelement(matrices, modes=4)
    assert_allclose(some.frequencies, every.frequencies[:4])
    below = jo.reduction.reduce_superelement(
        matrices, frequency_limit=float(every.frequencies[2]) * 1.01
    )
    assert below.n == 3 and below.interfaces == () and every.interfaces == ("n101", "n205")
    with pytest.raises(InputError, match="20 modes are requested, the superelement has 11 modes"):
        jo.reduction.reduce_superelement(matrices, modes=20)


def test_condensed_nodes_alone_are_a_part() -> None:
    # without modal coordinates the matrices go the way of all others
    from jousto.parts.matrices.matrices import nodal

    ordered = nodal(condensed(0))
    part = Part.from_matrices(ordered.M, ordered.K, ordered.nodes, node_sets=ordered.node_sets)
    ends = jo.reduce(part, jo.CraigBampton(interfaces=("n101", "n205"), modes=0))
    direct = jo.reduction.reduce_superelement(condensed(0))
    assert_allclose(ends.frequencies, direct.frequencies, rtol=1e-8)


def test_runs_in_a_mechanism() -> None:
    # a pendulum of the superelement falls as the full model does
    ends = []
    for reduced in (
        jo.reduce(FRAME, jo.CraigBampton(interfaces=("foot", "tip"), modes=3)),
        jo.reduction.reduce_superelement(condensed(3)),
    ):
        arm = jo.FlexibleBody("arm", reduced)
        pendulum = jo.Mechanism(
            arm,
            jo.Spherical("pivot", jo.ground["origin"], arm["node1"]),
            jo.Gravity((0.0, -9.81, 0.0)),
            jo.PositionSensor("tip", arm["tip"]),
        )
        run = jo.simulate(jo.compile(pendulum), t_end=0.3, solver=jo.ROS2(step=1e-3))
        ends.append(run["tip"][-1])
    # the inertia does not change with the deformation: 5 um of 1.2 m where the tip bends 0.2 mm
    assert_allclose(ends[1], ends[0], atol=5e-6)


def with_rows(matrices: jo.parts.Matrices, **matrix: np.ndarray) -> jo.parts.Matrices:
    return replace(matrices, **matrix)  # type: ignore[arg-type]


def test_refusals() -> None:
    good = condensed(2)
    K, M = good.K.toarray(), good.M.toarray()
    with pytest.raises(InputError, match="K is not free: a rigid translation"):
        held = K.copy()
        held[1, 1] *= 1.1
        jo.reduction.reduce_superelement(with_rows(good, K=held))
    with pytest.raises(InputError, match="K is not free: a rigid rotation"):
        jo.reduction.reduce_superelement(replace(good, nodes=1000.0 * good.nodes))
    with pytest.raises(InputError, match="the mass is not the same in all directions"):
        heavy = M.copy()
        heavy[0, 0] += 1.0
        jo.reduction.reduce_superelement(with_rows(good, M=heavy))
    with pytest.raises(InputError, match="M contains no mass"):
        jo.reduction.reduce_superelement(with_rows(good, M=0.0 * M))
    with pytest.raises(InputError, match="more free motions than the six"):
        loose = K.copy()
        loose[12:] = loose[:, 12:] = 0.0
        jo.reduction.reduce_superelement(with_rows(good, K=loose))
    with pytest.raises(InputError, match="K is not symmetric"):
        jo.reduction.reduce_superelement(with_rows(good, K=np.triu(K)))
    with pytest.raises(InputError, match="M is not positive semidefinite"):
        negative = M.copy()
        negative[12, 12] = -1.0
        jo.reduction.reduce_superelement(with_rows(good, M=negative))
    with pytest.raises(InputError, match="written with supports"):
        jo.reduction.reduce_superelement(replace(good, held=np.array([[101, 1]])))


def test_nodes_with_and_without_rotations() -> None:
    # node 300 keeps its translations, node 205 all directions, node 101 but two of them
    K, M = FRAME.K.toarray(), FRAME.M.toarray()
    rows = np.r_[0:2, 12:15, 24:30]
    rest = np.setdiff1d(np.arange(30), rows)
    T = np.zeros((30, len(rows)))
    T[rows, np.arange(len(rows))] = 1.0
    T[rest] = -np.linalg.solve(K[np.ix_(rest, rest)], K[np.ix_(rest, rows)])
    dofs = [(101, 1), (101, 2), (300, 1), (300, 2), (300, 3), *((205, c) for c in range(1, 7))]
    matrices = jo.parts.Matrices(
        name="arm",
        K=T.T @ K @ T,
        M=T.T @ M @ T,
        dofs=np.array(dofs),
        node_ids=np.array([101, 205, 300]),
        nodes=FRAME.nodes[[0, 4, 2]],
    )
    with pytest.warns(JoustoWarning, match="1 node without all translations cannot carry markers"):
        reduced = jo.reduction.reduce_superelement(matrices)
    assert reduced.n == len(rows) - 6
    assert_allclose(reduced.nodes, FRAME.nodes[[4, 2]])
    assert reduced.rotation_nodes is not None and list(reduced.rotation_nodes) == [0]
    assert reduced.rotation(reduced.node("n300")) is None
    # compliance between loads without resultant: the same as that of the full model
    R = FRAME.rigid_modes()[rows]
    balanced = np.eye(len(rows)) - R @ np.linalg.pinv(R)
    exact = balanced @ np.linalg.pinv(matrices.K.toarray()) @ balanced
    turns = reduced.rotation(0)
    assert turns is not None
    X = np.vstack([reduced.modes[1], reduced.modes[0], turns])
    at = np.r_[2:5, 5:8, 8:11]
    ours = X @ np.diag(1.0 / reduced.stiffness) @ X.T
    G = FRAME.rigid_modes()[np.r_[12:15, 24:30]]
    loads = np.eye(9) - G @ np.linalg.pinv(G)
    assert_allclose(
        loads @ ours @ loads, loads @ exact[np.ix_(at, at)] @ loads, rtol=1e-7, atol=1e-16
    )


def test_condensed_matrices_as_a_part_are_noticed(tmp_path: Path) -> None:
    K, M = FRAME.K.toarray(), FRAME.M.toarray()
    rows = np.r_[0:6, 12:18, 24:30]
    rest = np.setdiff1d(np.arange(30), rows)
    T = np.zeros((30, 18))
    T[rows, np.arange(18)] = 1.0
    T[rest] = -np.linalg.solve(K[np.ix_(rest, rest)], K[np.ix_(rest, rows)])
    dofs = np.array([(n, c) for n in (1, 3, 5) for c in range(1, 7)])
    # in a chain the middle node parts the others; Guyan's mass couples all the same when more
    # than static shapes are kept, so fill the blocks as a general condensation does
    noise = np.random.default_rng(2).normal(size=(18, 18)) * 1e-9
    np.savez(
        tmp_path / "arm.npz",
        K=T.T @ K @ T,
        M=T.T @ M @ T + noise + noise.T,
        dofs=dofs,
        nodes=np.column_stack([[1, 3, 5], FRAME.nodes[::2]]),
    )
    with pytest.warns(JoustoWarning, match="every node is coupled with every other"):
        Part.from_file(tmp_path / "arm.npz")
