"""Node order and face numbers are those of CalculiX: it presses on each face of each element."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.mesh.cells import SOLIDS, faces
from jousto.mesh.reference import places
from jousto.mesh.surface import face_normals

CCX = shutil.which("ccx") or ""
pytestmark = pytest.mark.skipif(not CCX, reason="CalculiX (ccx) is not installed")
TYPE = {
    "tetra": "C3D4",
    "tetra10": "C3D10",
    "hexahedron": "C3D8",
    "hexahedron20": "C3D20",
    "wedge": "C3D6",
    "wedge15": "C3D15",
}


@pytest.mark.filterwarnings("ignore:.*(type SPRING1|BOUNDARY .* ignored|DLOAD .* ignored)")
@pytest.mark.parametrize("kind", SOLIDS)
def test_forces_of_pressure_on_each_face(kind: str, tmp_path: Path) -> None:
    # an element that is stretched unequally, so that no two faces have the same normal and area
    stretch = np.array([[1.0, 0.2, 0.0], [0.0, 1.3, 0.1], [0.3, 0.0, 0.7]])
    nodes = places(kind) @ stretch
    sides = faces(kind)
    deck = ["*NODE, NSET=NALL"]
    deck += [f"{i}, {x[0]:.12e}, {x[1]:.12e}, {x[2]:.12e}" for i, x in enumerate(nodes, start=1)]
    deck += [f"*ELEMENT, TYPE={TYPE[kind]}, ELSET=EALL"]
    deck += [",\n".join(", ".join(map(str, row)) for row in _rows([1, *range(1, len(nodes) + 1)]))]
    deck += [f"*SURFACE, NAME=SIDE{i + 1}\n1, S{i + 1}" for i in range(len(sides))]
    deck += ["*MATERIAL, NAME=M\n*ELASTIC\n2.1E11, 0.3\n*SOLID SECTION, ELSET=EALL, MATERIAL=M"]
    # held by springs to the ground, so that the forces on the nodes add up to the load
    number = 2
    for dof in (1, 2, 3):
        deck += [f"*ELEMENT, TYPE=SPRING1, ELSET=SP{dof}"]
        deck += [f"{number + i}, {i + 1}" for i in range(len(nodes))]
        deck += [f"*SPRING, ELSET=SP{dof}\n{dof}\n1.E9"]
        number += len(nodes)
    for i in range(len(sides)):
        deck += [
            "*STEP\n*STATIC",
            f"*DLOAD, OP=NEW\n1, P{i + 1}, 1.0",
            "*NODE PRINT, NSET=NALL, TOTALS=ONLY\nRF\n*END STEP",
        ]
    path = tmp_path / "one.inp"
    path.write_text("\n".join(deck) + "\n")
    subprocess.run([CCX, "-i", "one"], cwd=tmp_path, capture_output=True, check=True, timeout=300)
    text = (tmp_path / "one.dat").read_text()
    totals = re.findall(r"total force.*\n\s*\n?((?:\s+[-+.\dEe]+){3})", text)
    found = np.array([[float(word) for word in row.split()] for row in totals])

    # the same file, read by us: the surfaces' outward area is minus the force of a pressure of 1 Pa
    mesh = jo.read_mesh(path)
    assert mesh.quality().scaled_jacobian.min() > 0.0
    count = SOLIDS[kind.rstrip("0123456789")]
    area = []
    for i, side in enumerate(sides):
        (row,) = mesh.surfaces[f"SIDE{i + 1}"]
        assert row[row >= 0].tolist() == list(side)
        corners = np.array([[n for n in side if n < count]])
        area.append(face_normals(mesh.nodes, corners)[0])
    np.testing.assert_allclose(-found, area, rtol=1e-5, atol=1e-6)


def _rows(words: list[int]) -> list[list[int]]:
    return [words[i : i + 12] for i in range(0, len(words), 12)]
