"""Craig-Bampton and free-free reduction: laws that hold for every part."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
from hypothesis import given, settings, strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from jousto.base.errors import InputError, JoustoWarning
from jousto.parts.part import Part
from jousto.reduction.methods import CraigBampton, FreeFree
from jousto.reduction.modes import eigen, rigid
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.reducer import reduce
from jousto.sections.section import Rectangle, Tube
from reduction.bodies import (
    STEEL,
    bent,
    dofs,
    general_section,
    lattice,
    pendulum,
    turned,
    without_points,
)

PARTS = {
    "bent": bent,
    "bent-lumped": lambda: bent(lumped=True),
    "bent-massless-rotations": lambda: bent(lumped=True, rotary=False, mass=False),
    "bent-from-matrices": lambda: without_points(bent()),
    "lattice": lattice,
}


def interface(part: Part) -> tuple[str, ...]:
    return ("foot",) if part.dofs_per_node == 3 else ("start",)


def full_frequencies(part: Part, held: list[int]) -> np.ndarray:
    """All finite frequencies of the whole model in Hz by a dense generalized eigenproblem."""
    free = np.setdiff1d(np.arange(part.K.shape[0]), held)
    K, M = part.K.toarray()[np.ix_(free, free)], part.M.toarray()[np.ix_(free, free)]
    # massless degrees of freedom by static condensation
    massless = np.flatnonzero(~M.any(axis=0))
    moving = np.flatnonzero(M.any(axis=0))
    if len(massless):
        K = K[np.ix_(moving, moving)] - K[np.ix_(moving, massless)] @ np.linalg.solve(
            K[np.ix_(massless, massless)], K[np.ix_(massless, moving)]
        )
        M = M[np.ix_(moving, moving)]
    squares = scipy.linalg.eigh(K, M, eigvals_only=True)
    return np.sqrt(np.maximum(squares, 0.0)) / (2.0 * np.pi)


def interior_modes(part: Part) -> int:
    held = [part.dofs_per_node * k + a for s in interface(part) for k in part.node_sets[s]
            for a in range(part.dofs_per_node)]  # fmt: skip
    return len(full_frequencies(part, held))


@pytest.mark.parametrize("name", PARTS)
def test_modes_are_orthonormal_and_free_of_rigid_motion(name: str) -> None:
    part = PARTS[name]()
    for method in (CraigBampton(interface(part), modes=5), FreeFree(modes=5)):
        r = reduce(part, method)
        X = dofs(r.modes, r.rotations)
        omega = 2.0 * np.pi * r.frequencies
        assert X.T @ part.M @ X == pytest.approx(np.eye(r.n), abs=1e-10)
        K = X.T @ part.K @ X / np.outer(omega, omega)
        assert K == pytest.approx(np.eye(r.n), abs=1e-7)
        assert np.abs(part.rigid_modes().T @ part.M @ X).max() < 1e-10
        assert np.all(np.diff(r.frequencies) >= 0.0)
        assert r.stiffness == pytest.approx(omega**2)


def moves_mass(r: ReducedPart) -> NDArray[np.bool_]:
    """Which modes move mass: the modal mass of the others is not that of the mesh."""
    return np.asarray(np.diag(r.invariants.I6) > 0.5)


@pytest.mark.parametrize("name", PARTS)
def test_all_fixed_interface_modes_give_the_full_model(name: str) -> None:
    part = PARTS[name]()
    truth = full_frequencies(part, [])
    r = reduce(part, CraigBampton(interface(part), modes=interior_modes(part)))
    # what moves no mass has no frequency in the full model; in the reduced one its shape is kept
    moving = moves_mass(r)
    # the six rigid modes are zero up to rounding in the full model, and left out in the reduced one
    assert moving.sum() == len(truth) - 6
    assert r.frequencies[moving] == pytest.approx(truth[6:], rel=1e-9)
    free = reduce(part, FreeFree(modes=int(moving.sum())))
    assert free.frequencies == pytest.approx(truth[6:], rel=1e-9)


@pytest.mark.parametrize("name", ["bent", "lattice"])
def test_held_at_the_interface_it_is_the_clamped_model(name: str) -> None:
    part = PARTS[name]()
    r = reduce(part, CraigBampton(interface(part), modes=interior_modes(part)))
    held = part.node_sets[interface(part)[0]]
    d = part.dofs_per_node
    clamped = full_frequencies(part, [d * k + a for k in held for a in range(d)])
    # hold the interface of modal plus rigid coordinates: null space of its displacements
    X = np.hstack([part.rigid_modes(), dofs(r.modes, r.rotations)])
    K = scipy.linalg.block_diag(np.zeros((6, 6)), np.diag(r.stiffness))
    M = X.T @ part.M @ X
    B = X.reshape(-1, d, X.shape[1])[list(held)].reshape(-1, X.shape[1])
    Z = scipy.linalg.null_space(B, rcond=1e-9)
    squares = scipy.linalg.eigh(Z.T @ K @ Z, Z.T @ M @ Z, eigvals_only=True)
    assert np.sqrt(squares) / (2.0 * np.pi) == pytest.approx(clamped, rel=1e-8)


@pytest.mark.parametrize("name", PARTS)
def test_frequencies_converge_from_above(name: str) -> None:
    part = PARTS[name]()
    truth = full_frequencies(part, [])[6:]
    before = np.full(3, np.inf)
    for modes in (3, 6, 9):
        found = reduce(part, CraigBampton(interface(part), modes=modes)).frequencies[:3]
        assert np.all(found <= before * (1.0 + 1e-10))
        assert np.all(found >= truth[:3] * (1.0 - 1e-10))
        before = found
    assert before == pytest.approx(truth[:3], rel=5e-3)


def test_number_of_modes() -> None:
    part = bent()
    assert reduce(part, CraigBampton(("start",), modes=4)).n == 4
    assert reduce(part, CraigBampton(("start", "end"), modes=4)).n == 10
    assert reduce(part, CraigBampton(("both",), modes=4)).n == 10
    assert reduce(part, CraigBampton(("start", "end", "node4"), modes=0)).n == 12
    assert reduce(part, CraigBampton("end", modes=2)).interfaces == ("end",)


def test_two_interfaces_hold_every_static_load_between_them() -> None:
    """Constraint modes make the deformation under interface loads exact, whatever the modes."""
    part = bent()
    r = reduce(part, CraigBampton(("start", "end"), modes=0))
    K = part.K.toarray()
    b = np.r_[0:6, K.shape[0] - 6 : K.shape[0]]
    i = np.setdiff1d(np.arange(K.shape[0]), b)
    # any relative displacement of the two ends, interior at rest under no load
    d = np.zeros((K.shape[0], 6))
    d[b[6:]] = np.eye(6)
    d[i] = -np.linalg.solve(K[np.ix_(i, i)], K[np.ix_(i, b)] @ d[b])
    basis = np.hstack([part.rigid_modes(), dofs(r.modes, r.rotations)])
    residual = d - basis @ np.linalg.lstsq(basis, d, rcond=None)[0]
    assert np.abs(residual).max() < 1e-10


def test_frequency_limit() -> None:
    part = bent()
    clamped = full_frequencies(part, list(range(6)))
    limit = 0.5 * (clamped[6] + clamped[7])
    assert reduce(part, CraigBampton(("start",), frequency_limit=limit)).n == 7
    assert reduce(part, CraigBampton(("start",), modes=3, frequency_limit=limit)).n == 3
    assert reduce(part, CraigBampton(("start",), modes=9, frequency_limit=limit)).n == 7
    free = full_frequencies(part, [])[6:]
    found = reduce(part, FreeFree(frequency_limit=1.0001 * free[3])).frequencies
    assert found == pytest.approx(free[:4], rel=1e-9)


def test_large_parts_give_the_same_modes() -> None:
    """Lanczos and dense solution, with all frequencies of the square beam double."""
    part = Part.beam(3.0, Rectangle(0.05, 0.05), 40, STEEL)
    for method in (
        CraigBampton(("start", "end"), modes=6),
        FreeFree(modes=8),
        CraigBampton(("start",), frequency_limit=800.0),
    ):
        with pytest.MonkeyPatch.context() as patch:
            dense = reduce(part, method)
            patch.setattr(eigen, "DENSE_LIMIT", 0)
            sparse = reduce(part, method)
        assert sparse.frequencies == pytest.approx(dense.frequencies, rel=1e-8)
        assert sparse.modes == pytest.approx(dense.modes, abs=1e-6)


def test_frequency_limit_of_a_large_part(monkeypatch: pytest.MonkeyPatch) -> None:
    """The number of modes is not known beforehand: Lanczos is repeated with more of them."""
    part = Part.beam(3.0, Rectangle(0.05, 0.04), 50, STEEL)
    limit = 0.5 * full_frequencies(part, [])[[6 + 39, 6 + 40]].sum()
    monkeypatch.setattr(eigen, "DENSE_LIMIT", 0)
    assert reduce(part, FreeFree(frequency_limit=limit)).n == 40


def test_highest_modes_have_their_digits_too() -> None:
    """All 240 modes of a beam, over a factor of 4000 in frequency and mostly in equal pairs."""
    e = np.array([1.0, 2.0, -0.7]) / np.linalg.norm([1.0, 2.0, -0.7])
    part = Part.frame(
        np.linspace(0.0, 3.0, 41)[:, None] * e, np.column_stack([np.arange(40), np.arange(1, 41)]),
        sections=Rectangle(0.02, 0.02), materials=STEEL,
    )  # fmt: skip
    r = reduce(part, FreeFree(modes=240))
    X = dofs(r.modes, r.rotations)
    assert r.frequencies[-1] > 3000.0 * r.frequencies[0]
    assert np.abs(X.T @ part.M @ X - np.eye(240)).max() < 1e-13
    # high modes: the stiffness itself is accurate there
    high = X[:, 120:] / (2.0 * np.pi * r.frequencies[120:])
    assert np.abs(high.T @ part.K @ high - np.eye(120)).max() < 1e-6


def test_modes_that_are_not_orthonormal_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(eigen, "polish", lambda X, M: (np.einsum("ij,ij->j", X, M @ X), X))
    part = Part.beam(3.0, Rectangle(0.02, 0.02), 40, STEEL)
    with pytest.raises(InputError, match="could not be made orthonormal"):
        reduce(part, FreeFree(modes=240))


@pytest.mark.parametrize("offset", [1e-5, 1e-6])
def test_rigid_motions_of_a_body_almost_on_a_line(offset: float) -> None:
    """Inertia about the axis 1e-11 to 1e-13 of the other, in any direction in space."""
    part = pendulum(offset=offset)
    Q = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
    part = turned(part, Q, np.array([2.0, -1.0, 0.5]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", JoustoWarning)
        basis = rigid.mass_orthonormal_rigid_modes(part.M, part.nodes, 6, "part")
    assert np.abs(basis.R.T @ (part.M @ basis.R) - np.eye(6)).max() < 1e-14


def any_chain(seed: int, nn: int, lumped: bool, rotary: bool) -> Part:
    random = np.random.default_rng(seed)
    steps = random.uniform(0.2, 0.6, (nn, 3)) * random.choice([-1.0, 1.0], (nn, 3))
    return Part.frame(
        np.cumsum(steps, axis=0), np.column_stack([np.arange(nn - 1), np.arange(1, nn)]),
        sections=Rectangle(*random.uniform(0.02, 0.06, 2)), materials=STEEL,
        lumped=lumped, rotary_inertia=rotary, node_sets={"a": (0,), "b": (nn - 1,)},
    )  # fmt: skip


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1), st.integers(3, 6), st.booleans(), st.booleans())
def test_modes_of_any_chain_of_beams(seed: int, nn: int, lumped: bool, rotary: bool) -> None:
    part = any_chain(seed, nn, lumped, rotary)
    r = reduce(part, CraigBampton(("a", "b"), modes=2))
    X = dofs(r.modes, r.rotations)
    # near-massless modes (no rotary inertia) have products of large numbers that cancel
    size = 1e-10 + 1e-14 * np.abs(X).T @ abs(part.M) @ np.abs(X)
    moving = moves_mass(r)
    mass = np.diag(moving.astype(float))
    # motions without mass are scaled as if they had some: what mass they may have is scaled too
    still = eigen.MASSLESS / eigen.STAND_IN
    size += np.where(np.logical_and.outer(moving, moving), 0.0, still)
    assert np.all(np.abs(X.T @ part.M @ X - mass) < size)
    assert np.all(np.abs(r.invariants.I6 - mass) < size)
    R = part.rigid_modes()
    assert np.all(np.abs(R.T @ part.M @ X) < 1e-10 + 1e-13 * np.abs(R).T @ abs(part.M) @ np.abs(X))
    assert r.n == 8
    assert moving.all() or not rotary


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1), st.integers(3, 6), st.sampled_from([(0, 1), (1, 0), (1, 1)]))
def test_frequencies_of_any_chain_are_not_below_the_true_ones(
    seed: int, nn: int, kind: tuple[int, int]
) -> None:
    """Rayleigh and Ritz; consistent mass without rotary inertia leaves rotations without any."""
    part = any_chain(seed, nn, *map(bool, kind))
    r = reduce(part, CraigBampton(("a", "b"), modes=2))
    moving = moves_mass(r)
    truth = full_frequencies(part, [])[6:]
    assert moving.sum() > 0
    assert np.all(r.frequencies[moving] >= truth[: moving.sum()] * (1.0 - 1e-9))


def test_massless_rotations_are_solved_sparsely_too(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(eigen, "DENSE_LIMIT", 0)
    part = pendulum(offset=1e-3)
    r = reduce(part, CraigBampton(("start",), modes=2))
    assert r.frequencies.shape == (2,)


@pytest.mark.parametrize("name", ["bent", "bent-massless-rotations"])
def test_description_in_another_frame(name: str) -> None:
    part = PARTS[name]()
    Q = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
    shift = np.array([2.0, -1.0, 0.5])
    a = reduce(part, CraigBampton(("start", "end"), modes=4))
    b = reduce(turned(part, Q, shift), CraigBampton(("start", "end"), modes=4))
    assert b.frequencies == pytest.approx(a.frequencies, rel=1e-9)
    back = np.einsum("ba,kbj->kaj", Q, b.modes)
    sign = np.sign(np.einsum("kaj,kaj->j", back, a.modes))
    assert back * sign == pytest.approx(a.modes, abs=1e-7)
    E = np.einsum("ca,jkcd,db,j,k->jkab", Q, b.invariants.E, Q, sign, sign)
    assert E == pytest.approx(a.invariants.E, abs=1e-7)


def test_units_do_not_matter() -> None:
    """Millimetres, tonnes and seconds: the same frequencies, lengths a thousand times longer."""
    part = bent()
    # d = S d_mm; energies are in mJ
    S = sp.diags_array(np.tile([1e-3, 1e-3, 1e-3, 1.0, 1.0, 1.0], len(part.nodes)))
    scaled = Part.from_matrices(
        1e3 * S @ part.M @ S, 1e3 * S @ part.K @ S, 1e3 * part.nodes, name="bent",
        node_sets={"start": (0,), "end": (len(part.nodes) - 1,)},
    )  # fmt: skip
    a = reduce(without_points(part), CraigBampton(("start", "end"), modes=4))
    b = reduce(without_points(scaled), CraigBampton(("start", "end"), modes=4))
    assert b.frequencies == pytest.approx(a.frequencies, rel=1e-9)
    # kg -> t: masses 1e-3, modes (kg^-0.5) 10^1.5 and lengths 1e3
    assert b.invariants.mass == pytest.approx(1e-3 * a.invariants.mass)
    assert b.invariants.I7 == pytest.approx(1e3 * a.invariants.I7)
    assert b.invariants.E == pytest.approx(a.invariants.E, abs=1e-7)
    assert b.modes == pytest.approx(10**1.5 * a.modes, abs=1e-5)


def test_same_input_same_bytes() -> None:
    a, b = (reduce(bent(), CraigBampton(("start", "end"), modes=6)) for _ in range(2))
    assert a.modes.tobytes() == b.modes.tobytes()
    assert a.frequencies.tobytes() == b.frequencies.tobytes()
    assert a.invariants.E.tobytes() == b.invariants.E.tobytes()
    assert dict(a.provenance) == dict(b.provenance)
    assert a.provenance["input"] != reduce(bent(elements=4), FreeFree(modes=1)).provenance["input"]


def tube(axis: tuple[float, float, float]) -> Part:
    e = np.array(axis) / np.linalg.norm(axis)
    return Part.frame(
        np.linspace(0.0, 1.0, 9)[:, None] * e, np.column_stack([np.arange(8), np.arange(1, 9)]),
        sections=Tube(0.05, 0.003), materials=STEEL, node_sets={"start": (0,)},
    )  # fmt: skip


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 0, 1), (1, 0, 1), (0.5, 0.7, -0.2)])
def test_equal_frequencies_give_plane_modes(axis: tuple[float, float, float]) -> None:
    """A tube bends at the same frequency in every plane; the pair is turned into two planes."""
    r = reduce(tube(axis), CraigBampton(("start",), modes=4))
    assert r.frequencies[0] == pytest.approx(r.frequencies[1], rel=1e-9)
    for j in range(4):
        # translations of each bending mode along one line
        singular = np.linalg.svd(r.modes[:, :, j], compute_uv=False)
        assert singular[1] < 1e-6 * singular[0]


def test_modes_of_equal_frequencies_are_in_the_planes_of_the_axes() -> None:
    r = reduce(tube((1.0, 0.0, 0.0)), CraigBampton(("start",), modes=4))
    assert r.in_plane("xy") == (0, 2)
    assert r.in_plane("xz") == (1, 3)
    assert r.in_plane("yz") == ()


def test_in_plane_of_a_plane_frame() -> None:
    part = Part.frame(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [2, 1, 0]], [[0, 1], [1, 2], [2, 3]],
        sections=general_section(), materials=STEEL,
    )  # fmt: skip
    r = reduce(part, FreeFree(modes=12))
    plane = set(r.in_plane("xy"))
    assert 0 < len(plane) < 12
    for j in range(12):
        out = np.abs(r.modes[:, 2, j]).max() + np.abs(r.rotations[:, :2, j]).max()  # type: ignore[index]
        assert (out < 1e-6) == (j in plane)
    with pytest.raises(InputError, match="plane is 'xw', must be 'xy'"):
        r.in_plane("xw")


def test_modal_stress_is_that_of_the_mode() -> None:
    part = bent()
    assert part.stress is not None
    r = reduce(part, CraigBampton(("start",), modes=4))
    assert r.stress is not None
    X = dofs(r.modes, r.rotations)
    p = np.array([1e-3, -2e-3, 5e-4, 1e-4])
    assert r.stress.modes @ p == pytest.approx(part.stress.evaluate(X @ p), rel=1e-9, abs=1.0)
    assert r.stress.labels == part.stress.sites
    kept = r.keep([2, 0]).stress
    assert kept is not None
    assert np.array_equal(kept.modes, r.stress.modes[:, :, [2, 0]])


def test_static_stress_of_a_cantilever() -> None:
    """A tip force on the modal model with its tip as interface: the stress of beam theory."""
    part = Part.beam(1.0, Rectangle(0.02, 0.04), 4, STEEL)
    r = reduce(part, CraigBampton(("start", "end"), modes=0))
    assert r.stress is not None and r.rotations is not None
    # force and reaction on the ends; inertia plays no part in self-equilibrated loads
    F, L = 100.0, 1.0
    end, start = r.node("end"), r.node("start")
    load = F * r.modes[end, 1] - F * r.modes[start, 1] - F * L * r.rotations[start, 2]
    stress = r.stress.modes @ (load / r.stiffness)
    # the largest bending stress, at the clamped end
    W = 0.02**2 * 0.04 / 6.0
    V = 0.02 * 0.04**2 / 6.0
    found = np.abs(stress[:, 0]).max()
    assert min(abs(found / (F * L / S) - 1.0) for S in (W, V)) < 1e-9
