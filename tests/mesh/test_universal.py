"""Universal files: written by Gmsh, compared with what it writes as .msh, and by hand."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from gmsh_session import opened
from jousto.base.errors import InputError


@pytest.fixture
def gmsh() -> Iterator[Any]:
    module = pytest.importorskip("gmsh")
    with opened(module):
        yield module


def model(gmsh: Any, shape: str, order: int) -> None:
    """A round body of tetrahedra, wedges or bricks with the groups 'all' and 'end'."""
    occ = gmsh.model.occ
    disk = occ.addDisk(0, 0, 0, 1, 1)
    layers = [] if shape == "tetra" else [2]
    body = occ.extrude([(2, disk)], 0, 0, 2, layers, recombine=True)[1][1]
    occ.synchronize()
    if shape == "hexahedron":
        gmsh.model.mesh.setRecombine(2, disk)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.8)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
    gmsh.option.setNumber("Mesh.SaveGroupsOfNodes", 1)
    gmsh.model.addPhysicalGroup(3, [body], 1, "all")
    gmsh.model.addPhysicalGroup(2, [disk], 2, "end")
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(order)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("shape", ["tetra", "wedge", "hexahedron"])
def test_gmsh_writes_we_read(gmsh: Any, shape: str, order: int, tmp_path: Path) -> None:
    model(gmsh, shape, order)
    for suffix in ("unv", "msh"):
        gmsh.write(str(tmp_path / f"body.{suffix}"))
    ours, theirs = jo.read_mesh(tmp_path / "body.unv"), jo.read_mesh(tmp_path / "body.msh")
    # .msh has 16 digits
    place = dict(zip(theirs.node_ids, theirs.nodes, strict=True))
    wanted = np.array([place[number] for number in ours.node_ids])
    np.testing.assert_allclose(ours.nodes, wanted, rtol=1e-15, atol=1e-15)
    a, b = ours.solids[0], theirs.solids[0]
    assert a.kind == b.kind
    np.testing.assert_array_equal(ours.node_ids[a.nodes], theirs.node_ids[b.nodes])
    assert ours.volume == pytest.approx(theirs.volume, rel=1e-14)
    end = set(ours.node_ids[ours.set("end")])
    assert end == set(theirs.node_ids[theirs.set("end")])
    assert len(ours.element_sets["all"]) == len(a)
    assert ours.check() == ()


HEAD = """    -1
   164
         5mm (milli newton)           2
    1.0000000000000000D+03    1.0000000000000000D+03    1.0000000000000000D+00
    2.7314999999999998D+02
    -1
"""
SYSTEM = """    -1
  2420
         1
Part1
         7         0         8
CS7
    1.0000000000000000D+00    0.0000000000000000D+00    0.0000000000000000D+00
    0.0000000000000000D+00    1.0000000000000000D+00    0.0000000000000000D+00
    0.0000000000000000D+00    0.0000000000000000D+00    1.0000000000000000D+00
    0.0000000000000000D+00    0.0000000000000000D+00    0.0000000000000000D+00
    -1
"""
BODY = """    -1
  2411
         1         7         1        11
    0.0000000000000000D+00    0.0000000000000000D+00    0.0000000000000000D+00
         2         7         1        11
    1.0000000000000000D+00    0.0000000000000000D+00    0.0000000000000000D+00
         3         7         1        11
    0.0000000000000000D+00    1.0000000000000000D+00    0.0000000000000000D+00
         4         7         1        11
    0.0000000000000000D+00    0.0000000000000000D+00    1.0000000000000000D+00
    -1
    -1
  2412
         8        21         2         9         7         2
         0         1         1
         1         2
         9       111         3         4         7         4
         1         3         2         4
        10       136         3         4         7         2
         1         3
        11       117         3         4         7         4
         1         3         2         4
    -1
    -1
  2467
         5         0         0         0         0         0         0         2
FOOT
         7         1         0         0         7         2         0         0
    -1
"""


def read(tmp_path: Path, text: str, unit: str = "m") -> jo.Mesh:
    path = tmp_path / "part.unv"
    path.write_text(text)
    return jo.read_mesh(path, unit=unit)


@pytest.mark.filterwarnings("ignore:.*elements not read")
def test_sets_units_and_beams(tmp_path: Path) -> None:
    mesh = read(tmp_path, HEAD + SYSTEM + BODY, "mm")
    # listed the other way round, as Salome does
    assert mesh.volume == pytest.approx(1e-9 / 6, rel=1e-12)
    assert mesh.solids[0].material == "mat4"
    assert mesh.node_ids[mesh.set("FOOT")].tolist() == [1, 2]
    assert mesh.element_ids[mesh.element_sets["pid3"]].tolist() == [9]
    with pytest.warns(
        jo.JoustoWarning, match=r"unit of length 0.001 m, but is read in m; give unit='mm'"
    ):
        read(tmp_path, HEAD + BODY)


def test_elements_that_are_not_read_are_told(tmp_path: Path) -> None:
    with pytest.warns(jo.JoustoWarning, match="elements not read: 1 of type 117"):
        read(tmp_path, BODY)


@pytest.mark.parametrize(
    ("found", "instead", "sentence"),
    [
        (
            "         7         0         8",
            "         7         1         8",
            "system 7, which is not",
        ),
        ("    1.0000000000000000E+00\n    -1\n    -1", "x\n    -1\n    -1", "three numbers"),
        (
            "         1         3         2         4\n",
            "         1         3         2\n",
            "9 of type 111 has 4 nodes, 9 are",
        ),
        (
            "         3         4         7         4",
            "         3         4         7         3",
            "has 3 nodes, 4 are listed; must be 4",
        ),
        ("    -1\n  2467", "", "is not closed: the file is truncated"),
        ("  2411", "  2414", "has no nodes"),
    ],
)
@pytest.mark.filterwarnings("ignore:.*elements not read")
def test_wrong_files_are_told(tmp_path: Path, found: str, instead: str, sentence: str) -> None:
    text = (SYSTEM + BODY).replace("D+00", "E+00")
    assert found in text
    with pytest.raises(InputError, match=sentence):
        read(tmp_path, text.replace(found, instead))
