"""read_record: measured data from text, universal and HDF5 files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, MissingFileError, Problem, Problems, suggest, warn
from jousto.base.files import check_input
from jousto.measurement.gauges.clock import counted
from jousto.measurement.gauges.lvm import read_lvm
from jousto.measurement.gauges.record import GAP, Raw, Record, record_of, too_large
from jousto.measurement.gauges.table import read_table
from jousto.measurement.gauges.time_stamps import ordered
from jousto.measurement.gauges.units import STRAIN, parse_unit

TIMES = ("time", "t", "zeit", "aika", "timestamp", "time stamp", "datetime", "date", "temps",
         "tiempo", "tid", "x")  # fmt: skip
"""Lower-case headings of a time column."""

FREQUENCIES = ("frequency", "freq", "f", "frequenz", "taajuus", "frequence", "fréquence")
"""Lower-case headings of a frequency column."""

FLAT = 5
"""Number of consecutive samples at the end of its range from which a channel is saturated."""


@explained
def read_record(
    path: str | Path,
    *,
    time: str | None = None,
    rate: float | None = None,
    units: Mapping[str, str] | None = None,
    repair: bool = False,
) -> Record:
    """Return the measured channels of a file in SI units.

    Text files (.csv, .txt, .asc ...): any of the usual delimiters, decimal point or comma, headings
    with units such as ``g1 [um/m]`` or a line of units. Times of day, dates, milliseconds since
    1970 and days of a spreadsheet become seconds from the first instant. LabVIEW (.lvm): names and
    units of the headers. Universal files (.uff, .unv): functions over time of data set 58. HDF5:
    results of jousto (its sensors are the channels), or data sets of equal length with an attribute
    ``unit``.

    Parameters
    ----------
    path : path
    time : str, optional
        Column of time; by default the column with such a heading, else the first one.
    rate : float, optional
        Samples per second of a file without time.
    units : mapping of str to str, optional
        Units of channels, or of the time column, that are missing or wrong in the file.
    repair : bool
        Whether to sort instants that run backwards, remove repeated ones and continue over
        midnight, instead of an error. A clock that restarts is still an error, since the file then
        contains several records.

    Raises
    ------
    InputError
        With all problems: no table, an empty file, time that runs backwards or stands still, an
        unknown unit, strain that is probably in percent or um/m, a missing column.

    Warns
    -----
    JoustoWarning
        For gaps, missing values, and channels that never change or are clipped at an end of their
        range; ``record.notes`` contains the same texts.
    """
    file = Path(path)
    where = str(file)
    if not file.exists():
        near = suggest(file.name, [p.name for p in file.parent.glob("*") if p.is_file()])
        raise MissingFileError(
            Problem(where, f"there is no such file{near if 'mean' in near else ''}")
        )
    check_input(file)
    asked = dict(units or {})
    with file.open("rb") as opened:
        head = opened.read(8)
    if not head:
        raise InputError(Problem(where, "is empty: there is no line of numbers"))
    if head == b"\x89HDF\r\n\x1a\n":
        raw = _hdf5(file, time, rate, asked)
    elif file.suffix.lower() in (".uff", ".unv", ".uf"):
        raw = _universal(file)
    elif file.suffix.lower() == ".lvm":
        raw = read_lvm(file)
    else:
        raw = _text(file, time, rate, asked)
    return _record(where, raw, asked, repair)


def _record(where: str, raw: Raw, given: dict[str, str], repair: bool) -> Record:
    t, channels, labels, time_unit, notes = raw
    problems = Problems()
    for name in given:
        if name not in channels and (name.lower() not in TIMES or time_unit != given[name]):
            problems.add(where, f"units: no channel '{name}'{suggest(name, channels)}")
    found = None if time_unit is None else parse_unit(time_unit)
    if time_unit is not None and (found is None or found[0] != "s"):
        problems.add(where, f"time is in '{time_unit}', must be s, ms, us, min or h")
    elif found is not None:
        t = t * found[1]

    units: dict[str, str] = {}
    for name in channels:
        label = given.get(name, labels.get(name))
        if label is None or label == "":
            units[name] = ""
            continue
        unit = parse_unit(label)
        if unit is None:
            problems.add(
                where,
                f"channel '{name}' has the unknown unit '{label}'; give units={{'{name}': ...}} "
                "with one such as um/m, mV/V, MPa, kN or 1",
            )
            continue
        units[name] = unit[0]
        channels[name] = channels[name] * unit[1]
        if unit[0] == STRAIN:
            sentence = too_large(name, channels[name])
            if sentence:
                problems.add(where, f"{sentence} (the file says '{label}')")
    t, channels, order = ordered(problems, where, t, channels, repair)
    problems.raise_if_any()
    remarks = [*notes, *order, *_remarks(t, channels)]
    for remark in remarks:
        warn(where, remark)
    return Record(t, channels, units, name=Path(where).name, notes=tuple(remarks))


def _remarks(t: Array, channels: dict[str, Array]) -> list[str]:
    """Return notes on gaps, missing values, constant and saturated channels."""
    out = []
    steps = np.diff(t)
    usual = float(np.median(steps))
    gaps = np.flatnonzero(steps > GAP * usual)
    if len(gaps):
        longest = int(gaps[np.argmax(steps[gaps])])
        out.append(
            f"{len(gaps)} gaps in time, the longest of {steps[longest]:.4g} s after "
            f"{t[longest]:.6g} s (usually {usual:.4g} s)"
        )
    for name, x in channels.items():
        good = np.isfinite(x)
        lost = len(x) - np.count_nonzero(good)
        if lost == len(x):
            out.append(f"channel '{name}' has no value at all")
            continue
        if lost:
            first = int(np.argmin(good))
            out.append(
                f"channel '{name}' misses {lost} of {len(x)} values, first at {t[first]:.6g} s"
            )
        y = x[good]
        if np.ptp(y) == 0.0:
            out.append(f"channel '{name}' is constant ({y[0]:.4g}): dead or not connected")
            continue
        for end, level in (("upper", float(y.max())), ("lower", float(y.min()))):
            number = saturated(y, level)
            if number:
                out.append(
                    f"channel '{name}' is cut off at its {end} end {level:.5g} for {number} "
                    "samples: the amplifier is saturated"
                )
    return out


def saturated(x: Array, level: float) -> int:
    """Return the number of samples of a signal that are clipped at an end of its range.

    A clipped sequence has at least `FLAT` samples at the end of the range, and the signal enters or
    leaves it with a step, in contrast to a signal that comes to rest.
    """
    if abs(level) < 0.5 * float(np.abs(x).max()):
        return 0
    at = x == level
    edges = np.flatnonzero(np.diff(np.concatenate([[False], at, [False]]).astype(np.int8)))
    moves = np.abs(np.diff(x))
    moving = moves[moves > 0.0]
    if not len(moving):
        return 0
    typical = float(np.median(moving))
    total = 0
    for a, b in zip(edges[::2], edges[1::2], strict=True):
        steps = [moves[a - 1]] if a > 0 else []
        steps += [moves[b - 1]] if b < len(x) else []
        if b - a >= FLAT and steps and max(steps) > 0.1 * typical:
            total += int(b - a)
    return total


# -- text -------------------------------------------------------------------------------------


def _text(path: Path, time: str | None, rate: float | None, given: dict[str, str]) -> Raw:
    """Return the raw data of text columns; a unit of the time column is removed from `units`."""
    table = read_table(path)
    names = list(table.names)
    where = str(path)
    if rate is not None:
        _check_rate(where, rate)
        t = np.arange(len(table.values)) / rate
        columns = dict(zip(names, table.values.T, strict=True))
        return t, columns, dict(zip(names, table.labels, strict=True)), None, table.notes
    k = _time_column(where, names, table.labels, table.values, time)
    label = given.pop(names[k], table.labels[k])
    t, about = counted(names[k], table.values[:, k].copy(), label)
    others = [i for i in range(len(names)) if i != k]
    columns = {names[i]: table.values[:, i].copy() for i in others}
    labels = {names[i]: table.labels[i] for i in others}
    return t, columns, labels, label, (*table.notes, *about)


def _check_rate(where: str, rate: float) -> None:
    problems = Problems()
    problems.positive(where, "rate", rate, "1/s")
    problems.raise_if_any()


def _time_column(
    where: str,
    names: list[str],
    labels: tuple[str | None, ...],
    values: Array,
    wanted: str | None,
) -> int:
    if wanted is not None:
        if wanted not in names:
            raise InputError(Problem(where, f"no column '{wanted}'{suggest(wanted, names)}"))
        return names.index(wanted)
    for i, name in enumerate(names):
        if name.lower() in TIMES:
            return i
    for i, label in enumerate(labels):
        unit = None if label is None else parse_unit(label)
        if unit is not None and unit[0] == "s":
            return i
    first = values[:, 0]
    if np.mean(np.diff(first[np.isfinite(first)]) > 0.0) > 0.9:
        parsed = None if labels[0] is None else parse_unit(labels[0])
        spectrum = names[0].lower() in FREQUENCIES or (parsed is not None and parsed[0] == "Hz")
        if parsed is None and not spectrum:
            return 0
        what = "a frequency: this is a spectrum" if spectrum else f"in {labels[0]}"
        raise InputError(
            Problem(
                where,
                f"no column of time: the first, '{names[0]}', is {what}; name the column of time, "
                "time=..., or give rate= in samples per second",
            )
        )
    raise InputError(
        Problem(
            where,
            f"no column of time: none of {', '.join(names[:6])} is called time and the first does "
            "not ascend; name it, time=..., or give rate= in samples per second",
        )
    )


# -- universal files --------------------------------------------------------------------------


def _universal(path: Path) -> Raw:
    where = str(path)
    try:
        import pyuff
    except ImportError:
        raise InputError(Problem(where, "universal files need pyuff: pip install pyuff")) from None
    try:
        sets = pyuff.UFF(str(path)).read_sets()
    except Exception as error:
        raise InputError(Problem(where, f"cannot be read as a universal file: {error}")) from error
    found: list[dict[str, Any]] = sets if isinstance(sets, list) else [sets]
    functions = [s for s in found if s.get("type") == 58 and s.get("func_type") == 1]
    if not functions:
        kinds = sorted({str(s.get("type")) for s in found})
        raise InputError(
            Problem(
                where,
                "has no function over time (data set 58 of type 1); it has data sets "
                f"{', '.join(kinds) or 'none'}",
            )
        )
    problems = Problems()
    for i, function in enumerate(functions):
        _cut_to_length(problems, where, i, function)
    problems.raise_if_any()
    t = np.asarray(functions[0]["x"], dtype=np.float64)
    columns: dict[str, Array] = {}
    labels: dict[str, str | None] = {}
    notes: list[str] = []
    for i, function in enumerate(functions):
        name = str(function.get("id1", "")).strip()
        if not name or name.upper() == "NONE":
            name = f"{function.get('rsp_node', i + 1)}:{function.get('rsp_dir', 0):+d}"
        while name in columns:
            name += "'"
        x = np.asarray(function["x"], dtype=np.float64)
        y = np.real(np.asarray(function["data"])).astype(np.float64)
        if len(x) != len(t) or not np.allclose(x, t, rtol=0.0, atol=1e-6 * abs(t[-1] - t[0])):
            notes.append(f"channel '{name}' has instants of its own and was interpolated")
            y = np.interp(t, x, y, left=np.nan, right=np.nan)
        columns[name] = y
        label = str(function.get("ordinate_axis_units_lab", "")).strip()
        known = label and label.upper() != "NONE"
        # specific data type 3: strain
        strain = function.get("ordinate_spec_data_type") == 3
        labels[name] = label if known else "m/m" if strain else None
    unit = str(functions[0].get("abscissa_axis_units_lab", "")).strip()
    return t, columns, labels, unit if unit and unit.upper() != "NONE" else None, tuple(notes)


def _cut_to_length(problems: Problems, where: str, i: int, function: dict[str, Any]) -> None:
    """Cut a function to its announced number of points; add a problem if it is shorter."""
    number = int(function.get("num_pts", len(function["data"])))
    held = min(len(function["data"]), len(function["x"]))
    if held < number:
        sentence = f"function {i + 1} announces {number} points but has {held}: it is cut off"
        problems.add(where, sentence)
    for name in ("data", "x"):
        function[name] = function[name][:number]


# -- HDF5 -------------------------------------------------------------------------------------


def _hdf5(path: Path, time: str | None, rate: float | None, given: dict[str, str]) -> Raw:
    """Return the raw data of HDF5 data sets; a unit of time is removed from `units`."""
    import h5py

    where = str(path)
    try:
        with h5py.File(path, "r") as file:
            if file.attrs.get("format") == "jousto results":
                return _results(path)
            found: dict[str, Array] = {}
            labels: dict[str, str | None] = {}

            def visit(name: str, item: Any) -> None:
                if isinstance(item, h5py.Dataset) and item.ndim == 1 and item.dtype.kind in "iuf":
                    found[name] = np.asarray(item[()], dtype=np.float64)
                    text = item.attrs.get("unit", item.attrs.get("units"))
                    plain = text.decode() if isinstance(text, bytes) else text
                    labels[name] = None if plain is None else str(plain)

            file.visititems(visit)
    except OSError as error:
        raise InputError(Problem(where, f"is damaged or cut short ({error})")) from error
    if not found:
        raise InputError(Problem(where, "has no data set of one dimension with numbers"))
    short = _short_names(list(found))
    found = {short[name]: x for name, x in found.items()}
    labels = {short[name]: label for name, label in labels.items()}
    notes: list[str] = []
    if rate is not None:
        _check_rate(where, rate)
        length = max(len(x) for x in found.values())
        t, unit = np.arange(length) / rate, None
    else:
        names = [name for name in found if name.split("/")[-1].lower() in TIMES]
        if time is not None:
            names = [name for name in found if name in (time, time.strip("/"))]
        if not names:
            raise InputError(
                Problem(
                    where,
                    f"no data set of time{suggest(time or 'time', found)}; name it, time=..., or "
                    "give rate= in samples per second",
                )
            )
        t, label = found.pop(names[0]), labels.pop(names[0])
        unit = given.pop(names[0], label)
        t, about = counted(names[0], t, unit)
        notes += about
    columns = {}
    for name, x in found.items():
        if len(x) == len(t):
            columns[name] = x
        else:
            notes.append(f"data set '{name}' has {len(x)} values, time {len(t)}: left out")
    return t, columns, labels, unit, tuple(notes)


def _results(path: Path) -> Raw:
    from jousto.simulation.results.solution import load

    record = record_of(load(path))
    labels: dict[str, str | None] = {
        name: unit if parse_unit(unit) is not None else None for name, unit in record.units.items()
    }
    return record.time, dict(record.channels), labels, None, ()


def _short_names(names: list[str]) -> dict[str, str]:
    """Return the last part of each path where it is unique, else the whole path."""
    last = [name.split("/")[-1] for name in names]
    return {
        name: end if last.count(end) == 1 else name for name, end in zip(names, last, strict=True)
    }
