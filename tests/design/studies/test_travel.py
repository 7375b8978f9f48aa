"""Functions of scripts and notebooks in other processes."""

from __future__ import annotations

import importlib
import pickle
import subprocess
import sys
from pathlib import Path

import pytest

ROOMS = ("jousto", "jousto.design", "jousto.fatigue", "jousto.mechanism", "jousto.robots")

MODEL = """
import jousto as jo
import numpy as np

def pushed(mass):
    block = jo.RigidBody("block", mass, (1, 1, 1))
    slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    push = jo.JointForce("push", slide.displacement, 4.0)
    return jo.Mechanism(block, slide, push, jo.CoordinateSensor("way", slide.displacement))

def way(run):
    return float(run["way"][-1, 0])

def table(**how):
    mass = jo.Parameter("mass", 2.0, unit="kg")
    study = jo.study(pushed, mass, {"way": way}, t_end=1.0, solver=jo.RK4(0.1))
    return study.run([[1.0], [2.0], [4.0]], **how)
"""
RUNS = {
    "dask": "found = table(workers='dask')",
    "processes": "found = table(workers=2, how='processes')",
    "joblib": (
        "import joblib\n"
        "class Found: y = np.array(joblib.Parallel(2)(joblib.delayed("
        "lambda m: [way(jo.simulate(jo.compile(pushed(m)), 1.0, solver=jo.RK4(0.1)))])(m) "
        "for m in (1.0, 2.0, 4.0)))\n"
        "found = Found"
    ),
}
SLOW = [pytest.param(way, marks=[] if way == "dask" else pytest.mark.slow) for way in RUNS]
# x = F t^2 / 2 m with 4 N
CHECK = "assert np.allclose(found.y.ravel(), [2.0, 1.0, 0.5], rtol=1e-12), found.y"


@pytest.mark.parametrize("name", ROOMS)
def test_rooms_travel_by_their_name(name: str) -> None:
    room = importlib.import_module(name)
    assert pickle.loads(pickle.dumps(room)) is room


@pytest.mark.parametrize("way", SLOW)
def test_functions_of_a_script_travel(way: str, tmp_path: Path) -> None:
    pytest.importorskip(
        "distributed" if way == "dask" else "joblib" if way == "joblib" else "numpy"
    )
    script = tmp_path / "script.py"
    body = "\n".join(f"    {line}" for line in f"{RUNS[way]}\n{CHECK}\nprint('fine')".splitlines())
    script.write_text(f"{MODEL}\nif __name__ == '__main__':\n{body}\n")
    found = subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, timeout=300, cwd=tmp_path
    )
    assert found.returncode == 0 and found.stdout.strip() == "fine", found.stderr


@pytest.mark.parametrize("way", SLOW)
def test_functions_of_a_notebook_travel(way: str, tmp_path: Path) -> None:
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    pytest.importorskip("cloudpickle")
    pytest.importorskip(
        "distributed" if way == "dask" else "joblib" if way == "joblib" else "numpy"
    )
    book = nbformat.v4.new_notebook(
        cells=[nbformat.v4.new_code_cell(text) for text in (MODEL, f"{RUNS[way]}\n{CHECK}")]
    )
    resources = {"metadata": {"path": str(tmp_path)}}
    nbclient.NotebookClient(book, timeout=300, resources=resources).execute()
