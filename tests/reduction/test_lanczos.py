"""Block Lanczos against dense solutions: equal frequencies, restarts, massless motions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

from jousto.base.errors import InputError
from jousto.reduction.modes import eigen, lanczos


def chain(n: int, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness of a chain of random masses and springs that is held at one end."""
    random = np.random.default_rng(seed)
    k = random.uniform(1.0, 2.0, n + 1)
    K = np.diag(k[:-1] + np.r_[k[1:-1], 0.0]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1)
    return np.diag(random.uniform(0.5, 1.5, n)), K


def solved(A: np.ndarray, B: np.ndarray, count: int, **changes: Any) -> tuple[Any, Any, int]:
    inverse = scipy.linalg.cho_factor(B)
    calls = []

    def solve(f: np.ndarray) -> np.ndarray:
        calls.append(f.shape[1])
        return np.asarray(scipy.linalg.cho_solve(inverse, f))

    mu, Y = lanczos.lanczos(lambda y: A @ y, sp.csr_array(B), solve, count)
    return mu, Y, sum(calls)


def check(A: np.ndarray, B: np.ndarray, mu: np.ndarray, Y: np.ndarray) -> None:
    truth = scipy.linalg.eigh(A, B, eigvals_only=True)[::-1]
    assert mu == pytest.approx(truth[: len(mu)], rel=1e-11)
    # vectors are normal to n eps; and y^T B y = 1 is what remains of terms that are much larger in
    # a long chain, 3e5 for 400 masses
    terms = len(B) + np.max(np.abs(Y).T @ np.abs(B) @ np.abs(Y))
    assert Y.T @ B @ Y == pytest.approx(np.eye(len(mu)), abs=np.finfo(float).eps * terms)
    assert A @ Y - (B @ Y) * mu == pytest.approx(0.0, abs=1e-9 * mu[0])


@pytest.mark.parametrize("count", [1, 7, 30])
def test_single_frequencies(count: int) -> None:
    A, B = chain(400)
    mu, Y, _ = solved(A, B, count)
    assert len(mu) == count
    check(A, B, mu, Y)


@pytest.mark.parametrize("copies", [2, 4, 6, 9])
def test_equal_frequencies(copies: int) -> None:
    """As many copies of every frequency as there are unconnected chains, more than a block wide."""
    A, B = (np.kron(np.eye(copies), matrix) for matrix in chain(60))
    mu, Y, _ = solved(A, B, 3 * copies)
    check(A, B, mu, Y)


def test_almost_equal_frequencies() -> None:
    A, B = (np.kron(np.eye(6), matrix) for matrix in chain(60))
    B += np.diag(1e-6 * np.random.default_rng(1).random(len(B)))
    mu, Y, _ = solved(A, B, 12)
    check(A, B, mu, Y)


def test_a_full_basis_is_restarted(monkeypatch: pytest.MonkeyPatch) -> None:
    restarts = []
    original = lanczos._restart
    monkeypatch.setattr(lanczos, "_restart", lambda *a: (restarts.append(1), original(*a)))
    # frequencies close together: hundreds of solutions are needed
    A, B = np.eye(600), np.diag(np.linspace(1.0, 1.5, 600))
    mu, Y, _ = solved(A, B, 20)
    assert len(restarts) > 1
    check(A, B, mu, Y)


def test_motions_without_mass() -> None:
    """Fewer frequencies than asked for: the rest of mu is zero, and the basis is exhausted."""
    A, B = chain(200)
    A[::3] = 0.0
    A[30:] = 0.0
    mu, Y, _ = solved(A, B, 25)
    assert np.linalg.matrix_rank(A) == 20
    truth = scipy.linalg.eigh(A, B, eigvals_only=True)[::-1]
    assert mu[:20] == pytest.approx(truth[:20], rel=1e-9)
    assert np.abs(mu[20:]).max(initial=0.0) < 1e-12 * mu[0]


def test_work_is_a_few_solutions_per_mode() -> None:
    """A stiff spectrum, as of finite elements: fewer than four solutions for each mode."""
    n = 500
    A, B = np.eye(n), np.diag(np.arange(1.0, n + 1.0) ** 2)
    mu, Y, solutions = solved(A, B, 24)
    check(A, B, mu, Y)
    assert solutions < 4 * 24


def test_the_same_bytes_every_time() -> None:
    A, B = chain(300)
    first, again = solved(A, B, 10), solved(A, B, 10)
    assert np.array_equal(first[0], again[0])
    assert np.array_equal(first[1], again[1])


@pytest.mark.parametrize("count", [140, 200])
def test_a_long_spectrum_is_found_to_its_end(count: int) -> None:
    """More restarts than one: no mode is left half found, and none is missing."""
    n = 3000
    k = 1.0 + np.arange(n) ** 1.5
    B = sp.csc_array(sp.diags_array(k))
    mu, _ = lanczos.lanczos(lambda y: y, B, lambda f: f / k[:, None], count)
    assert mu == pytest.approx(1.0 / k[:count], rel=1e-11)
    assert len(mu) == count


def test_the_basis_is_examined_a_few_times_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """An examination costs the cube of the basis: the sum of cubes stays a few of the last."""
    sizes: list[int] = []
    eigh = np.linalg.eigh
    monkeypatch.setattr(np.linalg, "eigh", lambda T: (sizes.append(len(T)), eigh(T))[1])
    k = np.arange(1.0, 901.0) ** 2
    B = sp.csc_array(sp.diags_array(k))
    mu, _ = lanczos.lanczos(lambda y: y, B, lambda f: f / k[:, None], 150)
    assert mu == pytest.approx(1.0 / k[:150], rel=1e-11)
    assert np.sum(np.array(sizes, dtype=float) ** 3) < 12.0 * max(sizes) ** 3


def test_what_does_not_converge_is_refused() -> None:
    """A solver with an error of its own each time: no residual falls below that error."""
    n = 400
    k = np.arange(1.0, n + 1.0)
    random = np.random.default_rng(5)

    def solve(f: np.ndarray) -> np.ndarray:
        y = f / k[:, None]
        return np.asarray(y + 1e-3 * np.linalg.norm(y, axis=0) * random.standard_normal(y.shape))

    with pytest.raises(InputError, match=r"body: only \d+ of 20 frequencies converge.*fewer modes"):
        lanczos.lanczos(
            lambda y: y, sp.csc_array(sp.diags_array(k)), solve, 20, where="reduction of body"
        )


def test_modes_that_are_orthogonal_are_multiplied_by_the_mass_once() -> None:
    """Each product with M passes over all its entries: the last one gives mu, too."""
    products = []

    class Mass:
        def __matmul__(self, X: np.ndarray) -> np.ndarray:
            products.append(X.shape)
            return np.arange(8.0, 0.0, -1.0)[:, None] * X

    mass: Any = Mass()
    mu, X = eigen.polish(np.eye(8)[:, ::-1], mass)
    assert mu.tolist() == [8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0]
    np.testing.assert_array_equal(X, np.eye(8))
    assert len(products) == 1
    # a rotation of two modes: one product to find it, one to see that nothing is left
    products.clear()
    turned = np.eye(8)
    turned[:2, :2] = [[0.8, -0.6], [0.6, 0.8]]
    mu, X = eigen.polish(turned, mass)
    np.testing.assert_allclose(mu, np.arange(8.0, 0.0, -1.0), rtol=1e-14)
    assert len(products) < 8
