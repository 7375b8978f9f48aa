"""Journals of studies: damaged lines, several programs, killed programs."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import warnings
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from design.studies import machines
from design.studies.machines import FORCES, RUN
from jousto.design.studies.running import guard

TESTS = Path(__file__).parents[2]
X = np.array([[2.0, 1.0], [2.0, 2.0], [2.0, 3.0]])
WAY = X[:, 1] / 4.0  # F t^2 / 2 m


def forces() -> jo.design.Study:
    return jo.study(machines.pushed, FORCES, {"way": machines.way}, **RUN)


def longer(line: bytes) -> bytes:
    """Return a row with one outcome more and a checksum that is right."""
    row = json.loads(line)
    row["y"] = row["y"] * 2
    del row["sum"]
    row["sum"] = zlib.crc32(json.dumps(row, separators=(",", ":")).encode())
    return json.dumps(row, separators=(",", ":")).encode()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda line: line.replace(b'"y":[0.5', b'"y":[5.0'), "line 3 was changed since it was"),
        (lambda line: line.replace(b'"x":[2.0', b'"x":[3.0'), "line 3 was changed since it was"),
        (lambda line: line.replace(b'"y"', b'"\xffy"'), "line 3 is not a row of a study"),
        (lambda line: line[:20] + line, "line 3 is not a row of a study"),
        (longer, "line 3 has 2 values and 2 outcomes, must have 2 values and 1 outcome"),
    ],
)
def test_a_damaged_line_is_skipped_reported_and_computed_again(
    change: Any, said: str, tmp_path: Path
) -> None:
    path = tmp_path / "t.jsonl"
    forces().run(X, path=path)
    lines = path.read_bytes().splitlines()
    assert change(lines[2]) != lines[2]
    lines[2] = change(lines[2])
    path.write_bytes(b"\n".join(lines) + b"\n")
    study = forces()
    with pytest.warns(jo.JoustoWarning, match=f"{said}.*computed again"):
        table = study.run(X, path=path)
    np.testing.assert_allclose(table["way"], WAY, rtol=1e-12)
    assert study.counts["runs"] == 1


def test_a_journal_without_checksums_is_refused_with_its_version(tmp_path: Path) -> None:
    path = tmp_path / "t.jsonl"
    forces().run(X, path=path)
    path.write_bytes(path.read_bytes().replace(b'"version":2', b'"version":1'))
    with pytest.raises(jo.InputError, match="is a journal of version 1, must be 2"):
        forces().run(X, path=path)


SCRIPT = """
import sys
import jousto as jo
from design.studies import machines as m
if __name__ == "__main__":
    s = jo.study(m.pushed, m.FORCES, {{"way": m.slow}}, **m.RUN)
    x = [[2.0, 0.5 + 0.01 * k] for k in range({points})]
    print(s.run(x, path={path!r}, {how}).y.shape)
"""


def started(folder: Path, path: Path, points: int, how: str) -> subprocess.Popen[bytes]:
    script = folder / "script.py"
    script.write_text(SCRIPT.format(points=points, path=str(path), how=how))
    env = os.environ | {"JOUSTO_TEST_MARK": str(folder / "mark"), "PYTHONPATH": str(TESTS)}
    return subprocess.Popen([sys.executable, str(script)], env=env, start_new_session=True)


def group(leader: int) -> list[int]:
    """Return the processes of a session that are alive."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == leader and fields[0] != "Z":
            found.append(int(stat.parent.name))
    return found


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks at processes in /proc")
@pytest.mark.parametrize(
    "how", ["workers=2, how='processes'", pytest.param("workers='dask'", marks=pytest.mark.slow)]
)
def test_workers_end_with_a_killed_program_and_nothing_is_computed_twice(
    how: str, tmp_path: Path
) -> None:
    """kill -9 of the program alone; the same study starts at once."""
    if "dask" in how:
        pytest.importorskip("distributed")
    path, mark = tmp_path / "t.jsonl", tmp_path / "mark"
    program = started(tmp_path, path, 400, how)
    try:
        while program.poll() is None and (not mark.exists() or mark.stat().st_size < 6):
            time.sleep(0.02)
        assert program.poll() is None and len(group(program.pid)) > 2
        os.kill(program.pid, signal.SIGKILL)
        program.wait()
        again = started(tmp_path, path, 40, how="workers=1")
        assert again.wait(120) == 0
        # its own sessions: what is left of the first is none of the second
        until = time.monotonic() + 20.0
        while group(program.pid) and time.monotonic() < until:
            time.sleep(0.05)
        assert not group(program.pid)
    finally:
        for left in group(program.pid):
            os.kill(left, signal.SIGKILL)
    rows = [json.loads(line) for line in path.read_text().splitlines()[1:]]
    places = [tuple(row["x"]) for row in rows]
    assert len(places) == len(set(places)) >= 40
    # of each worker the last point may have been marked and not written
    assert mark.stat().st_size - 4 <= len(places) <= mark.stat().st_size


def test_a_journal_that_another_program_writes_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("fcntl")
    monkeypatch.setattr(guard, "PATIENCE", 0.2)
    path, mark = tmp_path / "t.jsonl", tmp_path / "mark"
    program = started(tmp_path, path, 2000, "workers=1")
    try:
        while program.poll() is None and not mark.exists():
            time.sleep(0.02)
        before = path.stat().st_size
        with pytest.raises(jo.InputError, match="another study writes it at this moment"):
            forces().run(X, path=path)
        assert path.stat().st_size >= before
    finally:
        program.kill()
        program.wait()


def test_a_refused_study_leaves_no_empty_journal(tmp_path: Path) -> None:
    path = tmp_path / "t.h5"
    forces().run(X, path=path)
    other = jo.study(machines.pushed, FORCES, "peak(way)", **RUN)
    with pytest.raises(jo.InputError, match="contains another study"):
        other.run(X, path=path)
    assert [p.name for p in tmp_path.iterdir()] == ["t.h5"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert forces().run(X, path=path).good.all()
