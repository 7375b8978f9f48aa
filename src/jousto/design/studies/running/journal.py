"""Journal: rows of a study on disk as they are computed, one line each, whole or not there."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jousto.base.errors import InputError, Problem
from jousto.base.files import check_file, unwritable
from jousto.design.studies.running.evaluator import Row
from jousto.design.studies.running.keys import unknown

FORMAT = "jousto study"
VERSION = 1
Place = tuple[float, ...]


class Journal:
    """A file of lines: what the study is, then a row for each point, in any order.

    Lines are appended in one write each, also by several processes; a line that a kill cut off is
    left out when it is read.

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

    Raises
    ------
    InputError
        If the file is of another study, is none, or cannot be written.
    """

    def __init__(self, path: Path, about: dict[str, Any]) -> None:
        check_file(path)
        self.path = path
        self.rows: dict[Place, Row] = {}
        head = {"format": FORMAT, "version": VERSION, **about}
        try:
            text = path.read_bytes() if path.exists() else b""
            whole = text[: text.rfind(b"\n") + 1]
            if whole:
                self._read(whole.decode(), head)
            if len(whole) < len(text):  # cut off by a kill
                with path.open("r+b") as file:
                    file.truncate(len(whole))
            if not whole:
                append(path, head)
        except OSError as error:
            raise unwritable(path, error) from error
        except (UnicodeDecodeError, json.JSONDecodeError):
            raise InputError(Problem(str(path), "is not the journal of a study")) from None

    def _read(self, text: str, head: dict[str, Any]) -> None:
        first, *lines = text.splitlines()
        found = json.loads(first)
        if not isinstance(found, dict) or found.get("format") != FORMAT:
            raise InputError(Problem(str(self.path), "is not the journal of a study"))
        check_same(self.path, found, head)
        for line in lines:
            try:
                row = json.loads(line)
                self.rows[tuple(row["x"])] = ([float(y) for y in row["y"]], str(row["failed"]))
            except (ValueError, KeyError, TypeError):
                continue  # two programs that died at the same place

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


def write_row(path: Path, x: Sequence[float], row: Row) -> None:
    """Append a row to a journal.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    try:
        append(path, {"x": [float(v) for v in x], "y": row[0], "failed": row[1]})
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
