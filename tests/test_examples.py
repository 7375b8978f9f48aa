"""Every example is a test: it asserts its own numbers and must run without a warning."""

from __future__ import annotations

import os
import runpy
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from PIL import Image

import jousto as jo

FOLDER = Path(__file__).parent.parent / "examples"
SCRIPTS = sorted(FOLDER.glob("*.py"))
MODELS = sorted(FOLDER.glob("*.yaml"))
LARGEST = 5e6  # bytes of a picture or film


def ended(path: Path) -> object:
    """Run a script and return the code that it ends with."""
    try:
        runpy.run_path(str(path), run_name="__main__")
    except SystemExit as end:
        return end.code
    return 0


def test_an_example_is_a_program(tmp_path: Path) -> None:
    command = [sys.executable, "-W", "error", str(FOLDER / "portal_frame.py"), "pictures"]
    env = {**os.environ, "MPLBACKEND": "Agg"}
    run = subprocess.run(command, cwd=tmp_path, env=env, capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, "")
    assert list((tmp_path / "pictures").iterdir())


@pytest.mark.parametrize("path", SCRIPTS, ids=[path.stem for path in SCRIPTS])
def test_example(
    path: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    # in this process: one of its own would take two seconds to import what all of them need
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [str(path), "pictures"])
    monkeypatch.syspath_prepend(FOLDER)
    try:
        with plt.rc_context():
            code = ended(path)
    finally:
        plt.close("all")
    out, err = capfd.readouterr()
    assert not code, out + err
    assert err == ""
    pictures = sorted((tmp_path / "pictures").iterdir())
    assert pictures
    for picture in pictures:
        assert picture.stat().st_size < LARGEST
        with Image.open(picture) as image:
            # something is drawn on it
            assert len(image.convert("RGB").getcolors(1 << 24)) > 20


@pytest.mark.parametrize("path", SCRIPTS, ids=[path.stem for path in SCRIPTS])
def test_example_reads_well(path: Path) -> None:
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith('"""')
    assert 40 <= len(lines) <= 150


@pytest.mark.filterwarnings("ignore:.*softer than most plastics")
@pytest.mark.parametrize("path", MODELS, ids=[path.stem for path in MODELS])
def test_model_file(path: Path) -> None:
    file = jo.read_model(path)
    assert file.simulation is not None
    # the beginning of the run that the file asks for
    settings = file.simulation.given()
    run = jo.simulate(jo.compile(file.mechanism), 10 * file.simulation.output_step, **settings)
    assert run.complete
    assert run.nt == 11


def test_the_model_file_of_the_pendulum_is_that_of_the_script(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.syspath_prepend(str(FOLDER))
    import flexible_pendulum as script

    with pytest.warns(jo.JoustoWarning, match="flexible_pendulum.yaml:.*kPa"):
        file = jo.read_model(FOLDER / "flexible_pendulum.yaml")
    run = jo.simulate(jo.compile(file.mechanism), 1.0, **file.simulation.given())
    other = script.simulate(script.computed_modes(script.beam()), 1.0)
    assert abs(run["middle"] - other["middle"]).max() < 1e-13
