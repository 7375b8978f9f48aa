"""Reductions that are kept: found again, gone on with after a kill, and never stale."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from jousto.base.errors import InputError, JoustoWarning
from jousto.parts.part import Part
from jousto.reduction.files import cache
from jousto.reduction.files.cache import ReductionCache
from jousto.reduction.methods import CraigBampton, FreeFree
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.reducer import reduce
from jousto.reduction.sparse import factor
from reduction.blocks import block
from reduction.bodies import bent

METHOD = CraigBampton(("left", "right"), modes=4)


def same(a: ReducedPart, b: ReducedPart) -> None:
    assert np.array_equal(a.frequencies, b.frequencies)
    assert np.array_equal(a.modes, b.modes)
    assert np.array_equal(a.invariants.E, b.invariants.E)
    assert dict(a.provenance) == dict(b.provenance)


class Counter:
    """Counts factorisations."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.count = 0
        original = factor.factorise

        def counted(*args: Any, **kwargs: Any) -> Any:
            self.count += 1
            return original(*args, **kwargs)

        patch.setattr(factor, "factorise", counted)


def test_the_second_time_it_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    counter = Counter(monkeypatch)
    part = block((6, 2, 2))
    first = reduce(part, METHOD, cache=tmp_path)
    assert counter.count == 1
    second = reduce(block((6, 2, 2)), METHOD, cache=ReductionCache(tmp_path))
    assert counter.count == 1
    same(first, second)
    same(first, reduce(part, METHOD, cache=False))
    assert counter.count == 2
    # only the finished part stays
    (entry,) = ReductionCache(tmp_path).entries()
    assert [path.name for path in entry.iterdir()] == ["part.h5"]


def test_small_parts_are_not_kept_unless_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import platformdirs

    monkeypatch.delenv("JOUSTO_CACHE")
    monkeypatch.setattr(platformdirs, "user_cache_dir", lambda *args, **kwargs: str(tmp_path))
    part = block((3, 1, 1))
    reduce(part, METHOD)
    assert not list(tmp_path.iterdir())
    monkeypatch.setattr(cache, "AUTOMATIC", part.K.shape[0])
    reduce(part, METHOD, cache=False)
    assert not list(tmp_path.iterdir())
    reduce(part, METHOD)
    assert len(ReductionCache().entries()) == 1
    assert ReductionCache().path == tmp_path / "reductions"
    reduce(part, FreeFree(modes=3), cache=True)
    assert len(ReductionCache().entries()) == 2
    ReductionCache().clear()
    assert ReductionCache().size == 0


def test_any_change_is_another_reduction(tmp_path: Path) -> None:
    part = block((3, 1, 1))
    nodes = part.nodes.copy()
    nodes[0, 0] -= 1e-12
    K = sp.csr_array(part.K, copy=True)
    K.data *= 1.0 + 1e-15
    variants: list[tuple[Part, Any]] = [
        (part, METHOD),
        (part, replace(METHOD, modes=3)),
        (part, FreeFree(modes=3)),
        (replace(part, K=K), METHOD),
        (replace(part, M=sp.csr_array(part.M * 2.0)), METHOD),
        (replace(part, nodes=nodes), METHOD),
        (replace(part, name="other"), METHOD),
        (replace(part, node_sets={**part.node_sets, "tip": (0,)}), METHOD),
    ]
    keys = {cache.key(p, m) for p, m in variants}
    assert len(keys) == len(variants)
    assert cache.key(block((3, 1, 1)), METHOD) == cache.key(part, METHOD)
    # a mass without explicit zeros, or in another order of storage, is the same mass
    assert cache.key(replace(part, K=sp.csr_array(part.K.tocoo()))) == cache.key(part)


def test_stress_belongs_to_the_key(tmp_path: Path) -> None:
    part = bent()
    assert part.stress is not None
    fewer = replace(part, stress=part.stress.select(part.stress.sites[:3]))
    method = CraigBampton(("start",), modes=3)
    all_sites = reduce(part, method, cache=tmp_path).stress
    some = reduce(fewer, method, cache=tmp_path).stress
    assert all_sites is not None and some is not None
    assert len(some.labels) == 3 < len(all_sites.labels)


KILLED = """
import os, signal
from jousto.reduction.reducer import reduce
from reduction.test_cache import METHOD, block
def progress(stage, done):
    if stage == "orthonormalisation":
        os.kill(os.getpid(), signal.SIGKILL)
reduce(block((6, 2, 2)), METHOD, cache={folder!r}, progress=progress)
"""


def goes_on(folder: Path, stage: str, factorisations: int, patch: pytest.MonkeyPatch) -> None:
    """Reduce again what was stopped at the beginning of a stage: no stage before it is repeated."""
    (entry,) = ReductionCache(folder).entries()
    assert not (entry / "part.h5").exists()
    counter = Counter(patch)
    seen: list[str] = []
    again = reduce(
        block((6, 2, 2)), METHOD, cache=folder, progress=lambda name, done: seen.append(name)
    )
    assert counter.count == factorisations
    assert (entry / "part.h5").exists()
    order = ["constraint modes", "fixed-interface modes", "orthonormalisation", "invariants"]
    assert [name for name in order if name in seen] == order[order.index(stage) :]
    whole = reduce(block((6, 2, 2)), METHOD)
    assert np.array_equal(again.frequencies, whole.frequencies)
    assert np.array_equal(again.modes, whole.modes)
    # it says which library factorised, too
    assert dict(again.provenance) == dict(whole.provenance)


def test_a_killed_reduction_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kill -9 after the fixed-interface modes: nothing is factorised again."""
    path = os.pathsep.join(entry for entry in sys.path if entry)
    child = subprocess.run(
        [sys.executable, "-c", KILLED.format(folder=str(tmp_path))],
        env={**os.environ, "PYTHONPATH": path},
        timeout=300,
    )
    assert child.returncode == -signal.SIGKILL
    goes_on(tmp_path, "orthonormalisation", 0, monkeypatch)


@pytest.mark.parametrize("stage, factorisations", [("fixed-interface modes", 1), ("invariants", 0)])
def test_a_stopped_reduction_goes_on(
    stage: str, factorisations: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def progress(name: str, done: float) -> None:
        if name == stage:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        reduce(block((6, 2, 2)), METHOD, cache=tmp_path, progress=progress)
    goes_on(tmp_path, stage, factorisations, monkeypatch)


def test_damaged_files_are_computed_again(tmp_path: Path) -> None:
    part = block((4, 1, 1))
    first = reduce(part, METHOD, cache=tmp_path)
    (entry,) = ReductionCache(tmp_path).entries()
    file = entry / "part.h5"
    file.write_bytes(file.read_bytes()[:1000])
    same(first, reduce(part, METHOD, cache=tmp_path))
    # a stage cut short, and one that is no archive
    for content in (b"PK\x03\x04 cut", b""):
        file.unlink()
        (entry / "modes.npz").write_bytes(content)
        (entry / "constraint-modes.npz").write_bytes(content)
        same(first, reduce(part, METHOD, cache=tmp_path))


def test_a_full_disk_does_not_stop_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*args: Any, **kwargs: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez", full)
    with pytest.warns(JoustoWarning, match="No space left.*reduction continues") as caught:
        reduced = reduce(block((4, 1, 1)), METHOD, cache=tmp_path)
    assert len(caught) == 1
    assert reduced.n == 4 + 24 - 6
    assert not list(tmp_path.rglob(".*"))


def test_the_oldest_are_removed_above_the_limit(tmp_path: Path) -> None:
    part = block((4, 1, 1))
    reduce(part, METHOD, cache=tmp_path)
    room = 2.5 * ReductionCache(tmp_path).size
    for modes in (3, 2, 1):
        for age, entry in enumerate(ReductionCache(tmp_path).entries()):
            os.utime(entry, (1e9 + age, 1e9 + age))
        # used again: the last to go
        if modes == 2:
            reduce(part, METHOD, cache=tmp_path)
        reduce(part, replace(METHOD, modes=modes), cache=ReductionCache(tmp_path, room))
    kept = ReductionCache(tmp_path)
    assert len(kept.entries()) == 2
    assert kept.size <= room


def test_what_cannot_be_hashed_is_not_kept(tmp_path: Path) -> None:
    class Odd:
        def __init__(self) -> None:
            self.sites, self.positions, self.axes = ("a",), np.zeros((1, 3)), np.eye(3)[None]
            self.elasticity = self.compliance = None
            self.how = lambda d: np.zeros((1, 6, d.shape[1]))

        def evaluate(self, d: Any) -> Any:
            return self.how(d)

    odd: Any = Odd()
    part = replace(block((3, 1, 1)), stress=odd)
    assert reduce(part, METHOD, cache=tmp_path).stress is not None
    assert not ReductionCache(tmp_path).entries()


def test_stages_are_reported_in_order() -> None:
    seen: list[tuple[str, float]] = []
    reduce(block((4, 1, 1)), METHOD, progress=lambda stage, done: seen.append((stage, done)))
    names = list(dict.fromkeys(stage for stage, _ in seen))
    assert names == [
        "checks", "factorisation", "constraint modes", "fixed-interface modes",
        "orthonormalisation", "invariants",
    ]  # fmt: skip
    for name in names:
        done = [value for stage, value in seen if stage == name]
        assert done[0] == 0.0 and done[-1] == 1.0
        assert all(0.0 <= value <= 1.0 for value in done)


def test_bars_on_standard_error(capsys: pytest.CaptureFixture[str]) -> None:
    reduce(block((4, 1, 1)), METHOD, progress=True)
    captured = capsys.readouterr()
    assert "fixed-interface modes" in captured.err
    assert not captured.out


def test_nothing_but_reductions_is_ever_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A folder of your own may hold other things: neither the limit nor `clear` touches them."""
    others = [
        tmp_path / "thesis" / "data.bin",
        tmp_path / "part.h5",
        tmp_path / "0123456789abcdef" / "part.h5",
        # of our form, but it holds something else
        tmp_path / ("ab" * 20) / "part.h5",
        tmp_path / ("ab" * 20) / "notes.txt",
        tmp_path / ("cd" * 20) / "folder" / "part.h5",
    ]
    for path in others:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(bytes(1000))
    (tmp_path / ("ef" * 20)).symlink_to(tmp_path / "thesis")
    small = ReductionCache(tmp_path, limit=1.0)
    part = block((3, 1, 1))
    for modes in (1, 2):
        reduce(part, replace(METHOD, modes=modes), cache=small)
    assert len(small.entries()) == 1
    (tmp_path / f"mesh-{'12' * 20}").mkdir()
    (tmp_path / f"mesh-{'12' * 20}" / "mesh.npz").write_bytes(b"")
    assert len(small.entries()) == 2
    monkeypatch.chdir(tmp_path)
    for folder in (".", ""):
        reduce(part, METHOD, cache=folder)
        assert ReductionCache(folder).size < 1e6
        ReductionCache(folder).clear()
        assert not ReductionCache(folder).entries()
    assert all(path.read_bytes() == bytes(1000) for path in others)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        {path.relative_to(tmp_path).parts[0] for path in others} | {"ef" * 20}
    )


def test_what_killed_writers_left_is_removed(tmp_path: Path) -> None:
    part = block((3, 1, 1))
    reduce(part, METHOD, cache=tmp_path)
    (entry,) = ReductionCache(tmp_path).entries()
    old, fresh = entry / f".{'0' * 32}.npz", entry / f".{'1' * 32}.h5"
    for path in (old, fresh):
        path.write_bytes(bytes(10))
    os.utime(old, (1e9, 1e9))
    reduce(part, replace(METHOD, modes=1), cache=tmp_path)
    assert not old.exists() and fresh.exists()
    ReductionCache(tmp_path).clear()
    assert not list(tmp_path.iterdir())


def test_the_solver_counts_for_what_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    part = block((3, 1, 1))
    assert reduce(part, METHOD, cache=tmp_path).provenance["solver"] == "superlu"
    for wrong in ("nonsense", ["superlu"]):
        solver: Any = wrong
        with pytest.raises(InputError, match="no solver"):
            reduce(part, METHOD, cache=tmp_path, solver=solver)
    # what another library made is not taken for that of the one named
    counter = Counter(monkeypatch)
    assert reduce(part, METHOD, cache=tmp_path).provenance["solver"] == "superlu"
    assert counter.count == 0
    for _ in range(2):
        named = reduce(part, METHOD, cache=tmp_path, solver="superlu")
        assert named.provenance["solver"] == "superlu"
        assert counter.count == 1


def test_going_on_with_another_library_names_both(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def progress(name: str, done: float) -> None:
        if name == "fixed-interface modes":
            raise KeyboardInterrupt

    part = block((3, 1, 1))
    with pytest.raises(KeyboardInterrupt):
        reduce(part, METHOD, cache=tmp_path, progress=progress)
    original = factor.factorise

    def renamed(*args: Any, **kwargs: Any) -> Any:
        solve = original(*args, **kwargs)
        solve.name = "other"  # type: ignore[attr-defined]
        return solve

    monkeypatch.setattr(factor, "factorise", renamed)
    assert reduce(part, METHOD, cache=tmp_path).provenance["solver"] == "superlu, other"


def test_threads_reduce_one_part_side_by_side(tmp_path: Path) -> None:
    part = block((4, 2, 2))
    with warnings.catch_warnings(), ThreadPoolExecutor(6) as pool:
        warnings.simplefilter("error")
        found = list(pool.map(lambda _: reduce(part, METHOD, cache=tmp_path), range(6)))
    for reduced in found[1:]:
        assert np.array_equal(reduced.frequencies, found[0].frequencies)
    (entry,) = ReductionCache(tmp_path).entries()
    assert [path.name for path in entry.iterdir()] == ["part.h5"]


def test_what_is_no_cache_is_refused() -> None:
    wrong: Any = [1]
    with pytest.raises(InputError, match=r"^cache: is \[1\], must be True, False, a folder or"):
        reduce(block((3, 1, 1)), METHOD, cache=wrong)


def test_damaged_arrays_are_made_anew_or_told(tmp_path: Path) -> None:
    """Stages of a reduction and matrices in .npz files, with bits that tipped."""
    from jousto.parts.matrices.plain import is_pair, read_pair

    rng = np.random.default_rng(2)
    arrays = {"M": rng.normal(size=(8, 8)), "K": rng.normal(size=(8, 8))}
    entry = ReductionCache(tmp_path).entry("0" * 40)
    entry.write("modes", arrays)
    (path,) = (tmp_path / ("0" * 40)).glob("*.npz")
    whole = path.read_bytes()
    pair = tmp_path / "pair.npz"
    refused, intact = [], 0
    for k in range(150):
        damaged = bytearray(whole)
        if k % 5:
            damaged[rng.integers(len(whole))] ^= 1 << rng.integers(8)
        else:
            del damaged[rng.integers(len(whole)) :]
        path.write_bytes(damaged)
        pair.write_bytes(damaged)
        found = entry.read("modes")
        names = arrays.keys() & (found or {}).keys()
        intact += names == arrays.keys()
        wrong = [name for name in names if not np.array_equal((found or {})[name], arrays[name])]
        assert not wrong
        is_pair(pair)
        try:
            read_pair(pair)
        except InputError as error:
            refused.append(str(error))
    # a fifth is cut short; bits of the archive's own times and rights do not matter
    assert intact > 5
    assert len(refused) > 30
    assert all("pair.npz" in text for text in refused)
