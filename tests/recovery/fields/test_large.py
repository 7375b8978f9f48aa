"""Fields that do not fit into memory, and files of them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tracemalloc
from pathlib import Path

import h5py
import numpy as np
import pytest

import jousto as jo
from jousto.reduction.fields.stress import StressModes


def field(ns: int, nt: int, n: int = 4) -> jo.recovery.StressField:
    rng = np.random.default_rng(3)
    eye = np.broadcast_to(np.eye(3), (ns, 3, 3))
    S = rng.normal(size=(ns, 6, n))
    modes = StressModes(tuple(f"n{i}" for i in range(ns)), rng.normal(size=(ns, 3)), eye, S)
    return jo.recovery.field_from(modes, rng.normal(size=(nt, n)), np.arange(nt, dtype=float))


def test_memory_is_that_of_the_blocks(tmp_path: Path) -> None:
    """1e4 places x 1e4 instants are 800 MB; blocks, envelope and file need a few."""
    large = field(10_000, 10_000, n=1)
    large.values("s11", times=slice(1))  # modes in the engine's order are part of the field
    tracemalloc.start()
    try:
        envelope = large.envelope("s11")
        seen = 0
        for along in ("time", "sites"):
            for k, (_, _, values) in enumerate(large.blocks("s11", memory=4 << 20, along=along)):
                seen = max(seen, values.nbytes)
                if k == 3:
                    break
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert seen <= 64 * 10_000 * 8  # 64 whole histories, or the memory given
    assert peak < 24e6
    # the largest of all, from one coordinate: the largest product
    S, p = large.S[:, 0, 0], large.p[:, 0]
    np.testing.assert_allclose(envelope.max, np.maximum(S * p.max(), S * p.min()), rtol=1e-14)
    with pytest.raises(jo.InputError, match=r"need 0.8 GB, more than memory=0.1 GB"):
        large.values("s11", memory=10**8)


@pytest.mark.parametrize("criterion", ["signed-von-mises", None])
def test_files(tmp_path: Path, criterion: str | None) -> None:
    some = field(37, 211)
    path = some.write(tmp_path / "field.h5", criterion, memory=9000)
    with h5py.File(path) as file:
        assert int(file["rows"][()]) == 211
        assert file["labels"][5] == b"n5" and file.attrs["frame"] == "site"
        np.testing.assert_array_equal(file["time"], some.time)
        for name, values in file["values"].items():
            np.testing.assert_allclose(values, some.values(name), rtol=1e-14)
        assert len(file["values"]) == (6 if criterion is None else 1)
    with pytest.raises(jo.InputError, match="must end with .h5"):
        some.write(tmp_path / "field.csv")
    with pytest.raises(jo.InputError, match="cannot be written: the folder .* does not exist"):
        some.write(tmp_path / "no" / "field.h5")


KILLED = """
import sys
sys.path[:0] = {paths!r}
import os, signal
import jousto as jo
from jousto.recovery.fields import store
from recovery.fields.test_large import field
some, write, count = field(37, 211), store._write, [0]
def slow(*arguments):
    write(*arguments)
    count[0] += isinstance(arguments[2], bytes) and len(arguments[2]) == 8  # number of rows
    if count[0] == {writes}:
        os.kill(os.getpid(), signal.SIGKILL)
store._write = slow
some.write({path!r}, memory=9000)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="there is no SIGKILL")
def test_what_a_killed_run_wrote_is_there(tmp_path: Path) -> None:
    path = tmp_path / "field.h5"
    tests = str(Path(__file__).parents[2])
    code = KILLED.format(paths=[*sys.path, tests], path=str(path), writes=3)
    done = subprocess.run([sys.executable, "-c", code], env=os.environ, check=False)
    assert done.returncode == -signal.SIGKILL
    some = field(37, 211)
    with h5py.File(path) as file:
        rows = int(file["rows"][()])
        assert 0 < rows < 211
        written = file["values/von-mises"][:rows]
    np.testing.assert_allclose(written, some.values("von-mises", times=slice(rows)), rtol=1e-14)
