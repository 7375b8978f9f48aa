"""Matrix files of other programs: round trips, real files, and sentences for damaged ones."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp
from numpy.testing import assert_allclose, assert_array_equal

import jousto as jo
from jousto.base.errors import InputError, JoustoWarning
from jousto.materials.material import Material
from jousto.parts.matrices.plain import read_harwell_boeing
from jousto.parts.matrices.units import SYSTEMS, Units
from jousto.parts.part import Part
from jousto.sections.section import Circle, Rectangle
from parts.matrix_files import (
    full,
    write_abaqus,
    write_calculix,
    write_harwell_boeing,
    write_user_element,
)

FILES = Path(__file__).parent / "files"
STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
BEAM = Part.beam(1.2, Rectangle(0.06, 0.04), 3, STEEL)
IDS = np.array([11, 7, 40, 23])
DOFS = np.stack([np.repeat(IDS, 6), np.tile(np.arange(1, 7), 4)], axis=1)
TABLE = np.column_stack([IDS, BEAM.nodes])


def save(folder: Path, kind: str) -> dict[str, object]:
    """Write the beam's matrices and return the arguments that read them."""
    K, M = folder / f"k{kind}", folder / f"m{kind}"
    if kind == ".mtx":
        scipy.io.mmwrite(K, BEAM.K, precision=16)
        scipy.io.mmwrite(M, BEAM.M, precision=16)
    elif kind == ".npz":
        sp.save_npz(K, BEAM.K)
        sp.save_npz(M, BEAM.M)
    elif kind == ".npy":
        np.save(K, full(BEAM.K))
        np.save(M, full(BEAM.M))
    elif kind in (".rsa", ".rua"):
        write_harwell_boeing(K, BEAM.K, kind[1:].upper())
        write_harwell_boeing(M, BEAM.M, kind[1:].upper())
    elif kind == ".hb":
        # scipy's own writer
        from scipy.io import hb_write

        hb_write(K, sp.csc_matrix(BEAM.K))
        hb_write(M, sp.csc_matrix(BEAM.M))
    return {"K": K, "M": M, "nodes": BEAM.nodes, "dofs": None}


@pytest.mark.parametrize("kind", [".mtx", ".npz", ".npy", ".rsa", ".rua", ".hb"])
def test_plain_files(tmp_path: Path, kind: str) -> None:
    part = Part.from_file(**save(tmp_path, kind))  # type: ignore[arg-type]
    # scipy's Harwell-Boeing writer keeps 8 digits or more
    rtol = 1e-6 if kind == ".hb" else 1e-14
    scale = np.abs(full(BEAM.K)).max()
    assert_allclose(full(part.K), full(BEAM.K), rtol=rtol, atol=1e-14 * scale)
    assert_allclose(full(part.M), full(BEAM.M), rtol=rtol, atol=1e-15)
    assert part.dofs_per_node == 6 and part.node("n2") == 1


def test_one_npz_for_all(tmp_path: Path) -> None:
    path = tmp_path / "beam.npz"
    np.savez(path, K=full(BEAM.K), M=full(BEAM.M), nodes=TABLE, dofs=DOFS)
    part = Part.from_file(path)
    # the order of the table, with the numbers of the other program
    assert_array_equal(part.nodes, BEAM.nodes)
    assert part.node("n7") == 1 and part.node("n23") == 3
    assert_allclose(full(part.K), full(BEAM.K), rtol=1e-15)


def test_map_in_any_order(tmp_path: Path) -> None:
    # rows shuffled, positions by number: the part is the same
    order = np.random.default_rng(4).permutation(24)
    np.save(tmp_path / "k.npy", full(BEAM.K)[np.ix_(order, order)])
    np.save(tmp_path / "m.npy", full(BEAM.M)[np.ix_(order, order)])
    np.savetxt(tmp_path / "rows.txt", DOFS[order], fmt="%d")
    np.savetxt(tmp_path / "nodes.csv", TABLE, delimiter=",")
    part = Part.from_file(
        tmp_path / "k.npy",
        tmp_path / "m.npy",
        nodes=tmp_path / "nodes.csv",
        dofs=tmp_path / "rows.txt",
        node_sets={"tip": [23], "ends": (11, 23)},
    )
    assert_array_equal(full(part.K), full(BEAM.K))
    assert part.node("tip") == 3 and part.node_sets["ends"] == (0, 3)


@pytest.mark.parametrize("units", SYSTEMS)
def test_units(tmp_path: Path, units: str) -> None:
    system = Units.read(units)
    # in a consistent system the same beam has other numbers
    other = Part.beam(
        1.2 / system.length,
        Rectangle(0.06 / system.length, 0.04 / system.length),
        3,
        quiet_material(system),
    )
    np.save(tmp_path / "k.npy", full(other.K))
    np.save(tmp_path / "m.npy", full(other.M))
    files = tmp_path / "k.npy", tmp_path / "m.npy"
    part = Part.from_file(*files, nodes=other.nodes, units=units)
    assert part.mass == pytest.approx(BEAM.mass, rel=1e-12)
    assert_allclose(part.inertia, BEAM.inertia, rtol=1e-9, atol=1e-12)
    assert_allclose(full(part.K), full(BEAM.K), rtol=1e-11, atol=1e-6)


def quiet_material(system: Units) -> Material:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", JoustoWarning)
        pressure = system.force / system.length**2
        return Material(STEEL.E / pressure, STEEL.nu, STEEL.rho * system.length**3 / system.mass)


def test_other_units_are_noticed(tmp_path: Path) -> None:
    # N, mm, t taken for SI: the mass is small, sound is a thousand times too fast
    other = Part.beam(1200.0, Rectangle(60.0, 40.0), 3, quiet_material(Units.read("mm-t-s")))
    np.save(tmp_path / "k.npy", full(other.K))
    np.save(tmp_path / "m.npy", full(other.M))
    with pytest.warns(JoustoWarning, match="speed of sound in this part .* units='mm-t-s'"):
        Part.from_file(tmp_path / "k.npy", tmp_path / "m.npy", nodes=other.nodes)


# -- Harwell-Boeing ---------------------------------------------------------------------------


def test_harwell_boeing_fields_that_touch(tmp_path: Path) -> None:
    # 12 x 12 with pointers of two digits in fields of two
    A = np.diag(np.arange(1.0, 13.0)) + np.diag(-np.ones(11), 1) + np.diag(-np.ones(11), -1)
    write_harwell_boeing(tmp_path / "a.rsa", A)
    assert " 1 3 5 7 911" in (tmp_path / "a.rsa").read_text()
    assert_array_equal(full(read_harwell_boeing(tmp_path / "a.rsa")), A)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t[: len(t) // 2], "is truncated"),
        (lambda t: t.replace("RSA", "CSA"), "type CSA, which is complex"),
        (lambda t: t.replace("RSA", "PSA"), "a pattern without values"),
        (lambda t: t.replace("RSA", "RSE"), "of unassembled element matrices"),
        (lambda t: "solid brick\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "header cannot"),
        (lambda t: "one line", "the header of four lines is missing"),
        (lambda t: "", "is empty"),
    ],
)
def test_damaged_harwell_boeing(tmp_path: Path, change: Callable[[str], str], message: str) -> None:
    path = tmp_path / "k.rsa"
    write_harwell_boeing(path, BEAM.K)
    path.write_text(change(path.read_text()))
    with pytest.raises(InputError, match=message) as caught:
        read_harwell_boeing(path)
    assert len(caught.value.problems) == 1 and str(caught.value).startswith("k.rsa: ")


# -- Abaqus -----------------------------------------------------------------------------------


@pytest.mark.parametrize("lower", [True, False])
def test_abaqus_matrix_input(tmp_path: Path, lower: bool) -> None:
    write_abaqus(tmp_path / "job_STIF1.mtx", BEAM.K, DOFS, lower=lower)
    write_abaqus(tmp_path / "job_MASS1.mtx", BEAM.M, DOFS, lower=lower)
    part = Part.from_file(tmp_path / "job_STIF1.mtx", tmp_path / "job_MASS1.mtx", nodes=TABLE)
    assert_allclose(full(part.K), full(BEAM.K), rtol=1e-15)
    assert_allclose(full(part.M), full(BEAM.M), rtol=1e-15)


def test_abaqus_coordinate(tmp_path: Path) -> None:
    for name, matrix in (("k", BEAM.K), ("m", BEAM.M)):
        A = full(matrix)
        i, j = np.nonzero(A)
        rows = (f"{a + 1} {b + 1} {A[a, b]:.16e}" for a, b in zip(i, j, strict=True))
        (tmp_path / f"{name}.mtx").write_text("\n".join(rows))
    part = Part.from_file(tmp_path / "k.mtx", tmp_path / "m.mtx", nodes=BEAM.nodes)
    assert_allclose(full(part.K), full(BEAM.K), rtol=1e-15)


def test_abaqus_substructure(tmp_path: Path) -> None:
    write_user_element(tmp_path / "sub.mtx", DOFS, stiffness=BEAM.K, mass=BEAM.M)
    part = Part.from_file(tmp_path / "sub.mtx", nodes=TABLE)
    assert_allclose(full(part.K), full(BEAM.K), rtol=1e-15)
    assert_allclose(full(part.M), full(BEAM.M), rtol=1e-15)


# -- CalculiX ---------------------------------------------------------------------------------


def brick_nodes() -> np.ndarray:
    lines = (FILES / "brick.inp").read_text().split("*ELEMENT")[0].splitlines()[1:]
    return np.array([[float(x) for x in line.split(",")] for line in lines])


def test_calculix_files() -> None:
    # two C3D8 elements, 1 x 0.1 x 0.1 m, steel, written by CalculiX 2.20
    part = Part.from_file(FILES / "brick.sti", nodes=brick_nodes())
    assert part.mass == pytest.approx(78.5, rel=1e-12)
    assert_allclose(part.center, [0.5, 0.05, 0.05], rtol=1e-11)
    # trilinear elements integrate the inertia of a box exactly
    J = 78.5 / 12.0 * np.array([0.1**2 + 0.1**2, 1.0 + 0.1**2, 1.0 + 0.1**2])
    assert_allclose(part.inertia, np.diag(J), rtol=1e-10, atol=1e-10)
    # a pull along x with free sides stretches by F L / (E A)
    left, right = part.nodes[:, 0] == 0.0, part.nodes[:, 0] == 1.0
    held = [3 * i for i in np.flatnonzero(left)]
    corner = {name: part.node(name) for name in ("n10", "n40", "n70")}
    held += [3 * corner["n10"] + 1, 3 * corner["n10"] + 2, 3 * corner["n70"] + 1]
    free = np.setdiff1d(np.arange(36), held)
    f = np.zeros(36)
    f[3 * np.flatnonzero(right)] = 250.0
    u = np.zeros(36)
    u[free] = np.linalg.solve(full(part.K)[np.ix_(free, free)], f[free])
    assert_allclose(u[3 * np.flatnonzero(right)], 1000.0 / (210e9 * 0.01), rtol=1e-10)


def calculix(folder: Path) -> dict[str, object]:
    for suffix, matrix in ((".sti", BEAM.K), (".mas", BEAM.M)):
        write_calculix(folder / f"job{suffix}", matrix)
    (folder / "job.dof").write_text("".join(f"{n}.{c}\n" for n, c in DOFS))
    return {"K": folder / "job.sti", "nodes": TABLE}


def test_calculix_round_trip(tmp_path: Path) -> None:
    part = Part.from_file(**calculix(tmp_path))  # type: ignore[arg-type]
    assert_allclose(full(part.K), full(BEAM.K), rtol=1e-12)
    assert_array_equal(part.nodes, BEAM.nodes)


def cut(path: Path, part: float = 0.6) -> None:
    text = path.read_text()
    path.write_text(text[: int(len(text) * part)])


DAMAGE: dict[str, tuple[Callable[[Path], object], str]] = {
    "cut": (lambda p: cut(p / "job.sti"), "job.sti: (has .* rows but|ends with)"),
    "cut in a number": (
        lambda p: (p / "job.mas").write_text((p / "job.mas").read_text()[:-25]),
        "job.mas: ends with .* where i j value is expected: the file is truncated",
    ),
    "empty": (lambda p: (p / "job.mas").write_text(""), "job.mas: is empty"),
    "binary": (lambda p: (p / "job.mas").write_bytes(b"\0\1\2" * 99), "job.mas: is a binary file"),
    "missing": (lambda p: (p / "job.mas").unlink(), "no such file '.*job.mas'"),
    "map": (
        lambda p: (p / "job.dof").write_text("1 2 3\n"),
        "job.dof: line 1 is '1 2 3', node.direction such as 17.3",
    ),
    "text": (
        lambda p: (p / "job.sti").write_text("*HEADING\nmodel\n"),
        r"job.sti: line 1 is '\*HEADING', i j value is expected",
    ),
    "mesh": (
        lambda p: (p / "job.sti").write_text("1 0.5 0.25\n2 0.5 0.75\n"),
        "job.sti: has row numbers that are not whole numbers",
    ),
    "supports": (
        lambda p: (p / "job.dof").write_text((p / "job.dof").read_text().replace("23.6", "99.1")),
        "rows of node 99 without a position",
    ),
}


@pytest.mark.parametrize("name", DAMAGE)
def test_damaged_calculix(tmp_path: Path, name: str) -> None:
    arguments = calculix(tmp_path)
    damage, message = DAMAGE[name]
    damage(tmp_path)
    with pytest.raises(InputError, match=message) as caught:
        Part.from_file(**arguments)  # type: ignore[arg-type]
    assert len(caught.value.problems) == 1


# -- what cannot be a part --------------------------------------------------------------------


def beam_without(rows: list[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    keep = np.setdiff1d(np.arange(24), rows)
    pick = np.ix_(keep, keep)
    return full(BEAM.K)[pick], full(BEAM.M)[pick], DOFS[keep]


def read(folder: Path, K: np.ndarray, M: np.ndarray, dofs: np.ndarray, **more: object) -> Part:
    np.save(folder / "k.npy", K)
    np.save(folder / "m.npy", M)
    arguments = {"nodes": TABLE, "dofs": dofs, **more}
    return Part.from_file(folder / "k.npy", folder / "m.npy", **arguments)  # type: ignore[arg-type]


def test_held_directions(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match="1 of 4 nodes lack a direction, such as node 11, .* no uz"
    ):
        read(tmp_path, *beam_without([2]))


def test_rotations_without_stiffness_are_left_out(tmp_path: Path) -> None:
    # Nastran's solids: six rows for each node, three of them empty
    part = Part.from_file(FILES / "brick.sti", nodes=brick_nodes())
    table = brick_nodes()
    K, M = np.zeros((72, 72)), np.zeros((72, 72))
    at = (6 * np.arange(12)[:, None] + np.arange(3)).ravel()
    K[np.ix_(at, at)], M[np.ix_(at, at)] = full(part.K), full(part.M)
    dofs = np.stack([np.repeat(table[:, 0], 6), np.tile(np.arange(1, 7), 12)], axis=1)
    again = read(tmp_path, K, M, dofs.astype(int), nodes=table)
    assert again.dofs_per_node == 3
    assert_array_equal(full(again.K), full(part.K))


def test_mixed_directions(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="1 nodes have three directions and 3 have six"):
        read(tmp_path, *beam_without([21, 22, 23]))


def test_modal_rows(tmp_path: Path) -> None:
    dofs = DOFS.copy()
    dofs[-1] = (900001, 0)
    with pytest.raises(InputError, match="1 of its rows are modal coordinates"):
        read(tmp_path, full(BEAM.K), full(BEAM.M), dofs)


MISTAKES: tuple[tuple[dict[str, object], str], ...] = (
    ({"nodes": TABLE[:3]}, "rows of node 23 without a position"),
    ({"nodes": BEAM.nodes[:3]}, "have 4 nodes but there are 3 positions"),
    ({"dofs": DOFS[:-1]}, "K has shape .* but the map has 23 rows"),
    ({"dofs": np.vstack([DOFS[:-1], DOFS[:1]])}, "two rows are node 11 direction 1"),
    ({"dofs": np.vstack([DOFS[:-1], [[23, 7]]])}, "node 23 has the direction 7, must be 1..6"),
    ({"dofs": DOFS[:, :1]}, r"dofs has shape \(24, 1\)"),
    ({"units": "mm"}, "units is 'mm', must be length-mass-time such as SI, mm-t-s"),
    ({"format": "nastran"}, "format is 'nastran'"),
    ({"node_sets": {"tip": [24]}}, "node_sets..tip.. names node 24"),
    ({"node_sets": {"tip": [1.5]}}, "node_sets..tip.. names node 1.5"),
)


@pytest.mark.parametrize(("change", "message"), MISTAKES)
def test_mistakes(tmp_path: Path, change: dict[str, object], message: str) -> None:
    np.save(tmp_path / "k.npy", full(BEAM.K))
    np.save(tmp_path / "m.npy", full(BEAM.M))
    arguments: dict[str, object] = {"nodes": TABLE, "dofs": DOFS, **change}
    with pytest.raises(InputError, match=message):
        Part.from_file(tmp_path / "k.npy", tmp_path / "m.npy", **arguments)  # type: ignore[arg-type]


def test_wrong_kinds(tmp_path: Path) -> None:
    text = tmp_path / "k.mtx"
    text.write_text("%%MatrixMarket matrix coordinate real general\n3 3 2\n1 1 1.0\n")
    for path, message in (
        (text, "k.mtx: cannot be read as a Matrix Market file"),
        (tmp_path / "k.stl", "k.stl: has an unknown ending; known endings are .sti"),
        (tmp_path / "none.sti", "no such file '.*none"),
        (tmp_path / "k.npz", "k.npz: holds one matrix: give the file of the mass matrix"),
    ):
        if path.suffix in (".stl", ".npz"):
            path.write_bytes(b"solid")
        with pytest.raises(InputError, match=message):
            jo.parts.read_matrices(path, text if path is text else None, nodes=BEAM.nodes)
    np.save(tmp_path / "c.npy", 1j * np.ones((2, 2)))
    with pytest.raises(InputError, match="c.npy: is complex"):
        jo.parts.read_matrices(tmp_path / "c.npy", tmp_path / "c.npy", nodes=BEAM.nodes)
    with pytest.raises(InputError, match="k.mtx: begins with 'hello world'"):
        text.write_text("hello world\n")
        jo.parts.read_matrices(text, text, nodes=BEAM.nodes)
    with pytest.raises(InputError, match="nodes are missing"):
        jo.parts.read_matrices(**{**calculix(tmp_path), "nodes": None})  # type: ignore[arg-type]


def test_rows_in_the_order_of_the_directions(tmp_path: Path) -> None:
    # x of all nodes, then y of all nodes: not the order of a file without a map
    order = np.arange(24).reshape(4, 6).T.ravel()
    np.save(tmp_path / "k.npy", full(BEAM.K)[np.ix_(order, order)])
    np.save(tmp_path / "m.npy", full(BEAM.M)[np.ix_(order, order)])
    files = tmp_path / "k.npy", tmp_path / "m.npy"
    with pytest.warns(JoustoWarning, match="x of all nodes, then y .*: order them node by node"):
        part = Part.from_file(*files, nodes=BEAM.nodes)
    with pytest.raises(InputError, match="stiffness matrix is not free.*are consistent .order"):
        jo.reduce(part, jo.FreeFree(modes=2))
    # the map says the same without moving a number
    again = Part.from_file(*files, nodes=TABLE, dofs=DOFS[order])
    assert_array_equal(full(again.K), full(BEAM.K))


def test_one_triangle_in_a_plain_file(tmp_path: Path) -> None:
    # the format does not say that it is one: refused with the remedy
    with pytest.raises(InputError, match="K is not symmetric.*only one triangle is filled"):
        read(tmp_path, np.triu(full(BEAM.K)), full(BEAM.M), DOFS)


def test_abaqus_supports_and_internal_nodes(tmp_path: Path) -> None:
    K = full(BEAM.K)
    K[0, 0] = 1e36
    write_abaqus(tmp_path / "k.mtx", K, DOFS)
    write_abaqus(tmp_path / "m.mtx", BEAM.M, DOFS)
    files = tmp_path / "k.mtx", tmp_path / "m.mtx"
    with pytest.raises(InputError, match=r"with supports \(1 directions held: node 11 ux\)"):
        Part.from_file(*files, nodes=TABLE)
    files[0].write_text(files[0].read_text().replace("23,6", "0,6"))
    with pytest.raises(InputError, match="node 0 direction 6, which is internal to Abaqus"):
        Part.from_file(*files, nodes=TABLE)
    write_user_element(tmp_path / "k.mtx", DOFS, stiffness=BEAM.K)
    with pytest.raises(InputError, match="contains no mass"):
        Part.from_file(tmp_path / "k.mtx", nodes=TABLE)
    cut(tmp_path / "k.mtx", 0.9)
    with pytest.raises(InputError, match="numbers of stiffness, 300 are needed|cut off"):
        Part.from_file(tmp_path / "k.mtx", nodes=TABLE)


def test_the_speed_of_sound_does_not_suspect_beams() -> None:
    for length, elements in ((10.0, 4), (0.2, 8)):
        rod = Part.beam(length, Circle(0.02), elements, STEEL)
        matrices = jo.parts.Matrices(
            name="rod",
            K=rod.K,
            M=rod.M,
            dofs=np.stack(
                [
                    np.repeat(np.arange(elements + 1), 6),
                    np.tile(np.arange(1, 7), elements + 1),
                ],
                axis=1,
            ),
            node_ids=np.arange(elements + 1),
            nodes=rod.nodes,
        )
        from jousto.parts.matrices.read import _plausible

        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            _plausible(matrices, "rod", "SI")
        assert not said


def test_nodes_and_sets_from_the_mesh_beside(tmp_path: Path) -> None:
    part = Part.from_file(FILES / "brick.sti")
    table = brick_nodes()
    assert_array_equal(part.nodes, table[:, 1:])
    assert [part.nodes[i][0] for i in part.node_sets["LEFT"]] == [0.0] * 4
    assert part.elements.shape[1] == 3  # the outer surface, for drawing
    # a mesh in mm with matrices in N, mm, t is scaled as a whole
    for name in ("brick.sti", "brick.mas", "brick.dof"):
        (tmp_path / name).write_text((FILES / name).read_text())
    text = (FILES / "brick.inp").read_text()
    head, _, tail = text.partition("*ELEMENT")
    lines = [f"{row[0]:.0f}, {1e3 * row[1]}, {1e3 * row[2]}, {1e3 * row[3]}" for row in table]
    (tmp_path / "brick.inp").write_text("*NODE\n" + "\n".join(lines) + "\n*ELEMENT" + tail)
    scaled = jo.parts.read_matrices(tmp_path / "brick.sti", units="mm-t-s")
    assert_allclose(scaled.nodes, table[:, 1:], rtol=1e-15)
    assert_allclose(full(scaled.M), 1e3 * full(part.M), rtol=1e-12)


def test_directions_of_a_substructure_differ_between_nodes(tmp_path: Path) -> None:
    from jousto.parts.matrices.abaqus import read_substructure

    dofs = np.array([(5, 1), (5, 2), (5, 3), (2, 1), (2, 2), (2, 3), (2, 6), (9, 3)])
    A = np.arange(64.0).reshape(8, 8)
    write_user_element(tmp_path / "sub.mtx", dofs, stiffness=A + A.T)
    K, M, found = read_substructure(tmp_path / "sub.mtx")
    assert K is not None and M is None
    assert_array_equal(found, dofs)
    assert_array_equal(full(K), A + A.T)


def test_user_element_that_calculix_wrote() -> None:
    # *SUBSTRUCTURE MATRIX OUTPUT of CalculiX 2.20 with nodes 10, 40 and 120 of the brick retained;
    # that version writes the retained rows without condensing the others (a node for each row)
    from jousto.parts.matrices.abaqus import read_substructure

    K, M, dofs = read_substructure(FILES / "substructure.mtx")
    assert K is not None and M is None
    assert_array_equal(dofs, [(n, c) for n in (10, 40, 120) for c in (1, 2, 3)])
    part = Part.from_file(FILES / "brick.sti")
    rows = [3 * part.node(f"n{n}") + c - 1 for n, c in dofs]
    scale = np.abs(full(part.K)).max()
    assert_allclose(full(K), full(part.K)[np.ix_(rows, rows)], atol=1e-12 * scale)
    with pytest.raises(InputError, match="substructure.mtx: contains no mass; write it with"):
        Part.from_file(FILES / "substructure.mtx")
