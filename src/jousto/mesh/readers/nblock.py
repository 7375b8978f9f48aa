"""Nodes of Ansys archives: NBLOCK, whose field widths are given by a Fortran format."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array, Ints
from jousto.base.errors import InputError, Problem
from jousto.mesh.readers.raw import BIG

# (3i9,6e21.13e3) or, without solid model entities, (1i9,3e20.9e3)
_FORMAT = re.compile(rb"\s*\(\s*(\d*)i(\d+)\s*,\s*(\d*)[ef](\d+)\.\d+(?:e\d+)?\s*\)", re.I)
_BLOCK = re.compile(rb"^[ \t]*NBLOCK\b[^\r\n]*\r?\n([^\r\n]*)\r?\n", re.I | re.M)
_END = re.compile(rb"^[ \t]*(-1[ \t]*\r?$|N,|[A-Z/*!])", re.I | re.M)


def read_nblocks(path: Path, data: bytes) -> tuple[Ints, Array]:
    """Return numbers (nn,) and positions (nn, 3) of the nodes in all NBLOCKs of an archive.

    The format defines how many numbers a line has. Trailing zeros may be left out, even all three
    coordinates of a node at the origin.

    Raises
    ------
    InputError
        If the format is not supported, or a field is not a number; the message contains the line
        number.
    """
    ids, positions = [np.zeros(0, np.int64)], [np.zeros((0, 3))]
    for found in _BLOCK.finditer(data):
        first = data.count(b"\n", 0, found.end()) + 1  # line of the first node
        form = _FORMAT.match(found[1])
        if form is None:
            layout = found[1].decode("latin-1").strip()
            where = f"{path.name}:{first - 1}"
            raise InputError(
                Problem(where, f"the format of NBLOCK is '{layout}', must be like (3i9,6e21.13e3)")
            )
        end = _END.search(data, found.end())
        body = data[found.end() : end.start() if end else len(data)]
        number, wide, _, long = (int(group or 1) for group in form.groups())
        places = [0, wide, *(number * wide + long * i for i in range(4))]
        lines = [line.expandtabs() for line in body.splitlines()]
        columns = [_column(path, first, lines, (a, b), float) for a, b in pairwise(places[2:])]
        ids.append(_column(path, first, lines, (0, wide), int))
        positions.append(np.stack(columns, axis=1))
    return np.concatenate(ids), np.concatenate(positions)


def _column(
    path: Path, first: int, lines: list[bytes], places: tuple[int, int], kind: type
) -> NDArray[Any]:
    """Return the numbers at given columns of all lines; 0 for numbers left out."""
    a, b = places
    words = [line[a:b].strip() or b"0" for line in lines]
    try:
        return np.array([kind(word) for word in words], dtype=np.int64 if kind is int else None)
    except (ValueError, OverflowError):
        i = next(i for i, word in enumerate(words) if not _is(kind, word))
        text = words[i].decode("latin-1")
        what = "whole number" if kind is int else "number"
        sentence = f"'{text}' is not a {what}; the file may be truncated or damaged"
        raise InputError(Problem(f"{path.name}:{first + i}", sentence)) from None


def _is(kind: type, word: bytes) -> bool:
    try:
        return bool(abs(kind(word)) < BIG) or kind is float
    except ValueError:
        return False
