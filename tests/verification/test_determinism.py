"""The same model gives the same bytes, whatever the clock, the output step or the process.

`simulate` calls the engine in pieces whose length depends on the wall clock; this must not be seen
in the results. No published source: a law of the package.
"""

from __future__ import annotations

import subprocess
import sys
from functools import partial
from importlib import import_module
from pathlib import Path

import h5py
import numpy as np
import pytest

import jousto as jo
from verification.mechanisms import chain, loop

STEP = 2.0**-12  # s; a power of two, so that every output step gives the same step

SOLVERS = {
    "RK4": jo.RK4(step=STEP),
    "ROS2": jo.ROS2(step=STEP),
    "SSPRK3": jo.simulation.SSPRK3(step=STEP),
    "ROS3A": jo.simulation.ROS3A(step=STEP),
    "RK4, not projected": jo.RK4(step=STEP, projection=False),
    "ROS2, not projected": jo.ROS2(step=STEP, projection=False),
    "RK4, Baumgarte": jo.RK4(
        step=STEP, projection=False, baumgarte=jo.simulation.Baumgarte(50.0, 50.0)
    ),
}


def build():
    return jo.compile(chain("fixed", loads=True, damping=0.01))


def contents(path):
    """Bytes of every dataset that the motion fills."""
    found = {}
    with h5py.File(path) as file:

        def note(name, item):
            if isinstance(item, h5py.Dataset) and name != "model":
                found[name] = np.asarray(item).tobytes()

        file.visititems(note)
    return found


@pytest.mark.parametrize("solver", SOLVERS.values(), ids=SOLVERS.keys())
def test_two_runs_give_the_same_bytes(tmp_path, monkeypatch, solver):
    model = build()
    jo.simulate(model, 0.25, solver=solver, path=tmp_path / "a.h5")
    # a slow machine does fewer steps in each call of the engine: here one
    monkeypatch.setattr(import_module("jousto.simulation.running.simulate"), "WALL_PER_CALL", 1e-9)
    jo.simulate(model, 0.25, solver=solver, path=tmp_path / "b.h5")
    a, b = contents(tmp_path / "a.h5"), contents(tmp_path / "b.h5")
    assert a.keys() == b.keys()
    assert {"time", "state/q", "state/v", "sensors/tip", "diagnostics/kinetic"} <= a.keys()
    assert len(a["time"]) == 8 * 1025
    assert [name for name in a if a[name] != b[name]] == []


@pytest.mark.parametrize("solver", SOLVERS.values(), ids=SOLVERS.keys())
@pytest.mark.parametrize(
    "mechanism",
    [partial(chain, "spherical", loads=True, damping=0.01), loop],
    ids=["chain", "loop"],
)
def test_looking_at_a_run_does_not_change_it(mechanism, solver):
    # storing a row evaluates the equations; the next step must not notice
    model = jo.compile(mechanism())
    often = jo.simulate(model, 0.125, solver=solver)
    seldom = jo.simulate(model, 0.125, solver=solver, output_step=0.125 / 4)
    assert often.nt == 513
    assert seldom.nt == 5
    np.testing.assert_array_equal(often.q[::128], seldom.q)
    np.testing.assert_array_equal(often.v[::128], seldom.v)
    np.testing.assert_array_equal(often["tip"][::128], seldom["tip"])
    np.testing.assert_array_equal(often.energy.dissipated[::128], seldom.energy.dissipated)
    np.testing.assert_array_equal(often.energy.work[::128], seldom.energy.work)


def test_another_process_gives_the_same_bytes(tmp_path):
    script = (
        "import jousto as jo\n"
        "from verification.test_determinism import STEP, build\n"
        "jo.simulate(build(), 0.0625, solver=jo.ROS2(step=STEP), path='other.h5')\n"
    )
    here = tmp_path / "here.h5"
    jo.simulate(build(), 0.0625, solver=jo.ROS2(step=STEP), path=here)
    root = str(Path(__file__).parents[1])
    source = str(Path(jo.__file__).parents[1])
    subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path[:0] = [{source!r}, {root!r}]\n{script}"],
        cwd=tmp_path,
        check=True,
    )
    assert contents(here) == contents(tmp_path / "other.h5")


def test_one_model_can_run_many_times():
    # a model is constant: a run leaves nothing behind in it
    model = build()
    q0, v0 = model.q0.copy(), model.v0.copy()
    first = jo.simulate(model, 0.0625, solver=jo.RK4(step=STEP))
    jo.simulate(model, 0.0625, solver=jo.ROS2(step=STEP))
    again = jo.simulate(model, 0.0625, solver=jo.RK4(step=STEP))
    np.testing.assert_array_equal(first.q, again.q)
    np.testing.assert_array_equal(model.q0, q0)
    np.testing.assert_array_equal(model.v0, v0)
