"""The commands multiaxial, strain-life and hertz."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

import jousto as jo
from jousto.cli.group import app


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cantilever pushed up and down at its tip."""
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.02), 4, jo.Material(E=210e9, nu=0.3, rho=7850.0))
    body = jo.FlexibleBody(
        "beam", jo.reduce(part, jo.CraigBampton(("start",), modes=6)), damping=0.05
    )
    push = jo.Harmonic(frequency=2.0)
    mechanism = jo.Mechanism(
        body,
        jo.Fixed("clamp", jo.ground["origin"], body["start"]),
        jo.Force("push", body["end"], (0.0, 400.0, 0.0), signal=push),
    )
    path = tmp_path_factory.mktemp("cli") / "beam.h5"
    jo.simulate(jo.compile(mechanism), 1.0, solver=jo.ROS2(1e-3), output_step=0.01, path=path)
    return path


def run(*words: str) -> tuple[int, str]:
    found = CliRunner().invoke(app, list(words), prog_name="jousto")
    return found.exit_code, found.output


def test_multiaxial(result: Path) -> None:
    code, text = run("multiaxial", str(result), "--count", "2")
    assert code == 0 and "Findley(k=0.3)" in text and text.count("e1.a") == 2
    code, text = run("multiaxial", str(result), "beam", "--criterion", "dang-van 0.36 155 MPa")
    assert code == 0 and "least safety" in text
    code, text = run(
        *(
            "multiaxial",
            str(result),
            "--sn",
            "S355",
            "--residue",
            "repeat",
            "--site",
            "e1.a.top_left",
        )
    )
    assert code == 0 and "residue 'repeat'" in text and "e1.a.top_left" in text


def test_tables_and_pictures(result: Path, tmp_path: Path) -> None:
    table, picture = tmp_path / "a.csv", tmp_path / "a.png"
    code, text = run("multiaxial", str(result), "--csv", str(table))
    assert code == 0 and len(table.read_text().splitlines()) == 6 and "table in" in text
    code, text = run(
        *("strain-life", str(result), "--material", "man-ten", "--residue", "half"),
        *("--csv", str(table), "-o", str(picture)),
    )
    assert code == 0 and "loops of e1.a" in text
    assert "residue: half" in table.read_text() and picture.stat().st_size > 5000


def test_strain_life(result: Path) -> None:
    code, text = run(
        *("strain-life", str(result), "--material", "sae-1045", "--residue", "half", "--count", "1")
    )
    assert code == 0 and "sae-1045 from signed-von-mises: neuber, swt, residue 'half'" in text


def test_hertz() -> None:
    # Johnson 1985: 349.9 MPa, 0.6065 mm for E = 210 GPa
    code, text = run("hertz", "--force", "10 kN", "--radius", "100 mm", "--length", "30 mm")
    assert code == 0 and "p0 = 349.9 MPa, a = 0.6065 mm" in text and "87.47 MPa" in text
    code, text = run("hertz", "--force", "10 kN", "--radius", "100 mm", "--crown", "300 mm")
    assert code == 0 and "point contact" in text
    # friction: mu p0 at the surface is more than what stands below it
    words = ("hertz", "--force", "10 kN", "--radius", "100 mm", "--length", "30 mm")
    code, text = run(*words, "--friction", "0.4")
    assert code == 0 and "on the axis, without friction 105.1 MPa" in text
    assert "at the surface 140 MPa" in text


def test_mistakes(result: Path) -> None:
    for words, told in (
        (("multiaxial", str(result), "--criterion", "findly 0.3"), "did you mean 'findley'"),
        (("multiaxial", str(result), "--criterion", "findley"), "must be such as"),
        (("multiaxial", str(result), "--criterion", "findley x"), "not a number"),
        (("multiaxial", str(result), "--sn", "S355"), "--residue: is missing"),
        (("multiaxial", str(result), "beem"), "did you mean 'beam'"),
        (("multiaxial", str(result), "--count", "0"), "--count"),
        (("strain-life", str(result), "--residue", "half"), "--material: is missing"),
        (("hertz", "--force", "1 kN", "--radius", "1 m"), "--length of a line"),
    ):
        code, text = run(*words)
        assert code == 2 and told in text.replace("\n", " "), text
