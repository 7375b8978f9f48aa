"""Loads on bodies, and exact beams, on the command line: forces, stress, hotspots, films."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from cli.test_meshes import call
from recovery.beams.cases import cantilever


@pytest.fixture(scope="module")
def bent() -> jo.Solution:
    return cantilever((0.0, 3.0, -10.0), 4)


def test_forces(bent: jo.Solution, tmp_path: Path) -> None:
    code, text = call("forces", bent.path, "-o", tmp_path / "envelope.csv")
    assert code == 0, text
    row = next(line.split() for line in text.splitlines() if line.split()[0] == "My")
    assert float(row[4]) == pytest.approx(10.0, rel=1e-4) and float(row[5]) == 0.0
    code, text = call("forces", bent.path, "beam", "--at", "0 s", "-o", tmp_path / "at.csv")
    assert code == 0, text
    with (tmp_path / "at.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    assert float(rows[1][rows[0].index("My (N m)")]) == pytest.approx(10.0, rel=1e-4)
    for name in ("diagram.png", "skin.vtu"):
        code, text = call("forces", bent.path, "--at", "0 s", "-o", tmp_path / name)
        assert code == 0 and (tmp_path / name).stat().st_size > 1000, text
    code, text = call("forces", bent.path, "bean")
    assert code == 2 and "did you mean 'beam'" in text
    code, text = call("forces", bent.path, "beam", "--frame", "world", "--model", "other.yaml")
    assert code == 2 and "'beam' is an exact beam" in text
    assert "--model: is for loads on a body" in text and "--frame: is for loads" in text
    code, text = call("forces", bent.path, "--at", "0", "--at", "1e-9 s", "-o", tmp_path / "a.csv")
    assert code == 2 and "one instant" in text


def test_forces_tell_a_wrong_format_first(bent: jo.Solution, tmp_path: Path) -> None:
    code, text = call("forces", bent.path, "-o", tmp_path / "a.txt")
    told = " ".join(text.split())
    assert code == 2 and "My" not in told, text
    assert "known: .csv, .vtu, .pvd, .png, .svg, .pdf, .jpg, .jpeg, .webp, .eps" in told


def test_an_instant_is_shown_and_must_be_in_the_run(tmp_path: Path) -> None:
    """A strip let go: at 0 s it bears nothing yet, later its own weight."""
    steel = jo.Material(E=210e9, nu=0.3, rho=7850.0)
    beam = jo.BeamBody("strip", [(0, 0, 0), (1, 0, 0)], jo.Circle(0.02), steel, elements=2)
    base = jo.Fixed("base", jo.ground["origin"], beam["start"])
    model = jo.compile(jo.Mechanism(beam, base, jo.Gravity((0, 0, -9.81))))
    path = tmp_path / "strip.h5"
    jo.simulate(model, 0.02, output_step=1e-3, path=path)
    code, text = call("forces", path)
    rows = {line.split()[0]: line.split() for line in text.splitlines() if line.strip()}
    assert code == 0 and max(abs(float(x)) for x in (rows["My"][1], rows["My"][4])) > 0.1, text
    code, text = call("forces", path, "--at", "0 s")
    rows = {line.split()[0]: line.split() for line in text.splitlines() if line.strip()}
    assert code == 0 and max(abs(float(x)) for x in (rows["My"][1], rows["My"][4])) < 1e-3, text
    code, text = call("forces", path, "--at", "0.3 s")
    assert code == 2 and "0.3" in text and "0.02" in text, text


def test_beams_are_bodies_like_others(bent: jo.Solution, tmp_path: Path) -> None:
    code, text = call("stress", bent.path, "--criterion", "s11", "-o", tmp_path / "a.vtu")
    assert code == 0 and "e1.a.top_right" in text, text
    code, text = call("hotspots", bent.path, "-n", "2", "-o", tmp_path / "spots.png")
    assert code == 0 and "certified" in text, text
    code, text = call("peaks", bent.path)
    assert code == 0 and "von Mises in e1.a." in text, text
    code, text = call("fatigue", bent.path, "--body", "beam", "--sn", "fat71", "--residue", "half")
    assert code == 0 and "beam, 72 places" in text, text
    code, text = call("animate", bent.path, "-o", tmp_path / "film.png", "--stress")
    assert code == 0 and (tmp_path / "film.png").stat().st_size > 2000, text


PENDULUM = """
bodies: [{name: bob, mass: 2 kg, inertia: [0.01, 0.01, 0.01], center: [1, 0, 0]}]
joints: [{type: revolute, name: pin, a: ground.origin, b: bob.origin, axis: [0, 1, 0]}]
gravity: [0, 0, -9.81]
simulation: {t_end: 0.1 s, output_step: 10 ms}
"""


@pytest.fixture
def pendulum(tmp_path: Path) -> Path:
    path = tmp_path / "pendulum.yaml"
    path.write_text(PENDULUM, encoding="utf-8")
    return path


def test_loads_on_a_body_of_a_model_or_of_results(pendulum: Path, tmp_path: Path) -> None:
    """At first the pin bears what the centre does not take: m g J / (J + m l^2)."""
    code, text = call("forces", pendulum, "--at", "0 s", "--frame", "world")
    assert code == 0 and "balance" in text, text
    row = next(line.split() for line in text.splitlines() if line.split()[:1] == ["pin"])
    assert row[1:3] == ["joint", "bob.origin"]
    assert float(row[5]) == pytest.approx(2 * 9.81 * 0.01 / 2.01, rel=1e-5)
    assert call("run", "-q", pendulum, "-o", tmp_path / "run.h5")[0] == 0
    code, text = call("forces", tmp_path / "run.h5", "bob", "-o", tmp_path / "loads.csv")
    assert code == 0 and "gyroscopic" in text, text
    with (tmp_path / "loads.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    assert len(rows) == 1 + 11 * 4 and rows[1][1] == "pin"


def test_wrong_requests_for_loads(pendulum: Path, tmp_path: Path) -> None:
    code, text = call("forces", pendulum, "bop")
    assert code == 2 and "did you mean 'bob'" in text
    code, text = call("forces", pendulum, "--frame", "ground", "--at", "0", "--from", "0")
    assert code == 2 and "'body' or 'world'" in text and "either instants or a span" in text
    code, text = call("forces", pendulum, "--model", pendulum)
    assert code == 2 and "leave --model out" in text
    for more in ([], ["-o", tmp_path / "loads.csv"]):
        code, text = call("forces", pendulum, "--program", "abaqus", *more)
        assert code == 2 and "name the deck, -o FILE.inp" in " ".join(text.split())
    code, text = call("forces", pendulum, "-o", tmp_path / "loads.png")
    assert code == 2 and ".csv" in text
    ball = jo.RigidBody("ball", 1.0, (1, 1, 1))
    pin = jo.Spherical("pin", jo.ground["origin"], ball["origin"])
    model = jo.compile(jo.Mechanism(ball, pin, jo.Gravity((0, 0, -9.81))))
    jo.simulate(model, 0.01, path=tmp_path / "python.h5")
    code, text = call("forces", tmp_path / "python.h5")
    assert code == 2 and "was made in Python" in " ".join(text.split())
    code, text = call("forces", tmp_path / "python.h5", "--model", pendulum)
    assert code == 2 and "is not that of" in " ".join(text.split())


def test_a_rigid_body_has_no_part_for_a_deck(pendulum: Path, tmp_path: Path) -> None:
    deck = tmp_path / "bob.inp"
    code, text = call("forces", pendulum, "-o", deck)
    assert code == 2 and "name the instants of the load steps" in " ".join(text.split())
    code, text = call("forces", pendulum, "--at", "0.05 s", "-o", deck)
    assert code == 2 and "is rigid and has no part" in " ".join(text.split())
    assert not deck.exists()


def test_a_deck_of_the_part_of_a_model_file(tmp_path: Path) -> None:
    """The part is read again from the model file if the results do not contain it."""
    x, y, z = np.meshgrid(np.linspace(0, 0.4, 5), (0, 0.03), (0, 0.03), indexing="ij")
    nodes = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    ring = np.array([0, 4, 6, 2, 1, 5, 7, 3])
    bricks = jo.mesh.Cells("hexahedron", [4 * i + ring for i in range(4)])
    mesh = jo.Mesh("bar", nodes, bricks, node_sets={"root": np.arange(4)})
    jo.write(mesh, tmp_path / "bar.inp")
    model = tmp_path / "bar.yaml"
    model.write_text(
        """
parts:
  bar:
    type: solid
    mesh: bar.inp
    material: S355
    interfaces: [{name: end, nodes: root}]
    reduce: {type: craig-bampton, interfaces: [end], modes: 3}
bodies: [{name: arm, part: bar, position: [0, -15 mm, -15 mm]}]
joints: [{type: fixed, name: wall, a: ground.origin, b: arm.end}]
gravity: [0, 0, -9.81]
simulation: {t_end: 1 ms, output_step: 0.5 ms}
""",
        encoding="utf-8",
    )
    code, text = call("forces", model, "--at", "1 ms", "-o", tmp_path / "deck.inp")
    assert code == 0 and "written to" in text, text
    deck = (tmp_path / "deck.inp").read_text(encoding="utf-8")
    assert deck.count("*STEP") == 1 and "*RIGID BODY" in deck
    code, text = call(
        "forces", model, "--at", "1 ms", "--program", "ansys", "-o", tmp_path / "a.inp"
    )
    assert code == 2 and "'ansys'" in text


def test_another_model_than_that_of_the_results(pendulum: Path, tmp_path: Path) -> None:
    """Results contain the text of their model; another one is told, or refused if it differs."""
    run = tmp_path / "run.h5"
    assert call("run", "-q", pendulum, "-o", run)[0] == 0
    text = pendulum.read_text(encoding="utf-8")
    code, told = call("forces", run, "bob", "--model", pendulum)
    assert code == 0 and "is not the text" not in " ".join(told.split())
    remark = tmp_path / "remark.yaml"
    remark.write_text(text + "\n# a remark\n", encoding="utf-8")
    code, told = call("forces", run, "bob", "--model", remark)
    assert code == 0 and "is not the text of the model in run.h5" in " ".join(told.split()), told
    moon = tmp_path / "moon.yaml"
    moon.write_text(text.replace("-9.81", "-1.62"), encoding="utf-8")
    assert moon.read_text(encoding="utf-8") != text
    code, told = call("forces", run, "bob", "--model", moon)
    assert code == 2 and "its gravity is" in " ".join(told.split()), told
