"""Parts of type matrices in model files: files of other programs, superelements, mistakes."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from numpy.testing import assert_allclose

import jousto as jo
from jousto.base.errors import InputError
from jousto.materials.material import Material
from jousto.parts.part import Part
from jousto.schema.read import read_part, read_part_file
from jousto.sections.section import Circle
from parts.matrix_files import full, write_abaqus, write_calculix, write_user_element

FILES = Path(__file__).parent.parent / "parts" / "files"
ROD = Part.frame(
    [(0.0, 0.0, 0.0), (0.4, 0.0, 0.0), (0.4, 0.5, 0.1)],
    [(0, 1), (1, 2)],
    sections=Circle(0.03),
    materials=Material(E=210e9, nu=0.3, rho=7850.0),
)
DOFS = np.array([(n, c) for n in (3, 11, 27) for c in range(1, 7)])
TABLE = np.column_stack([[3, 11, 27], ROD.nodes])
MODES = jo.reduce(ROD, jo.FreeFree(modes=4))


def write(folder: Path, text: str) -> Path:
    path = folder / "rod.yaml"
    path.write_text(text)
    np.savetxt(folder / "nodes.txt", TABLE)
    return path


def test_files_beside_the_stiffness(tmp_path: Path) -> None:
    for suffix in (".sti", ".mas", ".dof", ".inp"):
        shutil.copy(FILES / f"brick{suffix}", tmp_path)
    path = write(
        tmp_path,
        "type: matrices\nK: brick.sti\nnode_sets: {right: [30, 60, 90, 120]}\n"
        "reduce: {type: craig-bampton, interfaces: [LEFT, right], modes: 2}\n",
    )
    file = read_part_file(path, reduce=False)
    assert file.part.mass == pytest.approx(78.5, rel=1e-12)
    assert file.part.node_sets["right"] == (2, 5, 8, 11)


def test_surfaces_that_follow_a_node(tmp_path: Path) -> None:
    for suffix in (".sti", ".mas", ".dof", ".inp"):
        shutil.copy(FILES / f"brick{suffix}", tmp_path)
    text = (
        "type: matrices\nK: brick.sti\nnode_sets: {right: [30, 60, 90, 120]}\n"
        "interfaces: [{name: foot, nodes: LEFT}, {name: end, nodes: right, at: [1, 0.05, 0.05]}]\n"
        "reduce: {type: craig-bampton, interfaces: [foot, end], modes: 0}\n"
    )
    reduced = read_part(write(tmp_path, text))
    assert len(reduced.nodes) == 14 and reduced.n == 12 - 6
    assert_allclose(reduced.nodes[reduced.node("end")], [1.0, 0.05, 0.05])
    assert reduced.rotation(reduced.node("end")) is not None
    with pytest.raises(InputError, match="no node set 'left'; did you mean 'LEFT'"):
        read_part(write(tmp_path, text.replace("nodes: LEFT", "nodes: left")))


@pytest.mark.parametrize("kind", ["calculix", "abaqus", "substructure", "plain with a map"])
def test_formats(tmp_path: Path, kind: str) -> None:
    if kind == "calculix":
        write_calculix(tmp_path / "rod.sti", ROD.K)
        write_calculix(tmp_path / "rod.mas", ROD.M)
        (tmp_path / "rod.dof").write_text("".join(f"{n}.{c}\n" for n, c in DOFS))
        files = "K: rod.sti"
    elif kind == "abaqus":
        write_abaqus(tmp_path / "rod_STIF1.mtx", ROD.K, DOFS)
        write_abaqus(tmp_path / "rod_MASS1.mtx", ROD.M, DOFS)
        files = "K: rod_STIF1.mtx\nM: rod_MASS1.mtx"
    elif kind == "substructure":
        write_user_element(tmp_path / "rod.mtx", DOFS, stiffness=ROD.K, mass=ROD.M)
        files = "K: rod.mtx"
    else:
        scipy.io.mmwrite(tmp_path / "k.mtx", ROD.K, precision=17)
        scipy.io.mmwrite(tmp_path / "m.mtx", ROD.M, precision=17)
        np.savetxt(tmp_path / "rows.txt", DOFS, fmt="%d")
        files = "K: k.mtx\nM: m.mtx\ndofs: rows.txt"
    path = write(
        tmp_path,
        f"type: matrices\n{files}\nnodes: nodes.txt\nnode_sets: {{tip: [27]}}\n"
        "reduce: {type: free-free, modes: 4}\n",
    )
    reduced = read_part(path)
    assert_allclose(reduced.frequencies, MODES.frequencies, rtol=1e-8)
    assert reduced.node("tip") == 2


def test_units_of_the_files(tmp_path: Path) -> None:
    # N, mm, t: translations per mm, masses per t
    s = np.where(DOFS[:, 1] <= 3, 1e-3, 1.0)
    np.save(tmp_path / "k.npy", full(ROD.K) * np.outer(s, s) * 1e3)
    np.save(tmp_path / "m.npy", full(ROD.M) * np.outer(s, s) * 1e3)
    np.savetxt(tmp_path / "mm.csv", 1e3 * ROD.nodes, delimiter=",")
    text = (
        "type: matrices\nK: k.npy\nM: m.npy\nnodes: mm.csv\nunits: mm-t-s\n"
        "reduce: {type: free-free, modes: 4}\n"
    )
    reduced = read_part(write(tmp_path, text))
    assert_allclose(reduced.frequencies, MODES.frequencies, rtol=1e-9)
    assert reduced.invariants.mass == pytest.approx(ROD.mass, rel=1e-12)
    with pytest.raises(InputError, match="rod.yaml:5: units: units is 'mm', must be"):
        read_part(write(tmp_path, text.replace("mm-t-s", "mm")))


def test_superelement(tmp_path: Path) -> None:
    write_user_element(tmp_path / "rod.mtx", DOFS, stiffness=ROD.K, mass=ROD.M)
    text = (
        "type: matrices\nK: rod.mtx\nnodes: nodes.txt\nnode_sets: {tip: [27]}\n"
        "reduce: {type: superelement, modes: 4}\n"
    )
    path = write(tmp_path, text)
    reduced = read_part(path)
    assert_allclose(reduced.frequencies, MODES.frequencies, rtol=1e-8)
    assert reduced.node("tip") == 2
    file = read_part_file(path)
    assert file.part is None and file.reduced.n == 4
    with pytest.raises(InputError, match="rod.yaml:5: reduce.modes: .*99 modes are requested"):
        read_part(write(tmp_path, text.replace("modes: 4", "modes: 99")))


MISTAKES = (
    ("K: no.sti", "rod.yaml:1: .*no such file '.*no.sti'"),
    ("K: k.npy\nM: m.npy", "rod.yaml:1: nodes is missing"),
    ("K: k.npy\nM: m.npy\nnodes: nodes.txt\nformat: nastran", "rod.yaml:5: format: .*'nastran'"),
    (
        "K: k.npy\nM: m.npy\nnodes: nodes.txt\nunits: SI\ndofs_per_node: 6",
        "rod.yaml:6: dofs_per_node: is for plain matrices node after node",
    ),
    (
        "K: k.npy\nM: m.npy\nnodes: nodes.txt\nunits: SI\nnode_sets: {tip: [28]}",
        "rod.yaml:6: node_sets.*tip.* names node 28",
    ),
)


@pytest.mark.parametrize(("lines", "message"), MISTAKES)
def test_mistakes_have_their_line(tmp_path: Path, lines: str, message: str) -> None:
    np.save(tmp_path / "k.npy", full(ROD.K))
    np.save(tmp_path / "m.npy", full(ROD.M))
    text = f"type: matrices\n{lines}\nreduce: {{type: free-free, modes: 1}}\n"
    with pytest.raises(InputError, match=message):
        read_part(write(tmp_path, text))
