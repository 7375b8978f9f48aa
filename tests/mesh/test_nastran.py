"""Nastran bulk data files: written by Gmsh and meshio, held against pyyeti, and by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.mesh.cells import SOLIDS
from jousto.mesh.readers.meshio_formats import load_meshio

from .blocks import block

# the bubble functions of both are not read, see test_element_types.py
pytestmark = pytest.mark.filterwarnings("ignore:.* (CHEXA|CPENTA) read as (hexahedron|wedge)")

meshio = load_meshio()


@pytest.mark.parametrize("kind", SOLIDS)
@pytest.mark.parametrize("form", ["free", "fixed-small", "fixed-large"])
def test_meshio_writes_we_read(kind: str, form: str, tmp_path: Path) -> None:
    mesh = block(kind, (2, 1, 1), (2.0, 1.0, 1.0))
    path = tmp_path / "block.bdf"
    meshio.nastran.write(
        path,
        meshio.Mesh(mesh.nodes, [(kind, mesh.solids[0].nodes)]),
        point_format=form,
        cell_format="fixed-small",
    )
    back = jo.read_mesh(path)
    np.testing.assert_allclose(back.nodes, mesh.nodes, atol=1e-12)
    np.testing.assert_array_equal(back.solids[0].nodes, mesh.solids[0].nodes)


def test_long_fields_and_upright_edges(tmp_path: Path) -> None:
    # a wedge with midside nodes, the upright edges before the top, in fields of 16 columns
    mesh = block("wedge15", (1, 1, 1), (1.0, 1.0, 1.0))
    lines = ["BEGIN BULK"]
    for number, x in enumerate(mesh.nodes, start=1):
        lines.append(f"GRID*   {number:<16d}{'':16s}{x[0]:<16.9f}{x[1]:<16.9f}*")
        lines.append(f"*       {x[2]:<16.9f}")
    for number, nodes in enumerate(mesh.solids[0].nodes + 1, start=1):
        theirs = [*nodes[:9], *nodes[12:], *nodes[9:12]]
        words = [f"{number}", "7", *(str(n) for n in theirs)]
        for i in range(0, len(words), 4):
            head = "CPENTA*" if i == 0 else "*"
            lines.append(f"{head:<8s}" + "".join(f"{word:<16s}" for word in words[i : i + 4]))
    lines.append("ENDDATA")
    path = tmp_path / "wedge.nas"
    path.write_text("\n".join(lines) + "\n")
    back = jo.read_mesh(path)
    np.testing.assert_array_equal(back.solids[0].nodes, mesh.solids[0].nodes)
    assert back.volume == pytest.approx(1.0)


SYSTEMS = """$ coordinate systems in a row: cylindrical on rectangular, spherical on cylindrical
CORD2R  1       0       1.      2.      3.      1.      2.      4.
        2.      3.      3.
CORD2C, 2, 1, .5, 0., 0., .5, 1., 0.
, 1.5, 0., .2
CORD2S  3       2       2.      30.     1.      2.      30.     3.
        4.      70.     1.
CORD1R  4       21      22      23
GRID    11              1.      0.      0.
GRID    12      1       1.5     -.25    +2.5-1
GRID    13      2       2.      135.    -1.
GRID    14      3       1.5     40.     250.
GRID    21      2       1.      10.     0.
GRID    22      1       3.      1.      7.
GRID    23              0.      0.      5.D0
GRID    15      4       .1      .2      .3
"""


def test_coordinate_systems_are_those_of_pyyeti(tmp_path: Path) -> None:
    with np.printoptions():  # pyyeti turns numpy's way of printing back to that of 2017
        bulk = pytest.importorskip("pyyeti.nastran.bulk")
    path = tmp_path / "systems.bdf"
    # pyyeti reads no free fields with continuation and no CORD1R: written out here
    path.write_text(
        "BEGIN BULK\n"
        + SYSTEMS.replace(
            "CORD2C, 2, 1, .5, 0., 0., .5, 1., 0.\n, 1.5, 0., .2\n",
            f"{'CORD2C':8s}{2:<8d}{1:<8d}"
            + "".join(f"{x:<8s}" for x in "0.5 0. 0. 0.5 1. 0.".split())
            + f"\n{'':8s}{'1.5':8s}{'0.':8s}{'0.2':8s}\n",
        ).replace("5.D0", "5.0")
        + "CTETRA  1       1       11      12      13      14\nENDDATA\n"
    )
    mesh = jo.read_mesh(path)
    without = tmp_path / "plain.bdf"
    kept = [
        line
        for line in path.read_text().splitlines()
        if "CORD1R" not in line and "GRID    15" not in line
    ]
    without.write_text("\n".join(kept) + "\n")
    uset, *_ = bulk.bulk2uset(str(without))
    for number in (11, 12, 13, 14, 21, 22, 23):
        theirs = np.asarray(uset.loc[(number, 1), "x":"z"], dtype=float)
        ours = mesh.nodes[np.flatnonzero(mesh.node_ids == number)[0]]
        np.testing.assert_allclose(ours, theirs, atol=1e-12)
    # CORD1R: z from grid 21 to 22, 23 in the plane of x and z
    a, b, c = (mesh.nodes[np.flatnonzero(mesh.node_ids == n)[0]] for n in (21, 22, 23))
    z = (b - a) / np.linalg.norm(b - a)
    y = np.cross(z, c - a)
    y /= np.linalg.norm(y)
    expected = a + 0.1 * np.cross(y, z) + 0.2 * y + 0.3 * z
    np.testing.assert_allclose(mesh.nodes[mesh.node_ids == 15][0], expected, atol=1e-12)


DECK = """SOL 103
CEND
BEGIN BULK
$ two tetrahedra and what hangs on them
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,0.,1.,0.
GRID,4,,0.,0.,1.
GRID,5,,1.,1.,1.
GRID,9,,.5,.5,.5
CTETRA  10      3       1       2       3       4
CTETRA  11      3       2       5       3       4
CTRIA3  20      4       1       2       3
CBAR    21      5       1       2       0.      0.      1.
RBE2    30      9       123456  1       2       3
RBE3    31              9       123456  1.      123     1       2
        4       1.      123     5
SET1    6       1       THRU    4
CONM2   40      9               12.5
PSOLID  3       8
MAT1    8       2.1+11          .3      7850.
ENDDATA
"""


def test_deck(tmp_path: Path) -> None:
    path = tmp_path / "deck.bdf"
    path.write_text(DECK)
    with pytest.warns(
        jo.JoustoWarning, match=r"1 CONM2 not read; give point masses to Part\.solid"
    ):
        mesh = jo.read_mesh(path)
    assert mesh.element_ids.tolist() == [10, 11]
    assert mesh.solids[0].material == "mat8"
    assert mesh.volume == pytest.approx(1 / 6 + 1 / 3)
    assert mesh.element_sets["pid3"].tolist() == [0, 1]

    def ids(name: str) -> list[int]:
        return mesh.node_ids[mesh.set(name)].tolist()

    assert ids("rbe2_30") == [1, 2, 3]
    assert ids("rbe3_31") == [1, 2, 4, 5]
    assert ids("set6") == [1, 2, 3, 4]
    assert ids("pid4") == [1, 2, 3]
    (finding,) = mesh.check()
    assert finding.kind == "unused nodes"
    assert finding.ids == (9,)


@pytest.mark.filterwarnings("ignore:.*CONM2")
@pytest.mark.parametrize(
    ("found", "instead", "sentence"),
    [
        ("GRID,2,,1.", "GRID,2,,one", r"deck.bdf:6: GRID: field 4 is 'one', must be a number"),
        ("GRID,2,", "GRID,2,77", "coordinate system 77 is used but not defined"),
        ("5       3       4", "5       3", r"deck.bdf:12: CTETRA: field 7 is missing"),
        ("2       5       3       4", "2       5       3       8", "element 11 needs node 8"),
        (
            "5       3       4",
            "5       3       4       9",
            "element 11 has 1 of 6 midside nodes; export with all of them or with none",
        ),
        ("GRID,", "GRIT,", "contains no GRID entries"),
        ("GRID,5,,1.,1.,1.", "GRID,4,,1.,1.,1.", "node 4 is defined twice"),
        ("PSOLID  3       8", "INCLUDE 'no.bdf'", "the included file 'no.bdf' does not exist"),
        (
            "PSOLID  3       8",
            "CORD2R,77,77,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nGRID,50,77,0.,0.,0.",
            "coordinate system 77 refers to itself",
        ),
        (
            "PSOLID  3       8",
            "CORD2R,77,,0.,0.,0.,0.,0.,1.\n,0.,0.,2.\nGRID,50,77,0.,0.,0.",
            "its three points lie on a line",
        ),
    ],
)
def test_wrong_decks_are_told(tmp_path: Path, found: str, instead: str, sentence: str) -> None:
    path = tmp_path / "deck.bdf"
    path.write_text(DECK.replace(found, instead))
    with pytest.raises(InputError, match=sentence):
        jo.read_mesh(path)


def test_cut_off_decks_are_told(tmp_path: Path) -> None:
    path = tmp_path / "deck.bdf"
    path.write_text(DECK.partition("CTRIA3")[0])
    with pytest.warns(jo.JoustoWarning, match="has no ENDDATA; the file may be truncated"):
        jo.read_mesh(path)
    path.write_text(DECK.partition("       3       4\nCTRIA3")[0])
    with pytest.raises(InputError, match="CTETRA: field 6 is missing"):
        jo.read_mesh(path)


PAIR = """BEGIN BULK
GRID,1,0,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,0.,1.,0.
GRID,4,,0.,0.,1.
GRID,5,,1.,1.,1.
CTETRA,1,7,1,2,3,4
CTETRA,2,8,2,5,3,4
PSOLID,7,1
PSOLID,8,2
SET1,5,1,THRU,3
ENDDATA
"""


@pytest.mark.parametrize(
    ("found", "instead", "sentence"),
    [
        ("CTETRA,2", "CTETRA,1", "number 1 belongs to more than one element"),
        ("THRU,3", "THRU,x", r"SET1: field 5 is 'x', must be a whole number"),
        ("THRU,3", "THRU", "SET1: field 5 is missing, must be a whole number"),
        ("1,THRU,3", "3,THRU,1", "SET1: field 5 is '1', must be 3 or more"),
        ("GRID,5", "GRID,99999999999999999999", "field 2 is '9{20}', must be a whole number"),
        ("CTETRA,2", "CTETRA,99999999999999999999", "field 2 is '9{20}', must be a whole number"),
        ("GRID,1", "GRDSET,,4\nGRDSET,,5\nGRID,1", "twice with different systems"),
    ],
)
def test_wrong_numbers_are_told(tmp_path: Path, found: str, instead: str, sentence: str) -> None:
    path = tmp_path / "pair.bdf"
    path.write_text(PAIR.replace(found, instead))
    with pytest.raises(InputError, match=sentence):
        jo.read_mesh(path)


def test_ranges_hold_what_is_there(tmp_path: Path) -> None:
    path = tmp_path / "pair.bdf"
    for last, expected in (("3", [0, 1, 2]), ("999999999999", [0, 1, 2, 3, 4])):
        path.write_text(PAIR.replace("THRU,3", f"THRU,{last}"))
        assert jo.read_mesh(path).node_sets["set5"].tolist() == expected


def test_systems_of_all_grids(tmp_path: Path) -> None:
    path = tmp_path / "pair.bdf"
    cylinder = "GRDSET,,9\nCORD2C,9,0,0.,0.,0.,0.,0.,1.\n+,1.,0.,0.\n"
    path.write_text(
        PAIR.replace("GRID,1", cylinder + "GRID,1").replace("3,,0.,1.,0.", "3,,1.,90.,0.")
    )
    mesh = jo.read_mesh(path)
    # grid 1 says 0: the basic system; grid 5 has an angle of 1 degree
    np.testing.assert_allclose(mesh.nodes[[0, 1, 2]], np.eye(4, 3, -1)[:3], atol=1e-15)
    np.testing.assert_allclose(mesh.nodes[4], (np.cos(np.pi / 180), np.sin(np.pi / 180), 1.0))


def test_ties_that_are_not_read(tmp_path: Path) -> None:
    path = tmp_path / "pair.bdf"
    path.write_text(PAIR.replace("ENDDATA", "MPC,9,1,1,1.,2,1,-1.\nENDDATA"))
    with pytest.warns(
        jo.JoustoWarning, match="1 MPC not read: the nodes are not tied; .*Interface"
    ):
        jo.read_mesh(path)


CUBE = "BEGIN BULK\n" + "".join(
    f"GRID,{i},,{x}.,{y}.,{z}.\n"
    for i, (x, y, z) in enumerate(
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)], 1
    )
)


def cube(tmp_path: Path, entries: str) -> jo.Mesh:
    path = tmp_path / "cube.bdf"
    path.write_text(f"{CUBE}{entries}\nENDDATA\n")
    return jo.read_mesh(path)


@pytest.mark.parametrize(
    "line",
    [
        "CHEXA,1,1,1,2,3,4,5,6\n,7,8",
        "CHEXA,1,1,1,2,3,4,5,6,7,8",
        "CHEXA,1,1,1,2,3,4,5,6,+A,+A,7,8",
        "CHEXA,1,1,1,2,3,4,5,6,+,,7,8",
        "CHEXA,1,1,1,2,3,4,5,6,,,7,8",
        "CHEXA,1,1,1,2,3,4,5,6,+A,7,8",
        "CHEXA,1,1,1,2,3,4,5,6,+A\n+A,7,8,,,,,,,mine",
        "CHEXA*,1,1,1,2,*,*,3,4,5,6,*\n*,7,8",
    ],
)
def test_lines_in_free_format_may_go_on(line: str, tmp_path: Path) -> None:
    mesh = cube(tmp_path, line + "\nSET1,5,1,2,3,4,5,6,7,THRU,8")
    np.testing.assert_array_equal(mesh.solids[0].nodes, [[*range(8)]])
    assert mesh.node_sets["set5"].tolist() == [*range(8)]


def test_a_free_line_that_can_mean_two_things_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cube.bdf:10: the field 10 is blank and '7' follows"):
        cube(tmp_path, "CHEXA,1,1,1,2,3,4,5,6,,7,8")


def test_shells_may_lack_midside_nodes(tmp_path: Path) -> None:
    mesh = cube(tmp_path, "CHEXA,1,1,1,2,3,4,5,6,7,8\nCQUAD8,2,2,1,2,3,4\nCTRIA6,3,3,1,2,3")
    assert [cells.kind for cells in mesh.cells] == ["hexahedron", "quad", "triangle"]
    assert mesh.set("pid2").tolist() == [0, 1, 2, 3]
    with pytest.warns(jo.JoustoWarning, match="1 CQUAD8 lack some midside nodes: read by their"):
        mesh = cube(tmp_path, "CHEXA,1,1,1,2,3,4,5,6,7,8\nCQUAD8,2,2,1,2,3,4,5,0\n,6")
    assert mesh.set("pid2").tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize("kind", ["tetra", "tetra10", "hexahedron", "hexahedron20", "wedge15"])
def test_solids_may_be_listed_in_either_sense(kind: str, tmp_path: Path) -> None:
    # CHEXA: the faces G1 to G4 and G5 to G8 are opposite, whichever way round they are listed
    mesh = block(kind, (2, 1, 1), (2.0, 1.0, 1.0))
    path = tmp_path / "block.bdf"
    mirrored_nodes = mesh.nodes * (1.0, 1.0, -1.0)
    meshio.nastran.write(path, meshio.Mesh(mirrored_nodes, [(kind, mesh.solids[0].nodes)]))
    back = jo.read_mesh(path)
    assert back.volume == pytest.approx(2.0, rel=1e-12)
    assert back.check() == ()


@pytest.mark.parametrize("element", ["CBAR,1,1,1,2,0.,0.,1.", "CTRIA3,1,1,1,2,3"])
def test_sets_of_numbers_that_are_not_there(element: str, tmp_path: Path) -> None:
    with pytest.warns(
        jo.JoustoWarning,
        match=r"cube.bdf:11: SET1: 100, 101 is neither a node nor a supported element",
    ):
        mesh = cube(tmp_path, f"{element}\nSET1,7,100,101")
    assert "set7" not in mesh.node_sets
    assert mesh.check()[0].kind == "empty"
