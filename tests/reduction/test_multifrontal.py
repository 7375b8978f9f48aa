"""Dissection separates, the factor is exact and grows as theory says, and bad pivots are named."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.spatial.transform import Rotation

from jousto.parts.part import Part
from jousto.reduction.methods import CraigBampton, FreeFree
from jousto.reduction.reducer import reduce
from jousto.reduction.sparse import factor
from jousto.reduction.sparse.dissection import dissect
from jousto.reduction.sparse.multifrontal import Cholesky, IndefiniteBlock
from reduction.blocks import block

TURN = Rotation.from_rotvec([0.3, -0.5, 0.4]).as_matrix()


def grid(n: int, dimensions: int = 3) -> tuple[sp.csr_array, np.ndarray]:
    """Laplacian of a grid of n nodes a side, held all around, and the places of its nodes."""
    line = sp.diags_array([-np.ones(n - 1), 2.0 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1])
    one, whole = sp.eye_array(n), sp.csr_array(line)
    for _ in range(dimensions - 1):
        whole = sp.kron(whole, one) + sp.kron(sp.eye_array(whole.shape[0]), line)
    axes = np.meshgrid(*dimensions * [np.arange(n)], indexing="ij")
    points = np.zeros((n**dimensions, 3))
    points[:, :dimensions] = np.stack(axes, axis=-1).reshape(-1, dimensions)
    return sp.csr_array(whole), points


def with_hubs() -> tuple[sp.csr_array, np.ndarray]:
    """Two nodes in the middle of a grid that touch all others, as those of rigid ties do."""
    K, points = grid(12)
    n = len(points)
    link = sp.csr_array(np.ones((n, 2)))
    both = sp.block_array([[K + n * sp.eye_array(n), -link], [-link.T, 4.0 * n * sp.eye_array(2)]])
    return sp.csr_array(both), np.concatenate([points, [[5.5, 5.5, 5.5], [6.5, 5.5, 5.5]]])


def two_pieces() -> tuple[sp.csr_array, np.ndarray]:
    K, points = grid(7)
    return sp.csr_array(sp.block_diag([K, K])), np.concatenate([points, points + [20.0, 0, 0]])


CASES = {
    "plane": grid(30, 2),
    "solid": grid(10),
    "turned": (grid(10)[0], grid(10)[1] @ TURN.T),
    "line": grid(500, 1),
    "one": grid(1),
    "hubs": with_hubs(),
    "pieces": two_pieces(),
    "one place": (grid(4)[0], np.zeros((64, 3))),
    "full": (sp.csr_array(np.eye(90) + 0.01), grid(90, 1)[1]),
}


@pytest.mark.parametrize("case", CASES)
def test_blocks_touch_what_separates_them_alone(case: str) -> None:
    """An entry of the matrix couples a block to itself or to one above it, never beside it."""
    K, points = CASES[case]
    cut = dissect(K, points)
    assert sorted(cut.order) == list(range(len(points)))
    block_of = np.empty(len(points), dtype=int)
    block_of[cut.order] = np.repeat(np.arange(len(cut.parents)), np.diff(cut.starts))
    above = [{k} for k in range(len(cut.parents))]
    for k in range(len(cut.parents))[::-1]:
        if cut.parents[k] >= 0:
            assert cut.parents[k] > k
            above[k] |= above[cut.parents[k]]
    for i, j in set(zip(block_of[K.tocoo().row], block_of[K.tocoo().col], strict=True)):
        assert i in above[j] or j in above[i]


@pytest.mark.parametrize("case", CASES)
def test_solves_what_dense_algebra_solves(case: str) -> None:
    K, points = CASES[case]
    f = np.random.default_rng(2).standard_normal((len(points), 5))
    x = Cholesky(K, points, least_pivot=1e-14).solve(f)
    # rounding, times the condition of the grids (below 1e5)
    assert x == pytest.approx(np.linalg.solve(K.toarray(), f), rel=0, abs=1e-10 * np.abs(x).max())


def test_the_factor_grows_as_nested_dissection_does() -> None:
    """``n^(4/3)`` in a solid, ``n log n`` in a plane, n along a line (George 1973)."""

    def ratio(dimensions: int, n: int) -> float:
        small, large = (Cholesky(*grid(m, dimensions), least_pivot=0.0).memory for m in (n, 2 * n))
        return large / small

    # 2^4, 4 log(64^2) / log(32^2) and 2; a fifth for what borders add in small ones
    assert ratio(3, 12) < 1.2 * 16.0
    assert ratio(2, 32) < 1.2 * 4.0 * np.log(64) / np.log(32)
    assert ratio(1, 1000) < 1.2 * 2.0


def test_a_pivot_that_is_not_positive_is_named() -> None:
    K, points = grid(8)
    K = sp.csr_array(K.tolil())
    K[77, 77] = -1.0
    with pytest.raises(IndefiniteBlock) as found:
        Cholesky(K, points, least_pivot=1e-14)
    # it, or one of those that it touches and that come later
    assert found.value.row in set(K[[77]].indices)


def test_what_does_not_fit_is_refused_before_it_is_begun() -> None:
    K, points = grid(10)
    needed = Cholesky(K, points, least_pivot=1e-14).memory
    with pytest.raises(MemoryError, match=r"it needs .* GiB, this machine has"):
        Cholesky(K, points, least_pivot=1e-14, limit=0.5 * needed)


@pytest.mark.parametrize(
    "method",
    [CraigBampton(("left",), modes=5), pytest.param(FreeFree(modes=5), marks=pytest.mark.slow)],
)
def test_a_part_of_twelve_thousand_unknowns_needs_no_extra(
    method: CraigBampton | FreeFree, monkeypatch: pytest.MonkeyPatch
) -> None:
    part: Part = block((50, 8, 8))
    monkeypatch.setattr(factor, "_installed", lambda module: module == "scipy")
    own = reduce(part, method, cache=False)
    assert own.provenance["solver"] == "multifrontal"
    slow = reduce(part, method, cache=False, solver="superlu")
    # two exact factorisations: the residual of the iteration for modes, 1e-9
    assert own.frequencies == pytest.approx(slow.frequencies, rel=1e-8)
