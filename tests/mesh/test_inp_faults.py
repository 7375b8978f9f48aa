"""Faults of Abaqus and CalculiX decks, and what only looks like one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError, JoustoWarning

NODES = "*NODE\n" + "".join(
    f"{i + 1}, {float(i & 1)}, {float(i >> 1 & 1)}, {float(i >> 2)}\n" for i in range(8)
)
BRICK = "1, 2, 4, 3, 5, 6, 8, 7"


def deck(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "deck.inp"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    "keyword",
    ["*SUBMODEL, INPUT=global.fil", "*CRACK PROPAGATION, INPUT=crack.in, MATERIAL=EL"],
)
def test_files_of_other_keywords_are_no_includes(keyword: str, tmp_path: Path) -> None:
    text = f"{NODES}*ELEMENT, TYPE=C3D8, ELSET=E\n1, {BRICK}\n{keyword}\n1\n*END STEP\n"
    mesh = jo.read_mesh(deck(tmp_path, text))
    assert len(mesh.nodes) == 8 and len(mesh.solids[0]) == 1


@pytest.mark.parametrize("line", ["9", "9,", "9,,,", "9, , ,"])
def test_a_node_without_coordinates_is_at_the_origin(line: str, tmp_path: Path) -> None:
    # Abaqus' manual: "blank or left-out coordinates are zero"; CalculiX reads it so, too
    mesh = jo.read_mesh(deck(tmp_path, f"{NODES}{line}\n*ELEMENT, TYPE=C3D8\n1, {BRICK}\n"))
    np.testing.assert_array_equal(mesh.nodes[mesh.node_ids == 9], [[0.0, 0.0, 0.0]])


def test_coordinates_left_out_at_the_end_are_zero(tmp_path: Path) -> None:
    # as both manuals say of data that are left out
    text = f"{NODES}9, 7.\n10, , 7.\n*ELEMENT, TYPE=C3D8\n1, {BRICK}\n"
    mesh = jo.read_mesh(deck(tmp_path, text))
    np.testing.assert_array_equal(mesh.nodes[8:], [[7.0, 0.0, 0.0], [0.0, 7.0, 0.0]])


def test_surplus_numbers_are_no_other_element(tmp_path: Path) -> None:
    # nine elements of ten numbers are ten of nine
    rows = "".join(f"{i + 1}, {BRICK}, 1\n" for i in range(9))
    with pytest.raises(
        InputError, match="too many numbers for a C3D8, which has its number and 8 nodes"
    ):
        jo.read_mesh(deck(tmp_path, f"{NODES}*ELEMENT, TYPE=C3D8\n{rows}"))
    # over two lines they may stand
    mesh = jo.read_mesh(
        deck(tmp_path, f"{NODES}*ELEMENT, TYPE=C3D8\n1, 1, 2, 4, 3,\n5, 6, 8, 7\n2, {BRICK}\n")
    )
    np.testing.assert_array_equal(mesh.solids[0].nodes, [[0, 1, 3, 2, 4, 5, 7, 6]] * 2)


def test_a_surface_on_a_beam_is_told(tmp_path: Path) -> None:
    text = (
        f"{NODES}*ELEMENT, TYPE=C3D8\n1, {BRICK}\n*ELEMENT, TYPE=B31, ELSET=ROD\n2, 1, 2\n"
        "*SURFACE, NAME=TOP\n1, S1\nROD, S1\n"
    )
    with pytest.warns(JoustoWarning) as told:
        mesh = jo.read_mesh(deck(tmp_path, text))
    assert [str(item.message) for item in told] == [
        "deck.inp: surface 'TOP': faces of element 2 not read: a line has none",
        "deck.inp: 1 B31: a beam has no stiffness and mass beside solids here; kept for names and"
        " drawing",
    ]
    assert mesh.surfaces["TOP"].shape == (1, 4)


def test_a_deck_of_other_elements_names_them_and_what_is_read(tmp_path: Path) -> None:
    text = f"{NODES}*ELEMENT, TYPE=MASS\n1, 1\n2, 2\n*ELEMENT, TYPE=EC3D8R\n3, {BRICK}\n"
    with pytest.raises(InputError) as error:
        jo.read_mesh(deck(tmp_path, text))
    told = str(error.value)
    assert "contains only elements of type MASS (2), EC3D8R (1), which are not supported" in told
    for kind in ("tetra10", "hexahedron20", "wedge15"):
        assert kind in told
