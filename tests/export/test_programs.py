"""Exported programs of C: they compile without a warning and compute the engine's own bits."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from exported import (
    CC,
    FLAGS,
    STEP,
    WARNINGS,
    compiled,
    engine_rows,
    reaching_arm,
    rows_of,
    swinging_arm,
    table,
)
from jousto.export.constants import number
from jousto.export.project import write_program

pytestmark = pytest.mark.skipif(
    CC is None or sys.platform == "win32", reason="no C compiler to compile the programs with"
)


@pytest.fixture(scope="module")
def machine() -> jo.Model:
    return jo.compile(swinging_arm())


@pytest.fixture(scope="module")
def built(machine: jo.Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("program")
    write_program(machine, folder / "arm.c", jo.ROS2(step=STEP))
    # as the compiler takes it by itself, with the names of GNU's library
    subprocess.run([str(CC), "-fsyntax-only", "-Werror", "arm.c"], cwd=folder, check=True)
    return compiled(folder, "arm.c", flags=(*FLAGS, "-DMAIN"))


def test_a_program_of_one_file_computes_the_bits_of_the_engine(
    machine: jo.Model, built: Path, tmp_path: Path
) -> None:
    """Friction that sticks, an event, damage and an input included."""
    assert np.array_equal(table(built, "0.4", "10"), engine_rows(tmp_path, 0.4, 10))


@pytest.mark.parametrize(
    ("solver", "make"),
    [
        pytest.param(jo.simulation.SSPRK3, reaching_arm, marks=pytest.mark.slow),
        (jo.simulation.ROS3A, swinging_arm),
    ],
    ids=["SSPRK3", "ROS3A"],
)
def test_a_program_has_each_method(solver: type, make: Callable, tmp_path: Path) -> None:
    """Within round-off; the explicit one for rigid bodies: modes need shorter steps."""
    machine = jo.compile(make(), core="maximal")
    found = rows_of(machine, solver(step=STEP), tmp_path, "0.2", "5")
    rows = engine_rows(tmp_path, 0.2, 5, make.__name__, "maximal", solver.__name__)
    scale = np.maximum(np.abs(rows).max(axis=0), 1e-9)
    assert (np.abs(found - rows) <= 1e-10 * scale).all()


@pytest.mark.skipif(shutil.which("make") is None, reason="no make")
def test_a_project_builds_with_its_makefile_without_a_warning(
    machine: jo.Model, built: Path, tmp_path: Path
) -> None:
    out = write_program(machine, tmp_path / "arm.zip", jo.ROS2(step=STEP))
    shutil.unpack_archive(out, tmp_path)
    flags = " ".join([*WARNINGS[1:], "-O0", *FLAGS[1:]])
    done = subprocess.run(
        ["make", f"CFLAGS={flags}"], cwd=tmp_path / "arm", capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert np.array_equal(table(tmp_path / "arm" / "arm", "0.1", "4"), table(built, "0.1", "4"))


def test_machines_are_saved_changed_and_kept_apart(machine: jo.Model, tmp_path: Path) -> None:
    """As part of a program of somebody else's, under the address and behaviour sanitizers."""
    write_program(machine, tmp_path / "arm.c", jo.ROS2(step=STEP))
    shutil.copy(Path(__file__).with_name("use.c"), tmp_path)
    # not optimised: compiling takes a quarter of the time
    flags = ("-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g")
    program = compiled(tmp_path, "arm.c", "use.c", flags=(*FLAGS[1:], *flags))
    done = subprocess.run([program], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_what_no_program_can_do_is_refused(machine: jo.Model, tmp_path: Path) -> None:
    with pytest.raises(jo.InputError, match="DormandPrince chooses its steps itself"):
        write_program(machine, tmp_path / "arm.c", jo.simulation.DormandPrince())
    ball = jo.RigidBody("ball", 1.0, (1, 1, 1))
    law = jo.UserForce("law", ball["origin"], lambda t, x: [0.0] * 6)
    rail = jo.Prismatic("rail", jo.ground["origin"], ball["origin"])
    model = jo.compile(jo.Mechanism(ball, rail, law))
    with pytest.raises(jo.InputError, match="force 'law': is a Python function"):
        jo.write(model, tmp_path / "ball.c")
    assert not list(tmp_path.iterdir())


def test_numbers_are_exact() -> None:
    values = [0.1, -1 / 3, 5e-324, 1.7976931348623157e308, -0.0]
    assert [float.fromhex(number(x)) for x in values] == values
    assert [number(x) for x in (12.0, -3.0)] == ["12.0", "-3.0"]
    assert number(-0.0) == "-0.0"
