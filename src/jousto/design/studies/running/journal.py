"""Journal: the rows of a study on disk, one complete line per point."""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jousto.base.errors import InputError, Problem, count, warn
from jousto.base.files import check_file, unwritable
from jousto.design.studies.running.content_hash import incomparable
from jousto.design.studies.running.evaluator import Row

FORMAT = "jousto study"
VERSION = 2
"""Format of the file; each row has a checksum since version 2."""
SHOWN = 5
"""Number of damaged lines named in a warning."""
Place = tuple[float, ...]
Sizes = tuple[int, int] | None
"""Numbers of parameters and outcomes of a row; None if unknown."""


class Journal:
    """File of lines: the identity of the study, then one row per point in any order.

    Each line is appended in one write, also by several processes, and has a checksum; reading skips
    a line that is incomplete after a kill or was changed later.

    Parameters
    ----------
    path : Path
        The file; it is created if it does not exist.
    about : dict
        Identity of the study: names of parameters and outcomes, and the hash of the model.

    Attributes
    ----------
    rows : dict
        Rows already in the file, by their point.
    sizes : tuple of int
        Numbers of parameters and outcomes in a row.

    Raises
    ------
    InputError
        If the file belongs to another study, is not a journal, or cannot be written.

    Warns
    -----
    JoustoWarning
        For damaged lines; their points are computed again.
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
            if len(whole) < len(text):  # incomplete last line of a killed program
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
            If the row cannot be written.
        """
        write_row(self.path, x, row)


def check_same(path: Path, found: dict[str, Any], about: dict[str, Any]) -> None:
    """Raise InputError if the file belongs to another study or to one without comparable key.

    Raises
    ------
    InputError
        If the study is not the same.
    """
    if found == about:
        return
    changed = [name for name in about if found.get(name) != about[name]]
    message = (
        f"contains another study ({', '.join(changed)} differ); name another file or remove it"
    )
    for name in changed:
        if what := incomparable(about[name]):
            message = (
                f"may contain another study: {what} in its {name} cannot be compared; name "
                "another file, or define that at the top level of a module"
            )
    raise InputError(Problem(str(path), message))


def checksum(row: dict[str, Any]) -> int:
    """Return the CRC-32 of the text of a row."""
    return zlib.crc32(json.dumps(row, separators=(",", ":")).encode())


def read_row(line: bytes, sizes: Sizes) -> tuple[Place, Row]:
    """Return point and row of a line.

    Raises
    ------
    ValueError
        If the line is damaged; the message gives the reason.
    """
    try:
        found = json.loads(line.decode())
        row = {key: found[key] for key in ("x", "y", "failed")}
        x, y = tuple(map(float, row["x"])), [float(v) for v in row["y"]]
        good = found["sum"] == checksum(row)
    except (ValueError, KeyError, TypeError):
        raise ValueError("is not a row of a study") from None
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
        If the row cannot be written.
    """
    try:
        line = {"x": [float(v) for v in x], "y": row[0], "failed": row[1]}
        append(path, line | {"sum": checksum(line)})
    except OSError as error:
        raise unwritable(path, error) from error


def append(path: Path, line: dict[str, Any]) -> None:
    """Append a line in one write call: after a kill only the last line can be incomplete."""
    data = (json.dumps(line, separators=(",", ":")) + "\n").encode()
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
    try:
        while data:
            data = data[os.write(handle, data) :]
    finally:
        os.close(handle)
