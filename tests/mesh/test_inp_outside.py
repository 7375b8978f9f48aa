"""Input decks of solids that contain more than a mesh: what is not taken is named with its line."""

from __future__ import annotations

from pathlib import Path

import pytest

import jousto as jo

DECK = """*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 0, 1, 0
4, 0, 0, 1
*ELEMENT, TYPE=C3D4, ELSET=all
1, 1, 2, 3, 4
*BOUNDARY
1, 1, 3
*INITIAL CONDITIONS, TYPE=TEMPERATURE
1, 20.0
*STEP
*STATIC
*CLOAD
4, 3, -1.0
*BOUNDARY
2, 3
*END STEP
"""


def test_supports_and_loads_are_named(tmp_path: Path) -> None:
    path = tmp_path / "part.inp"
    path.write_text(DECK)
    said = (
        r"part\.inp: \*BOUNDARY \(lines 8, 16\), \*INITIAL CONDITIONS \(line 10\), "
        r"\*CLOAD \(line 14\) ignored: declare supports and loads as joints and forces"
    )
    with pytest.warns(jo.JoustoWarning, match=said):
        mesh = jo.read_mesh(path)
    assert len(mesh.nodes) == 4
