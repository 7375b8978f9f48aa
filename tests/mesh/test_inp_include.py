"""Data of Abaqus and CalculiX decks in included files, beside what CalculiX reads of them."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError, JoustoWarning
from verification.calculix import needed
from verification.calculix_kept import PROGRAM

DECK = """*NODE, NSET=ALL
1, 0, 0, 0
2, 1, 0, 0
*INCLUDE, INPUT=nodes.txt
*ELEMENT, TYPE=C3D4, ELSET=E
1, 1, 2, 3, 4
*INCLUDE,
 INPUT=elements.txt
3, 2, 5, 3, 6
*NSET, NSET=SOME
1,
*INCLUDE, INPUT=set.txt
*MATERIAL, NAME=M
*ELASTIC
1., .3
*DENSITY
1.
*SOLID SECTION, ELSET=E, MATERIAL=M
"""
STEP = "*STEP\n*FREQUENCY\n1\n*END STEP\n"
FILES = {
    "nodes.txt": "3, 0, 1, 0\n** a comment\n4, 0, 0, 1\n5, 1, 1, 1\n\n6, 2, 0, 1\n",
    "elements.txt": "2, 2, 3, 4, 5\n",
    "set.txt": "3,\n*NSET, NSET=OTHER\n5,\n",
}


def written(folder: Path, deck: str = DECK, **files: str) -> Path:
    for name, text in {"deck.inp": deck, **FILES, **files}.items():
        (folder / name).write_text(text)
    return folder / "deck.inp"


def test_included_data_continue_the_open_keyword(tmp_path: Path) -> None:
    mesh = jo.read_mesh(written(tmp_path))
    np.testing.assert_array_equal(mesh.node_ids, [1, 2, 3, 4, 5, 6])
    np.testing.assert_array_equal(mesh.nodes[5], [2.0, 0.0, 1.0])
    np.testing.assert_array_equal(mesh.element_ids, [1, 2, 3])
    np.testing.assert_array_equal(mesh.solids[0].nodes[1], [1, 2, 3, 4])
    assert len(mesh.element_sets["E"]) == 3
    assert mesh.solids[0].material == "M"
    np.testing.assert_array_equal(mesh.set("SOME"), [0, 2])
    np.testing.assert_array_equal(mesh.set("OTHER"), [4])


@needed
def test_calculix_reads_as_many(tmp_path: Path) -> None:
    deck = DECK.replace("*INCLUDE,\n", "*INCLUDE,")  # ccx wants it on one line
    path = written(tmp_path, deck + STEP)
    said = subprocess.run(
        [str(PROGRAM), path.stem], cwd=tmp_path, capture_output=True, text=True, timeout=60
    ).stdout
    mesh = jo.read_mesh(path)
    for word, number in (("nodes", len(mesh.nodes)), ("elements", len(mesh.element_ids))):
        found = re.search(rf"^ *{word}: +(\d+)", said, re.MULTILINE)
        assert found is not None and int(found[1]) == number


def test_data_behind_an_include_belong_to_its_last_keyword(tmp_path: Path) -> None:
    deck = DECK.replace("*INCLUDE, INPUT=set.txt\n", "*INCLUDE, INPUT=set.txt\n6,\n")
    mesh = jo.read_mesh(written(tmp_path, deck))
    np.testing.assert_array_equal(mesh.set("SOME"), [0, 2])
    np.testing.assert_array_equal(mesh.set("OTHER"), [4, 5])


def test_files_of_data_lines_of_a_keyword(tmp_path: Path) -> None:
    deck = DECK.replace(
        "*ELEMENT, TYPE=C3D4, ELSET=E", "*ELEMENT, ELSET=E, INPUT=in.txt, TYPE=C3D4"
    )
    deck = deck.replace("1, 1, 2, 3, 4\n", "")
    mesh = jo.read_mesh(written(tmp_path, deck, **{"in.txt": "1, 1, 2, 3, 4\n"}))
    np.testing.assert_array_equal(mesh.element_ids, [1, 2, 3])


def test_included_files_are_searched_beside_both(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "outer.txt").write_text("*INCLUDE, INPUT=inner.txt\n")
    (tmp_path / "parts" / "inner.txt").write_text("*INCLUDE, INPUT=elements.txt\n")
    deck = DECK.replace("INPUT=elements.txt", "INPUT=parts/outer.txt")
    np.testing.assert_array_equal(jo.read_mesh(written(tmp_path, deck)).element_ids, [1, 2, 3])


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("*INCLUDE, INPUT=elements.txt\n", "a file includes itself"),
        ("2, 2, 3, 4\n", "deck.inp:5: .ELEMENT: '3, 2, 5, 3, 6' has too many"),
        ("*INCLUDE, INPUT=there.txt\n", "elements.txt:1: .INCLUDE: the included file 'there.txt'"),
        ("*INCLUDE\n", "elements.txt:1: .INCLUDE: the included file ''"),
        ("2, 2, 3, x, 5\n", "'x' is not a whole number"),
    ],
)
def test_wrong_includes_are_refused(tmp_path: Path, text: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        jo.read_mesh(written(tmp_path, **{"elements.txt": text}))


def test_data_before_any_keyword_are_named(tmp_path: Path) -> None:
    with pytest.warns(JoustoWarning, match="deck.inp:1: '7, 0, 0, 0' is below no .KEYWORD"):
        mesh = jo.read_mesh(written(tmp_path, f"7, 0, 0, 0\n{DECK}"))
    assert len(mesh.nodes) == 6
