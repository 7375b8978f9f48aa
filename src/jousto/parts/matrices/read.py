"""`read_matrices`: choice of the reader, search for other files, units, and plausibility."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array, Ints, Sparse, as_csr
from jousto.base.errors import InputError, MissingFileError, Problem, suggest, warn
from jousto.base.files import check_input
from jousto.parts.matrices import abaqus, ansys, calculix, nastran, plain
from jousto.parts.matrices.matrices import Matrices
from jousto.parts.matrices.nodes import Positions, read_positions
from jousto.parts.matrices.text import diagonal, expanded, read_numbers, read_text, refuse
from jousto.parts.matrices.units import Units

FORMATS = {
    "calculix": (".sti", ".mas"),
    "ansys": (".full",),
    "op4": (".op4",),
    "dmig": (".pch", ".dmig", ".bdf", ".nas", ".dat"),
    "abaqus": (".mtx",),
    "plain": plain.SUFFIXES,
}
"""Names of the formats and the endings of their files."""


@dataclass(frozen=True, eq=False)
class Raw:
    """Content of the files in their own units; None for missing data."""

    K: Sparse
    M: Sparse
    dofs: Ints | None = None
    positions: Positions | None = None
    held: Ints | None = None
    axes: dict[int, Array] | None = None


@explained
def read_matrices(
    K: str | Path,
    M: str | Path | None = None,
    *,
    nodes: Any = None,
    dofs: Any = None,
    format: str | None = None,
    units: str = "SI",
    name: str | None = None,
) -> Matrices:
    """Read mass and stiffness matrices written by another program.

    Parameters
    ----------
    K : str or Path
        File of the stiffness matrix, or of both: .sti (CalculiX), .full (Ansys), .op4 or .pch
        (Nastran), .mtx (Abaqus or Matrix Market), .npz, .npy, .hb or .rsa.
    M : str or Path, optional
        File of the mass matrix if it is a separate file; for CalculiX it is found beside the .sti
        file.
    nodes : Mesh, str, Path or array_like, optional
        Positions: a mesh (in m) or mesh file of the same model, a table with the columns x y z in
        the order of the rows, or with the node number before them. With None the positions are
        searched in files beside the matrices of CalculiX (.inp), Ansys (.rst) and Nastran (.pch,
        .bdf).
    dofs : (ndof, 2) array_like, str or Path, optional
        Node number and direction (1..6, 0 for a modal coordinate) of each row, as an array, a text
        file of such lines or a .dof file. With None the map in the files is used or, without one,
        the order node by node with 3 or 6 directions.
    format : str, optional
        ``calculix``, ``ansys``, ``op4``, ``dmig``, ``abaqus`` or ``plain``; from the ending and
        the content if not given.
    units : str
        Units of the files as length-mass-time: ``"SI"``, ``"mm-t-s"``, ``"in-lbf-s"`` ...
    name : str, optional
        Name in messages; None for the name of the file.

    Returns
    -------
    Matrices
        Matrices in SI units. Formats with one triangle are completed to the full matrix.

    Raises
    ------
    InputError
        If a file is missing, truncated or of another kind, files are inconsistent, or a name is
        unknown.

    Warns
    -----
    JoustoWarning
        If the speed of sound in the part is beyond that of any material: the units are probably
        wrong.
    """
    path = Path(K)
    mass = None if M is None else Path(M)
    for file in (path, *([mass] if mass else [])):
        check_input(file)
    system = Units.read(units)
    given_dofs = None if dofs is None else read_dofs(dofs)
    raw = _reader(path, format)(path, mass, system.unit if nodes is None else None)
    positions = raw.positions if nodes is None else read_positions(nodes, system.unit)
    if positions is None:
        raise refuse(path, "nodes are missing: give their positions, or a mesh of the same model")
    where = f"matrices '{name or path.stem}'"
    map_of, positions = _number(raw, given_dofs, positions, where)

    # displacements in basic axes, then SI units
    stiff, mass_matrix = raw.K, raw.M
    if raw.axes:
        stiff = nastran.to_basic(stiff, map_of, raw.axes, where)
        mass_matrix = nastran.to_basic(mass_matrix, map_of, raw.axes, where)
    held = np.zeros((0, 2), dtype=np.int64) if raw.held is None else raw.held
    if raw.held is None and stiff.shape == mass_matrix.shape == (len(map_of), len(map_of)):
        stiff, mass_matrix, held = abaqus.take_out_held(stiff, mass_matrix, map_of)
    assert positions.ids is not None
    matrices = Matrices(
        name=name or path.stem,
        K=stiff,
        M=mass_matrix,
        dofs=map_of,
        node_ids=positions.ids,
        nodes=positions.xyz * (1.0 if positions.metres else system.length),
        node_sets=positions.node_sets,
        elements=positions.elements,
        held=held,
    )
    s, m, k = system.factors(map_of[:, 1])
    S = diagonal(s)
    matrices = replace(matrices, K=as_csr(S @ matrices.K @ S * k), M=as_csr(S @ matrices.M @ S * m))
    _plausible(matrices, where, units)
    return matrices


def read_dofs(dofs: Any) -> Ints:
    """Return the map of rows (ndof, 2) from an array or a file.

    Raises
    ------
    InputError
        If the file does not exist, or its lines do not contain node and direction.
    """
    if isinstance(dofs, (str, Path)):
        path = Path(dofs)
        text = read_text(path)
        if path.suffix.lower() == ".dof" or len(text.partition("\n")[0].split()) == 1:
            return calculix.read_dofs(path)
        table = read_numbers(path, text, 2, "node direction")
    else:
        table = np.asarray(dofs)
    if table.ndim != 2 or table.shape[1] != 2 or np.any(table != np.round(table)):
        message = f"dofs has shape {table.shape}, must be whole numbers (rows, 2): node, direction"
        raise InputError(Problem("", message))
    return np.asarray(table, dtype=np.int64)


# signature of a reader: (files, unit of length of the nodes or None if they are given)
def _reader(path: Path, format: str | None) -> Callable[[Path, Path | None, str | None], Raw]:
    """Return the reader of a format; without a format, the reader that fits the file."""
    readers = {
        "calculix": _calculix,
        "ansys": _ansys,
        "op4": _op4,
        "dmig": _dmig,
        "abaqus": _abaqus,
        "plain": _plain,
    }
    if format is not None:
        if format not in readers:
            raise InputError(
                Problem("", f"format is {format!r}{suggest(format, readers)}", path=("format",))
            )
        return readers[format]
    if not path.is_file():
        raise MissingFileError(Problem("", f"no such file {str(path)!r}"))
    suffix = path.suffix.lower()
    if suffix == ".mtx" and abaqus.is_matrix_market(path):
        return _plain
    for known, suffixes in FORMATS.items():
        if suffix in suffixes:
            return readers[known]
    endings = ", ".join(dict.fromkeys(s for suffixes in FORMATS.values() for s in suffixes))
    raise refuse(path, f"has an unknown ending; known endings are {endings}, or give format=")


def _beside(path: Path, suffixes: tuple[str, ...]) -> Path | None:
    candidates = [path.with_suffix(s) for s in suffixes]
    return next((p for p in candidates if p.is_file() and p != path), None)


def _calculix(path: Path, mass: Path | None, unit: str | None) -> Raw:
    mass = mass or path.with_suffix(".mas")
    dofs = calculix.read_dofs(path.with_suffix(".dof"))
    beside = _beside(path, (".inp",)) if unit else None
    return Raw(
        calculix.read_triangle(path, len(dofs)),
        calculix.read_triangle(mass, len(dofs)),
        dofs,
        None if beside is None or unit is None else read_positions(beside, unit),
    )


def _ansys(path: Path, mass: Path | None, unit: str | None) -> Raw:
    if mass is not None:
        raise refuse(path, f"contains K and M; leave out M ({mass.name})")
    K, M, dofs, held = ansys.read_full(path)
    positions = None
    if unit and (beside := _beside(path, (".rst", ".cdb"))) is not None:
        rst = beside.suffix == ".rst"
        positions = ansys.read_result_nodes(beside) if rst else read_positions(beside, unit)
    return Raw(K, M, dofs, positions, held)


def _op4(path: Path, mass: Path | None, unit: str | None) -> Raw:
    if mass is not None:
        raise refuse(path, f"must contain K and M; leave out M ({mass.name})")
    K, M = nastran.read_op4(path)
    beside = _beside(path, nastran.BULK) if unit else None
    if beside is None:
        return Raw(K, M)
    positions, dofs, axes = nastran.read_grids(beside)
    if len(dofs) != K.shape[0]:
        raise refuse(
            path,
            f"has {K.shape[0]} rows but {beside.name} has {len(dofs)}: give the map of the rows"
            " as dofs, and the nodes",
        )
    return Raw(K, M, dofs, positions, axes=axes)


def _dmig(path: Path, mass: Path | None, unit: str | None) -> Raw:
    if mass is not None:
        raise refuse(path, f"must contain K and M; leave out M ({mass.name})")
    K, M, dofs = nastran.read_dmig(path)
    if not unit:
        return Raw(K, M, dofs)
    own = "GRID" in read_text(path).upper()
    source = path if own else _beside(path, nastran.BULK)
    if source is None:
        return Raw(K, M, dofs)
    positions, _, axes = nastran.read_grids(source)
    return Raw(K, M, dofs, positions, axes=axes)


def _abaqus(path: Path, mass: Path | None, unit: str | None) -> Raw:
    if not path.is_file():
        raise MissingFileError(Problem("", f"no such file {str(path)!r}"))
    if abaqus.is_substructure(path):
        K, M, dofs = abaqus.read_substructure(path)
        if mass is not None:
            M = abaqus.read_substructure(mass)[1]
        if K is None or M is None:
            lacks = "stiffness" if K is None else "mass"
            raise refuse(
                path,
                f"contains no {lacks}; write it with *SUBSTRUCTURE MATRIX OUTPUT, STIFFNESS, MASS",
            )
        return Raw(K, M, dofs)
    if mass is None:
        raise refuse(path, "holds one matrix: give the file of the mass matrix as M, too")
    K, rows = abaqus.read_global(path)
    M, rows_of_mass = abaqus.read_global(mass)
    if rows is None or rows_of_mass is None:
        return Raw(K, M)
    both = np.unique(np.concatenate([rows, rows_of_mass]), axis=0)
    return Raw(expanded(K, rows, both), expanded(M, rows_of_mass, both), both)


def _plain(path: Path, mass: Path | None, unit: str | None) -> Raw:
    if mass is None and plain.is_pair(path):
        data = plain.read_pair(path)
        positions = None
        if unit and "nodes" in data:
            positions = read_positions(data["nodes"], unit)
        dofs = read_dofs(data["dofs"]) if "dofs" in data else None
        return Raw(as_csr(data["K"]), as_csr(data["M"]), dofs, positions)
    if mass is None:
        raise refuse(path, "holds one matrix: give the file of the mass matrix as M, too")
    return Raw(plain.read_plain(path), plain.read_plain(mass))


def _number(
    raw: Raw, given: Ints | None, positions: Positions, where: str
) -> tuple[Ints, Positions]:
    """Return the map of the rows, and the positions with node numbers."""
    dofs = raw.dofs if given is None else given
    nn, rows = len(positions.xyz), raw.K.shape[0]
    if dofs is None:
        # order node by node
        each = rows // nn if nn else 0
        if each not in (3, 6) or each * nn != rows:
            raise InputError(
                Problem(
                    where,
                    f"{rows} rows do not fit {nn} nodes with 3 or 6 directions each; give the map"
                    " of the rows as dofs",
                )
            )
        ids = np.arange(1, nn + 1) if positions.ids is None else np.sort(positions.ids)
        directions = np.tile(np.arange(1, each + 1), nn)
        dofs = np.stack([np.repeat(ids, each), directions], axis=1)
    if positions.ids is None:
        ids = np.unique(dofs[dofs[:, 1] > 0, 0])
        if len(ids) != nn:
            raise InputError(
                Problem(
                    where,
                    f"the rows have {len(ids)} nodes but there are {nn} positions: give tables with"
                    " the number of the node in a first column, or a mesh",
                )
            )
        positions = replace(positions, ids=ids)
    return dofs, positions


def _plausible(matrices: Matrices, where: str, units: str) -> None:
    """Warn if the speed of sound in the part is beyond that of any material.

    Each pair of connected nodes gives ``c = l sqrt(k/m)`` with their distance l and the mean of
    the nodal stiffness and mass; solids and beams give one to six times the speed of sound.
    """
    xyz = matrices.nodes
    translations = np.flatnonzero((matrices.dofs[:, 1] >= 1) & (matrices.dofs[:, 1] <= 3))
    if len(translations) < 6 or np.any(matrices.dofs[:, 1] == 0):
        return
    place = {int(number): i for i, number in enumerate(matrices.node_ids)}
    node = np.array([place[int(i)] for i in matrices.dofs[translations, 0]])
    k, m = np.zeros(len(xyz)), np.zeros(len(xyz))
    np.add.at(k, node, matrices.K.diagonal()[translations])
    np.add.at(m, node, matrices.M.diagonal()[translations])
    coo = matrices.K.tocoo()
    of_row = np.full(len(matrices.dofs), -1)
    of_row[translations] = node
    i, j = of_row[coo.row], of_row[coo.col]
    pairs = (i >= 0) & (j >= 0) & (i != j)
    length = np.full(len(xyz), np.inf)
    np.minimum.at(length, i[pairs], np.linalg.norm(xyz[i[pairs]] - xyz[j[pairs]], axis=1))
    good = np.isfinite(length) & (k > 0.0) & (m > 0.0)
    if not np.any(good):
        return
    c = float(np.median(length[good] * np.sqrt(k[good] / m[good])))
    if 3.0 < c < 7e4:
        return
    warn(
        where,
        f"the speed of sound in this part would be about {c:.2g} m/s (steel: 5000 m/s); its units "
        f"are probably not {units}. Models in mm with forces in N need units='mm-t-s'",
    )
