"""Meshes of CAD files are the same the next time, so that their reductions are found again."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from gmsh_session import opened
from jousto.base import errors
from jousto.base.errors import JoustoWarning
from jousto.reduction.files import cache
from jousto.schema.read import read_part_file

gmsh = pytest.importorskip("gmsh")
PART = """\
type: solid
mesh: {cad: CAD, size: SIZE, order: 1}
material: S355
reduce: {type: free-free, modes: 2}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cad: Path) -> Path:
    shutil.copy(cad, tmp_path / "arm.step")
    monkeypatch.setenv("JOUSTO_CACHE", str(tmp_path / "kept"))
    return tmp_path / "kept"


@pytest.fixture(scope="module")
def cad(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a CAD file of a pin on a block, mm."""
    path = tmp_path_factory.mktemp("cad") / "arm.step"
    with opened(gmsh):
        block = (3, gmsh.model.occ.addBox(0, 0, 0, 100, 40, 20))
        pin = (3, gmsh.model.occ.addCylinder(30, 20, 20, 0, 0, 30, 10))
        gmsh.model.occ.fuse([block], [pin])
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    return path


def part(tmp_path: Path, size: str = "20 mm", **options: object) -> jo.Part:
    path = tmp_path / "arm.yml"
    path.write_text(PART.replace("SIZE", size).replace("CAD", str(tmp_path / "arm.step")))
    return read_part_file(path, reduce=False, **options).part


def no_mesh(*args: object, **values: object) -> None:
    raise AssertionError("meshed once more")


@pytest.mark.filterwarnings("default")
def test_a_cad_file_is_meshed_once(
    tmp_path: Path, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = part(tmp_path, cache=True)
    with monkeypatch.context() as patch:
        patch.setattr("jousto.mesh.readers.step.mesh_cad", no_mesh)
        second = part(tmp_path, cache=True)
        for size, options in (("25 mm", {"cache": True}), ("20 mm", {"cache": False})):
            with pytest.raises(AssertionError, match="once more"):
                part(tmp_path, size, **options)
    assert cache.key(first) == cache.key(second)
    for name in ("node_sets", "element_sets", "surfaces"):
        one, other = getattr(first.mesh, name), getattr(second.mesh, name)
        assert list(one) == list(other)
        for key in one:
            np.testing.assert_array_equal(one[key], other[key])
    # a damaged file is no mesh
    (file,) = folder.glob("*/mesh.npz")
    file.write_bytes(file.read_bytes()[:1000])
    assert part(tmp_path, cache=True).nodes.shape[1] == 3


@pytest.mark.filterwarnings("default")
def test_small_meshes_are_not_kept_unless_asked_for(
    tmp_path: Path, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cache, "AUTOMATIC", 1e9)
    part(tmp_path)
    assert not folder.exists()
    monkeypatch.setattr(cache, "AUTOMATIC", 1)
    part(tmp_path)
    assert len(list(folder.glob("mesh-*"))) == 1


def test_warnings_of_the_mesh_are_told_again(
    tmp_path: Path, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    mesh = jo.Mesh("arm", corners, jo.mesh.Cells("tetra", [(0, 1, 2, 3)]))

    def bad(*args: object, **values: object) -> jo.Mesh:
        errors.warn("arm.step", "two elements would be folded")
        return mesh

    monkeypatch.setattr("jousto.mesh.readers.step.mesh_cad", bad)
    told = []
    for _ in range(2):
        with pytest.warns(JoustoWarning) as caught:
            part(tmp_path, cache=True)
        told.append([str(item.message) for item in caught])
        monkeypatch.setattr("jousto.mesh.readers.step.mesh_cad", no_mesh)
    assert any("two elements would be folded" in text for text in told[0])
    assert told[0] == told[1]
