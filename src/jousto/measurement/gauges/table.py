"""Text tables of loggers, with delimiters and decimal signs of all countries."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.files import check_text
from jousto.measurement.gauges.units import parse_unit, split_label

MISSING = {"", "nan", "na", "n/a", "-", "--", "---", "***", "null", "none", "ovl", "overflow",
           "inf", "-inf", "+inf", "1.#qnan", "#nv", "#n/a", "err", "error"}  # fmt: skip
_STAMPS = (
    "%d.%m.%Y %H:%M:%S.%f", "%d.%m.%Y %H:%M:%S", "%d/%m/%Y %H:%M:%S.%f", "%d/%m/%Y %H:%M:%S",
    "%H:%M:%S.%f", "%H:%M:%S",
)  # fmt: skip
SAMPLE = 300
"""Number of lines from which delimiter and decimal sign are determined."""

SHOWN = 3
"""Number of lines that a message names."""


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of a text file.

    Attributes
    ----------
    names : tuple of str
        Headings of the columns without units.
    labels : tuple of str or None
        Units as in the file.
    values : (nt, nc) array
        Numbers; nan where a field is empty or marked as not measured. Times of day and
        dates are seconds.
    lines : (nt,) int array
        Line of each row, from 1.
    notes : tuple of str
        Notes on lines that were left out.
    """

    names: tuple[str, ...]
    labels: tuple[str | None, ...]
    values: Array
    lines: NDArray[np.int64]
    notes: tuple[str, ...]


def read_table(path: Path) -> Table:
    """Return the table of a text file: blanks, tabs, commas or semicolons; point or comma.

    The table is the longest block of lines with equally many numbers; names are in the line above
    it, units in the names or in a line of their own. Lines of text inside the block are left out
    and noted.

    Raises
    ------
    InputError
        If the file is empty or contains no table of numbers.
    """
    check_text(path)
    text = _decoded(path)
    lines = text.splitlines()
    if not any(line.strip() for line in lines):
        raise InputError(Problem(str(path), "is empty: there is no line of numbers"))
    best: tuple[int, str | None, str, int] | None = None
    sample = lines[:SAMPLE]
    for delimiter, decimal in ((";", ","), (";", "."), ("\t", ","), ("\t", "."), (",", "."),
                               (",", ","), (None, ","), (None, ".")):  # fmt: skip
        rows, width, _ = _block(sample, delimiter, decimal)
        # a wrong delimiter gives fewer columns
        score = len(rows) * width
        if width and (best is None or score > best[0]):
            best = (score, delimiter, decimal, width)
    if best is None:
        first = next(line for line in lines if line.strip()).strip()
        raise InputError(
            Problem(
                str(path),
                f"has no table of numbers: two columns or more, separated by , ; blanks or tabs; "
                f"its first line is {first[:60]!r}",
            )
        )
    _, delimiter, decimal, width = best
    rows, _, numbers = _block(lines, delimiter, decimal, width)
    names, labels = _heads(lines[: rows[0]], delimiter, width)
    values = np.array(numbers)
    _check_heads(path, lines, rows, delimiter, values)
    notes = _left_out(lines, rows, width, delimiter, decimal)
    # many loggers end every line with a delimiter
    if not names[-1] and np.all(np.isnan(values[:, -1])):
        names, labels, values = names[:-1], labels[:-1], values[:, :-1]
    names = tuple(name or f"column{i + 1}" for i, name in enumerate(names))
    return Table(names, labels, values, np.array(rows) + 1, notes)


def _decoded(path: Path) -> str:
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise InputError(Problem(str(path), f"cannot be read: {error.strerror}")) from error
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return raw.decode("utf-16", errors="replace")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace")


def _fields(line: str, delimiter: str | None) -> list[str]:
    if delimiter is None:
        return line.split()
    if '"' in line:  # a delimiter within quotes belongs to the field
        row = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
        return [field.strip() for field in row]
    return [field.strip().strip('"').strip() for field in line.split(delimiter)]


def _block(
    lines: list[str], delimiter: str | None, decimal: str, width: int | None = None
) -> tuple[list[int], int, list[list[float]]]:
    """Return the lines of numbers, their indices, their usual width and the values."""
    found: dict[int, tuple[list[int], list[list[float]]]] = {}
    for i, line in enumerate(lines):
        fields = _fields(line, delimiter)
        if len(fields) < 2 or (width is not None and len(fields) != width):
            continue
        numbers = _numbers(fields, decimal)
        if numbers is not None:
            rows, values = found.setdefault(len(fields), ([], []))
            rows.append(i)
            values.append(numbers)
    if not found:
        return [], 0, []
    usual = max(found, key=lambda w: len(found[w][0]) * w)
    return found[usual][0], usual, found[usual][1]


def _numbers(fields: list[str], decimal: str) -> list[float] | None:
    """Return the numbers of a line, nan for missing ones; None for a line of text."""
    if decimal == ",":
        if any("." in field and ":" not in field for field in fields):
            return None
        fields = [field.replace(",", ".") for field in fields]
    out, known = [], 0
    for k, field in enumerate(fields):
        try:
            value = float(field)
        except ValueError:
            stamp = _stamp(field) if k == 0 else None
            if stamp is None and field.lower() not in MISSING:
                return None
            value = float("nan") if stamp is None else stamp
        else:
            # float() also accepts words and underscores
            if field[-1:].isalpha() or "_" in field:
                if field.lower() not in MISSING:
                    return None
                value = float("nan")
        known += value == value
        out.append(value)
    return out if known else None


def _stamp(field: str) -> float | None:
    """Return the seconds of a date or a time of day; None for another text."""
    if ":" not in field:
        return None
    text = re.sub(r"(:\d\d),(\d)", r"\1.\2", field)
    try:
        return datetime.fromisoformat(text).timestamp()
    except ValueError:
        pass
    for form in _STAMPS:
        try:
            moment = datetime.strptime(text, form)
        except ValueError:
            continue
        if moment.year == 1900:  # a time of day without date
            return (moment - datetime(1900, 1, 1)).total_seconds()
        return moment.timestamp()
    return None


def _heads(
    above: list[str], delimiter: str | None, width: int
) -> tuple[tuple[str, ...], tuple[str | None, ...]]:
    """Return names and units of the columns from the lines above the numbers."""
    plain = [line.strip().lstrip("#%!").strip() for line in above]
    rows = [_fields(line, delimiter) for line in plain if line]
    rows = [[*row, *[""] * (width - len(row))] for row in rows if width - 1 <= len(row) <= width]
    units: list[str | None] = [None] * width
    if len(rows) > 1 and _are_units(rows[-1], rows[-2]):
        units = [text.strip("[](){} ") or None for text in rows[-1]]
        rows = rows[:-1]
    if not rows:
        return ("time", *(f"channel{i}" for i in range(1, width))), tuple(units)
    names, seen = [], set()
    for i, text in enumerate(rows[-1]):
        name, unit = split_label(text)
        while name and name in seen:
            name += "'"
        seen.add(name)
        names.append(name)
        units[i] = unit if unit is not None else units[i]
    return tuple(names), tuple(units)


def _check_heads(
    path: Path, lines: list[str], rows: list[int], delimiter: str | None, values: Array
) -> None:
    """Raise InputError if the headings do not match the columns of numbers."""
    above = [i for i in range(rows[0]) if lines[i].strip()]
    if delimiter is None or not above or lines[above[-1]].lstrip()[0] in "#%!":
        return
    heads = _fields(lines[above[-1]], delimiter)
    while heads and not heads[-1]:
        heads.pop()
    width = values.shape[1]
    while width > len(heads) and np.all(np.isnan(values[:, width - 1])):
        width -= 1
    if len(heads) < 2 or len(heads) >= width:
        return
    hint = "; quote numbers with a decimal comma, or separate columns by semicolons"
    raise InputError(
        Problem(
            str(path),
            f"line {above[-1] + 1} names {len(heads)} columns ({', '.join(heads[:4])}), line "
            f"{rows[0] + 1} has {width} numbers ({lines[rows[0]].strip()[:40]!r})"
            f"{hint if delimiter == ',' else ''}",
        )
    )


def _are_units(row: list[str], above: list[str]) -> bool:
    """Return whether a line contains units: in all fields, or in half and more than above.

    An unknown unit is then reported, and the other units are not read as names.
    """

    def known(fields: list[str]) -> list[bool]:
        return [parse_unit(field) is not None or field.startswith("[") for field in fields if field]

    here = known(row)
    return any(here) and (all(here) or (2 * sum(here) >= len(here) and not any(known(above))))


def _left_out(
    lines: list[str], rows: list[int], width: int, delimiter: str | None, decimal: str
) -> tuple[str, ...]:
    """Return notes on lines that were not read."""
    kept = set(rows)
    bad = []
    for i, line in enumerate(lines):
        if i in kept or not line.strip():
            continue
        fields = _fields(line, delimiter)
        if rows[0] < i < rows[-1] or (len(fields) > 1 and _numbers(fields, decimal) is not None):
            bad.append(i + 1)
    if not bad:
        return ()
    named = ", ".join(str(i) for i in bad[:SHOWN]) + (", ..." if len(bad) > SHOWN else "")
    return (f"{len(bad)} lines are not {width} numbers and were left out (line {named})",)
