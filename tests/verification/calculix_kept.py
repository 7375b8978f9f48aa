"""Results of CalculiX that are kept, so that comparisons run where it is not installed.

``data/calculix.json`` holds for every deck the version of ccx, the lines of its steps and what ccx
printed. A deck is known by a digest of its words and whole numbers and by sums of its other
numbers, which allow for round-off of the nodes. Where ccx is installed it runs, and what it finds
must be what is kept. To make the file again with ccx installed, delete it and say::

    JOUSTO_KEEP_CALCULIX=1 pytest tests/verification -k calculix
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import subprocess
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

import numpy as np

PROGRAM = shutil.which("ccx")
FILE = Path(__file__).parent / "data" / "calculix.json"
KEEP = bool(os.environ.get("JOUSTO_KEEP_CALCULIX"))
DIGITS = 2e-6
"""ccx prints six digits of stress, seven of displacements, eight of frequencies."""
OF_MATRICES = 1e-10
"""ccx prints entries of matrices with fourteen digits; sums of them keep most of these."""

NUMBER = re.compile(r"-?\d\.\d+e[+-]\d+")


def answer(
    lines: Sequence[str], compute: Callable[[], np.ndarray], *, digits: float = DIGITS
) -> np.ndarray:
    """Return the numbers that ccx finds for a deck, from a run or as they are kept.

    A run must give what is kept to `digits`: each number of a list, displacements and stresses to
    that share of their largest.

    Raises
    ------
    LookupError
        ccx is not installed and the deck is not kept.
    """
    words, sums = fingerprint(lines)
    if PROGRAM is None:
        return np.array(_find(words, sums)["values"])
    found = np.asarray(compute(), dtype=np.float64)
    if KEEP:
        _keep(lines, words, sums, found, 14 if digits < DIGITS else 9 - found.ndim)
    kept = np.array(_find(words, sums)["values"])
    if kept.ndim == 1:
        np.testing.assert_allclose(found, kept, rtol=digits)
        return found
    for one, other in zip(np.split(found, [3], axis=1), np.split(kept, [3], axis=1), strict=True):
        size = np.abs(other).max(initial=0.0)
        np.testing.assert_allclose(one, other, rtol=0.0, atol=digits * size)
    return found


def fingerprint(lines: Sequence[str]) -> tuple[str, list[float]]:
    """Return a digest of words and whole numbers, and sums of the numbers with a point.

    The sums have pseudo-random weights, so that numbers do not change places unseen.
    """
    text = "\n".join(lines)
    numbers = np.array([float(x) for x in NUMBER.findall(text)])
    weights = np.random.default_rng(1).uniform(0.5, 1.5, (3, len(numbers)))
    digest = hashlib.sha256(NUMBER.sub("#", text).encode()).hexdigest()[:16]
    # nodes, elastic constants and loads are of different sizes: roots bring them together
    roots = np.sign(numbers) * np.abs(numbers) ** (1.0 / 3.0)
    return digest, [*(weights[:2] @ np.where(np.abs(numbers) < 1e-9, 0.0, roots)), len(numbers)]


def _find(words: str, sums: list[float]) -> dict:
    for row in _table()["results"]:
        if row["words"] == words and np.allclose(row["sums"], sums, rtol=1e-7, atol=1e-7):
            return row
    raise LookupError(
        f"{FILE.name} has no result for this deck ({words}); with CalculiX installed make it again "
        "as the head of calculix_kept.py says"
    )


@cache
def _table() -> dict:
    return json.loads(FILE.read_text()) if FILE.exists() else {"results": []}


def _keep(
    lines: Sequence[str], words: str, sums: list[float], found: np.ndarray, digits: int
) -> None:
    table = _table()
    rows = [r for r in table["results"] if r["words"] != words or not np.allclose(r["sums"], sums)]
    nodes = sum(1 for line in lines if re.match(r"\d+, +-?\d\.", line))
    first = next(i for i, line in enumerate(lines) if line.startswith("*STEP"))
    row = {
        "deck": {
            "element": next(x for x in lines if x.startswith("*ELEMENT")).split("TYPE=")[1][:6],
            "nodes": nodes,
            "steps": [line for line in lines[first:] if line.startswith("*")],
        },
        "words": words,
        "sums": [float(f"{x:.10g}") for x in sums],
        "values": np.vectorize(lambda x: float(f"{x:.{digits}g}"))(found).tolist(),
    }
    table["version"] = _version()
    table["results"] = sorted([*rows, row], key=lambda r: (r["words"], r["sums"]))
    one = ",\n".join(json.dumps(r, separators=(",", ":")) for r in table["results"])
    FILE.write_text(f'{{"version": "{table["version"]}",\n"results": [\n{one}\n]}}\n')


def _version() -> str:
    assert PROGRAM is not None
    said = subprocess.run([PROGRAM, "-v"], capture_output=True, text=True, check=False).stdout
    found = re.search(r"[Vv]ersion (\S+)", said)
    return f"CalculiX {found[1] if found else said.strip()}"
