"""Exported programs of rigid trees: they run in joint coordinates, as the engine does."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from exported import CC, PLAIN, STEP, compiled, expected, reaching_arm, rows_of
from jousto.export.program import program
from jousto.export.project import write_program
from model.test_tree_ports import machine

pytestmark = pytest.mark.skipif(
    CC is None or sys.platform == "win32", reason="no C compiler to compile the programs with"
)


@pytest.fixture(scope="module")
def model() -> jo.Model:
    return jo.compile(reaching_arm(), core="joint")


@pytest.fixture(scope="module")
def folder(model: jo.Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("tree")
    write_program(model, out / "arm.c", jo.ROS2(step=STEP))
    return out


def test_a_program_runs_the_tree(model: jo.Model, tmp_path: Path) -> None:
    """Links of every kind, a drive, all forces, an event and damage: the same within round-off."""
    assert {link.kind for link in model.links} == {"hinge", "slide", "ball", "fixed", "free"}
    found = rows_of(model, jo.ROS2(step=STEP), tmp_path, "0.4", "10")
    run = jo.simulate(model, 0.4, solver=jo.ROS2(step=STEP), output_step=0.04)
    want = expected(model, run)
    # what the other core computes differs by 1e-6 m and 1e-3 N, the error of the method; touches
    # are located in time within 1e-11 s, in which places move by 1e-11 m
    scale = np.maximum(np.abs(want).max(axis=0), 0.1)
    assert found.shape == want.shape
    assert (np.abs(found - want) <= 1e-10 * scale).all()


def test_machines_are_saved_changed_and_kept_apart(folder: Path) -> None:
    """As part of a program of somebody else's, with the vectors of four numbers where it can."""
    shutil.copy(Path(__file__).with_name("tree_use.c"), folder)
    native = (
        () if subprocess.run([str(CC), "-mavx2", "-E", "-"], input="").returncode else ("-mavx2",)
    )
    for flags in {(), native}:
        use = compiled(folder, "arm.c", "tree_use.c", flags=(*PLAIN, *flags))
        assert subprocess.run([use]).returncode == 0, flags


def test_implicit_methods_run_in_the_positions_of_the_bodies(model: jo.Model) -> None:
    assert ".nlink = 10" in program(model, jo.RK4(step=STEP)).constants.text
    made = program(model, jo.GeneralizedAlpha(step=STEP))
    assert ".nlink = 0" in made.constants.text and not made.model.links


@pytest.mark.parametrize("solver", [jo.RK4(step=STEP), jo.ROS2(step=STEP)], ids=["RK4", "ROS2"])
def test_a_program_runs_trees_on_flexible_bodies(solver: jo.RK4 | jo.ROS2, tmp_path: Path) -> None:
    """Links of every kind on bodies that stay, drives, springs: the same within round-off."""
    model = jo.compile(machine(1, drives=True), core="joint")
    assert {link.kind for link in model.links} == {"body", "hinge", "slide", "ball", "fixed"}
    found = rows_of(model, solver, tmp_path, "0.1", "5")
    run = jo.simulate(model, 0.1, solver=solver, output_step=0.02)
    want = expected(model, run)
    scale = np.maximum(np.abs(want).max(axis=0), 1e-3)  # moments about free axes vanish
    assert found.shape == want.shape
    # motion, which doubles round-off now and then; the shock is that of accelerations
    assert (np.abs(found - want) <= 1e-9 * scale).all()
