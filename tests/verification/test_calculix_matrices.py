"""Matrices that CalculiX writes, read and reduced, against the frequencies that it finds itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import jousto as jo
from jousto.base.errors import InputError
from jousto.materials.material import Material
from jousto.parts.part import Part
from verification.boxes import block
from verification.calculix import STORAGE, Deck, frequencies, needed, run

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)


def bar(**more: object) -> Deck:
    # no two sides are equal, so that no two frequencies are
    return Deck(block("hexahedron20", (0.4, 0.05, 0.03), (5, 2, 1)), STEEL, **more)  # type: ignore[arg-type]


def store(deck: Deck, folder: Path) -> Path:
    lines = deck.head() + STORAGE
    for suffix, text in run(lines, ("sti", "mas", "dof")).items():
        (folder / f"bar.{suffix}").write_text(text)
    (folder / "bar.inp").write_text("\n".join(lines) + "\n")
    return folder / "bar.sti"


@needed
def test_free_frequencies(tmp_path: Path) -> None:
    part = Part.from_file(store(bar(), tmp_path))
    assert part.mass == pytest.approx(7850.0 * 0.4 * 0.05 * 0.03, rel=1e-12)
    found = jo.reduce(part, jo.FreeFree(modes=8)).frequencies
    # ccx prints eight digits
    assert_allclose(found, frequencies(bar(), 8), rtol=1e-6)


@needed
@pytest.mark.filterwarnings("ignore:.*BOUNDARY .* ignored:jousto.JoustoWarning")
def test_supports_are_named(tmp_path: Path) -> None:
    grid = bar().mesh
    clamped = np.flatnonzero(grid.nodes[:, 0] == 0.0)
    # nodes without any row do not show in the matrices but in the mesh
    path = store(bar(fixed=tuple(int(i) for i in clamped)), tmp_path)
    with pytest.raises(InputError, match=r"of the mesh have no rows.*without supports"):
        Part.from_file(path)
