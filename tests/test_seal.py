"""Checksums of files that grow while they are read."""

from __future__ import annotations

import numpy as np
import pytest

from jousto.base.checksums import BLOCK, Seal, sealed


@pytest.fixture
def growing(tmp_path):
    """Return a file with one column, laid out, and what adds a block of rows to it."""
    path = tmp_path / "run"
    seal = Seal(8 * 4 * BLOCK, [(0, 8)], 4 * BLOCK)
    path.write_bytes(b"\0" * (8 * 4 * BLOCK))
    done = 0

    def write(at, data):
        with path.open("r+b") as file:
            file.seek(at)
            file.write(data)

    def add():
        nonlocal done
        rows = np.arange(done, done + BLOCK, dtype="<f8").tobytes()
        write(8 * done, rows)
        seal.add([rows], BLOCK, write)
        done += BLOCK

    seal.finish([], write, closed=False)
    add()
    return path, add, write


def test_rows_that_came_after_the_checksums_were_read_have_theirs(growing):
    path, add, _ = growing
    seen = sealed(path)
    add()
    seen.check(0, "time", 0, 2 * BLOCK, 2 * BLOCK)


def test_changed_rows_of_a_growing_file_are_told(growing):
    path, add, write = growing
    seen = sealed(path)
    add()
    write(8 * BLOCK + 16, b"\1")
    with pytest.raises(ValueError, match="time was changed between rows 1024 and 2047"):
        seen.check(0, "time", 0, 2 * BLOCK, 2 * BLOCK)
