"""StudyTable: parameters and outcomes of all points, and the reasons of failed points."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, UnknownNameError, count, suggest
from jousto.base.files import Rows, Tabular, written
from jousto.base.hdf5 import open_format
from jousto.base.object_repr import described
from jousto.design.studies.running.journal import FORMAT, VERSION

SUFFIXES = (".h5", ".hdf5", ".csv", ".parquet")
FAILED = "failed"
REMEDY = "the study can be run again"


def label(name: str, unit: str) -> str:
    """Return ``wall (m)``."""
    return name if unit == "1" else f"{name} ({unit})"


@described
@dataclass(frozen=True, eq=False)
class StudyTable(Tabular):
    """Parameters and outcomes of the points of a study.

    ``table["wall"]`` and ``table["max(tip.y)"]`` are columns (n,); outcomes of failed points are
    NaN.

    Parameters
    ----------
    parameters, outcomes : tuple of str
        Names of the columns.
    x : (n, np) array
        Values of the parameters, SI.
    y : (n, no) array
        Outcomes, SI; NaN where a point failed.
    reasons : tuple of str
        Reason of each failed point; empty for the others.
    units : dict of str to str
        SI unit of every column.
    notes : dict of str to int
        Warnings, with the number of their occurrences.
    about : dict
        Identity of the study, so that a later run can continue it.
    """

    parameters: tuple[str, ...]
    outcomes: tuple[str, ...]
    x: Array
    y: Array
    reasons: tuple[str, ...]
    units: dict[str, str] = field(default_factory=dict)
    notes: dict[str, int] = field(default_factory=dict)
    about: dict[str, Any] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.x)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of all columns, parameters first."""
        return (*self.parameters, *self.outcomes)

    @property
    def good(self) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """Mask (n,) of the points that did not fail."""
        return np.array([not reason for reason in self.reasons], dtype=bool)

    @property
    def failed(self) -> dict[int, str]:
        """Indices of the failed points with the reasons."""
        return {i: reason for i, reason in enumerate(self.reasons) if reason}

    def label(self, name: str) -> str:
        """Return name and unit of a column, ``wall (m)``."""
        return label(name, self.units.get(name, "1"))

    def __getitem__(self, name: str) -> Array:
        """Return a column (n,).

        Raises
        ------
        InputError
            For an unknown name; close ones are suggested. A `KeyError`, too.
        """
        if name in self.parameters:
            return self.x[:, self.parameters.index(name)]
        if name in self.outcomes:
            return self.y[:, self.outcomes.index(name)]
        raise UnknownNameError(Problem("study", f"no column {name!r}{suggest(name, self.columns)}"))

    def _facts(self) -> str:
        failed = len(self.failed)
        facts = f"{count(len(self), 'point')} of {', '.join(self.parameters)}; "
        return facts + ", ".join(self.outcomes) + (f"; {failed} failed" if failed else "")

    def __str__(self) -> str:
        """Return the smallest and largest value of every column, and the reasons of failures."""
        lines = [repr(self)]
        width = max((len(self.label(name)) for name in self.columns), default=0)
        for name in self.columns:
            values = self[name][np.isfinite(self[name])]
            span = f"{values.min():.6g} to {values.max():.6g}" if len(values) else "nothing"
            lines.append(f"  {self.label(name):<{width}}  {span}")
        counts: dict[str, int] = {}
        for reason in self.failed.values():
            counts[reason] = counts.get(reason, 0) + 1
        lines += [f"  failed {n} x: {reason}" for reason, n in counts.items()]
        lines += [f"  warned {n} x: {note}" for note, n in self.notes.items()]
        return "\n".join(lines)

    def _csv(self) -> Rows:
        head = [*map(self.label, self.columns), FAILED]
        both = zip(self.x.tolist(), self.y.tolist(), self.reasons, strict=True)
        return head, ([*x, *y, reason] for x, y, reason in both)

    def to_pandas(self) -> Any:
        """Return a ``pandas.DataFrame``; needs the extra ``frames``.

        ``frame.attrs["units"]`` contains the unit of each column; the last column, ``failed``,
        contains the reason of a failure.

        Raises
        ------
        InputError
            If pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            message = "needs pandas: pip install pandas"
            raise InputError(Problem("to_pandas", message)) from None
        frame = pandas.DataFrame(np.hstack([self.x, self.y]), columns=list(self.columns))
        frame[FAILED] = list(self.reasons)
        frame.attrs["units"] = dict(self.units)
        return frame

    @explained
    def save(self, path: str | Path) -> Path:
        """Write the table in the format of the suffix: .h5, .csv, .parquet.

        Only .h5 contains the whole table, for `read_study`. Parquet needs pandas and pyarrow.

        Raises
        ------
        InputError
            For another suffix, or a file that cannot be written.
        """
        target = Path(path)
        check_suffix(target)
        if target.suffix == ".csv":
            return self.to_csv(target)
        if target.suffix == ".parquet":
            return self._parquet(target)
        with written(target) as beside, h5py.File(beside, "w") as file:
            file.attrs["format"] = FORMAT
            about = {name: getattr(self, name) for name in ("parameters", "outcomes", "units")}
            about |= {"notes": self.notes, "about": self.about, "version": VERSION}
            file.attrs["about"] = json.dumps(about)
            file["x"], file["y"] = self.x, self.y
            file["failed"] = np.frombuffer(json.dumps(self.reasons).encode(), np.uint8)
        return target

    def _parquet(self, target: Path) -> Path:
        frame = self.to_pandas()
        try:
            with written(target) as beside:
                frame.to_parquet(beside)
        except ImportError:
            raise InputError(Problem(str(target), "needs the package pyarrow")) from None
        return target


def check_suffix(path: Path) -> None:
    """Raise InputError for a suffix in which tables cannot be written.

    Raises
    ------
    InputError
        For an unknown suffix.
    """
    if path.suffix not in SUFFIXES:
        known = ", ".join(SUFFIXES)
        found = f"{path.suffix!r} is not a format of tables" if path.suffix else "has no suffix"
        raise InputError(Problem(str(path), f"{found}; known: {known}"))


@explained
def read_study(path: str | Path) -> StudyTable:
    """Return the table of a study from an .h5 file that ``save`` wrote.

    Parameters
    ----------
    path : path
        The file.

    Raises
    ------
    InputError
        If the file is missing, damaged or of another kind.
    """
    with open_format(Path(path), FORMAT, "the table of a study", REMEDY) as file:
        about = json.loads(str(file.attrs["about"]))
        names, outcomes = tuple(about["parameters"]), tuple(about["outcomes"])
        x = file.array("x", (None, len(names)))
        y = file.array("y", (len(x), len(outcomes)))
        reasons = tuple(json.loads(bytes(file.array("failed", (None,), "u"))))
        if len(reasons) != len(x):
            raise ValueError("the number of its reasons is not that of its points")
        return StudyTable(
            names, outcomes, x, y, reasons, about["units"], about["notes"], about["about"]
        )
