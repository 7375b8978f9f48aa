"""Exact beams on the command line: forces, stress, hotspots, peaks and films."""

from __future__ import annotations

import csv
from pathlib import Path

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
