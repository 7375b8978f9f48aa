"""Interfaces in the reduction: rigid and averaging ties against the full model with multipliers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

from jousto.base.errors import InputError
from jousto.materials.material import Material
from jousto.parts.interface import Interface
from jousto.parts.part import Part
from jousto.reduction.methods import CraigBampton, FreeFree
from jousto.reduction.modes import eigen
from jousto.reduction.modes.fixed_interface_response import rigid_left
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.reducer import reduce
from jousto.sections.section import Tube
from reduction.hexes import box

Array = NDArray[np.float64]
STEEL = Material(E=210e9, nu=0.3, rho=7850.0)

KINDS = ("rigid", "average")


def arm(left: Any = "rigid", right: Any = "average", **options: Any) -> Part:
    """A box with a tie at each end, the right one about a point beside it; equal weights."""
    return replace(box(**options), faces=()).with_interfaces(
        Interface("a", "left", kind=left),
        Interface("b", "right", kind=right, at=(0.45, 0.02, -0.03)),
    )


# -- the full model: every tie as equations with multipliers --------------------------------


def tie_equations(part: Part) -> tuple[Array, int]:
    """Rows of ``B [u; q] = 0`` of all ties, written from their definition with equal weights."""
    ndof, m, d = part.K.shape[0], len(part.ties), part.dofs_per_node
    rows = []
    for number, tie in enumerate(part.ties):
        s = part.nodes[tie.nodes] - tie.at
        R = np.zeros((len(s), 3, 6))
        R[:, :, :3] = np.eye(3)
        for c, e in enumerate(np.eye(3)):
            R[:, :, 3 + c] = np.cross(e, s)
        R = R.reshape(-1, 6)
        # translations: a rigid tie of nodes that turn is not written here
        assert d == 3 or tie.kind == "average"
        dofs = (d * tie.nodes[:, None] + np.arange(3)).ravel()
        own = slice(ndof + 6 * number, ndof + 6 * number + 6)
        if tie.kind == "rigid":
            block = np.zeros((len(dofs), ndof + 6 * m))
            block[np.arange(len(dofs)), dofs] = 1.0
            block[:, own] = -R
        else:
            block = np.zeros((6, ndof + 6 * m))
            block[:, dofs] = -R.T
            block[:, own] = R.T @ R
        rows.append(block)
    return np.concatenate(rows), ndof + 6 * m


def allowed(part: Part, held: tuple[int, ...] = ()) -> Array:
    """A basis of all ``[u; q]`` that the ties allow, with some coordinates held."""
    B, n = tie_equations(part)
    B = np.concatenate([B / np.abs(B).max(axis=1, keepdims=True), np.eye(n)[list(held)]])
    return scipy.linalg.null_space(B)


def padded(matrix: Any, n: int) -> Array:
    out = np.zeros((n, n))
    ndof = matrix.shape[0]
    out[:ndof, :ndof] = matrix.toarray()
    return out


def full_static(part: Part, held: tuple[int, ...], loads: Array) -> Array:
    Z = allowed(part, held)
    K = Z.T @ padded(part.K, len(Z)) @ Z
    return Z @ np.linalg.solve(K, Z.T @ loads)


def full_frequencies(part: Part, held: tuple[int, ...] = ()) -> Array:
    Z = allowed(part, held)
    K, M = (Z.T @ padded(A, len(Z)) @ Z for A in (part.K, part.M))
    values = scipy.linalg.eigh(K, M, eigvals_only=True)
    return np.sqrt(np.maximum(values, 0.0)) / (2 * np.pi)


# -- the reduced model ----------------------------------------------------------------------


def shapes(reduced: ReducedPart) -> Array:
    """All motions ``[u; q]`` of the reduced body: six rigid ones, then the modes."""
    nn = len(reduced.nodes)
    R = np.zeros((nn, 6, 6))
    R[:, :3, :3] = R[:, 3:, 3:] = np.eye(3)
    for c, e in enumerate(np.eye(3)):
        R[:, :3, 3 + c] = np.cross(e, reduced.nodes)
    X = np.zeros((nn, 6, reduced.n))
    X[:, :3] = reduced.modes
    turning = reduced.rotation_nodes
    turning = np.arange(nn) if turning is None else turning
    X[turning, 3:] = reduced.rotations
    Y = np.concatenate([R, X], axis=2)
    rows = [Y[k, : 6 if k in set(turning.tolist()) else 3] for k in range(nn)]
    return np.concatenate(rows)


def reduced_static(reduced: ReducedPart, held: tuple[int, ...], loads: Array) -> Array:
    Y = shapes(reduced)
    K = np.diag(np.concatenate([np.zeros(6), reduced.stiffness]))
    B = Y[list(held)]
    m = len(held)
    A = np.block([[K, B.T], [B, np.zeros((m, m))]])
    s = 1.0 / np.sqrt(np.abs(A).max(axis=1))
    right = np.concatenate([Y.T @ loads, np.zeros((m, loads.shape[1]))])
    x = s[:, None] * np.linalg.solve(s[:, None] * A * s, s[:, None] * right)
    return Y @ x[: len(K)]


def unit_loads(part: Part, number: int) -> Array:
    n = part.K.shape[0] + 6 * len(part.ties)
    f = np.zeros((n, 6))
    f[part.K.shape[0] + 6 * number + np.arange(6), np.arange(6)] = 1.0
    return f


def reference(part: Part, number: int) -> tuple[int, ...]:
    return tuple(part.K.shape[0] + 6 * number + np.arange(6))


def worst(found: Array, truth: Array) -> float:
    return float((np.abs(found - truth).max(axis=0) / np.abs(truth).max(axis=0)).max())


# -- statics --------------------------------------------------------------------------------


@pytest.mark.parametrize("left", KINDS)
@pytest.mark.parametrize("right", KINDS)
@pytest.mark.parametrize("modes", [0, 4])
def test_interface_loads_are_those_of_the_full_model(left: str, right: str, modes: int) -> None:
    part = arm(left, right)
    reduced = reduce(part, CraigBampton(("a", "b"), modes=modes))
    assert reduced.n == 6 + modes
    held, loads = reference(part, 0), unit_loads(part, 1)
    truth = full_static(part, held, loads)
    assert worst(reduced_static(reduced, held, loads), truth) < 1e-8
    # the other way round
    held, loads = reference(part, 1), unit_loads(part, 0)
    assert worst(reduced_static(reduced, held, loads), full_static(part, held, loads)) < 1e-8


def test_nodes_that_only_translate_beside_an_average() -> None:
    """A hinge of one node holds three translations only; the average does the rest."""
    sets = {**arm().node_sets, "hinge": (40,)}
    sets = {name: sets[name] for name in ("hinge", "left", "right")}
    part = replace(arm("average", "average"), node_sets=sets)
    reduced = reduce(part, CraigBampton(("hinge", "b"), modes=2))
    assert reduced.n == 3 + 6 - 6 + 2
    # the hinge and three motions of the average are held, the others loaded
    b = reference(part, 1)
    held = (120, 121, 122, b[1], b[2], b[3])
    load = np.zeros((part.K.shape[0] + 12, 3))
    load[[b[0], b[4], b[5]], [0, 1, 2]] = 1.0
    truth = full_static(part, held, load)
    assert worst(reduced_static(reduced, held, load), truth) < 1e-8


@pytest.mark.parametrize("left", KINDS)
def test_residual_vector_makes_its_load_exact(left: str, rng: np.random.Generator) -> None:
    part = arm(left, "average")
    patterns = rng.standard_normal((part.K.shape[0], 2))
    held = reference(part, 0)
    loads = np.concatenate([patterns @ [[1.0, -0.3], [2.0, 1.0]], np.zeros((12, 2))])
    truth = full_static(part, held, loads)
    plain = reduce(part, CraigBampton(("a", "b"), modes=3))
    assert worst(reduced_static(plain, held, loads), truth) > 1e-3
    # one of the two depends on the other, a third is no load on the inside
    edge = np.zeros((part.K.shape[0], 1))
    edge[part.ties[1].dofs] = part.ties[1].averaging.T[:, :1]
    method = CraigBampton(("a", "b"), modes=3, residuals=(patterns, patterns[:, 0] * 3, edge))
    exact = reduce(part, method)
    assert exact.n == plain.n + 2
    assert worst(reduced_static(exact, held, loads), truth) < 1e-8


@pytest.mark.parametrize("left", KINDS)
def test_inertia_relief_makes_weight_exact(left: str) -> None:
    part = arm(left, "average")
    weight = np.zeros((part.K.shape[0] + 12, 3))
    weight[:-12] = part.M @ np.tile(np.eye(3), (len(part.nodes), 1))
    held = reference(part, 0)
    truth = full_static(part, held, weight)
    method = CraigBampton(("a", "b"), modes=2, inertia_relief=True)
    assert worst(reduced_static(reduce(part, method), held, weight), truth) < 1e-8
    method = CraigBampton(("a", "b"), modes=2)
    assert worst(reduced_static(reduce(part, method), held, weight), truth) > 1e-3


# -- vibration ------------------------------------------------------------------------------


@pytest.mark.parametrize("left", KINDS)
@pytest.mark.parametrize("right", KINDS)
def test_all_modes_are_the_full_model(left: str, right: str) -> None:
    part = arm(left, right, counts=(3, 2, 2))
    truth = full_frequencies(part)
    assert np.all(truth[:6] < 1e-2 * truth[6])
    n = len(truth) - 6
    free = reduce(part, FreeFree(modes=n))
    np.testing.assert_allclose(free.frequencies, truth[6:], rtol=1e-9)
    craig = reduce(part, CraigBampton(modes=n - 6))
    np.testing.assert_allclose(craig.frequencies, truth[6:], rtol=1e-9)


@pytest.mark.parametrize("left", KINDS)
@pytest.mark.parametrize("right", KINDS)
def test_large_and_small_parts_take_the_same_modes(
    left: str, right: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    part = arm(left, right)
    small = reduce(part, CraigBampton(modes=5))
    monkeypatch.setattr(eigen, "DENSE_LIMIT", 0)
    large = reduce(part, CraigBampton(modes=5))
    np.testing.assert_allclose(large.frequencies, small.frequencies, rtol=1e-9)
    np.testing.assert_allclose(
        np.abs(large.modes), np.abs(small.modes), atol=1e-6 * np.abs(small.modes).max()
    )


def test_an_average_frees_what_a_rigid_tie_stiffens() -> None:
    f = {kind: reduce(arm(kind, kind), FreeFree(modes=4)).frequencies for kind in KINDS}
    plain = reduce(box(), FreeFree(modes=4)).frequencies
    np.testing.assert_allclose(f["average"], plain, rtol=1e-12)
    assert np.all(f["rigid"] > 1.0001 * plain)


# -- coordinates that turn inside, beside averages ------------------------------------------


def cage(L: float) -> Part:
    """A frame of tubes, 6-DOF nodes, whose only interfaces are averages of its two ends."""
    nodes = L * np.array([(x, y, z) for z in (0, 1 / 3) for x, y in
                          ((0, 0), (1, 0), (1, 0.5), (0, 0.5))])  # fmt: skip
    bars = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6),
            (3, 7)]  # fmt: skip
    part = Part.frame(nodes, bars, sections=Tube(0.05 * L, 0.002 * L), materials=STEEL)
    return part.with_interfaces(
        Interface("a", [0, 3, 4, 7], kind="average"), Interface("b", [1, 2, 5, 6], kind="average")
    )


def clamped_between(L: float) -> Part:
    """A box with averages at both ends and a rigid tie in between that no reduction names."""
    part = replace(box((L, L / 4, 0.15 * L), (6, 3, 2)), faces=())
    x, y = part.nodes[:, 0] / L, part.nodes[:, 1] / L
    return part.with_interfaces(
        Interface("a", "left", kind="average"),
        Interface("b", "right", kind="average", at=(1.1 * L, 0.05 * L, 0.0)),
        Interface("c", np.flatnonzero((np.abs(x - 0.5) < 0.3) & (y > 0.12))),
    )


@pytest.mark.parametrize("made", [cage, clamped_between])
@pytest.mark.parametrize("L", [0.4, 3.0])
@pytest.mark.parametrize("modes", [0, 4])
def test_what_turns_inside_moves_with_averages(made: Any, L: float, modes: int) -> None:
    """Statics of the full model whatever the size of the body."""
    part = made(L)
    reduced = reduce(part, CraigBampton(("a", "b"), modes=modes))
    loads = unit_loads(part, 1)
    found = reduced_static(reduced, reference(part, 0), loads)
    assert worst(found, full_static(part, reference(part, 0), loads)) < 1e-7


@pytest.mark.parametrize("made", [cage, clamped_between])
@pytest.mark.parametrize("L", [0.4, 3.0])
def test_frequencies_with_what_turns_inside(made: Any, L: float) -> None:
    """With all fixed-interface modes the frequencies are those of the full model."""
    part = made(L)
    truth = full_frequencies(part)[6:]
    found = reduce(part, CraigBampton(("a", "b"), modes=len(truth) - 6)).frequencies
    np.testing.assert_allclose(found, truth, rtol=1e-7)


def test_rows_of_very_many_held_coordinates_take_little() -> None:
    """Half a million coordinates: a square matrix of them would be 2 TB."""
    R = np.random.default_rng(0).standard_normal((500_000, 6))
    R[:, 5] = R[:, 0] - R[:, 3]
    rest = rigid_left(R)
    assert rest.shape == (6, 1)
    np.testing.assert_allclose(R @ rest, 0.0, atol=1e-11)
    assert rigid_left(R[:2]).shape == (6, 4)


# -- free-free with attachment modes --------------------------------------------------------


def relieved(part: Part, loads: Array) -> Array:
    """Elastic response of the full free model to loads and balancing inertia, without momentum."""
    Z = allowed(part)
    K, M = (Z.T @ padded(A, len(Z)) @ Z for A in (part.K, part.M))
    R = scipy.linalg.null_space(K, rcond=1e-9)
    assert R.shape[1] == 6
    R = R @ np.linalg.inv(np.linalg.cholesky(R.T @ M @ R).T)
    f = Z.T @ loads
    f = f - M @ R @ (R.T @ f)
    scale = np.abs(K).max()
    A = np.block([[K / scale, M @ R], [(M @ R).T, np.zeros((6, 6))]])
    y = np.linalg.solve(A, np.concatenate([f / scale, np.zeros((6, f.shape[1]))]))[: len(K)]
    return Z @ y


@pytest.mark.parametrize("left", KINDS)
@pytest.mark.parametrize("modes", [0, 3])
def test_attachment_modes_make_interface_loads_exact(left: str, modes: int) -> None:
    part = arm(left, "average")
    free = reduce(part, FreeFree(modes=modes, interfaces=("a", "b")))
    # every one of the twelve forces and moments strains the accelerated part
    assert free.n == 12 + modes
    X = shapes(free)[:, 6:]
    for number in (0, 1):
        loads = unit_loads(part, number)
        found = X @ ((X.T @ loads) / free.stiffness[:, None])
        assert worst(found, relieved(part, loads)) < 1e-8


def test_rigid_ties_hold_without_being_named() -> None:
    """A bolted flange stays stiff whatever the reduction names, and still is a marker."""
    part = arm("rigid", "rigid", counts=(3, 2, 2))
    truth = full_frequencies(part)
    named = reduce(part, CraigBampton(("b",), modes=len(truth) - 6))
    np.testing.assert_allclose(named.frequencies, truth[6:], rtol=1e-9)
    assert named.interfaces == ("b",) and named.rotation(named.node("a")) is not None
    # a free end is another body
    free = reduce(part.with_interfaces(part.interfaces[1]), FreeFree(modes=4))
    assert free.frequencies[0] < 0.999 * truth[6]


@pytest.mark.parametrize("kind", KINDS)
def test_nodes_of_an_interface_in_another_one(kind: str) -> None:
    part = arm(kind, "average")
    message = {
        "rigid": "node1 of node set 'left' is tied to interface 'a'; use that interface",
        "average": "interfaces 'a' and 'left' share node1; keep one",
    }
    with pytest.raises(InputError, match=message[kind]):
        reduce(part, CraigBampton(("a", "left"), modes=1))


def test_one_average_is_enough_to_hold_a_body() -> None:
    part = arm("average", "average")
    reduced = reduce(part, CraigBampton(("b",), modes=4))
    assert reduced.n == 4
    truth = full_frequencies(part, reference(part, 1))
    # held at b again, Galerkin in the reduced basis
    Y = shapes(reduced)
    B = Y[list(reference(part, 1))]
    Z = scipy.linalg.null_space(B / np.abs(B).max(axis=0)) / np.abs(B).max(axis=0)[:, None]
    U = Y[: part.K.shape[0]] @ Z
    K, M = U.T @ (part.K @ U), U.T @ (part.M @ U)
    f = np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True)) / (2 * np.pi)
    np.testing.assert_allclose(f, truth[:4], rtol=1e-8)
