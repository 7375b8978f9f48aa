"""Piecewise polynomial signals: step, ramp, table and S-curve.

Between the times t_i and t_i+1 a signal is ``sum_j c_ji (t - t_i)^(m-j)``; it is constant before
the first time and after the last.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.fields import Choice, Field, field
from jousto.base.files import check_text
from jousto.base.numbers import Number
from jousto.mechanism.signals.base import USE, Jet, Law, Signal


class Series(Field[ArrayLike, Array]):
    """Field of a sequence of numbers."""

    form = "series"
    noun = "(k,) array_like"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a read-only array, or report what is wrong."""
        return problems.array(where, self.name, value, (None,))


class Step(Signal, tag="step", by_value=True):
    """Signal that jumps: `before` for t < time, `after` from then on.

    Examples
    --------
    >>> Step(1.0)([0.999, 1.0])
    array([0., 1.])
    """

    time: Number = field("Time of the jump", unit="s")
    before: Number = field("Value before the jump", unit=USE, default=0.0)
    after: Number = field("Value from the jump on", unit=USE, default=1.0)

    def jet(self, t: Array) -> Jet:
        """Return value, rate and acceleration; the last two are zero."""
        zero = np.zeros(t.shape)
        return zero + np.where(t < self.time, self.before, self.after), zero, zero

    @property
    def law(self) -> Law:
        """Law of the jump."""
        return Law("step", {"time": self.time, "before": self.before, "after": self.after})

    @property
    def jumps(self) -> tuple[float, ...]:
        """The time of the jump, s."""
        return () if self.before == self.after else (self.time,)


class Ramp(Signal, tag="ramp", by_value=True):
    """Straight line from `before` at the time start to `after` at the time end.

    The signal is constant before start and after end.

    Examples
    --------
    >>> Ramp(1.0, 3.0, after=10.0)([0.0, 2.0, 5.0])
    array([ 0.,  5., 10.])
    """

    start: Number = field("Time", unit="s")
    end: Number = field("Time after start", unit="s")
    before: Number = field("Value until start", unit=USE, default=0.0)
    after: Number = field("Value from end on", unit=USE, default=1.0)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report an end that is not after the start."""
        if self.end <= self.start:
            problems.add(
                where, f"end is {self.end:g} s, must be after start, {self.start:g} s", "end"
            )

    def jet(self, t: Array) -> Jet:
        """Return value, rate and acceleration."""
        slope = self._slope
        share = np.clip((t - self.start) / (self.end - self.start), 0.0, 1.0)
        inside = (t >= self.start) & (t < self.end)
        # exact at both ends
        value = self.before * (1 - share) + self.after * share
        return value, np.where(inside, slope, 0.0), np.zeros(t.shape)

    @property
    def _slope(self) -> float:
        return (self.after - self.before) / (self.end - self.start)

    @property
    def law(self) -> Law:
        """Law of the line, a polynomial of degree 1."""
        times = np.array([self.start, self.end])
        return polynomials(times, np.array([[self._slope], [self.before]]))

    @property
    def kinks(self) -> tuple[float, ...]:
        """Start and end, s."""
        return () if self.before == self.after else (self.start, self.end)


class Points(Signal):
    """Signal given by points."""

    times: Series = field("Strictly increasing times", unit="s")
    values: Series = field("Values at these times", unit=USE)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report times that do not increase, and a different number of values."""
        t, y = self.times, self.values
        if len(t) == 0:
            problems.add(where, "times is empty, must have at least one point", "times")
        elif len(t) != len(y):
            problems.add(
                where,
                f"{len(t)} times but {len(y)} values, both must have the same number",
                "values",
            )
        back = np.flatnonzero(np.diff(t) <= 0)
        if len(back):
            i = int(back[0])
            problems.add(
                where,
                f"times must increase: times[{i}] = {t[i]:g} s, times[{i + 1}] = {t[i + 1]:g} s",
                "times",
            )


class Table(Points, tag="table"):
    """Signal interpolated between points, constant before the first and after the last.

    Examples
    --------
    >>> Table((0, 1, 2), (0, 10, 0))([0.5, 5.0])
    array([5., 0.])
    >>> Table((0, 1, 2, 3), (0, 1, 8, 27), "cubic")(2.5)
    np.float64(15.625)
    """

    interpolation: Choice = field(
        "Straight lines, or a cubic spline whose third derivative is continuous at the second "
        "and the last but one point; the cubic has two continuous derivatives between the ends",
        words=("linear", "cubic"),
        default="linear",
    )

    @classmethod
    def from_csv(
        cls,
        path: str | Path,
        *,
        time: str | int = 0,
        value: str | int = 1,
        delimiter: str | None = None,
        interpolation: str = "linear",
    ) -> Table:
        """Return a table whose points are two columns of a text file.

        Parameters
        ----------
        path : str or Path
            File with one point in each line; empty lines and lines that start with # are
            skipped. The first line may contain the names of the columns.
        time, value : str or int
            Column of the times, s, and of the values: its name in the first line or its
            number from 0.
        delimiter : str, optional
            Separator of the columns; None for the first of semicolon, tab, comma and blank (in this
            order) that occurs in the first line.
        interpolation : {"linear", "cubic"}
            As for a table of arrays.

        Raises
        ------
        InputError
            If the file cannot be read, a column is missing or an entry is not a number.
        """
        t, y = read_columns(Path(path), (time, value), delimiter)
        return cls(t, y, interpolation)

    @property
    def coefficients(self) -> Array:
        """Coefficients (m+1, k-1) of the polynomials in t - t_i, highest power first."""
        t, y = self.times, self.values
        if len(t) == 1:
            return np.zeros((2, 0))
        if self.interpolation == "cubic" and len(t) > 2:
            from scipy.interpolate import CubicSpline  # slow to import and rarely needed

            return np.asarray(CubicSpline(t, y).c, dtype=np.float64)
        return np.stack([np.diff(y) / np.diff(t), y[:-1]])

    def jet(self, t: Array) -> Jet:
        """Return value, rate and acceleration."""
        return piecewise(self.times, self.values, self.coefficients, t)

    @property
    def law(self) -> Law:
        """Law of the straight lines, or of the polynomials of the spline."""
        if len(self.times) > 1 and self.interpolation == "cubic":
            return polynomials(self.times, self.coefficients)
        return Law("table", {}, (self.times, self.values), count=len(self.times))

    @property
    def kinks(self) -> tuple[float, ...]:
        """Points at which the slope jumps, s."""
        c = self.coefficients
        if not c.shape[1]:
            return ()
        h = np.diff(self.times)
        powers = np.arange(len(c) - 1, -1, -1)
        # slopes at the end and at the start of each interval
        at_end = sum(p * c[j] * h ** (p - 1) for j, p in enumerate(powers) if p)
        left = np.concatenate([[0.0], np.atleast_1d(at_end)])
        right = np.concatenate([c[-2], [0.0]])
        scale = np.maximum(np.abs(left), np.abs(right)).max()
        return tuple(float(x) for x in self.times[np.abs(right - left) > 1e-9 * scale])


class SCurve(Points, tag="s-curve"):
    """Smooth moves between points with a stop at each point: the usual motion of a machine axis.

    ``y_i + (y_i+1 - y_i) (10 s^3 - 15 s^4 + 6 s^5)`` with ``s = (t - t_i) / (t_i+1 - t_i)``:
    rate and acceleration are zero at every point, so both are continuous everywhere. The
    largest rate is 15/8 of the mean one, the largest acceleration 10/sqrt(3) dy/dt^2.

    Examples
    --------
    >>> lift = SCurve((0.0, 2.0), (0.0, 1.0))
    >>> lift([0.0, 1.0, 2.0]), lift.rate(1.0)
    (array([0. , 0.5, 1. ]), np.float64(0.9375))
    """

    def consistent(self, problems: Problems, where: str) -> None:
        """Report fewer than two points."""
        super().consistent(problems, where)
        if len(self.times) == 1:
            problems.add(where, "has one point, must have at least two")

    @property
    def coefficients(self) -> Array:
        """Coefficients (6, k-1) of the polynomials in t - t_i, highest power first."""
        h, dy = np.diff(self.times), np.diff(self.values)
        zero = np.zeros(len(h))
        return np.stack(
            [6 * dy / h**5, -15 * dy / h**4, 10 * dy / h**3, zero, zero, self.values[:-1]]
        )

    def jet(self, t: Array) -> Jet:
        """Return value, rate and acceleration."""
        # in s instead of t: exact at the end of every move
        i = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.times) - 2)
        h, y = np.diff(self.times)[i], self.values
        s = np.clip((t - self.times[i]) / h, 0.0, 1.0)
        dy = y[i + 1] - y[i]
        blend = s**3 * (10 + s * (6 * s - 15))
        rate = 30 * s**2 * (1 - s) ** 2 / h
        acceleration = 60 * s * (1 - s) * (1 - 2 * s) / h**2
        value = np.where(s < 1, y[i] + dy * blend, y[i + 1])
        return value, dy * rate, dy * acceleration

    @property
    def law(self) -> Law:
        """Law of the polynomials of degree 5."""
        return polynomials(self.times, self.coefficients)


def polynomials(times: Array, c: Array) -> Law:
    """Return the law of polynomials between times, with coefficients c (m+1, k-1)."""
    rising = np.asarray(c)[::-1].T
    return Law("pieces", {}, (times, rising), count=len(times), degree=len(c) - 1)


def piecewise(times: Array, values: Array, c: Array, t: Array) -> Jet:
    """Return value, rate and acceleration at times t of polynomials, coefficients c (m+1, k-1)."""
    last = len(times) - 2
    inside = (t >= times[0]) & (t < times[-1])
    held = np.where(t < times[0], values[0], values[-1])
    f, df, ddf = (np.zeros(t.shape) for _ in range(3))
    if last >= 0:
        i = np.clip(np.searchsorted(times, t, side="right") - 1, 0, last)
        x = t - times[i]
        # Horner's scheme for the polynomial and its derivatives
        for row in c:
            ddf = ddf * x + 2 * df
            df = df * x + f
            f = f * x + row[i]
    return np.where(inside, f, held), np.where(inside, df, 0.0), np.where(inside, ddf, 0.0)


def read_columns(
    path: Path, columns: tuple[str | int, ...], delimiter: str | None
) -> list[list[float]]:
    """Return columns of numbers from a text file; see `Table.from_csv`."""
    check_text(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(Problem(f"Table: {path}", f"cannot be read: {error}")) from None
    lines = [
        (i, line)
        for i, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    where = f"Table: {path}"
    if not lines:
        raise InputError(Problem(where, "has no lines with numbers"))
    if delimiter is None:
        delimiter = next((c for c in ";\t," if c in lines[0][1]), " ")
    rows = [
        (i, [cell.strip() for cell in next(csv.reader([line.strip()], delimiter=delimiter,
                                                     skipinitialspace=True))])
        for i, line in lines
    ]  # fmt: skip
    header = rows[0][1]
    named = any(as_float(cell) is None for cell in header)
    problems = Problems()
    places: list[int] = []
    for column in columns:
        if isinstance(column, int) and 0 <= column < len(header):
            places.append(column)
        elif isinstance(column, int):
            problems.add(where, f"no column {column}: there are {len(header)}, counted from 0")
        elif named and column in header:
            places.append(header.index(column))
        else:
            known = suggest(column, header) if named else "; the first line has no names"
            problems.add(where, f"no column {column!r}{known}")
    problems.raise_if_any()
    found: list[list[float]] = [[] for _ in columns]
    for i, row in rows[1:] if named else rows:
        for out, place in zip(found, places, strict=True):
            cell = row[place] if place < len(row) else ""
            x = as_float(cell)
            if x is None:
                problems.add(f"{where}:{i}", f"column {place} is {cell!r}, must be a number")
            else:
                out.append(x)
    problems.raise_if_any()
    return found


def as_float(cell: Any) -> float | None:
    """Return the number in a cell, or None."""
    try:
        return float(cell)
    except ValueError:
        return None
