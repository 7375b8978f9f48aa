"""Stress jumps of many shapes: against their definition, and the work of their blocks."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.parts.solids import stress_jumps
from jousto.parts.solids.model import SolidModel
from jousto.parts.solids.stress import SolidStress, point_strains
from jousto.parts.solids.stress_jumps import neighbours_together, place_scatter
from parts.grids import grid

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0, name="steel")


def part_of(
    kind: str, cells: tuple[int, int, int] = (4, 2, 2)
) -> tuple[jo.Part, SolidModel, SolidStress]:
    part = jo.Part.solid(grid(kind, cells, np.array([0.4, 0.2, 0.2]), distort=0.2), STEEL)
    assert part.solids is not None and isinstance(part.stress, SolidStress)
    return part, part.solids, part.stress


def shapes(part: jo.Part, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Random displacements (ndof, n), and amplitudes that fall like those of modes."""
    rng = np.random.default_rng(n)
    return rng.standard_normal((3 * len(part.nodes), n)), 1.0 / (1.0 + np.arange(n)) ** 2


@pytest.mark.parametrize("kind", ["tetra10", "hexahedron20", "hexahedron"])
@pytest.mark.parametrize("n", [4, 20, 30])
def test_the_largest_part_of_the_error_is_kept(kind: str, n: int) -> None:
    """E^T E has the largest eigenvalues of Q, which follows from errors of sums of two shapes."""
    part, _, stress = part_of(kind)
    X, size = shapes(part, n)
    E = place_scatter(stress, X, stress.evaluate(X), size)
    i, j = np.triu_indices(n)
    pairs = np.zeros((n, len(i)))
    pairs[i, np.arange(len(i))] = size[i]
    pairs[j, np.arange(len(i))] += size[j]
    square = jo.parts.place_errors(part, X @ pairs) ** 2
    Q = np.zeros((len(square), n, n))
    Q[:, i, j] = square
    own = np.einsum("sii->si", Q) / 4.0  # p^T Q p of a shape added to itself
    Q[:, i, j] = 0.5 * (square - own[:, i] - own[:, j])
    Q[:, j, i] = Q[:, i, j]
    Q[:, np.arange(n), np.arange(n)] = own
    r = min(stress_jumps.ROWS, n)
    exact = np.linalg.eigvalsh(Q)[:, -r:]
    B = E * size
    found = np.linalg.eigvalsh(B @ np.swapaxes(B, 1, 2))
    # seven digits of E are kept
    np.testing.assert_allclose(found, exact, atol=1e-6 * exact.max())
    # and no direction has more than the whole
    assert np.linalg.eigvalsh(Q - np.swapaxes(B, 1, 2) @ B).min() > -1e-6 * exact.max()


def test_blocks_share_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """The elements of a block are those around its sites, for any number of blocks."""
    part, model, stress = part_of("tetra10", (8, 4, 4))
    X, size = shapes(part, 8)
    s = stress.evaluate(X)
    evaluated: list[int] = []

    def counted(model: Any, group: Any, chosen: Any, *rest: Any) -> None:
        evaluated.append(len(chosen))
        point_strains(model, group, chosen, *rest)

    def whole(self: Any) -> Any:
        raise AssertionError("work over the whole mesh")

    monkeypatch.setattr(stress_jumps, "point_strains", counted)
    monkeypatch.setattr(SolidStress, "_averages", property(whole))
    once = place_scatter(stress, X, s, size)
    assert evaluated == [model.count]
    evaluated.clear()
    monkeypatch.setattr(stress_jumps, "BLOCK_BYTES", stress_jumps.BLOCK_BYTES // 128)
    np.testing.assert_allclose(
        np.linalg.norm(place_scatter(stress, X, s, size) @ size, axis=1),
        np.linalg.norm(once @ size, axis=1),
        rtol=1e-6,
    )
    assert len(evaluated) > 8
    # neighbours are in one block: an element is evaluated for a few blocks, not for most of its
    # ten nodes
    assert sum(evaluated) < 3.5 * model.count


def test_strains_of_few_elements_copy_their_own_displacements_only() -> None:
    """For any order of the displacements in memory."""
    part, model, _ = part_of("hexahedron20", (10, 5, 5))
    chosen = np.arange(2)
    X = shapes(part, 50)[0]
    out = {}
    for order in ("C", "F"):
        given = np.array(X, order=order)
        out[order] = np.empty((len(chosen) * 8, 6, 50))
        point_strains(model, model.groups[0], chosen, given, out[order])  # fill the tables
        tracemalloc.start()
        point_strains(model, model.groups[0], chosen, given, out[order])
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert peak < 0.3 * X.nbytes
    np.testing.assert_array_equal(out["C"], out["F"])


def test_neighbours_follow_each_other() -> None:
    """Blocks of eight of a grid are its cubes; one point, and points on a line, have an order."""
    points = np.stack(np.meshgrid(*[np.arange(4.0)] * 3), axis=-1).reshape(-1, 3)
    blocks = points[neighbours_together(points)].reshape(8, 8, 3)
    assert np.all(np.ptp(blocks, axis=1) == 1.0)
    assert neighbours_together(np.ones((1, 3))).tolist() == [0]
    line = np.array([[0.0, 0, 3], [0, 0, 1], [0, 0, 2]])
    assert neighbours_together(line).tolist() == [1, 2, 0]
