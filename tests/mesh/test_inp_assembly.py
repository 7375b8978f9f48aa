"""Abaqus decks with parts and instances: places, numbers and names such as ``A-1.corner``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jousto as jo
from jousto.base.errors import InputError

BRICK = "".join(
    f"{n}, {x}., {y}., {z}.\n"
    for n, (x, y, z) in enumerate(
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)], 1
    )
)
PART = f"""*PART, NAME=Arm
*NODE
{BRICK}*ELEMENT, TYPE=C3D8I, ELSET=solid
1, 1, 2, 3, 4, 5, 6, 7, 8
*NSET, NSET=corner
1,
*NSET, NSET=all, GENERATE
1, 99999
*ELSET, ELSET=right side
1,
*SURFACE, NAME=top
solid, S2
*SOLID SECTION, ELSET=solid, MATERIAL=steel
*END PART
"""
TWO = f"""*HEADING
{PART}*ASSEMBLY, NAME=Assembly
*INSTANCE, NAME=A-1, PART=arm
*END INSTANCE
*INSTANCE, NAME=B-1, PART=ARM
10., 0., 0.
10., 0., 0., 10., 0., 1., 90.
*END INSTANCE
*NODE, NSET=reference
1, 5., 5., 5.
*NSET, NSET=ends
A-1.corner, B-1.corner
*NSET, NSET=second, INSTANCE=B-1
2, CORNER
*NSET, NSET=single
A-1.7,
*ELSET, ELSET=both
A-1.solid, B-1.solid
*SURFACE, NAME=faces
A-1.solid, S4
both, S1
*END ASSEMBLY
*MATERIAL, NAME=steel
*STEP
*END STEP
"""


def read(folder: Path, text: str) -> jo.Mesh:
    (folder / "deck.inp").write_text(text)
    return jo.read_mesh(folder / "deck.inp")


def positions(mesh: jo.Mesh, name: str) -> list[list[float]]:
    return np.round(mesh.nodes[mesh.set(name)], 12).tolist()


def test_two_instances_stand_where_they_are_put(tmp_path: Path) -> None:
    mesh = read(tmp_path, TWO)
    assert mesh.volume == pytest.approx(2.0, rel=1e-12)
    # the first keeps its numbers, the second has 10 more, the reference point 20
    assert mesh.node_ids.tolist() == [*range(1, 9), *range(11, 19), 21]
    assert mesh.element_ids.tolist() == [1, 11]
    # translated, then turned by 90 degrees about z through (10, 0, 0)
    assert positions(mesh, "B-1.all")[:3] == [[10, 0, 0], [10, 1, 0], [9, 1, 0]]
    assert positions(mesh, "ends") == [[0, 0, 0], [10, 0, 0]]
    assert positions(mesh, "A-1.corner") == [[0, 0, 0]]
    assert positions(mesh, "second") == [[10, 0, 0], [10, 1, 0]]
    assert positions(mesh, "single") == [[1, 1, 1]]
    assert positions(mesh, "reference") == [[5, 5, 5]]
    assert len(mesh.set("A-1.all")) == len(mesh.set("B-1.all")) == 8
    assert mesh.element_sets["both"].tolist() == [0, 1]
    assert mesh.surfaces["A-1.top"].shape == mesh.surfaces["B-1.top"].shape == (1, 4)
    assert len(mesh.surfaces["faces"]) == 3
    assert all(block.material == "steel" for block in mesh.cells)
    assert all(block.formulation == "incompatible" for block in mesh.cells)


def test_a_turned_instance_is_turned_about_any_axis(tmp_path: Path) -> None:
    a, b, angle = np.array([1.0, -2.0, 0.5]), np.array([2.0, 1.0, 3.0]), 37.0
    lines = f"3., 4., 5.\n{','.join(map(str, [*a, *b, angle]))}\n"
    text = TWO.replace("10., 0., 0.\n10., 0., 0., 10., 0., 1., 90.\n", lines)
    mesh = read(tmp_path, text)
    axis = (b - a) / np.linalg.norm(b - a)
    turn = Rotation.from_rotvec(np.radians(angle) * axis)
    at = mesh.set("A-1.all")
    expected = turn.apply(mesh.nodes[at] + [3.0, 4.0, 5.0] - a) + a
    np.testing.assert_allclose(mesh.nodes[mesh.set("B-1.all")], expected, atol=1e-12)
    assert mesh.volume == pytest.approx(2.0, rel=1e-12)


def test_one_instance_keeps_names_and_numbers(tmp_path: Path) -> None:
    start, end = TWO.index("*INSTANCE, NAME=B-1"), TWO.index("*NODE, NSET=reference")
    text = TWO[:start] + TWO[end:].replace(", B-1.corner", "").replace(", B-1.solid", "")
    text = text.replace("*NSET, NSET=second, INSTANCE=B-1\n2, CORNER\n", "")
    moved = text.replace("PART=arm\n", "PART=arm\n0., 0., 7.\n")
    mesh = read(tmp_path, moved)
    assert mesh.node_ids.tolist() == [*range(1, 9), 11]
    assert positions(mesh, "corner") == positions(mesh, "ends") == [[0, 0, 7]]
    # a set of the assembly takes a name of the part: that of the part is named by its instance
    twice = text.replace("*NSET, NSET=ends\nA-1.corner", "*NSET, NSET=Corner\nA-1.7")
    mesh = read(tmp_path, twice)
    assert positions(mesh, "A-1.corner") == [[0, 0, 0]]
    assert len(mesh.surfaces["top"]) == 1


def test_parts_without_an_assembly(tmp_path: Path) -> None:
    assert read(tmp_path, PART).volume == pytest.approx(1.0)
    other = PART.replace("NAME=Arm", "NAME=Leg")
    mesh = read(tmp_path, PART + other)
    assert positions(mesh, "Leg.corner") == positions(mesh, "Arm.corner")


@pytest.mark.parametrize(
    ("found", "instead", "sentence"),
    [
        ("PART=arm", "PART=arn", "INSTANCE: there is no part 'arn' above it; did you mean 'Arm'"),
        ("NAME=B-1", "NAME=a-1", "there are two instances 'a-1'"),
        ("A-1.corner,", "A-1.korner,", "'A-1.korner' is neither a number nor a set"),
        ("A-1.corner,", "A-3.corner,", "'A-3.corner' is neither a number nor a set"),
        ("INSTANCE=B-1", "INSTANCE=B-2", "there is no instance 'B-2'; did you mean"),
        ("10., 0., 1., 90.", "10., 0., 1.", "needs x, y, z of its translation, then two points"),
        ("10., 0., 1., 90.", "10., 0., x, 90.", "needs x, y, z of its translation"),
        ("10., 0., 1., 90.", "10., 0., 0., 90.", "the two points of its axis coincide"),
        ("PART=arm", "LIBRARY=old, PART=arm", "taken from the results of another analysis"),
        ("A-1.solid, S4", "A-1.solidd, S4", "'A-1.solidd' is neither a number nor a set"),
    ],
)
def test_wrong_assemblies_are_refused(
    tmp_path: Path, found: str, instead: str, sentence: str
) -> None:
    assert found in TWO
    with pytest.raises(InputError, match=sentence):
        read(tmp_path, TWO.replace(found, instead, 1))
