"""Every factorisation library solves the same, says what is loose, and is chosen by size."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from jousto.base.errors import InputError
from jousto.reduction.methods import CraigBampton, FreeFree
from jousto.reduction.modes import eigen
from jousto.reduction.reducer import reduce
from jousto.reduction.sparse import backends, factor, mkl
from jousto.reduction.sparse.factor import solvers
from reduction.blocks import block

INSTALLED = [known.name for known in solvers() if known.installed]


def held(cells: tuple[int, int, int] = (8, 3, 3)) -> sp.csr_array:
    """Stiffness of a block without its left end."""
    part = block(cells)
    free = np.setdiff1d(np.arange(part.K.shape[0]), dofs_of(part.node_sets["left"]))
    return sp.csr_array(part.K[free][:, free])


def places(cells: tuple[int, int, int] = (8, 3, 3)) -> np.ndarray:
    """Places of the unknowns of a held block."""
    part = block(cells)
    free = np.setdiff1d(np.arange(part.K.shape[0]), dofs_of(part.node_sets["left"]))
    return np.repeat(part.nodes, 3, axis=0)[free]


def dofs_of(nodes: tuple[int, ...]) -> np.ndarray:
    return (3 * np.array(nodes)[:, None] + np.arange(3)).ravel()


def label(dof: int) -> str:
    return f"dof{dof}"


@pytest.mark.parametrize("solver", INSTALLED)
def test_solves_one_and_many(solver: str) -> None:
    K = held()
    x = np.random.default_rng(1).standard_normal((K.shape[0], 37))
    solve = factor.factorise(K, "part", label, places(), solver=solver)
    assert solve(K @ x) == pytest.approx(x, abs=1e-10)
    assert solve(K @ x[:, 3]) == pytest.approx(x[:, 3], abs=1e-10)
    assert solve(np.zeros((K.shape[0], 0))).shape == (K.shape[0], 0)
    # columns read as rows: the same matrix
    assert factor.factorise(K.tocsc(), "part", label, places(), solver=solver)(
        K @ x
    ) == pytest.approx(x, abs=1e-10)


@pytest.mark.parametrize("solver", INSTALLED)
def test_unsorted_and_doubled_entries(solver: str) -> None:
    K = held()
    coo = K.tocoo()
    twice = sp.csr_array(K.shape)
    # every entry in two halves, in the order of its column: neither sorted nor unique
    order = np.lexsort((coo.row, -coo.col))
    rows = np.repeat(coo.row[order], 2)
    position = np.argsort(rows, kind="stable")
    indptr = np.r_[0, np.cumsum(np.bincount(rows, minlength=K.shape[0]))]
    data, columns = np.repeat(0.5 * coo.data[order], 2)[position], np.repeat(coo.col[order], 2)
    twice = sp.csr_array((data, columns[position], indptr), shape=K.shape)
    assert not twice.has_canonical_format
    x = np.linspace(-1.0, 1.0, K.shape[0])
    assert factor.factorise(twice, "part", label, places(), solver=solver)(K @ x) == pytest.approx(
        x
    )


@pytest.mark.parametrize("solver", INSTALLED)
def test_a_mechanism_is_named(solver: str) -> None:
    K = held().tolil()
    # dof 40 hangs on dof 43 alone and moves with it; the pair is cut from the rest
    for i in (40, 43):
        K[i, :] = 0.0
        K[:, i] = 0.0
    K[40, 40] = K[43, 43] = 1e9
    K[40, 43] = K[43, 40] = -1e9
    with pytest.raises(InputError, match=r"part: .*has a free motion.* dof4[03] moves most"):
        factor.factorise(sp.csr_array(K), "part", label, places(), solver=solver)
    # nearly: the rest is round-off
    K[40, 40] = 1e9 * (1.0 + 1e-15)
    with pytest.raises(InputError, match="dof4[03] moves most"):
        factor.factorise(sp.csr_array(K), "part", label, places(), solver=solver)
    # a soft spring is no mechanism
    K[40, 40] = 1e9 * (1.0 + 1e-9)
    factor.factorise(sp.csr_array(K), "part", label, places(), solver=solver)


@pytest.mark.parametrize("solver", INSTALLED)
def test_a_degree_of_freedom_without_stiffness_is_named(solver: str) -> None:
    K = held().tolil()
    K[12, :] = 0.0
    K[:, 12] = 0.0
    with pytest.raises(InputError, match="dof12 moves most"):
        factor.factorise(sp.csr_array(K), "part", label, places(), solver=solver)


@pytest.mark.parametrize("solver", INSTALLED)
def test_the_whole_reduction_with_each_library(
    solver: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    part = block((10, 2, 2))
    method = CraigBampton(("left", "right"), modes=6)
    dense = reduce(part, method)
    monkeypatch.setattr(eigen, "DENSE_LIMIT", 0)
    found = reduce(part, method, solver=solver)
    assert found.frequencies == pytest.approx(dense.frequencies, rel=1e-9)
    assert found.provenance["solver"] == solver


def test_the_best_library_is_chosen_by_size(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(factor, "_installed", lambda module: module in {"scipy", "ngsolve"})
    always = ["multifrontal", "superlu"]
    assert [known.name for known in solvers() if known.installed] == ["ngsolve", *always]
    assert factor.choose(factor.SMALL, "part") == "superlu"
    assert factor.choose(factor.SMALL + 1, "part") == "ngsolve"
    assert factor.choose(10, "part", "ngsolve") == "ngsolve"
    monkeypatch.setattr(factor, "_installed", lambda module: module == "scipy")
    assert factor.choose(factor.SMALL + 1, "part") == "multifrontal"
    assert factor.choose(10**6, "part") == "multifrontal"


def test_without_places_superlu_finds_an_order() -> None:
    solve: Any = factor.factorise(held(), "part", label, solver="multifrontal")
    assert solve.name == "superlu"


def test_solvers_that_are_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(factor, "_installed", lambda module: module == "scipy")
    part = block((4, 1, 1))
    with pytest.raises(InputError, match="no solver 'pardisso'; did you mean 'pardiso'"):
        reduce(part, FreeFree(modes=2), solver="pardisso")
    with pytest.raises(
        InputError, match=r"solver 'pardiso' .*not installed: pip install pypardiso"
    ):
        reduce(part, FreeFree(modes=2), solver="pardiso")


def test_memory_of_the_factor_is_known() -> None:
    K = held((12, 6, 6))
    lower = 8 * (K.nnz + K.shape[0]) // 2
    for solver in set(INSTALLED) - {"cholmod"}:
        solve: Any = factor.factorise(K, "part", label, places((12, 6, 6)), solver=solver)
        assert solve.name == solver
        assert lower < solve.memory < 400 * lower


def test_a_library_that_fails_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    class Failing(backends.SuperLU):
        def __init__(self, matrix: sp.csr_array, points: Any = None, limit: float = 0) -> None:
            raise MemoryError("no room")

    known = factor._KNOWN["superlu"]
    monkeypatch.setitem(factor._KNOWN, "superlu", (known[0], Failing, *known[2:]))
    with pytest.raises(InputError, match=r"part: superlu could not factorise .*no room.*memory"):
        factor.factorise(held(), "part", label, solver="superlu")


def test_the_library_is_found_without_a_search_of_folders() -> None:
    """In a process of its own: without pypardiso and glob; folders are listed, not trees."""
    pytest.importorskip("pypardiso")
    code = """if True:
        import sys
        import numpy as np
        import scipy.sparse as sp
        from jousto.reduction.sparse.backends import Pardiso
        seen = []
        A = sp.csr_array(sp.diags_array([2.0, 4.0]))
        sys.addaudithook(lambda event, about: seen.append(event))
        print(np.round(Pardiso(A).solve(np.ones((2, 1))).ravel(), 12).tolist())
        folders = seen.count("os.listdir") + seen.count("os.scandir")
        print("pypardiso" in sys.modules, "glob.glob" in seen, folders < 20)
    """
    run = [sys.executable, "-c", code]
    environment = {key: value for key, value in os.environ.items() if key != "PYPARDISO_MKL_RT"}
    found = subprocess.run(run, env=environment, capture_output=True, text=True, check=True)
    assert found.stdout.splitlines() == ["[0.5, 0.25]", "False False True"]


def test_the_named_library_is_used(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """`PYPARDISO_MKL_RT` first; then folders, in which files that are no library are skipped."""
    mkl.mkl_runtime.cache_clear()
    monkeypatch.setenv("PYPARDISO_MKL_RT", str(tmp_path / "nothing.so"))
    with pytest.raises(OSError, match=r"nothing\.so"):
        mkl.mkl_runtime()
    monkeypatch.delenv("PYPARDISO_MKL_RT")
    (tmp_path / "lib").mkdir()
    for name in ("libmkl_rt.so.3", "libmkl_rt.a", "libmkl_core.so.3"):
        (tmp_path / "lib" / name).write_text("no library")
    usual = sys.prefix
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    monkeypatch.setattr(sys, "base_prefix", usual)
    assert mkl.runtime_files()[0] == tmp_path / "lib" / "libmkl_rt.so.3"
    assert tmp_path / "lib" / "libmkl_rt.a" not in mkl.runtime_files()
    pytest.importorskip("pypardiso")
    assert mkl.mkl_runtime()["pardiso"]
    mkl.mkl_runtime.cache_clear()


def test_upper_triangle() -> None:
    """Values, columns and row starts; a row without entries above the diagonal."""
    rng = np.random.default_rng(0)
    A = sp.csr_array(sp.random_array((30, 30), density=0.2, rng=rng))
    A = sp.csr_array(A + A.T)
    A.sort_indices()
    values, columns, starts = backends.upper_triangle(A)
    np.testing.assert_array_equal(
        sp.csr_array((values, columns, starts), shape=A.shape).toarray(), np.triu(A.toarray())
    )
