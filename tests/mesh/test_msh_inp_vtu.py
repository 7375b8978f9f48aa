"""Gmsh, Abaqus/CalculiX, VTK and MED files, written by Gmsh and meshio themselves."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from gmsh_session import opened
from jousto.base.errors import InputError
from jousto.mesh.cells import SOLIDS
from jousto.mesh.readers.meshio_formats import load_meshio

from .blocks import block

gmsh = pytest.importorskip("gmsh")
meshio = load_meshio()


@pytest.fixture(scope="module", params=[1, 2], ids=["linear", "quadratic"])
def written(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plate with a hole, meshed by Gmsh and written in all its formats."""
    folder = tmp_path_factory.mktemp("gmsh")
    with opened(gmsh):
        occ = gmsh.model.occ
        plate = occ.addBox(0, 0, 0, 40, 20, 10)
        pin = occ.addCylinder(20, 10, -5, 0, 0, 20, 5)
        occ.cut([(3, plate)], [(3, pin)])
        occ.synchronize()
        faces = gmsh.model.getEntities(2)
        bore = [tag for dim, tag in faces if gmsh.model.getType(dim, tag) == "Cylinder"]
        left = [tag for dim, tag in faces if abs(occ.getCenterOfMass(dim, tag)[0]) < 1e-6]
        gmsh.model.addPhysicalGroup(3, [1], 7, "body")
        gmsh.model.addPhysicalGroup(2, bore, 3, "bore")
        gmsh.model.addPhysicalGroup(2, left, 4, "left end")
        gmsh.model.mesh.setSize(gmsh.model.getEntities(0), 8)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 8)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(request.param)
        tags, _, _ = gmsh.model.mesh.getNodes()
        elements, _ = gmsh.model.mesh.getElementsByType(4 if request.param == 1 else 11)
        least = gmsh.model.mesh.getElementQualities(elements, "minDetJac").min()
        np.savez(folder / "truth.npz", nodes=tags, elements=elements, least=least)
        for version in (2.2, 4.0, 4.1):
            for binary in (0, 1) if version != 4.0 else (0,):
                gmsh.option.setNumber("Mesh.MshFileVersion", version)
                gmsh.option.setNumber("Mesh.Binary", binary)
                gmsh.write(str(folder / f"plate_{version}_{binary}.msh"))
        gmsh.option.setNumber("Mesh.Binary", 0)
        for suffix in ("inp", "vtk", "med", "bdf"):
            gmsh.write(str(folder / f"plate.{suffix}"))
    return folder


# what meshio calls them where the suffix says several
FORMATS = {"msh": "gmsh"}
VERSIONS = [f"plate_{version}_{binary}.msh" for version in ("2.2", "4.1") for binary in (0, 1)]


@pytest.mark.parametrize("name", [*VERSIONS, "plate.inp", "plate.vtk", "plate.med", "plate.bdf"])
def test_gmsh_writes_we_read(written: Path, name: str) -> None:
    mesh = jo.read_mesh(written / name, unit="mm")
    # 40 x 20 x 10 less a hole of 10 mm: eight chords or parabolas round the hole
    exact = (40 * 20 * 10 - np.pi * 25 * 10) * 1e-9
    order = 1 if mesh.solids[0].kind == "tetra" else 2
    assert mesh.volume == pytest.approx(exact, rel=0.01 if order == 1 else 1e-4)
    assert mesh.check() == ()
    # a wrong order of midside nodes shows in the Jacobian
    assert np.all(mesh.quality().jacobian_ratio > 0.2)


@pytest.mark.parametrize("name", [*VERSIONS, "plate.inp", "plate.bdf"])
def test_numbers_of_gmsh_are_kept(written: Path, name: str) -> None:
    mesh, truth = jo.read_mesh(written / name), np.load(written / "truth.npz")
    np.testing.assert_array_equal(np.sort(mesh.node_ids), np.sort(truth["nodes"]))
    np.testing.assert_array_equal(mesh.element_ids, truth["elements"])


def test_groups_of_gmsh_are_property_numbers_in_bulk_data(written: Path) -> None:
    assert set(jo.read_mesh(written / "plate.bdf", unit="mm").element_sets) == {"pid1"}


@pytest.mark.parametrize("name", [*VERSIONS, "plate.inp", "plate.med"])
def test_groups_of_gmsh_are_sets(written: Path, name: str) -> None:
    mesh = jo.read_mesh(written / name, unit="mm")
    left = "left_end" if name.endswith(".inp") else "left end"
    assert len(mesh.element_sets["body"]) == len(mesh.element_ids)
    x = mesh.nodes[mesh.set(left), 0]
    assert len(x) > 5
    np.testing.assert_allclose(x, 0.0, atol=1e-12)
    bore = mesh.set("bore")
    away = np.linalg.norm(mesh.nodes[bore, :2] - (0.02, 0.01), axis=1)
    np.testing.assert_allclose(away, 0.005, rtol=1e-9)
    np.testing.assert_array_equal(bore, mesh.cylinder((0.02, 0.01, 0), (0, 0, 1), 0.005))
    # the surface's corners come first: its area is that of the hole
    faces = mesh.surfaces["bore"]
    p = mesh.nodes[faces[:, :3]]
    area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum() / 2
    assert area == pytest.approx(2 * np.pi * 5e-3 * 10e-3, rel=0.06)


def test_midside_order_of_gmsh_is_not_ours(written: Path) -> None:
    mesh = jo.read_mesh(written / "plate_4.1_0.msh", unit="mm")
    if mesh.solids[0].kind != "tetra10":
        pytest.skip("these four-node elements have no midside nodes to swap")
    nodes = mesh.solids[0].nodes
    swapped = jo.Mesh("swapped", mesh.nodes, jo.mesh.Cells("tetra10", nodes[:, [*range(8), 9, 8]]))
    (finding,) = [f for f in swapped.check() if f.kind == "jacobian"]
    assert finding.severity == "error"
    assert len(finding.ids) == len(nodes)


def test_gmsh_format_4_0_is_refused(written: Path) -> None:
    with pytest.raises(InputError, match=r"Gmsh's format 4; formats 2\.2 and 4\.1 are supported"):
        jo.read_mesh(written / "plate_4.0_0.msh")


@pytest.mark.parametrize("name", [*VERSIONS, "plate.inp", "plate.vtk", "plate.med", "plate.bdf"])
@pytest.mark.parametrize("part", [0.3, 0.6, 0.9])
def test_cut_off_files_are_told(written: Path, tmp_path: Path, name: str, part: float) -> None:
    data = (written / name).read_bytes()
    broken = tmp_path / name
    broken.write_bytes(data[: int(len(data) * part)])
    with pytest.raises((InputError, jo.JoustoWarning)) as caught:
        jo.read_mesh(broken)
    assert name in str(caught.value)
    assert len(str(caught.value)) < 400
    # a deck may end anywhere between its sets, but hardly within a line
    assert caught.type is InputError or name in ("plate.inp", "plate.bdf")


def how_it_ends(path: Path) -> str | None:
    """Return the sentence that refuses a file, or None if it is read; all else is a failure."""
    try:
        jo.read_mesh(path).check()
    except InputError as error:
        return str(error)
    return None


# not .med: the HDF5 library itself may crash on damaged files
@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
@pytest.mark.parametrize("name", [*VERSIONS, "plate.inp", "plate.vtk", "plate.bdf"])
def test_random_damage_never_ends_in_a_traceback(
    written: Path, tmp_path: Path, name: str, rng: np.random.Generator
) -> None:
    data = (written / name).read_bytes()
    path = tmp_path / name
    ended = []
    for _ in range(12):
        broken = bytearray(data)
        at = int(rng.integers(len(broken)))
        how = rng.integers(3)
        if how == 0:
            del broken[at : at + int(rng.integers(1, 200))]
        elif how == 1:
            broken[at] = int(rng.integers(256))
        else:
            broken[at : at + 1] = (b"9", b"-", b"99999", b"x", b",")[rng.integers(5)]
        path.write_bytes(bytes(broken))
        # damage within the coordinates makes another mesh, which is checked at least
        ended.append(how_it_ends(path))
    assert len(ended) == 12
    assert all(name in said for said in ended if said is not None)


# words that stand in no sound file, or mean something else there
WORDS = [
    "",
    "1.9",
    "9" * 20,
    "123456789012",
    "THRU",
    "x",
    "1.0D+00",
    "-1",
    "nan",
    "1e400",
    "1",
    "S9",
]
BULK = """BEGIN BULK
GRDSET,,3
CORD2C,3,0,0.,0.,0.,0.,0.,1.
+,1.,0.,0.
GRID,1,0,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,90.,0.
GRID,4,0,0.,0.,1.
GRID,5,0,1.,1.,1.
CTETRA,1,7,1,2,3,4
CTETRA,2,8,2,5,3,4
PSOLID,7,1
PSOLID,8,2
SET1,5,1,THRU,3,5
RBE2,9,1,123456,2,THRU,4
RBE3,10,,1,123456,1.0,123,2,3
ENDDATA
"""


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
@pytest.mark.parametrize("suffix", ["inp", "bdf"])
def test_wrong_words_and_lines_never_end_in_a_traceback(
    suffix: str, tmp_path: Path, rng: np.random.Generator
) -> None:
    lines = (DECK if suffix == "inp" else BULK).splitlines()
    path = tmp_path / f"damaged.{suffix}"
    jobs = [
        (i, j, word) for i, s in enumerate(lines) for j in range(s.count(",") + 1) for word in WORDS
    ]
    ended = []
    for job in rng.permutation(len(jobs))[:150]:
        i, j, word = jobs[job]
        words = lines[i].split(",")
        words[j] = word
        path.write_text("\n".join([*lines[:i], ",".join(words), *lines[i + 1 :]]) + "\n")
        ended.append(how_it_ends(path))
    for i in range(len(lines)):
        for instead in ([], [lines[i]] * 2):  # a line less, a line twice
            path.write_text("\n".join([*lines[:i], *instead, *lines[i + 1 :]]) + "\n")
            ended.append(how_it_ends(path))
    # most words matter: a third of the damage at least is refused, by a sentence with the file
    refused = [said for said in ended if said is not None]
    assert len(refused) > len(ended) / 3
    assert all(path.name in said for said in refused)


# meshio writes C3D10MH and C3D20RH
@pytest.mark.filterwarnings("ignore:.* C3D(10M|20R)H read as")
@pytest.mark.parametrize("kind", SOLIDS)
@pytest.mark.parametrize("suffix", ["vtu", "vtk", "inp", "msh", "med"])
def test_meshio_writes_we_read(kind: str, suffix: str, tmp_path: Path) -> None:
    mesh = block(kind, (2, 1, 1), (0.2, 0.1, 0.1))
    path = tmp_path / f"block.{suffix}"
    ne = len(mesh.element_ids)
    data = {"material": [np.arange(ne) % 2 + 1]} if suffix.startswith("vt") else {}
    meshio.Mesh(mesh.nodes, [(kind, mesh.solids[0].nodes)], cell_data=data).write(
        path, file_format=FORMATS.get(suffix)
    )
    back = jo.read_mesh(path)
    np.testing.assert_allclose(back.nodes, mesh.nodes, atol=1e-15)
    np.testing.assert_array_equal(back.solids[0].nodes, mesh.solids[0].nodes)
    assert back.volume == pytest.approx(2e-3, rel=1e-12)
    if data:
        np.testing.assert_array_equal(back.element_sets["material=2"], np.arange(1, ne, 2))


DECK = """*HEADING
 a bar of two cubes, numbers as they come
** a comment
*Node, nset=ALL
 10, 0., 0., 0.
 11, 1., 0., 0.
 12, 1., 1., 0.
 13, 0., 1.
 20, 0., 0., 1.
 21, 1., 0., 1.
 22, 1., 1., 1.
 23, 0., 1., 1.
 31, 2., 0., 0.
 32, 2., 1., 0.
 41, 2., 0., 1.
 42, 2., 1., 1.
*element, type=C3D8R,
 elset=First
 7, 10, 11, 12, 13,
 20, 21, 22, 23
*Element, TYPE=C3D8, ELSET=second
 5, 11, 31, 32, 12, 21, 41, 42, 22
*element, type=MASS, elset=m
 99, 10
*Nset, nset=range, generate
 10, 13, 1
*NSET, NSET=both
 RANGE, 42,
*ELSET, ELSET=everything
 first, SECOND
*SURFACE, NAME=top
 EVERYTHING, S2
*SURFACE, NAME=right, TYPE=ELEMENT
 5, S4
*SURFACE, NAME=cloud, TYPE=NODE
 range,
*SOLID SECTION, ELSET=FIRST, MATERIAL=steel
*SOLID SECTION, ELSET=second, MATERIAL=iron
*STEP
*END STEP
"""


def test_abaqus_deck(tmp_path: Path) -> None:
    path = tmp_path / "bar.inp"
    path.write_text(DECK)
    with pytest.warns(jo.JoustoWarning, match="1 element of type MASS not read"):
        mesh = jo.read_mesh(path)
    assert mesh.volume == pytest.approx(2.0)
    np.testing.assert_array_equal(mesh.element_ids, [7, 5])
    assert [block.material for block in mesh.cells] == ["steel", "iron"]

    def ids(name: str) -> list[int]:
        return sorted(mesh.node_ids[mesh.set(name)].tolist())

    assert ids("range") == [10, 11, 12, 13]
    assert ids("both") == [10, 11, 12, 13, 42]
    assert ids("top") == [20, 21, 22, 23, 41, 42]
    assert ids("right") == [31, 32, 41, 42]
    assert ids("cloud") == [10, 11, 12, 13]
    assert mesh.element_sets["everything"].tolist() == [0, 1]
    assert mesh.element_sets["second"].tolist() == [1]


@pytest.mark.parametrize(
    ("found", "instead", "sentence"),
    [
        (" 31, 2.,", " 31, two,", r"bar.inp:4: \*NODE: ' *31, two, 0., 0.' is not a node"),
        (" 5, 11, 31", " 5, 11, 77", "element 5 needs node 77, which the file does not contain"),
        (" 5, 11, 31,", " 5, 11,", "8 numbers do not make whole C3D8 elements of 9 numbers"),
        (" RANGE, 42,", " RAGNE, 42,", "'RAGNE' is neither a number nor a set"),
        (" first, SECOND", " first, 8, x", "'x' is neither a number nor a set"),
        (" EVERYTHING, S2", " NOTHING, S2", "'NOTHING' is neither a number nor a set"),
        (" 5, S4", " 6, S4", "surface 'right' contains element 6, which is not in the file"),
        (" 42, 2., 1., 1.", " 10, 2., 1., 1.", "node 10 is defined twice, at different positions"),
        ("*STEP", "*INCLUDE, INPUT=more.inp", "the included file 'more.inp' does not exist"),
        ("*HEADING", "*INSTANCE, NAME=a, PART=b", "INSTANCE: there is no part 'b' above it"),
        (" 5, 11, 31", " 7, 11, 31", "number 7 belongs to more than one element"),
        (" 5, 11, 31", " 5, 11.9, 31", r"\*ELEMENT: '11.9' is not a whole number"),
        (" 31, 2.,", " 31.7, 2.,", r"\*NODE: '31.7' is not a whole number"),
        (" 31, 2.,", f" {10**19}, 2.,", f"'{10**19}' is too large for a number"),
        (" EVERYTHING, S2", " EVERYTHING, S9", "face 9 of element 7; a hexahedron has 6"),
        ("*Nset, nset=range,", "*Nset,", r"\*NSET: has no name; add NSET="),
        ("*SURFACE, NAME=right,", "*SURFACE,", r"\*SURFACE: has no name; add NAME="),
        ("*STEP", "*NGEN\n10,13,1", r"\*NGEN: generates nodes or elements .* export the full mesh"),
        ("*STEP", "*ELCOPY, ELEMENT SHIFT=9", r"\*ELCOPY: generates nodes or elements"),
        ("*Node,", "*Node, system=S,", "SYSTEM=S is not supported; export the nodes with SYSTEM=R"),
        ("*Node,", "*SYSTEM\n0,0,0,1,0,0\n2,0,0\n*Node,", "points lie on a line"),
    ],
)
def test_wrong_decks_are_told(tmp_path: Path, found: str, instead: str, sentence: str) -> None:
    path = tmp_path / "bar.inp"
    path.write_text(DECK.replace(found, instead))
    with pytest.raises(InputError, match=sentence):
        jo.read_mesh(path)


@pytest.mark.filterwarnings("ignore:.*type MASS")
def test_numbers_as_abaqus_takes_them(tmp_path: Path) -> None:
    path = tmp_path / "bar.inp"
    path.write_text(
        DECK.replace(" 31, 2., 0., 0.", " 31, 2.0D+00,, 0.").replace(
            " 10, 13, 1", " 10, 100000000000, 1"
        )
    )
    mesh = jo.read_mesh(path)
    assert mesh.volume == pytest.approx(2.0)
    # a range holds those that are there
    assert len(mesh.set("range")) == len(mesh.nodes)


TETRA = "1,0,0,0\n2,2,{0},0\n3,2,{1},0\n4,0,0,3\n*ELEMENT,TYPE=C3D4\n1,1,2,3,4\n"


@pytest.mark.parametrize(
    ("head", "angles", "nodes"),
    [
        # radius 2 at 0 and 90 degrees
        ("*NODE, SYSTEM=C\n", (0, 90), [(0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 3)]),
        # moved only
        ("*SYSTEM\n1,1,1\n*NODE\n", (0, 2), [(1, 1, 1), (3, 1, 1), (3, 3, 1), (1, 1, 4)]),
        # x' along y, z' stays
        ("*SYSTEM\n0,0,0,0,5,7\n*NODE\n", (0, 2), [(0, 0, 0), (0, 2, 0), (-2, 2, 0), (0, 0, 3)]),
        # x' along y, y' along z, z' along x
        (
            "*SYSTEM\n1,0,0,1,1,0\n1,1,1\n*NODE\n",
            (0, 2),
            [(1, 0, 0), (1, 2, 0), (1, 2, 2), (4, 0, 0)],
        ),
        # cylindrical in the system; the first *SYSTEM is called off
        (
            "*SYSTEM\n9,9,9\n*SYSTEM\n*SYSTEM\n1,0,0,1,1,0\n1,1,1\n*NODE, SYSTEM=C\n",
            (0, 90),
            [(1, 0, 0), (1, 2, 0), (1, 0, 2), (4, 0, 0)],
        ),
    ],
)
def test_coordinate_systems_of_abaqus(
    tmp_path: Path, head: str, angles: tuple[int, int], nodes: list[tuple[int, int, int]]
) -> None:
    path = tmp_path / "tetra.inp"
    path.write_text(head + TETRA.format(*angles))
    np.testing.assert_allclose(jo.read_mesh(path).nodes, nodes, atol=1e-15)


def test_fractions_in_gmsh_files(tmp_path: Path) -> None:
    path = tmp_path / "tetra.msh"
    text = (
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
        "$EndNodes\n$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n"
    )
    path.write_text(text)
    assert jo.read_mesh(path).volume == pytest.approx(1 / 6)
    for found, instead in (("1 1 1 2 3 4", "1 1 1 2 3.5 4"), ("\n3 0 1 0", "\n3.5 0 1 0")):
        path.write_text(text.replace(found, instead))
        with pytest.raises(InputError, match=r"'3\.5' is not a whole number"):
            jo.read_mesh(path)
    # an element in two groups stands there twice; another element may not have its number
    path.write_text(
        text.replace("\n1\n1 4 2 1 1 1 2 3 4", "\n2\n1 4 2 1 1 1 2 3 4\n1 4 2 2 1 1 2 3 4")
    )
    assert jo.read_mesh(path).volume == pytest.approx(1 / 6)
    path.write_text(
        text.replace("\n1\n1 4 2 1 1 1 2 3 4", "\n2\n1 4 2 1 1 1 2 3 4\n1 4 2 2 1 1 3 2 4")
    )
    with pytest.raises(InputError, match="number 1 belongs to more than one element"):
        jo.read_mesh(path)


@pytest.mark.filterwarnings("ignore:.*type MASS")
def test_included_and_packed_files(tmp_path: Path) -> None:
    text = DECK
    head, _, tail = text.partition("*element")
    (tmp_path / "nodes.txt").write_text(head)
    (tmp_path / "bar.inp").write_text("*INCLUDE, INPUT=nodes.txt\n*element" + tail)
    assert jo.read_mesh(tmp_path / "bar.inp").volume == pytest.approx(2.0)
    with gzip.open(tmp_path / "packed.inp.gz", "wt") as file:
        file.write(text)
    packed = jo.read_mesh(tmp_path / "packed.inp.gz", unit="in")
    assert packed.name == "packed"
    assert packed.volume == pytest.approx(2.0 * 0.0254**3)
    (tmp_path / "cut.inp.gz").write_bytes((tmp_path / "packed.inp.gz").read_bytes()[:200])
    with pytest.raises(InputError, match="cannot be unpacked"):
        jo.read_mesh(tmp_path / "cut.inp.gz")


@pytest.mark.filterwarnings("ignore:.*type MASS")
def test_wrong_files_are_told(tmp_path: Path) -> None:
    def told(name: str, content: bytes) -> str:
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError) as caught:
            jo.read_mesh(tmp_path / name)
        return str(caught.value)

    deck = DECK.encode()
    assert "is empty" in told("a.msh", b" \n")
    assert "has the suffix of a Gmsh mesh but contains an Abaqus" in told("b.msh", deck)
    assert "a STEP file: name it c.step and mesh it, jousto mesh c.step" in told(
        "c.inp", b"ISO-10303-21;\nHEADER;"
    )
    assert "an IGES file" in told("l.msh", b" " * 72 + b"S      1\n,,4Hpart")
    assert "a ZIP archive" in told("d.inp", b"PK\x03\x04" + bytes(100))
    assert "a web page" in told("e.msh", b"<!DOCTYPE html><html></html>")
    assert "is a binary file, not an Abaqus" in told("f.inp", bytes(range(256)) * 4)
    assert "contains neither *NODE nor *ELEMENT" in told("g.inp", b"hello world\n")
    assert "has no supported format; known: .msh" in told("h.xyz", b"hello world\n")
    assert "does not begin with $MeshFormat" in told("i.msh", b"hello world\n")
    assert "cannot be read as a .vtu file" in told("j.vtu", b"<VTKFile type='PolyData'></VTKFile>")
    assert "cannot be read as a .med file" in told("k.med", b"\x89HDF\r\n\x1a\n" + bytes(50))
    with pytest.raises(InputError, match="no such file; did you mean 'a.msh'"):
        jo.read_mesh(tmp_path / "aa.msh")
    with pytest.raises(InputError, match="is a folder"):
        jo.read_mesh(tmp_path)
    with pytest.raises(InputError, match="unit is 'inches'; did you mean 'inch'"):
        jo.read_mesh(tmp_path / "a.msh", unit="inches")
    # the content decides where the suffix says nothing
    (tmp_path / "bar.txt").write_bytes(deck)
    assert jo.read_mesh(tmp_path / "bar.txt").volume == pytest.approx(2.0)


@pytest.mark.filterwarnings("ignore:.*BOUNDARY .* ignored:jousto.JoustoWarning")
def test_a_deck_of_calculix(tmp_path: Path) -> None:
    # as CalculiX's own examples are written: an empty keyword, blanks, elements on two lines,
    # a comma at the end of a keyword line
    cube = block("hexahedron20", (1, 1, 1), (1.0, 1.0, 1.0))
    nodes = "".join(
        f"  {i}, {x:.5e}, {y:.5e}, {z:.5e} \n" for i, (x, y, z) in enumerate(cube.nodes, 1)
    )
    row = [str(n + 1) for n in cube.solids[0].nodes[0]]
    path = tmp_path / "cube.inp"
    path.write_text(
        f"**\n*NODE, NSET=Nall\n{nodes}*ELEMENT, TYPE=C3D20R, ELSET=Eall,\n"
        f"     1, {', '.join(row[:10])},\n   {',  '.join(row[10:])}\n*\n"
        "*SOLID SECTION,ELSET=EALL,MATERIAL=EL\n*STEP,INC=100\n*BOUNDARY\nNall,11,11,5.\n"
        "*FILM\n1,F1,-12.,10.e10\n*END STEP\n\n"
    )
    mesh = jo.read_mesh(path)
    np.testing.assert_array_equal(mesh.solids[0].nodes, cube.solids[0].nodes)
    assert mesh.volume == pytest.approx(1.0)
    assert mesh.solids[0].material == "EL"
    assert len(mesh.set("Eall")) == len(mesh.set("Nall")) == 20


def test_middle_nodes_of_lines(tmp_path: Path) -> None:
    path = tmp_path / "line.inp"
    path.write_text("*NODE\n1,0,0,0\n2,1,0,0\n3,2,0,0\n*ELEMENT,TYPE=B32\n1,1,2,3\n")
    (line,) = jo.read_mesh(path).cells
    assert line.kind == "line3"
    assert line.nodes.tolist() == [[0, 2, 1]]  # the ends, then the middle


def test_full_second_order_is_refused(tmp_path: Path) -> None:
    points = np.array(np.meshgrid([0, 0.5, 1], [0, 0.5, 1], [0, 0.5, 1])).reshape(3, -1).T
    mesh = meshio.Mesh(points, [("hexahedron27", [np.arange(27)])])
    for suffix in ("msh", "vtu"):
        mesh.write(tmp_path / f"full.{suffix}", file_format=FORMATS.get(suffix))
        with pytest.raises(InputError, match="hexahedron27"):
            jo.read_mesh(tmp_path / f"full.{suffix}")
