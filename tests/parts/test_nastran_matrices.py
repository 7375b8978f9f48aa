"""Nastran's OP4 and DMIG: round trips with pyyeti, and superelements that NX Nastran wrote."""

from __future__ import annotations

import subprocess
import sys
import warnings
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from numpy.testing import assert_allclose

import jousto as jo
from jousto.base.errors import InputError
from jousto.materials.material import Material
from jousto.parts.part import Part
from jousto.sections.section import Circle
from parts.matrix_files import full

with warnings.catch_warnings(), np.printoptions():
    warnings.simplefilter("ignore")
    nastran = pytest.importorskip("pyyeti.nastran")

ROD = Part.frame(
    [(0.0, 0.0, 0.0), (0.4, 0.0, 0.0), (0.4, 0.5, 0.1)],
    [(0, 1), (1, 2)],
    sections=Circle(0.03),
    materials=Material(E=210e9, nu=0.3, rho=7850.0),
)
GRIDS = "GRID,3,,0.,0.,0.\nGRID,11,,0.4,0.,0.\nGRID,27,,0.4,0.5,0.1\n"
DOFS = np.array([(n, c) for n in (3, 11, 27) for c in range(1, 7)])


def outboard() -> Path:
    """Return an external superelement of NX Nastran 9 that pyyeti ships with its tests."""
    spec = find_spec("pyyeti")
    assert spec is not None and spec.origin is not None
    path = Path(spec.origin).parent / "tests" / "nas2cam_extseout" / "outboard.op4"
    if not path.is_file():
        pytest.skip("this pyyeti comes without its test files")
    return path


def write_op4(path: Path, **matrices: object) -> None:
    nastran.op4.write(str(path), {name: full(m) for name, m in matrices.items()})


@pytest.mark.parametrize("names", [("KAA", "MAA"), ("KGG", "MGG")])
def test_op4(tmp_path: Path, names: tuple[str, str]) -> None:
    write_op4(tmp_path / "rod.op4", **dict(zip(names, (ROD.K, ROD.M), strict=True)))
    (tmp_path / "rod.bdf").write_text(GRIDS)
    part = Part.from_file(tmp_path / "rod.op4")
    assert_allclose(full(part.K), full(ROD.K), rtol=1e-15)
    assert_allclose(full(part.M), full(ROD.M), rtol=1e-15)
    assert_allclose(part.nodes, ROD.nodes, atol=1e-15)
    assert part.node("n27") == 2


def write_dmig(path: Path, K: np.ndarray, M: np.ndarray, grids: str = GRIDS) -> None:
    import pandas as pd

    index = pd.MultiIndex.from_tuples([tuple(row) for row in DOFS.tolist()], names=["id", "dof"])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        frames = {"KAAX": (K, index), "MAAX": (M, index)}
        nastran.wtdmig(
            str(path), {k: pd.DataFrame(A, index=i, columns=i) for k, (A, i) in frames.items()}
        )
    path.write_text(grids + path.read_text())


def test_dmig(tmp_path: Path) -> None:
    write_dmig(tmp_path / "rod.pch", full(ROD.K), full(ROD.M))
    part = Part.from_file(tmp_path / "rod.pch")
    # ten digits in the fields of a DMIG card
    scale = np.abs(full(ROD.K)).max()
    assert_allclose(full(part.K), full(ROD.K), rtol=1e-8, atol=1e-9 * scale)
    assert_allclose(part.inertia, ROD.inertia, rtol=1e-7, atol=1e-9)


def test_displacements_in_axes_of_a_grid(tmp_path: Path) -> None:
    # grid 11 moves in a system turned by 90 degrees about z: its x is the basic y
    turn = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    B = np.eye(18)
    B[6:9, 6:9] = B[9:12, 9:12] = turn.T
    K, M = B.T @ full(ROD.K) @ B, B.T @ full(ROD.M) @ B
    grids = GRIDS.replace("GRID,11,,0.4,0.,0.", "GRID,11,,0.4,0.,0.,5")
    grids += "CORD2R,5,,0.,0.,0.,0.,0.,1.\n,0.,1.,0.\n"
    write_op4(tmp_path / "rod.op4", KAA=K, MAA=M)
    (tmp_path / "rod.bdf").write_text(grids)
    part = Part.from_file(tmp_path / "rod.op4")
    assert_allclose(full(part.K), full(ROD.K), rtol=1e-12, atol=1e-6)


def test_damaged_files(tmp_path: Path) -> None:
    path = tmp_path / "rod.op4"
    write_op4(path, KAA=ROD.K, MAA=ROD.M)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    with pytest.raises(
        InputError, match="rod.op4: (is not an OP4 file, or it is truncated|contains no)"
    ):
        jo.parts.read_matrices(path, nodes=ROD.nodes)
    path.write_text("solid brick\n")
    with pytest.raises(InputError, match="rod.op4: (is not an OP4 file|holds no matrix)"):
        jo.parts.read_matrices(path, nodes=ROD.nodes)
    write_op4(path, KAA=ROD.K, PHI=ROD.M)
    with pytest.raises(InputError, match="contains no matrix M .* it has KAA, PHI"):
        jo.parts.read_matrices(path, nodes=ROD.nodes)
    write_op4(path, KAA=ROD.K, MAA=ROD.M)
    (tmp_path / "rod.bdf").write_text(GRIDS[: GRIDS.index("GRID,27")])
    with pytest.raises(InputError, match="has 18 rows but rod.bdf has 12"):
        jo.parts.read_matrices(path)
    with pytest.raises(InputError, match="leave out M"):
        jo.parts.read_matrices(path, path)
    (tmp_path / "mesh.pch").write_text(GRIDS)
    with pytest.raises(InputError, match="mesh.pch: contains no DMIG entries"):
        jo.parts.read_matrices(tmp_path / "mesh.pch")


def test_superelement_of_nastran() -> None:
    # 4 grids in inches or mm (the sources do not say), one with axes of its own, and 22 modes
    matrices = jo.parts.read_matrices(outboard())
    assert len(matrices.modal) == 22 and list(matrices.node_ids) == [3, 11, 19, 27]
    # Nastran's list of the fixed-interface modes (outboard.out, CYCLES)
    q = matrices.modal
    f = np.sqrt(matrices.K.diagonal()[q] / matrices.M.diagonal()[q]) / (2.0 * np.pi)
    printed = [1.650001, 1.650249, 1.674265, 1.674687, 7.025350, 7.025411, 10.91274, 10.91454]
    assert_allclose(f[:8], printed, rtol=1e-6)
    with pytest.raises(InputError, match="22 of its rows are modal coordinates.*reduce_superel"):
        Part.from_file(outboard())

    reduced = jo.reduction.reduce_superelement(matrices)
    # the elastic free-free modes are those of K x = w^2 M x
    values = scipy.linalg.eigh(full(matrices.K), full(matrices.M), eigvals_only=True)
    free = np.sqrt(values[6:]) / (2.0 * np.pi)
    assert_allclose(reduced.frequencies, free[: reduced.n], rtol=1e-8)
    assert reduced.n == 40 and reduced.interfaces == ("n3", "n11", "n19", "n27")
    # mass, centre and inertia as Nastran prints them (outboard.out, grid point weight generator)
    inv = reduced.invariants
    assert inv.mass == pytest.approx(1.590384, rel=1e-6)
    centre = inv.I2 / inv.mass
    assert_allclose(centre, [184.6398, 150.0, 150.0], rtol=1e-6)
    J = inv.I7 - inv.mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    # (Nastran prints products of inertia with the other sign)
    printed_J = np.diag([3.569328e5, 4.515897e4, 3.763282e5])
    printed_J[1, 2] = printed_J[2, 1] = -1.095583e2
    assert_allclose(J, printed_J, rtol=1e-6, atol=0.01)


def test_reading_leaves_numpy_as_it_is(tmp_path: Path) -> None:
    # in a fresh process: importing the package would change how numpy prints
    write_op4(tmp_path / "rod.op4", KAA=ROD.K, MAA=ROD.M)
    code = (
        "import sys, numpy as np, jousto as jo; x = np.array([0.3, 0.0]);"
        "jo.parts.read_matrices(sys.argv[1], nodes=[[0, 0, 0], [0.4, 0, 0], [0.4, 0.5, 0.1]]);"
        "print(x)"
    )
    command = [sys.executable, "-c", code, tmp_path / "rod.op4"]
    assert subprocess.check_output(command, text=True).strip() == "[0.3 0. ]"


def test_superelement_with_some_directions_of_its_grids() -> None:
    # the same superelement type, with a boundary that keeps only some directions
    path = outboard().with_name("reduced_bset_notall6.op4")
    matrices = jo.parts.read_matrices(path)
    assert len(matrices.dofs) == 29 and len(matrices.modal) == 10
    per_grid = [int(np.sum(matrices.dofs[:, 0] == grid)) for grid in matrices.node_ids]
    assert sum(per_grid) == 19 and min(per_grid) < 6
    values = scipy.linalg.eigh(full(matrices.K), full(matrices.M), eigvals_only=True)
    assert np.all(np.abs(values[:6]) < 1e-6 * values[6])
    with pytest.warns(jo.JoustoWarning, match="1 node without all translations"):
        reduced = jo.reduction.reduce_superelement(matrices)
    assert_allclose(reduced.frequencies, np.sqrt(values[6:]) / (2.0 * np.pi), rtol=1e-7)
