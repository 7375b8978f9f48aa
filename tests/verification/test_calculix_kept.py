"""The kept results of CalculiX belong to the decks of the tests, not to others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import jousto as jo
from verification import calculix, calculix_kept
from verification.boxes import Grid, block

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
GRID = block("hexahedron", (0.4, 0.1, 0.06), (2, 1, 1))


def moved(by: float) -> Grid:
    return replace(GRID, nodes=GRID.nodes + by * np.eye(len(GRID.nodes), 3))


def test_a_deck_is_known_by_its_numbers_but_for_round_off() -> None:
    words, sums = calculix_kept.fingerprint(calculix.Deck(GRID, STEEL).head())
    for by, same in ((1e-17, True), (1e-4, False)):
        other, theirs = calculix_kept.fingerprint(calculix.Deck(moved(by), STEEL).head())
        assert other == words
        assert np.allclose(theirs, sums, rtol=1e-7) == same
    assert calculix_kept.fingerprint(calculix.Deck(GRID, STEEL, (0,)).head())[0] != words


def test_a_deck_that_is_not_kept_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(calculix_kept, "PROGRAM", None)
    with pytest.raises(LookupError, match="make it again"):
        calculix.frequencies(calculix.Deck(moved(1e-3), STEEL), 3)


def test_a_run_that_differs_from_what_is_kept_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    row = calculix_kept._table()["results"][0]
    monkeypatch.setattr(calculix_kept, "PROGRAM", "ccx")
    monkeypatch.setattr(calculix_kept, "fingerprint", lambda lines: (row["words"], row["sums"]))
    values = np.array(row["values"])
    assert np.array_equal(calculix_kept.answer([], lambda: values), values)
    with pytest.raises(AssertionError):
        calculix_kept.answer([], lambda: values * (1.0 + 5e-6))
