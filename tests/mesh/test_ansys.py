"""Ansys archives: those that mapdl-archive brings as examples, and collapsed bricks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.mesh.readers.cdb import _brick

from .blocks import block


@pytest.fixture
def samples() -> Path:
    """The folder of the archives that come with mapdl-archive (MIT), written by Ansys."""
    package = pytest.importorskip("mapdl_archive")
    return Path(package.__file__).parent / "examples"


def test_bricks_of_ansys(samples: Path) -> None:
    mesh = jo.read_mesh(samples / "HexBeam.cdb")
    # 40 bricks of 20 nodes, a beam of 1 x 1 x 5
    assert mesh.volume == pytest.approx(5.0, rel=1e-12)
    assert [(cells.kind, len(cells), cells.material) for cells in mesh.cells] == [
        ("hexahedron20", 40, "mat1")
    ]
    assert mesh.check() == ()
    np.testing.assert_allclose(mesh.quality().scaled_jacobian, 1.0, rtol=1e-9)
    assert len(mesh.set("NCOMP2")) == 98


def test_tetrahedra_and_wedges_of_ansys(samples: Path) -> None:
    mesh = jo.read_mesh(samples / "TetBeam.cdb")
    assert mesh.volume == pytest.approx(10.0, rel=1e-9)
    sector = jo.read_mesh(samples / "sector.cdb")
    kinds = {cells.kind: len(cells) for cells in sector.cells}
    assert kinds == {"hexahedron": 101, "wedge": 4}
    # VTK's volume of the grid that mapdl-archive makes of it
    assert sector.volume == pytest.approx(0.06855882966412952, rel=1e-9)
    assert {finding.kind for finding in sector.check()} == {"unused nodes"}
    assert sector.solid().check() == ()


@pytest.mark.parametrize("part", [0.1, 0.5, 0.9])
def test_cut_off_archives_are_told(samples: Path, tmp_path: Path, part: float) -> None:
    data = (samples / "HexBeam.cdb").read_bytes()
    # from the beginning into the nodes, the end of the nodes, into the elements
    nodes, elements = data.find(b"NBLOCK"), data.find(b"EBLOCK")
    end = data.find(b"\n      -1", elements)
    for cut in (nodes + part * (elements - nodes) * 0.9, elements + part * (end - elements)):
        path = tmp_path / "cut.cdb"
        path.write_bytes(data[: int(cut)])
        with pytest.raises(InputError, match="truncated"):
            jo.read_mesh(path)


@pytest.mark.parametrize("quadratic", [False, True])
@pytest.mark.parametrize("shape", ["tetra", "wedge", "hexahedron"])
def test_collapsed_bricks(shape: str, quadratic: bool) -> None:
    kind = {"tetra": "tetra10", "wedge": "wedge15", "hexahedron": "hexahedron20"}[shape]
    kind = kind if quadratic else shape
    n = block(kind, (1, 1, 1), (1.0, 1.0, 1.0)).solids[0].nodes[0] + 1
    # I J K L M N O P, then the midside nodes of the edges, of bricks as the manual draws them
    brick = {
        "tetra": [0, 1, 2, 2, 3, 3, 3, 3, 4, 5, 2, 6, 3, 3, 3, 3, 7, 8, 9, 9],
        "wedge": [0, 1, 2, 2, 3, 4, 5, 5, 6, 7, 2, 8, 9, 10, 5, 11, 12, 13, 14, 14],
        "hexahedron": list(range(20)),
    }[shape]
    nodes = n[np.array(brick if quadratic else brick[:8])]
    found, back = _brick(nodes, 20 if quadratic else 8)
    assert found == kind
    np.testing.assert_array_equal(back, n)


def test_archives_need_a_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "mapdl_archive", None)
    path = tmp_path / "part.cdb"
    path.write_text("/PREP7\nNBLOCK,6,SOLID\n")
    with pytest.raises(InputError, match=r"pip install mapdl-archive"):
        jo.read_mesh(path)


BRICK = """/PREP7
ET,1,185
NBLOCK,3
(1i9,3e20.9e3)
        1
        2    1.000000000E+000
        3    1.000000000E+000    1.000000000E+000
        4    0.000000000E+000    1.000000000E+000    0.000000000E+000
        5    0.000000000E+000    0.000000000E+000    1.000000000E+000
        6    1.000000000E+000    0.000000000E+000    1.000000000E+000
        7    1.000000000E+000    1.000000000E+000    1.000000000E+000
        8    0.000000000E+000    1.000000000E+000    1.000000000E+000
N,R5.3,LOC,       -1,
EBLOCK,19,SOLID,         1,         1
(19i9)
        1        1        1        1        0        0        0        0        8        0        1\
        1        2        3        4        5        6        7        8
       -1
FINISH
"""


@pytest.mark.usefixtures("samples")
@pytest.mark.parametrize("end", ["N,R5.3,LOC,       -1,", "-1", "N,UNBL,LOC,  -1,"])
def test_nodes_without_solid_model_entities(end: str, tmp_path: Path) -> None:
    # lines end with the last coordinate that is not 0: "1" is the node at the origin
    path = tmp_path / "brick.cdb"
    path.write_text(BRICK.replace("N,R5.3,LOC,       -1,", end).replace("NBLOCK", "nblock"))
    mesh = jo.read_mesh(path)
    cube = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    np.testing.assert_array_equal(mesh.nodes, cube)
    assert mesh.volume == pytest.approx(1.0, rel=1e-14)


@pytest.mark.usefixtures("samples")
@pytest.mark.parametrize(
    ("found", "instead", "sentence"),
    [
        ("(1i9,3e20.9e3)", "(3i9,6e2", r"brick.cdb:4: the format of NBLOCK is '\(3i9,6e2'"),
        (
            "        4    0.000000000E+000    1.0",
            "        4    0.000000000E+000    one",
            "cdb:8: 'one",
        ),
        ("        3    1", "      3.5    1", "brick.cdb:7: '3.5' is not a whole number"),
    ],
)
def test_wrong_nodes_are_told(found: str, instead: str, sentence: str, tmp_path: Path) -> None:
    path = tmp_path / "brick.cdb"
    path.write_text(BRICK.replace(found, instead))
    with pytest.raises(InputError, match=sentence):
        jo.read_mesh(path)
