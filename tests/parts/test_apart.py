"""Readers in a process of their own: what they return, and how they may die."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from gmsh_session import opened
from hearing import hear
from jousto.base.errors import InputError, JoustoWarning
from jousto.mesh.readers.subprocess_reader import apart, packed, unpacked

MODULE = """
import faulthandler, json, os, sys, time
import numpy as np
from jousto.base.errors import InputError, Problem, warn

def data(path, size):
    warn(path.name, "is odd")
    return {"x": np.arange(size, dtype=float), "rows": [[1, np.array([2])], None], 7: "seven"}

def refused(path):
    raise InputError([Problem(path.name, "is wrong"), Problem(path.name, "is bad")])

def segmentation_fault(path):
    faulthandler._sigsegv()

def aborted(path):
    os.abort()

def left(path):
    os._exit(3)

def raised(path):
    raise KeyError("deep inside")

def objects(path):
    return np.array([{}], dtype=object)

def noise(path):
    os.write(1, b"x" * 1_000_000)
    return 1

def endless(path):
    path.write_text(str(os.getpid()))
    time.sleep(600)
"""


@pytest.fixture(autouse=True)
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "strange.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)


def test_data_warnings_and_problems_come_back(tmp_path: Path) -> None:
    with pytest.warns(JoustoWarning, match=r"a\.x: is odd"):
        found = apart(tmp_path / "a.x", "strange:data", "", size=3)
    np.testing.assert_array_equal(found["x"], [0.0, 1.0, 2.0])
    assert found["rows"][0][0] == 1 and found["rows"][1] is None and found[7] == "seven"
    with pytest.raises(InputError) as error:
        apart(tmp_path / "a.x", "strange:refused", "")
    assert str(error.value) == "a.x: is wrong\na.x: is bad"
    assert apart(tmp_path / "a.x", "strange:noise", "") == 1


@pytest.mark.parametrize(
    ("function", "sentence"),
    [
        ("segmentation_fault", "the library that reads it crashed|failed"),
        ("aborted", "the library that reads it crashed|failed"),
        ("left", "the library that reads it failed .exit code 3.; try again$"),
        ("raised", "failed .exit code 1.: KeyError: 'deep inside'; try again$"),
        ("objects", "failed .exit code 1.: ValueError: .*; try again$"),
    ],
)
def test_the_death_of_a_reader_is_one_sentence(
    function: str, sentence: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=rf"^boom\.x: .*({sentence})") as error:
        apart(tmp_path / "boom.x", f"strange:{function}", "try again")
    assert str(error.value).count("\n") == 0 and "try again" in str(error.value)


def test_nested_values_are_packed_and_unpacked() -> None:
    arrays: dict[str, np.ndarray] = {}
    value = {"a": [1, (2.5, None)], 3: {"array": np.arange(3)}, "": [], "map": True}
    back = unpacked(packed(value, arrays), arrays)
    np.testing.assert_array_equal(back[3].pop("array"), np.arange(3))
    assert back == {"a": [1, [2.5, None]], 3: {}, "": [], "map": True}


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_ends_both_processes(tmp_path: Path) -> None:
    script = (
        "import sys; from pathlib import Path\n"
        "from jousto.mesh.readers.subprocess_reader import apart\n"
        "apart(Path(sys.argv[1]), 'strange:endless', '')\n"
    )
    mark = tmp_path / "pid"
    paths = os.pathsep.join(entry for entry in sys.path if entry)
    with subprocess.Popen(
        [sys.executable, "-c", script, str(mark)],
        env={**os.environ, "PYTHONPATH": paths},
        stderr=subprocess.DEVNULL,
        preexec_fn=hear,
    ) as process:
        while not (mark.exists() and mark.read_text()):
            assert process.poll() is None
            time.sleep(0.02)
        # the parent alone is told, as by a window that ends it
        process.send_signal(signal.SIGINT)
        process.wait(60)
    with pytest.raises(ProcessLookupError):
        os.kill(int(mark.read_text()), 0)


def test_modules_in_the_working_folder_are_not_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "downloaded"
    folder.mkdir()
    (folder / "json.py").write_text("open('was run', 'w')\n")
    monkeypatch.chdir(folder)
    assert apart(tmp_path / "a.x", "strange:noise", "") == 1
    assert not (folder / "was run").exists()


@pytest.mark.parametrize("seed", range(3))
def test_damaged_cad_files_leave_python_alive(seed: int, tmp_path: Path) -> None:
    gmsh = pytest.importorskip("gmsh")
    with opened(gmsh):
        gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 40, 10)
        gmsh.model.occ.synchronize()
        gmsh.write(str(tmp_path / "good.brep"))
    rng = np.random.default_rng(seed)
    data = bytearray((tmp_path / "good.brep").read_bytes())
    digits = [i for i, byte in enumerate(data) if chr(byte).isdigit() and i > 100]
    for i in rng.choice(digits, size=len(digits) // 20, replace=False):
        data[i] = ord("0") + int(rng.integers(10))
    (tmp_path / "bad.brep").write_bytes(data)
    try:
        ended = f"{len(jo.mesh_cad(tmp_path / 'bad.brep', size=10e-3, unit='mm').nodes)} nodes"
    except InputError as error:
        ended = str(error)
    # which of both it is depends on what the CAD kernel can still make of it
    assert "bad.brep: " in ended or re.fullmatch(r"[1-9]\d* nodes", ended)
