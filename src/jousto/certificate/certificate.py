"""Certificate of a part: its mass properties, checks of its data, and accuracy of its modes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, count
from jousto.base.object_repr import described

Status = Literal["ok", "note", "warn", "fail"]

STATUSES = ("ok", "note", "warn", "fail")
"""Statuses from good to bad; a note is information and no fault."""

MOST_ROWS = 14
"""Largest number of printed rows of a table."""


@described
@dataclass(frozen=True)
class Check:
    """Result of one check.

    Parameters
    ----------
    topic : str
        Subject of the check, such as ``"units"``.
    status : str
        ``"ok"``, ``"note"`` (information), ``"warn"`` (probable mistake) or ``"fail"`` (results are
        unreliable).
    value : str
        Result with unit.
    limit : str
        Limit of the value; empty if there is none.
    sentence : str
        Meaning of the result.
    remedy : str
        What to do; empty if nothing.
    """

    topic: str
    status: Status
    value: str
    limit: str = ""
    sentence: str = ""
    remedy: str = ""

    @property
    def advice(self) -> str:
        """Sentence and remedy, as complete sentences."""
        texts = [text for text in (self.sentence, self.remedy) if text]
        return " ".join(f"{text[0].upper()}{text[1:]}." for text in texts)

    def __post_init__(self) -> None:
        if self.status not in STATUSES:
            message = f"status is {self.status!r}, must be one of {', '.join(STATUSES)}"
            raise InputError(Problem(f"check '{self.topic}'", message))


@described
@dataclass(frozen=True)
class Table:
    """Table of numbers behind the checks, as text.

    Parameters
    ----------
    title : str
    columns : tuple of str
        Headings, with units.
    rows : tuple of tuple of str
    remark : str
        Explanation of the table.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    remark: str = ""

    def shown(self, most: int) -> tuple[tuple[str, ...], ...]:
        """Return table rows; of long tables the first rows and the last one."""
        if len(self.rows) <= most:
            return self.rows
        gap = (f"... {len(self.rows) - most} more", *[""] * (len(self.columns) - 1))
        return (*self.rows[: most - 1], gap, self.rows[-1])

    def lines(self, most: int | None = None) -> list[str]:
        """Return the table as lines of text; of long tables the first rows and the last one."""
        rows = self.rows if most is None else self.shown(most)
        width = [
            max(len(row[i]) for row in (self.columns, *rows)) for i in range(len(self.columns))
        ]
        text = []
        for row in (self.columns, *rows):
            cells = [row[0].ljust(width[0])]
            cells += [cell.rjust(w) for cell, w in zip(row[1:], width[1:], strict=True)]
            text.append("  " + "  ".join(cells).rstrip())
        return text


@described
@dataclass(frozen=True, eq=False)
class Silhouette:
    """Shape of the part, for a picture.

    Parameters
    ----------
    nodes : (nn, 3) array
        Undeformed positions, part frame, m.
    lines : (k, 2) int array
        Beams and edges.
    triangles : (m, 3) int array
        Outer surface of solids.
    interfaces : tuple of (str, tuple of int)
        Names and nodes where joints and forces act.
    """

    nodes: Array
    lines: NDArray[np.int64]
    triangles: NDArray[np.int64]
    interfaces: tuple[tuple[str, tuple[int, ...]], ...] = ()


@dataclass(frozen=True, eq=False)
class Certificate:
    """Findings of `certify` about a part and its modes; ``print`` displays them on one page.

    Parameters
    ----------
    name : str
        Name of the part.
    facts : tuple of (str, str)
        Names and values: mass, centre, inertia, size and the like.
    checks : tuple of Check
        Checks in the order of execution.
    tables : tuple of Table
        Numbers behind the checks.
    silhouette : Silhouette
        Shape of the part.
    """

    name: str
    facts: tuple[tuple[str, str], ...]
    checks: tuple[Check, ...]
    tables: tuple[Table, ...]
    silhouette: Silhouette

    @property
    def status(self) -> Status:
        """Worst status of all checks; notes count as ok."""
        found = {check.status for check in self.checks}
        return "fail" if "fail" in found else "warn" if "warn" in found else "ok"

    @property
    def passed(self) -> bool:
        """Whether no check failed; there may be warnings."""
        return self.status != "fail"

    def __getitem__(self, topic: str) -> Check:
        """Return the check with a topic.

        Raises
        ------
        KeyError
            If there is no such topic.
        """
        for check in self.checks:
            if check.topic == topic:
                return check
        known = ", ".join(check.topic for check in self.checks)
        raise KeyError(f"no check of '{topic}'; the checks are: {known}")

    @property
    def verdict(self) -> str:
        """Number of checks by status, in one line."""
        number = {
            status: sum(check.status == status for check in self.checks)
            for status in ("fail", "warn", "note", "ok")
        }
        words = {"fail": "fault", "warn": "warning", "note": "note"}
        found = [count(number[s], words[s]) for s in words if number[s]]
        return ", ".join([*found, f"{number['ok']} of {count(len(self.checks), 'check')} ok"])

    def __str__(self) -> str:
        lines = [f"certificate of part '{self.name}': {self.verdict}"]
        lines += _columns(self.facts)
        lines.append("checks")
        width = max((len(check.topic) for check in self.checks), default=0)
        for check in self.checks:
            value = f"{check.value} ({check.limit})" if check.limit else check.value
            lines.append(f"  {check.status:<4}  {check.topic:<{width}}  {value}")
            if check.status != "ok":
                lines += _wrapped(check.advice, " " * (width + 10))
        for table in self.tables:
            lines += [table.title, *table.lines(MOST_ROWS)]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<Certificate {self.name!r}: {self.verdict}>"


def _columns(rows: tuple[tuple[str, str], ...]) -> list[str]:
    width = max((len(name) for name, _ in rows), default=0)
    return [f"  {name:<{width}}  {value}" for name, value in rows]


def _wrapped(text: str, indent: str, width: int = 100) -> list[str]:
    import textwrap

    return textwrap.wrap(text, width, initial_indent=indent, subsequent_indent=indent)


def number(value: float, digits: int = 4) -> str:
    """Return a number as short text.

    Examples
    --------
    >>> number(0.000123456), number(1234567.0)
    ('0.0001235', '1.235e+06')
    """
    return f"{value:.{digits}g}"


def vector(values: Any, digits: int = 6, size: float = 0.0) -> str:
    """Return numbers as short text, with rounding errors as zero.

    `size` is the scale of the numbers; values far below it are rounding errors.

    Examples
    --------
    >>> vector([1000.0, 1e-13, -2.5])
    '1000, 0, -2.5'
    """
    array = np.asarray(values, dtype=float)
    size = max(size, np.abs(array).max(initial=0.0))
    return ", ".join(f"{0.0 if abs(x) <= 1e-9 * size else x:.{digits}g}" for x in array)


def percent(value: float) -> str:
    """Return a fraction in per cent as text, with rounding errors as zero.

    Examples
    --------
    >>> percent(0.01234), percent(1e-12)
    ('1.2 %', '0 %')
    """
    size = abs(value)
    if size < 1e-6:
        return "0 %"
    return f"{100.0 * value:.2g} %" if size < 0.1 else f"{100.0 * value:.3g} %"
