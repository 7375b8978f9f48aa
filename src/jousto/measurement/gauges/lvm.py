"""LabVIEW measurement files (.lvm): a file header, a header for each segment, columns.

National Instruments, *Specification for the LabVIEW Measurement File (.lvm)*.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from jousto.base.arrays import Array, some
from jousto.base.errors import InputError, Problem
from jousto.measurement.gauges.record import Raw

END = "***End_of_Header***"
NO_UNIT = ("", "none", "unitless")


def read_lvm(path: Path) -> Raw:
    """Return the channels of the first segment with the names and units of its header.

    Raises
    ------
    InputError
        If the file is of another kind or cut off, or a line contains something other than numbers.
    """
    where = str(path)
    lines = path.read_text(encoding="utf-8-sig", errors="replace").splitlines()
    ends = [i for i, line in enumerate(lines) if line.startswith(END)]
    if not lines or not lines[0].startswith("LabVIEW Measurement") or len(ends) < 2:
        raise InputError(
            Problem(
                where,
                "is not a LabVIEW measurement file, or its header is cut off: export it again",
            )
        )
    head = _header(lines[: ends[0]], "\t")
    separator = {"comma": ",", "tab": "\t"}.get(head.get("Separator", ["Tab"])[0].lower(), "\t")
    head = _header(lines[: ends[0]], separator) | _header(lines[ends[0] + 1 : ends[1]], separator)
    dimension = (head.get("X_Dimension") or ["Time"])[0]
    if dimension.lower() not in ("", "time"):
        raise InputError(Problem(where, f"runs over {dimension}, not over time"))
    columns = lines[ends[1] + 1].split(separator) if ends[1] + 1 < len(lines) else []
    x = (head.get("X_Columns") or ["One"])[0].lower()
    entry = (head.get("Channels") or [""])[0]
    titles = [text for text in columns if text.strip() not in ("", "X_Value", "Comment")]
    count = int(entry) if entry.isdigit() else len(titles)
    stop = ends[2] if len(ends) > 2 else len(lines)
    width = count + {"no": 0, "one": 1}.get(x, count)
    if x == "no":  # no column of X: the first field is blank
        columns = columns[1:]
    body = range(ends[1] + 2, stop)
    comma = head.get("Decimal_Separator", ["."])[0] == ","
    rows = [(i + 1, lines[i].split(separator)) for i in body if lines[i].strip()]
    rows = [(i, row[1:] if x == "no" and not row[0].strip() else row) for i, row in rows]
    values, left = _numbers(where, rows, comma, width)
    each = 2 if x == "multi" else 1
    places = [each * i + (x != "no") for i in range(count)]
    names = _unique([columns[k].strip() if k < len(columns) else "" for k in places])
    labels = [*head.get("Y_Unit_Label", []), *[""] * count][:count]
    t = values[:, 0] if x != "no" else _instants(where, head, len(values))
    notes = list(left)
    if len(ends) > 2:
        message = f"{len(ends) - 2} more segments follow from line {ends[2] + 1}: left out"
        notes.append(message)
    channels: dict[str, Array] = {}
    for i, (name, k) in enumerate(zip(names, places, strict=True)):
        y = values[:, k]
        if x == "multi" and i:
            y = np.interp(t, values[:, k - 1], y, left=np.nan, right=np.nan)
        channels[name] = y
    units: dict[str, str | None] = {
        name: _unit(label) for name, label in zip(names, labels, strict=True)
    }
    return t, channels, units, None, tuple(notes)


def _header(lines: list[str], separator: str) -> dict[str, list[str]]:
    rows = [line.split(separator) for line in lines]
    return {row[0]: [word.strip() for word in row[1:]] for row in rows if len(row) > 1}


def _instants(where: str, head: dict[str, list[str]], number: int) -> Array:
    found = []
    for key, default in (("X0", "0"), ("Delta_X", "")):
        entry = (head.get(key) or [default])[0] or default
        try:
            found.append(float(entry.replace(",", ".")))
        except ValueError:
            message = f"{key} is {entry!r}, must be a number, since there is no column of X"
            raise InputError(Problem(where, message)) from None
    instants = found[0] + found[1] * np.arange(number, dtype=np.float64)
    return np.asarray(instants)


def _numbers(
    where: str, rows: list[tuple[int, list[str]]], comma: bool, width: int
) -> tuple[Array, tuple[str, ...]]:
    """Return the columns (nt, width); nan for empty fields. A trailing comment is ignored."""
    out, short = [], []
    for i, row in rows:
        words = [word.replace(",", ".") if comma else word for word in row[:width]]
        if len(words) < width:
            short.append(str(i))
            continue
        try:
            out.append([float(word.strip() or "nan") for word in words])
        except ValueError:
            message = " ".join(row)[:40]
            sentence = f"{message!r} must be {width} numbers"
            raise InputError(Problem(f"{where}:{i}", sentence)) from None
    if not out or not width:
        raise InputError(Problem(where, "has no line of numbers below its header: is it cut off?"))
    text = f"{len(short)} lines are not {width} numbers and were left out (line {some(short, 3)})"
    return np.array(out), ((text,) if short else ())


def _unique(names: list[str]) -> list[str]:
    out: list[str] = []
    for i, name in enumerate(names, 1):
        name = name or f"channel{i}"
        while name in out:
            name += "'"
        out.append(name)
    return out


def _unit(label: str) -> str | None:
    known = {"volts": "V", "newtons": "N", "strain": "m/m", "pascals": "Pa"}
    return None if label.lower() in NO_UNIT else known.get(label.lower(), label)
