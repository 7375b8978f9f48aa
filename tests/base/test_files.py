"""What is written and removed: files only, whole or not at all, never what others made."""

from __future__ import annotations

import functools
import os
import stat
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import jousto as jo
from cli.test_cli import MODEL
from jousto.base.files import create, write_table, written
from jousto.cli.group import app
from jousto.measurement.monitor.record_writer import Layout, Record
from jousto.mesh.cells import Cells
from jousto.output.files.meshes import write_mesh
from jousto.output.files.sid import write_sid
from jousto.output.files.table import write_csv
from jousto.recovery.fields.build import stress_field
from output.runs import swing

posix = pytest.mark.skipif(sys.platform == "win32", reason="devices and pipes are files of POSIX")


def block() -> jo.Mesh:
    grid = np.stack(np.meshgrid([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], indexing="ij"), axis=-1)
    nodes = [[0, 4, 6, 2, 1, 5, 7, 3]]
    return jo.Mesh("block", grid.reshape(8, 3), Cells("hexahedron", nodes))


@functools.cache
def arm() -> jo.ReducedPart:
    part = jo.Part.beam(1.0, jo.Circle(0.02), 2, jo.Material(2.1e11, 0.3, 7850.0))
    return jo.reduce(part, jo.CraigBampton(("start",), modes=2))


def run_to(path: Path) -> object:
    arm = jo.RigidBody("arm", 1.0, (0.1, 0.1, 0.1), center=(1.0, 0.0, 0.0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], arm["origin"], axis=(0, 1, 0))
    model = jo.compile(jo.Mechanism(arm, hinge, jo.Gravity((0, 0, -9.81))))
    return jo.simulate(model, 0.01, solver=jo.RK4(1e-3), path=path)


def field(path: Path) -> object:
    return stress_field(swing(), "arm").write(path)


WRITERS: dict[str, Callable[[Path], object]] = {
    "a.h5": run_to,
    "b.h5": lambda path: Record.create(path, Layout((), {}, {})).close("", complete=True),
    "c.h5": field,
    "d.h5": lambda path: arm().save(path),
    "e.png": lambda path: jo.plot(swing(), "tip", path=path),
    "f.csv": lambda path: write_csv(swing(), path),
    "g.vtu": lambda path: write_mesh(block(), path),
    "h.csv": lambda path: write_table(path, ["a"], [[1]]),
    "i.SID_FEM": lambda path: write_sid(arm(), path),
    "j.gif": lambda path: jo.animate(swing(), path, fps=2),
}


def null_device(path: Path) -> None:
    """Make a device like /dev/null, which only root can, or a pipe."""
    try:
        os.mknod(path, stat.S_IFCHR | 0o666, os.makedev(1, 3))
    except OSError:
        os.mkfifo(path)


@posix
@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("linked", [False, True])
def test_a_device_is_refused_and_stays(name: str, linked: bool, tmp_path: Path) -> None:
    target = device = tmp_path / name
    if linked:
        device = tmp_path / "device"
        target.symlink_to(device)
    null_device(device)
    before = device.lstat()
    with pytest.raises(jo.InputError, match="is a (device|pipe), must be a file"):
        WRITERS[name](target)
    after = device.lstat()
    assert (after.st_ino, after.st_mode, after.st_rdev) == (
        *(before.st_ino, before.st_mode),
        before.st_rdev,
    )
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted({target.name, device.name})


@pytest.mark.parametrize("name", WRITERS)
def test_every_writer_of_the_list_writes(name: str, tmp_path: Path) -> None:
    WRITERS[name](tmp_path / name)
    assert (tmp_path / name).stat().st_size
    assert [p.name for p in tmp_path.iterdir()] == [name]


@posix
@pytest.mark.parametrize("command", ["run", "plot", "linearise", "reduce", "animate", "kinematics"])
def test_commands_leave_a_device_alone(command: str, tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(MODEL)
    run_to(tmp_path / "run.h5")
    source = tmp_path / ("run.h5" if command in ("plot", "animate") else "m.yaml")
    null_device(tmp_path / "null")
    result = CliRunner().invoke(
        app, [command, str(source), "-o", str(tmp_path / "null")], catch_exceptions=False
    )
    assert result.exit_code == 2
    assert not stat.S_ISREG((tmp_path / "null").lstat().st_mode)


def test_what_was_there_stays_where_writing_fails(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("old")

    class Refused(Exception):
        pass

    with pytest.raises(Refused), written(path) as beside:
        beside.write_text("half")
        raise Refused
    assert path.read_text() == "old"
    with written(path) as beside:
        beside.write_text("new")
    assert path.read_text() == "new"
    assert [p.name for p in tmp_path.iterdir()] == ["a.csv"]


@posix
def test_a_link_keeps_pointing_and_modes_stay(tmp_path: Path) -> None:
    path, link = tmp_path / "a.csv", tmp_path / "b.csv"
    path.write_text("old")
    path.chmod(0o640)
    link.symlink_to(path)
    write_table(link, ["new"], [])
    assert link.is_symlink() and path.read_text().strip() == "new"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_new_files_get_the_mode_of_others(tmp_path: Path) -> None:
    (tmp_path / "plain").write_text("x")
    write_table(tmp_path / "a.csv", ["x"], [])
    assert (tmp_path / "a.csv").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_folders_are_refused(tmp_path: Path) -> None:
    for name in ("a.csv", "b.h5"):
        (tmp_path / name).mkdir()
    with pytest.raises(jo.InputError, match="is a folder, must be a file"):
        write_table(tmp_path / "a.csv", ["x"], [])
    with pytest.raises(jo.InputError, match="is a folder, must be a file"):
        create(tmp_path / "b.h5")
