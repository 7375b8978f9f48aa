"""Reading the record of a monitoring run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, count, suggest
from jousto.base.files import written
from jousto.base.hdf5 import Group, check_dataset
from jousto.measurement.monitor.health import STATES
from jousto.measurement.monitor.record_writer import ENDED, open_record

# columns of each table: values per row (None: any number, 0: a scalar) and data type
TABLES: dict[str, dict[str, tuple[str | int | None, str]]] = {
    "samples": {
        "time": (0, "f"),
        "strain": ("channels", "f"),
        "states": ("channels", "u"),
        "stress": ("spots", "f"),
        "low": ("spots", "f"),
        "high": ("spots", "f"),
    },
    "summary": {
        **dict.fromkeys(("time", "watched"), (0, "f")),
        **dict.fromkeys(("samples", "blind", "garbage", "backwards"), (0, "i")),
        **dict.fromkeys(("peak", "damage", "damage_low", "damage_high"), ("spots", "f")),
        **dict.fromkeys(("remaining", "remaining_low", "remaining_high"), ("spots", "f")),
    },
    "events": {"time": (0, "f"), "kind": (0, "u"), "text": (None, "u")},
}
KINDS = ("start", "channel", "alarm", "garbage", "backwards", "clock", "gap", "resumed", "end")
"""Kinds of events."""
WITHOUT_CURVE = ("time", "samples", "blind", "garbage", "backwards", "peak")


@dataclass(frozen=True)
class Event:
    """Event of a monitoring run.

    Attributes
    ----------
    time : float
        s; nan before the first sample.
    kind : str
        "start", "channel", "alarm", "garbage", "backwards", "clock", "gap", "resumed" or "end".
    text : str
        Description.
    """

    time: float
    kind: str
    text: str


@explained
class MonitorRecord:
    """Record of a monitoring run, also of a running or a killed one.

    Parameters
    ----------
    path : path
        File that `watch` or ``jousto monitor`` wrote.

    Attributes
    ----------
    path : Path
        The file.
    attributes : dict
        criterion, level, every, residue, curve, limit_stress, ...
    channels, spots : tuple of str
        Gauges and hot spots.
    complete : bool
        Whether the source was read to its end.
    ended : str
        Reason of the end.

    Raises
    ------
    InputError
        If the file is not a record.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        with open_record(self.path) as file:
            self.attributes: dict[str, Any] = {
                name: value.item() if isinstance(value, np.generic) else value
                for name, value in file.attrs.items()
            }
            self.channels = tuple(name.decode() for name in file["channels"][()])
            self.spots = tuple(name.decode() for name in file["spots"][()])
            self.complete = bool(file["complete"][()])
            self.ended = bytes(file[ENDED][()]).decode(errors="replace").strip()
            self._rows = {t: int(file.array(f"{t}/rows", (), "iu")) for t in TABLES}
            _check(file, self._rows, len(self.channels), len(self.spots))

    def __len__(self) -> int:
        return self._rows["samples"]

    def __repr__(self) -> str:
        return f"<MonitorRecord {self.path.name!r}: {count(len(self), 'sample')}>"

    def _read(self, table: str, name: str) -> NDArray[Any]:
        with open_record(self.path) as file:
            if f"{table}/{name}" not in file:
                known = sorted(file.group(table))
                raise InputError(
                    Problem(str(self.path), f"{table} has no '{name}'{suggest(name, known)}")
                )
            return np.asarray(file[f"{table}/{name}"][: self._rows[table]])

    @property
    def time(self) -> Array:
        """Instants (nt,), s."""
        return self._read("samples", "time")

    @property
    def strain(self) -> Array:
        """Strains as measured (nt, nc), m/m."""
        return self._read("samples", "strain")

    @property
    def states(self) -> NDArray[np.uint8]:
        """States of the channels (nt, nc), indices of `STATES`; 0 is ok."""
        return self._read("samples", "states")

    @property
    def stress(self) -> Array:
        """Stress at the hot spots (nt, ns), Pa; nan with too few valid channels."""
        return self._read("samples", "stress")

    @property
    def low(self) -> Array:
        """Lower end of the band of the stress (nt, ns), Pa."""
        return self._read("samples", "low")

    @property
    def high(self) -> Array:
        """Upper end of the band of the stress (nt, ns), Pa."""
        return self._read("samples", "high")

    def summary(self, name: str) -> Array:
        """Return a column of the interval summaries, one row per interval.

        Parameters
        ----------
        name : str
            "time", "samples", "blind", "garbage", "backwards", "peak", and with an S-N curve
            "watched", "damage", "damage_low", "damage_high", "remaining", "remaining_low",
            "remaining_high" (s).
        """
        return self._read("summary", name)

    @property
    def counted(self) -> bool:
        """Whether the record contains damage."""
        with open_record(self.path) as file:
            return "damage" in file["summary"]

    @property
    def events(self) -> tuple[Event, ...]:
        """Events in order of time."""
        rows = zip(*(self._read("events", n) for n in ("time", "kind", "text")), strict=True)
        return tuple(
            Event(float(t), KINDS[int(k)], bytes(x).rstrip(b"\0").decode(errors="replace"))
            for t, k, x in rows
        )

    @property
    def model_text(self) -> str:
        """Text of the model file."""
        with open_record(self.path) as file:
            return str(file["model"].asstr()[()])

    def to_csv(self, path: str | Path) -> None:
        """Write time and stress with its band as CSV, one line per sample; MPa."""
        names = [f"{s}{end} [MPa]" for s in self.spots for end in ("", " low", " high")]
        table = np.stack([self.stress, self.low, self.high], axis=2) / 1e6
        rows = np.column_stack([self.time, table.reshape(len(table), -1)])
        head = ",".join(["time [s]", *names])
        with written(Path(path)) as beside:
            np.savetxt(beside, rows, delimiter=",", header=head, comments="", fmt="%.9g")

    def __str__(self) -> str:
        n, summary = len(self), self._rows["summary"]
        state = "complete" if self.complete else self.ended
        lines = [
            f"{count(n, 'sample')}, {count(len(self.channels), 'channel')}, "
            f"{self.attributes['criterion']}, {100 * self.attributes['level']:g} % bands; {state}"
        ]
        if n:
            states, time = self.states, self.time
            lines[0] += f"; {time[0]:.6g} to {time[-1]:.6g} s"
            for c, name in enumerate(self.channels):
                bad = np.bincount(states[:, c], minlength=len(STATES))
                if bad[1:].any():
                    parts = [f"{STATES[k]} {bad[k]}" for k in range(1, len(STATES)) if bad[k]]
                    lines.append(f"channel {name}: {', '.join(parts)} of {n} samples")
        if summary:
            lost = {name: int(self.summary(name)[-1]) for name in ("garbage", "backwards")}
            blind = int(self.summary("blind").sum())
            if any(lost.values()) or blind:
                lines.append(
                    f"{lost['garbage']} invalid lines, {lost['backwards']} whose time goes "
                    f"backwards; {blind} samples with too few channels"
                )
            peak = np.fmax.reduce(self.summary("peak"), axis=0)
            width = max(4, *(len(s) for s in self.spots))
            head = f"{'spot':<{width}}  peak, MPa"
            if self.counted:
                head += "     damage  (band)                  remaining life (band)"
                last = {
                    x: self.summary(x)[-1]
                    for x in (
                        "damage",
                        "damage_low",
                        "damage_high",
                        "remaining",
                        "remaining_low",
                        "remaining_high",
                    )
                }
            lines.append(head)
            for k, spot in enumerate(self.spots):
                line = f"{spot:<{width}}  {peak[k] / 1e6:9.4g}"
                if self.counted:
                    line += (
                        f"  {last['damage'][k]:9.3g}  ({last['damage_low'][k]:.3g} to "
                        f"{last['damage_high'][k]:.3g})"
                    ).ljust(38)
                    line += (
                        f"{duration(last['remaining'][k])} ({duration(last['remaining_low'][k])} "
                        f"to {duration(last['remaining_high'][k])})"
                    )
                lines.append(line)
        return "\n".join(lines)


def duration(seconds: float) -> str:
    """Return a duration in s as text such as "1.5 min".

    Examples
    --------
    >>> duration(90.0), duration(3.2e8), duration(float("inf"))
    ('1.5 min', '10.1 years', 'no damage')
    """
    if not np.isfinite(seconds):
        return "no damage"
    for size, unit in (
        (365.25 * 86400.0, "years"),
        (86400.0, "days"),
        (3600.0, "h"),
        (60.0, "min"),
    ):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"


def _check(file: Group, rows: dict[str, int], channels: int, spots: int) -> None:
    """Raise InputError with the first invalid field of a record."""
    for name in ("criterion", "level"):
        wanted = str if name == "criterion" else float
        if not isinstance(file.attrs.get(name), wanted):
            raise ValueError(f"attribute {name} is missing or of another kind")
    check_dataset(file["model"], (), "OS")
    sizes = {"channels": channels, "spots": spots}
    for table, columns in TABLES.items():
        found = file.group(table)
        for name, (width, kinds) in columns.items():
            if table == "summary" and name not in WITHOUT_CURVE and "watched" not in found:
                continue  # a record without damage
            number = sizes[width] if isinstance(width, str) else width
            check_dataset(found[name], (None, number) if width != 0 else (None,), kinds)
            if not 0 <= rows[table] <= len(found[name]):
                raise ValueError(
                    f"{table}/rows is {rows[table]}, {table}/{name} has {len(found[name])}"
                )
    kind = file["events/kind"][: rows["events"]]
    if kind.size and kind.max() >= len(KINDS):
        raise ValueError("events/kind contains kinds of events that do not exist")
