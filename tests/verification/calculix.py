"""CalculiX (ccx) as a second opinion: write a deck, run it, read what it found.

G. Dhondt and K. Wittig, CalculiX, a free three-dimensional structural finite element program. The
deck holds the nodes with all digits that ccx reads, so that both programs solve one problem.
"""

from __future__ import annotations

import os
import re
import subprocess
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from verification.calculix_kept import OF_MATRICES, PROGRAM, answer

LIMIT = 120.0
"""Seconds after which ccx is stopped."""

needed = pytest.mark.skipif(PROGRAM is None, reason="CalculiX (ccx) is not installed")

TYPES = {
    "tetra": "C3D4",
    "tetra10": "C3D10",
    "wedge": "C3D6",
    "wedge15": "C3D15",
    "hexahedron": "C3D8",
    "hexahedron20": "C3D20",
}
FACES = {  # corners of the faces P1, P2, ...
    4: ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    6: ((0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    8: (
        (0, 1, 2, 3),
        (4, 7, 6, 5),
        (0, 4, 5, 1),
        (1, 5, 6, 2),
        (2, 6, 7, 3),
        (3, 7, 4, 0),
    ),
}
CORNERS = {4: 4, 10: 4, 6: 6, 15: 6, 8: 8, 20: 8}


@dataclass(frozen=True)
class Deck:
    """What ccx is asked to compute: a mesh, one material, held nodes.

    Parameters
    ----------
    mesh : Mesh or Grid
        With ``nodes`` (nn, 3) in m and ``cells``, each of a ``kind`` and with ``nodes`` (ne, k).
    material : Material
        E, nu, rho.
    fixed : sequence of int
        Nodes, from 0, whose three displacements are zero.
    types : mapping of str to str
        ccx's element for a kind, where it is not that of `TYPES`.
    """

    mesh: Any
    material: Any
    fixed: Sequence[int] = ()
    types: dict[str, str] = field(default_factory=dict)

    def head(self) -> list[str]:
        lines = ["*NODE, NSET=NALL"]
        for number, (x, y, z) in enumerate(self.mesh.nodes, 1):
            lines.append(f"{number}, {x:.12e}, {y:.12e}, {z:.12e}")
        first = 1
        for cells in self.mesh.cells:
            lines.append(f"*ELEMENT, TYPE={(TYPES | self.types)[cells.kind]}, ELSET=EALL")
            for number, nodes in enumerate(np.asarray(cells.nodes) + 1, first):
                words = [str(n) for n in (number, *nodes)]
                # at most 16 entries a line
                for start in range(0, len(words), 14):
                    more = "," if start + 14 < len(words) else ""
                    lines.append(", ".join(words[start : start + 14]) + more)
            first += len(cells.nodes)
        lines += self._properties()
        if len(self.fixed):
            lines += ["*BOUNDARY"] + [f"{n + 1}, 1, 3" for n in self.fixed]
        return lines

    def _properties(self) -> list[str]:
        m = self.material
        section = "*SOLID SECTION, ELSET=EALL, MATERIAL=M"
        lines = ["*MATERIAL, NAME=M"]
        if hasattr(m, "axes"):
            names = ("E1", "E2", "E3", "nu12", "nu13", "nu23", "G12", "G13", "G23")
            words = [f"{getattr(m, name):.12e}" for name in names]
            lines += ["*ELASTIC, TYPE=ENGINEERING CONSTANTS", ", ".join(words[:8]) + ",", words[8]]
            # two points on the axes 1 and 2
            points = ", ".join(f"{x:.12e}" for x in (*m.axes[:, 0], *m.axes[:, 1]))
            lines += ["*DENSITY", f"{m.rho:.12e}", "*ORIENTATION, NAME=AXES", points]
            return [*lines, f"{section}, ORIENTATION=AXES"]
        lines += ["*ELASTIC", f"{m.E:.12e}, {m.nu:.12e}", "*DENSITY", f"{m.rho:.12e}"]
        return [*lines, section]


def frequencies(deck: Deck, number: int = 10, *, kept: bool = True) -> np.ndarray:
    """Return the lowest natural frequencies in Hz, without those of rigid motion.

    ccx prints eight digits. A deck whose mesh depends on the version of Gmsh is not kept.
    """
    rigid = 0 if len(deck.fixed) else 6
    lines = [*deck.head(), "*STEP", "*FREQUENCY", str(number + rigid), "*END STEP"]
    # frequencies of rigid motion are round-off

    def compute() -> np.ndarray:
        return _frequencies(run(lines, ("dat",))["dat"])[rigid:]

    found = answer(lines, compute) if kept else compute()
    assert len(found) == number
    return found


def _frequencies(text: str) -> np.ndarray:
    table = text.split("E I G E N V A L U E   O U T P U T")[-1]
    rows = _numbered(table.split("P A R T I C I P A T I O N")[0])
    return np.array([float(row[3]) for row in rows])


def _numbered(table: str) -> list[list[str]]:
    """Return the words of the rows that begin with a number of a mode."""
    return [line.split() for line in table.splitlines() if re.match(r"\s+\d+\s+[-0-9.]+E", line)]


Forces = Iterable[tuple[int, Sequence[float]]]


def buckling(deck: Deck, forces: Forces, number: int) -> np.ndarray:
    """Return the lowest factors on nodal forces at which the part buckles."""
    steps = ["*STEP", "*BUCKLE", str(number), *_cload(forces), "*END STEP"]
    lines = deck.head() + steps

    def factors() -> np.ndarray:
        text = run(lines, ("dat",))["dat"]
        return np.array([float(row[1]) for row in _numbered(text.split("F A C T O R")[1])])

    return answer(lines, factors)


def loaded_frequencies(deck: Deck, forces: Forces, number: int) -> np.ndarray:
    """Return the lowest frequencies in Hz of the part deformed by constant nodal forces."""
    steps = ["*STEP, NLGEOM", "*STATIC", *_cload(forces), "*END STEP"]
    steps += ["*STEP, PERTURBATION", "*FREQUENCY", str(number), "*END STEP"]
    lines = deck.head() + steps
    return answer(lines, lambda: _frequencies(run(lines, ("dat",))["dat"]))


def spun_frequencies(deck: Deck, speed: float, axis: Sequence[float], number: int) -> np.ndarray:
    """Return the lowest frequencies in Hz of the part spun about an axis through the origin.

    Seen in the turning frame, without Coriolis forces.
    """
    words = ", ".join(f"{x:.12e}" for x in (speed**2, 0.0, 0.0, 0.0, *axis))
    steps = ["*STEP, NLGEOM", "*STATIC", "*DLOAD", f"EALL, CENTRIF, {words}", "*END STEP"]
    steps += ["*STEP, PERTURBATION", "*FREQUENCY", str(number), "*END STEP"]
    lines = deck.head() + steps
    return answer(lines, lambda: _frequencies(run(lines, ("dat",))["dat"]))


def _cload(forces: Forces) -> list[str]:
    rows = [
        f"{node + 1}, {direction + 1}, {value:.12e}"
        for node, force in forces
        for direction, value in enumerate(force)
        if value
    ]
    return ["*CLOAD", *rows] if rows else []


STORAGE = ["*STEP", "*FREQUENCY, SOLVER=MATRIXSTORAGE", "10", "*END STEP"]


def probes(A: sp.csr_array) -> np.ndarray:
    """Return numbers (23,) that tell a symmetric matrix from any other of its size.

    ``x_i^T A x_j`` of six vectors of random signs, in which every entry of A stands, the trace and
    the root of the sum of all squares.
    """
    X = np.random.default_rng(6).choice([-1.0, 1.0], (A.shape[0], 6))
    return np.array([*(X.T @ (A @ X))[np.triu_indices(6)], A.trace(), np.sqrt((A * A).sum())])


def matrix_probes(deck: Deck) -> tuple[np.ndarray, np.ndarray]:
    """Return the `probes` of the stiffness and the mass that ccx writes, or that are kept of it."""
    found = answer(
        deck.head() + STORAGE,
        lambda: np.concatenate([probes(A) for A in matrices(deck)]),
        digits=OF_MATRICES,
    )
    K, M = np.split(found, 2)
    return K, M


def assert_probed(A: sp.csr_array, theirs: np.ndarray, digits: float) -> None:
    """Assert that entries of A differ by `digits` of the largest from a matrix known by its probes.

    Differences of all entries add up with random signs: to the root of their number, of which
    four times allow for the largest of the probes.
    """
    allowed = 4.0 * digits * np.sqrt(A.nnz) * abs(A).max()
    np.testing.assert_allclose(probes(A), theirs, rtol=0.0, atol=allowed)


def matrices(deck: Deck) -> tuple[sp.csr_array, sp.csr_array]:
    """Return stiffness and mass (3 nn, 3 nn) of the free mesh, node after node, x, y, z."""
    assert not len(deck.fixed)
    out = run(deck.head() + STORAGE, ("dof", "sti", "mas"))
    places = []
    for line in out["dof"].split():
        node, direction = line.split(".")
        places.append(3 * (int(node) - 1) + int(direction) - 1)
    dofs = np.array(places)
    size = 3 * len(deck.mesh.nodes)

    def read(text: str) -> sp.csr_array:
        # one triangle: row, column, value
        table = np.array(text.split()).reshape(-1, 3)
        i, j = (dofs[table[:, c].astype(int) - 1] for c in (0, 1))
        value = table[:, 2].astype(float)
        off = i != j
        return sp.csr_array(
            (
                np.concatenate([value, value[off]]),
                (np.concatenate([i, j[off]]), np.concatenate([j, i[off]])),
            ),
            shape=(size, size),
        )

    return read(out["sti"]), read(out["mas"])


@dataclass(frozen=True)
class Static:
    """Nodal displacements (nn, 3) in m, nodal stresses (nn, 6) in Pa: xx yy zz xy yz zx."""

    u: np.ndarray
    stress: np.ndarray


def static(
    deck: Deck,
    *,
    forces: Forces = (),
    pressure: tuple[np.ndarray, float] | None = None,
    spin: tuple[float, Sequence[float], Sequence[float]] | None = None,
) -> Static:
    """Return the response to loads.

    Parameters
    ----------
    forces : iterable of (node, (3,) N)
    pressure : (nodes, Pa), optional
        On every element face all corners of which are among the nodes.
    spin : (rad/s, point, axis), optional
        Centrifugal load.
    """
    lines = deck.head() + ["*STEP", "*STATIC", *_cload(forces)]
    if pressure is not None:
        lines += ["*DLOAD", *_pressed(deck, *pressure)]
    if spin is not None:
        speed, point, axis = spin
        words = ", ".join(f"{x:.12e}" for x in (speed**2, *point, *axis))
        lines += ["*DLOAD", f"EALL, CENTRIF, {words}"]
    lines += ["*NODE PRINT, NSET=NALL", "U", "*NODE FILE", "U", "*EL FILE", "S", "*END STEP"]
    nn = len(deck.mesh.nodes)

    def both() -> np.ndarray:
        out = run(lines, ("dat", "frd"))
        stress = np.full((nn, 6), np.nan)
        block = out["frd"].split("STRESS")[1].split("\n -3")[0]
        for line in block.splitlines():
            if line.startswith(" -1"):
                columns = [line[13 + 12 * k : 25 + 12 * k] for k in range(6)]
                stress[int(line[3:13]) - 1] = [float(c) for c in columns]
        return np.hstack([displacements(out["dat"], nn), stress])

    return Static(*np.split(answer(lines, both), [3], axis=1))


def displacements(text: str, nn: int) -> np.ndarray:
    """Return the printed displacements (nn, 3) in m."""
    u = np.full((nn, 3), np.nan)
    for line in text.splitlines():
        words = line.split()
        if len(words) == 4 and words[0].isdigit():
            u[int(words[0]) - 1] = [float(w) for w in words[1:]]
    return u


def _pressed(deck: Deck, nodes: np.ndarray, value: float) -> list[str]:
    held = {int(n) for n in nodes}
    lines, first = [], 1
    for cells in deck.mesh.cells:
        array = np.asarray(cells.nodes)
        for number, face in enumerate(FACES[CORNERS[array.shape[1]]], 1):
            whole = np.all(np.isin(array[:, list(face)], list(held)), axis=1)
            lines += [f"{first + e}, P{number}, {value:.12e}" for e in np.flatnonzero(whole)]
        first += len(array)
    assert lines, "no element face lies among the nodes"
    return lines


def run(lines: Sequence[str], wanted: Sequence[str]) -> dict[str, str]:
    """Run a deck in a folder of its own and return the text of the wanted files.

    Raises
    ------
    RuntimeError
        ccx takes too long, fails or leaves out a file.
    """
    assert PROGRAM is not None
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "deck.inp").write_text("\n".join(lines) + "\n")
        try:
            done = subprocess.run(
                [PROGRAM, "-i", "deck"],
                cwd=folder,
                capture_output=True,
                text=True,
                timeout=LIMIT,
                env=os.environ | {"OMP_NUM_THREADS": "1"},
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise RuntimeError(f"ccx did not finish within {LIMIT:g} s") from None
        files = {suffix: Path(folder, f"deck.{suffix}") for suffix in wanted}
        missing = [str(path.name) for path in files.values() if not path.is_file()]
        if missing or "*ERROR" in done.stdout:
            tail = "\n".join(done.stdout.splitlines()[-15:])
            raise RuntimeError(f"ccx failed ({done.returncode}); missing {missing}:\n{tail}")
        return {suffix: path.read_text() for suffix, path in files.items()}
