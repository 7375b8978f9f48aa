"""Times of single steps: what is counted adds up; how long they take depends on the computer."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from exported import CC
from jousto.export.instruction_count import by_file

MODEL = """
bodies: [{name: mass, mass: 1 kg, inertia: [1, 1, 1], position: [1, 0, 0]}]
joints: [{type: prismatic, name: rail, a: ground.origin, b: mass.origin, axis: [1, 0, 0]}]
forces: [{type: spring, name: k, coordinate: rail.displacement, stiffness: 40 N/m}]
simulation: {t_end: 1 s}
"""


def test_every_step_is_in_one_class() -> None:
    times = np.array([1e-6, 2e-6, 5e-5])
    found = jo.export.StepTimes("m", 1e-3, 10000, 1.3e-6, 4.9e-5, times, [9000, 999, 1], 4096)
    assert (found.median, found.share(0.999), found.share(1.0)) == (1e-6, 2e-6, 4.9e-5)
    assert found.rate(2.0) == pytest.approx(1 / (2 * 2e-6)) and found.rate(4.0) < found.rate(2.0)
    assert "4.0 KiB" in str(found)


@pytest.mark.chooses
@pytest.mark.skipif(CC is None or sys.platform == "win32", reason="no C compiler")
def test_steps_of_a_model_file_are_timed(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    from jousto.cli.group import app

    path = tmp_path / "mass.yaml"
    path.write_text(MODEL)
    with pytest.raises(SystemExit) as end:
        app(["realtime", str(path), "--steps", "1000", "--step", "0.5 ms"])
    out = capsys.readouterr().out
    assert end.value.code in (0, None) and "1000 steps of 0.0005 s" in out
    if shutil.which("valgrind"):
        assert re.search(r"trees in joint coordinates +\d+, .* each of 1\n", out)
        assert re.search(r"work +\d+ instructions a step", out)
    else:
        assert "instructions are not counted: that needs Valgrind" in out
    if sys.platform == "linux":
        assert re.search(r"memory stays in place: (yes|not allowed here)", out)


@pytest.mark.skipif(shutil.which("valgrind") is None, reason="no Valgrind")
def test_instructions_of_files_add_up_to_those_of_the_program(tmp_path: Path) -> None:
    """Callgrind's own total stands at the end of what it writes."""
    out = tmp_path / "out"
    line = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", "true"]
    subprocess.run(line, check=True, capture_output=True)
    text = out.read_text()
    total = int(re.findall(r"^totals: (\d+)", text, flags=re.MULTILINE)[-1])
    assert sum(by_file(text).values()) == total


def test_too_few_steps_are_refused() -> None:
    mass = jo.RigidBody("mass", 1.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], mass["origin"])
    with pytest.raises(jo.InputError, match="steps is 5, must be 1000 or more"):
        jo.export.realtime(jo.compile(jo.Mechanism(mass, rail)), steps=5)
