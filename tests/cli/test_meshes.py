"""`jousto mesh`: what is in a mesh, what is wrong with it, and the way to other formats."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import jousto as jo
from jousto.cli.group import app
from schema.plates import plate


def call(*words: str | Path) -> tuple[int, str]:
    """Return exit code and output of a command."""
    result = CliRunner().invoke(app, [str(word) for word in words], prog_name="jousto")
    return result.exit_code, result.output


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return jo.write(plate(), tmp_path / "plate.inp", unit="mm")


def test_says_what_is_in_a_mesh(file: Path) -> None:
    code, text = call("mesh", file, "--unit", "mm")
    assert code == 0
    lines = {line[2:15].strip(): line[2:] for line in text.splitlines() if line.startswith("  ")}
    assert "400 x 100 x 20 mm" in text
    assert "hexahedron20" in text
    # 0.4 x 0.1 x 0.02 m less the hole, of steel
    mass = 7850 * (0.4 * 0.1 * 0.02 - np.pi * 0.025**2 * 0.02)
    found = next(
        word for word, unit in zip(text.split(), text.split()[1:], strict=False) if unit == "kg"
    )
    assert float(found) == pytest.approx(mass, rel=1e-4)
    assert "50 mm, 20 mm long, at (300, 50, 10) mm along z" in text
    assert any(key.startswith("set left") for key in lines)
    assert text.endswith("plate: nothing wrong found\n")


def test_a_wrong_unit_is_seen(file: Path) -> None:
    code, text = call("mesh", file)
    assert code == 0
    assert "400000 x 100000 x 20000 mm" in text.replace("4e+05 x 1e+05", "400000 x 100000")
    assert "warning: " in text


def test_writes_other_formats_and_a_picture(file: Path, tmp_path: Path) -> None:
    picture = tmp_path / "plate.png"
    code, text = call("mesh", file, "--unit", "mm", "-o", tmp_path / "plate.vtu",
                      "--picture", picture, "--mark", "left")  # fmt: skip
    assert code == 0, text
    assert jo.read_mesh(tmp_path / "plate.vtu").volume == pytest.approx(plate().volume)
    assert picture.stat().st_size > 5000


def test_a_damaged_mesh_ends_with_code_2(tmp_path: Path) -> None:
    mesh = plate()
    cells = np.array(mesh.cells[0].nodes)
    cells[3] = cells[3][[4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11, 16, 17, 18, 19]]
    bad = jo.Mesh("bad", mesh.nodes, jo.mesh.Cells("hexahedron20", cells))
    code, text = call("mesh", jo.write(bad, tmp_path / "bad.vtu"))
    assert code == 2
    assert "error: " in text


def test_refuses_clearly(file: Path, tmp_path: Path) -> None:
    code, text = call("mesh", tmp_path / "no.msh")
    assert (code, "no such file" in text) == (2, True)
    code, text = call("mesh", file, "-o", file)
    assert (code, "is the input" in text) == (2, True)
    (tmp_path / "part.step").write_text("ISO-10303-21;\n")
    code, text = call("mesh", tmp_path / "part.step")
    assert code == 2
    assert "part.step: a CAD file needs the length of the elements: --size '8 mm'" in text
    code, text = call("mesh", tmp_path / "part.step", "--size", "8 kg")
    assert (code, "--size: expects a length" in text) == (2, True)
    code, text = call("mesh", tmp_path / "part.step", "--size", "8 mm", "--refine", "face3")
    assert (code, "--refine: is 'face3'" in text) == (2, True)


def test_says_where_sets_are(file: Path) -> None:
    _, text = call("mesh", file, "--unit", "mm")
    (line,) = (line for line in text.splitlines() if line.startswith("  set left"))
    assert "at (0, 50, 10) mm, 0 x 100 x 20 mm" in line


def test_surfaces_are_flat_or_cylinders() -> None:
    from dataclasses import replace

    from jousto.schema.summary import set_text

    mesh = plate()
    wall = mesh.holes()[0].nodes
    left = mesh.node_sets["left"]
    mesh = replace(mesh, surfaces={"wall": wall[None, :3], "end": left[None, :3]})
    assert "cylinder of radius 25 mm along z" in set_text(mesh, "wall", wall)
    assert set_text(mesh, "end", left).endswith("flat, normal x")


def test_options_of_cad_files_are_refused_for_meshes(file: Path) -> None:
    code, text = call("mesh", file, "--size", "8 mm")
    assert (code, "--size: is for CAD files" in text) == (2, True)
    assert call("mesh", file, "--refine", "left=1 mm")[0] == 2


def test_files_of_other_kinds_are_named(tmp_path: Path, file: Path) -> None:
    step = tmp_path / "rod.step"
    step.write_text("ISO-10303-21;\n")
    for verb in ("info", "reduce", "check", "run"):
        code, text = call(verb, step)
        assert (code, "rod.step: is a CAD file" in text) == (2, True)
        assert "jousto mesh rod.step --size" in text and "type: solid" in text
    code, text = call("reduce", file)
    assert (code, "plate.inp: is a mesh" in text) == (2, True)
    hidden = tmp_path / "s.inp"
    hidden.write_text("ISO-10303-21;\n")
    code, text = call("mesh", hidden)
    assert (code, "jousto mesh s.step --size '8 mm'" in text) == (2, True)
    (tmp_path / "x.xyz").write_text("what\n")
    assert ".step .stp .brep" in call("mesh", tmp_path / "x.xyz")[1]


def test_what_is_wrong_goes_to_the_stream_of_errors(tmp_path: Path) -> None:
    path = tmp_path / "flat.inp"
    path.write_text("*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4\n1,1,3,2,4\n")
    result = CliRunner().invoke(app, ["mesh", str(path)])
    assert result.exit_code == 2
    assert "error: the Jacobian of 1 element" in result.stderr
    assert "error" not in result.stdout and "4, 12 degrees of freedom" in result.stdout
