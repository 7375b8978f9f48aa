"""The end of `jousto reduce`: the certificate."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from jousto.cli.group import app

PART = """\
type: beam
length: 1 m
section: {type: rectangle, width: 20 mm, height: 30 mm}
elements: 6
material: {E: 210 GPa, nu: 0.3, rho: 7850}
reduce: {type: craig-bampton, interfaces: [start, end], modes: 6}
"""


def jousto(*args: object) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, [str(arg) for arg in args])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result.exit_code, result.stdout, result.stderr


@pytest.fixture
def rod(tmp_path: Path) -> Path:
    path = tmp_path / "rod.yml"
    path.write_text(PART)
    return path


def test_reduce_ends_with_the_certificate(rod: Path) -> None:
    code, out, err = jousto("reduce", rod, "--html", rod.with_suffix(".html"))
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert "certificate of part 'rod': 2 notes, 12 of 14 checks ok" in lines
    assert "  bounding size         1000 x 0 x 0 mm (of the nodes)" in lines
    assert any(line.startswith("  ok    static loads") for line in lines)
    assert lines[-2:] == [
        f"certificate in {rod.with_suffix('.html')}",
        f"reduced part in {rod.with_suffix('.h5')}",
    ]
    assert "Certificate of part" in rod.with_suffix(".html").read_text(encoding="utf-8")


def test_the_certificate_uses_the_solver_asked_for(rod: Path) -> None:
    assert jousto("reduce", rod, "--solver", "superlu", "-q")[0] == 0
    code, _, err = jousto("reduce", rod, "--solver", "mumps")
    assert code == 2 and "no solver 'mumps'" in err


def test_without_certificate(rod: Path) -> None:
    code, out, _ = jousto("reduce", rod, "--no-certificate")
    assert code == 0 and "certificate of" not in out


def test_a_part_reduced_before_has_none(rod: Path) -> None:
    assert jousto("reduce", rod)[0] == 0
    again = rod.with_name("again.yml")
    again.write_text("file: rod.h5\n")
    code, out, _ = jousto("reduce", again)
    assert code == 0
    assert "no certificate: the part was reduced before, its mesh is not in the file" in out


def test_a_wrong_page_is_said_before_anything_is_computed(rod: Path) -> None:
    code, out, err = jousto("reduce", rod, "--html", rod.with_suffix(".pdf"))
    assert (code, out) == (2, "")
    assert "must end with .html; print it to PDF in a browser" in err
    code, out, err = jousto("reduce", rod, "--html", rod.with_name("no") / "rod.html")
    assert (code, out) == (2, "") and "there is no folder" in err
    assert not rod.with_suffix(".h5").exists()


# -- advise ---------------------------------------------------------------------------------


def test_advise_proposes_modes(rod: Path) -> None:
    code, out, err = jousto("advise", rod, "--frequency-limit", "0.5 kHz")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert (
        lines[0] == "take CraigBampton(interfaces=('start', 'end'), modes=4, frequency_limit=None)"
    )
    assert lines[1].startswith("The free part has 4 elastic modes up to 500 Hz, from ")
    assert any(line.startswith("  4 <") for line in lines)


def test_advise_for_a_load(rod: Path) -> None:
    code, out, _ = jousto("advise", rod, "--load", "node4.fz", "--accuracy", "0.05")
    assert code == 0 and "node4.fz: stress" in out


def test_advise_takes_the_limit_of_the_file(rod: Path) -> None:
    rod.write_text(PART.replace("modes: 6", "frequency_limit: 500"))
    assert "up to 500 Hz" in jousto("advise", rod)[1]


def test_advise_says_what_is_wrong(rod: Path) -> None:
    assert jousto("advise", rod)[::2] == (
        2, "advise: give frequency_limit=Hz or loads=patterns (or both)\n",
    )  # fmt: skip
    assert "did you mean 'end'?" in jousto("advise", rod, "--load", "edn.fx")[2]
    assert "must be a node set and one of fx, fy" in jousto("advise", rod, "--load", "end")[2]
    assert jousto("advise", rod, "--frequency-limit", "5 kg")[0] == 2
    wrong = jousto("advise", rod, "--frequency-limit", "500", "--solver", "mumps")
    assert wrong[0] == 2 and "no solver 'mumps'" in wrong[2]
    assert jousto("reduce", rod)[0] == 0
    again = rod.with_name("again.yml")
    again.write_text("file: rod.h5\n")
    assert "was reduced before: advice needs the part" in jousto("advise", again)[2]


def test_strict_ends_with_1_if_the_certificate_fails(rod: Path) -> None:
    assert jousto("reduce", rod, "--strict")[0] == 0
    rod.write_text(PART.replace("7850", "7850e-12"))
    assert jousto("reduce", rod)[0] == 0
    assert jousto("reduce", rod, "--strict")[0] == 1


def test_a_part_or_its_modes_given_to_other_commands(rod: Path) -> None:
    for verb in ("run", "check"):
        code, _, err = jousto(verb, rod)
        assert (code, "is a part, not a model: jousto reduce rod.yml" in err) == (2, True)
    assert jousto("reduce", rod)[0] == 0
    code, _, err = jousto("mesh", rod.with_suffix(".h5"))
    assert (code, "rod.h5: is a reduced part of jousto, not a mesh" in err) == (2, True)


def test_advise_goes_on_after_the_load_of_an_interface(tmp_path: Path) -> None:
    import jousto as jo
    from schema.plates import plate
    from schema.test_solids import PLATE

    jo.write(plate(), tmp_path / "plate.vtu")
    path = tmp_path / "arm.yml"
    path.write_text(PLATE)
    code, out, err = jousto("advise", path, "--load", "bore.fz", "--frequency-limit", "500")
    assert (code, err) == (0, "")
    assert "--load bore.fz: 'bore' is an interface, its static loads are exact anyway" in out


def test_advise_prints_residuals_as_a_model_file_says_them(rod: Path) -> None:
    rod.write_text(PART.replace("elements: 6", "elements: 24"))
    code, out, _ = jousto("advise", rod, "--load", "node5.fz", "--accuracy", "1e-5")
    assert code == 0
    assert "residuals: [{force: [0, 0, 1], nodes: node5}])" in out.splitlines()[0]
    assert "1 residual vector instead makes" in out
