"""Journal: rows of a study on disk as they are computed, one line each, whole or not there."""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jousto.base.errors import InputError, Problem, count, warn
from jousto.base.files import check_file, unwritable
from jousto.design.studies.running.content_hash import unknown
from jousto.design.studies.running.evaluator import Row

FORMAT = "jousto study"
VERSION = 2
"""Since 2 each row has a checksum."""
SHOWN = 5
"""Bad lines in a warning."""
Place = tuple[float, ...]
Sizes = tuple[int, int] | None
"""How many parameters and outcomes a row has; None if that is not known."""


class Journal:
    """A file of lines: what the study is, then a row for each point, in any order.

    Lines are appended in one write each, also by several processes, and have a checksum; a line
    that a kill cut off is left out when it is read, so is one that was changed since.

    Parameters
    ----------
    path : Path
        The file; it is made if it is not there.
    about : dict
        What the study is: names of parameters and outcomes, and what they come from.

    Attributes
    ----------
    rows : dict
        Rows that were there, by their point.
    sizes : tuple of int
        Of a row: parameters and outcomes.

    Raises
    ------
    InputError
        If the file is of another study, is none, or cannot be written.

    Warns
    -----
    JoustoWarning
        Of lines that are not as they were written; their points are computed again.
    """

    def __init__(self, path: Path, about: dict[str, Any]) -> None:
        check_file(path)
        self.path = path
        self.rows: dict[Place, Row] = {}
        self.sizes: Sizes = None
        if "outcomes" in about:
            self.sizes = len(about["parameters"]), len(about["outcomes"])
        head = {"format": FORMAT, "version": VERSION, **about}
        try:
            text = path.read_bytes() if path.exists() else b""
            whole = text[: text.rfind(b"\n") + 1]
            if whole:
                self._read(whole, head)
            if len(whole) < len(text):  # cut off by a kill
                with path.open("r+b") as file:
                    file.truncate(len(whole))
            if not whole:
                append(path, head)
        except OSError as error:
            raise unwritable(path, error) from error
        except (UnicodeDecodeError, json.JSONDecodeError):
            raise InputError(Problem(str(path), "is not the journal of a study")) from None

    def _read(self, data: bytes, head: dict[str, Any]) -> None:
        first, *lines = data.split(b"\n")[:-1]
        found = json.loads(first.decode())
        if not isinstance(found, dict) or found.get("format") != FORMAT:
            raise InputError(Problem(str(self.path), "is not the journal of a study"))
        if found.get("version") != VERSION:
            message = (
                f"is a journal of version {found.get('version')!r}, must be {VERSION}, whose rows "
                "have checksums; name another file or remove it"
            )
            raise InputError(Problem(str(self.path), message))
        check_same(self.path, found, head)
        bad: list[str] = []
        for number, line in enumerate(lines, 2):
            try:
                x, row = read_row(line, self.sizes)
                self.rows[x] = row
            except ValueError as error:
                bad.append(f"line {number} {error}")
        if bad:
            more = "" if len(bad) <= SHOWN else f" and {count(len(bad) - SHOWN, 'more')}"
            message = f"{'; '.join(bad[:SHOWN])}{more}; skipped, and computed again where needed"
            warn(str(self.path), message)

    def add(self, x: Sequence[float], row: Row) -> None:
        """Append a row.

        Raises
        ------
        InputError
            If it cannot be written.
        """
        write_row(self.path, x, row)


def check_same(path: Path, found: dict[str, Any], about: dict[str, Any]) -> None:
    """Refuse a file of another study, or of one that cannot be compared with this.

    Raises
    ------
    InputError
        If it is not the same.
    """
    if found == about:
        return
    changed = [name for name in about if found.get(name) != about[name]]
    message = f"holds another study ({', '.join(changed)} differ); name another file or remove it"
    for name in changed:
        if what := unknown(about[name]):
            message = (
                f"may hold another study: its {name} cannot be compared, it holds {what}; name "
                "another file, or let functions find that at the top level of their module"
            )
    raise InputError(Problem(str(path), message))


def checksum(row: dict[str, Any]) -> int:
    """Return the CRC-32 of a row as it is written."""
    return zlib.crc32(json.dumps(row, separators=(",", ":")).encode())


def read_row(line: bytes, sizes: Sizes) -> tuple[Place, Row]:
    """Return point and row of a line.

    Raises
    ------
    ValueError
        With what is wrong with the line.
    """
    try:
        found = json.loads(line.decode())
        row = {key: found[key] for key in ("x", "y", "failed")}
        x, y = tuple(map(float, row["x"])), [float(v) for v in row["y"]]
        good = found["sum"] == checksum(row)
    except (ValueError, KeyError, TypeError):
        raise ValueError("is no row of a study") from None
    if not good:
        raise ValueError("was changed since it was written (checksum)")
    if sizes is not None and (len(x), len(y)) != sizes:
        has, must = (
            f"{count(a, 'value')} and {count(b, 'outcome')}" for a, b in ((len(x), len(y)), sizes)
        )
        raise ValueError(f"has {has}, must have {must}")
    return x, (y, str(row["failed"]))


def write_row(path: Path, x: Sequence[float], row: Row) -> None:
    """Append a row to a journal.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    try:
        line = {"x": [float(v) for v in x], "y": row[0], "failed": row[1]}
        append(path, line | {"sum": checksum(line)})
    except OSError as error:
        raise unwritable(path, error) from error


def append(path: Path, line: dict[str, Any]) -> None:
    """Append a line in one write, so that a kill leaves the whole line or a piece at the end."""
    data = (json.dumps(line, separators=(",", ":")) + "\n").encode()
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
    try:
        while data:
            data = data[os.write(handle, data) :]
    finally:
        os.close(handle)
