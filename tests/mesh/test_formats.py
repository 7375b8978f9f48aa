"""Endings of meshes and CAD files: the same ones in every command and message."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

import jousto as jo
from jousto.base.errors import InputError
from jousto.cli.group import app
from jousto.mesh.formats import CAD, FORMATS, MESHES, is_cad, is_mesh
from jousto.schema.file.document import read_document
from jousto.viewer.viewable import read

DECK = """BEGIN BULK
GRID,1
GRID,2,,1.
GRID,3,,,1.
GRID,4,,,,1.
CTETRA,1,1,1,2,3,4
ENDDATA
"""


@pytest.mark.parametrize("name", ["x.fem", "X.FEM", "x.nas", "x.dat", "deck"])
def test_a_deck_is_one_in_every_command(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(DECK)
    assert jo.read_mesh(path).volume == pytest.approx(1 / 6)
    assert isinstance(read(path), jo.Mesh)
    for command in ("mesh", "info"):
        result = CliRunner().invoke(app, [command, str(path)])
        assert result.exit_code == 0, result.output
        assert "nodes         4, 12 degrees" in result.output


@pytest.mark.parametrize("suffix", [*MESHES, *CAD])
def test_no_model_file(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"part{suffix}"
    path.write_text("no mesh")
    with pytest.raises(InputError, match=r"is a (mesh|CAD file), not a model or part file"):
        read_document(path)


@pytest.mark.parametrize("suffix", MESHES)
def test_no_geometry(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"part{suffix}"
    path.write_text("no mesh")
    with pytest.raises(InputError, match=r"is a mesh, not a geometry"):
        jo.mesh_cad(path, size=1e-2)


def test_each_ending_has_one_format() -> None:
    assert len(set(MESHES)) == len(MESHES) == sum(len(form.suffixes) for form in FORMATS)
    assert all(is_mesh(Path(f"a{suffix}.gz")) for suffix in MESHES)
    assert not any(is_mesh(Path(f"a{suffix}")) or not is_cad(Path(f"a{suffix}")) for suffix in CAD)
