"""Tyres and wheels on tracks in an exported program: the same motion as in the engine."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from exported import CC, PLAIN, compiled, expected, rows_of, table
from jousto.export.project import write_program
from jousto.mechanism import BrushTyre, MagicFormula, PowerLaw, TrackContact, Tyre

pytestmark = pytest.mark.skipif(
    CC is None or sys.platform == "win32", reason="no C compiler to compile the programs with"
)


@pytest.mark.filterwarnings("ignore:.*moves freely")
def test_a_program_rolls(tmp_path: Path) -> None:
    """Two wheels on tyres, a ball that is dropped on a beam, a wheelset against its flange."""
    brush = BrushTyre(0.9, load=300, stiffness_x=9e3, stiffness_y=6e3, half_length=0.05)
    items: list[object] = []
    for i, law in enumerate((brush, MagicFormula(300.0))):
        wheel = jo.RigidBody(
            f"w{i}", 30.0, (0.6, 1, 0.6), position=(0, 2.0 + i, 0.3), velocity=(2, 0.3, 0),
            angular_velocity=(0, 4.0, 0.2),
        )  # fmt: skip
        tyre = Tyre(
            *(f"t{i}", jo.ground["origin"], wheel["origin"], 0.31, law, 2e5), axle=(0, 1, 0)
        )
        items += [wheel, tyre, jo.PositionSensor(f"p{i}", wheel["origin"])]
    steel = jo.Material(E=210e9, nu=0.3, rho=7850)
    part = jo.Part.beam(2.0, jo.Rectangle(0.03, 0.01), 4, steel)
    reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=2))
    beam = jo.FlexibleBody("beam", reduced.keep(reduced.in_plane("xz")))
    held = jo.Fixed("held", jo.ground["origin"], beam["start"])
    ball = jo.RigidBody.sphere(
        "ball", radius=0.02, mass=0.3, position=(0.5, 0, 0.03), velocity=(1, 0, 0)
    )
    touch = TrackContact(
        *("touch", (beam["start"], beam["end"]), ball["origin"], PowerLaw(1e5, 1.0)),
        radius=0.02,
        mu_kinetic=0.3,
    )
    items += [beam, held, ball, touch, jo.PositionSensor("ball", ball["origin"])]
    axle = jo.RigidBody(
        "axle", 1200.0, (700, 100, 700), position=(0, -1.15e-3, 0.4603), velocity=(20, 0, 0),
        angular_velocity=(0, 20 / 0.46, 0),
    )  # fmt: skip
    wheels = [
        jo.mechanism.RailContact(
            *(name, jo.ground.at((0, y, 0)), axle.at((0, y, 0)), 0.46, cone),
            play=1e-3, damping=1.0, axle=(0, 1, 0),
        )
        for name, y, cone in (("left", 0.75, -0.05), ("right", -0.75, 0.05))
    ]  # fmt: skip
    flange = jo.mechanism.RailContactSensor("flange", wheels[1], "flange")
    items += [axle, *wheels, jo.PositionSensor("axle", axle["origin"])]
    gravity = jo.Gravity((0, 0, -9.81))
    model = jo.compile(jo.Mechanism(*items, flange, gravity))  # type: ignore[arg-type]
    solver = jo.RK4(step=1e-4)
    found = rows_of(model, solver, tmp_path, "0.2", "10")
    run = jo.simulate(model, 0.2, solver=solver, output_step=0.02)
    want = expected(model, run)
    off = np.abs(found - want)
    count = run["flange"].shape[1]
    assert off[:, :-count].max() < 1e-9
    assert (off[:, -count:] <= 1e-6 * np.abs(want[:, -count:]).max(axis=0)).all()
    assert np.abs(np.diff(want[:, :-count], axis=0)).max() > 0.01
    assert run["flange"][:, 0].max() > 1e3


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
def test_a_program_steers_a_wheelset(tmp_path: Path) -> None:
    """Two conical wheels on rails: joints that share a body, whose table has the name of a type."""
    axle = jo.RigidBody(
        "axle", 1200.0, (700, 100, 700), position=(0, 0, 0.46), velocity=(20, 0.05, 0),
        angular_velocity=(0, 20 / 0.46, 0),
    )  # fmt: skip
    wheels = [
        jo.mechanism.RailWheel(
            *(name, jo.ground.at((0, y, 0)), axle.at((0, y, 0)), 0.46, cone), axle=(0, 1, 0)
        )
        for name, y, cone in (("left", 0.75, -0.05), ("right", -0.75, 0.05))
    ]
    p = jo.PositionSensor("p", axle["origin"])
    items = (axle, *wheels, p, jo.Gravity((0, 0, -9.81)))
    model = jo.compile(jo.Mechanism(*items), core="maximal")
    solver = jo.RK4(step=1e-3)
    write_program(model, tmp_path / "axle.c", solver)
    found = table(compiled(tmp_path, "axle.c", flags=(*PLAIN, "-DMAIN")), "0.2", "10")
    want = expected(model, jo.simulate(model, 0.2, solver=solver, output_step=0.02))
    assert np.abs(found - want).max() < 1e-9
    assert np.ptp(want[:, 2]) > 1e-3


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
def test_a_program_lets_a_beam_fall_on_its_skin(tmp_path: Path) -> None:
    """A modal beam falls on a ball: its nodes touch, slip and bend it."""
    steel = jo.Material(E=210e9, nu=0.3, rho=7850)
    reduced = jo.reduce(jo.Part.beam(1.0, jo.Rectangle(0.03, 0.01), 6, steel), jo.FreeFree(modes=3))
    beam = jo.FlexibleBody("beam", reduced, position=(0, 0, 0.012))
    ball, law = jo.mechanism.Sphere(1.0), PowerLaw(1e7, 1.0)
    touch = jo.mechanism.SkinContact(
        *("touch", jo.ground.at((0.45, 0, -1)), ball, beam, law), radius=0.005, mu_kinetic=0.3
    )
    items = (beam, touch, jo.PositionSensor("p", beam["node1"]), jo.Gravity((0, 0, -9.81)))
    model = jo.compile(jo.Mechanism(*items))
    solver = jo.RK4(step=1e-4)
    found = rows_of(model, solver, tmp_path, "0.1", "10")
    run = jo.simulate(model, 0.1, solver=solver, output_step=0.01)
    want = expected(model, run)
    assert len(run.contacts) >= 2
    assert np.abs(found - want).max() < 1e-9
