"""Rainflow counting by the engine, with a mandatory residue rule."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arrays import Array, Ints
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.files import Rows, Tabular
from jousto.base.object_repr import described
from jousto.mechanism.sensors.damage_rule import RESIDUES
from jousto.model.native.damage_meter import count_cycles

_EXPLAIN = (
    'give the rule for cycles open at the end of the history: "half" (half cycles, ASTM E1049),'
    ' "repeat" (the history repeats from its beginning, as in a duty cycle) or "ignore" (for'
    " pieces of a longer history whose residues are counted later); for one random walk they give"
    " damages of 3.6e-6, 5.1e-6 and 5.1e-7, a factor of ten"
)


def check_residue(residue: str | None, where: str = "rainflow") -> str:
    """Return the residue rule if it is valid.

    Raises
    ------
    InputError
        If the rule is missing or unknown; the message explains the rules.
    """
    if residue is None:
        raise InputError(Problem(where, f"residue is missing: {_EXPLAIN}"))
    if residue not in RESIDUES:
        raise InputError(
            Problem(where, f"residue is {residue!r}{suggest(residue, RESIDUES)}: {_EXPLAIN}")
        )
    return residue


@described
@dataclass(frozen=True, eq=False)
class RainflowMatrix:
    """Rainflow matrix: numbers of cycles in classes of range and mean, or of from and to.

    Attributes
    ----------
    kind : str
        "range-mean" or "from-to".
    x, y : (n + 1,) array
        Limits of the classes of range or from (x), and of mean or to (y), Pa.
    counts : (n, n) array
        Number of cycles in class [x, y].
    residue : str
        Residue rule of the count.
    """

    kind: str
    x: Array
    y: Array
    counts: Array
    residue: str

    def __str__(self) -> str:
        n = int(np.count_nonzero(self.counts))
        return (
            f"rainflow matrix {self.kind}, {len(self.x) - 1} x {len(self.y) - 1} classes, {n} of"
            f" them with {self.counts.sum():g} cycles; residue: {self.residue}"
        )


@described
@dataclass(frozen=True, eq=False)
class Cycles(Tabular):
    """Cycles of a history by rainflow counting.

    Attributes
    ----------
    range, mean : (nc,) array
        Range and mean of each cycle, Pa (or the unit of the history).
    count : (nc,) array
        Number of cycles: 1 for a closed cycle, 0.5 for a half cycle, times the repetitions of a
        duty cycle.
    from_index, to_index : (nc,) int array
        Samples of the history at the first and the second extreme of a cycle.
    residue : str
        Residue rule: "half", "repeat" or "ignore".
    turning : (nr,) array
        Turning points of the history, its ends included.
    open : (no,) array
        Residue: turning points of cycles that do not close.
    rising : (nc,) bool array
        Whether the first extreme of a cycle is its minimum.
    """

    range: Array
    mean: Array
    count: Array
    from_index: Ints
    to_index: Ints
    residue: str
    turning: Array = field(default_factory=lambda: np.zeros(0))
    open: Array = field(default_factory=lambda: np.zeros(0))
    rising: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))

    def _facts(self) -> str:
        largest = f"largest range {self.range.max():.6g}, " if len(self) else ""
        return f"{self.total:g} of {len(self)} sizes, {largest}residue {self.residue!r}"

    def __len__(self) -> int:
        return len(self.range)

    @property
    def amplitude(self) -> Array:
        """Amplitude (nc,): half of the range."""
        return 0.5 * self.range

    @property
    def total(self) -> float:
        """Number of cycles."""
        return float(self.count.sum())

    def sums(self, digits: int = 12) -> dict[float, float]:
        """Return the number of cycles of each range, ascending, rounded to `digits`.

        Examples
        --------
        >>> history = [-2, 1, -3, 5, -1, 3, -4, 4, -2]  # ASTM E1049-85, figure 6
        >>> rainflow(history, residue="half").sums()
        {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}
        """
        size = _positive(float(self.range.max(initial=0.0)))
        keys = np.round(self.range / size, digits)
        _, first, where = np.unique(keys, return_index=True, return_inverse=True)
        counts = np.bincount(where.ravel(), weights=self.count, minlength=len(first))
        values = self.range[first]
        return {float(f"{v:.12g}"): float(c) for v, c in zip(values, counts, strict=True)}

    def matrix(self, bins: int = 32, kind: str = "range-mean") -> RainflowMatrix:
        """Return the rainflow matrix.

        Parameters
        ----------
        bins : int
            Number of classes in each direction.
        kind : str
            "range-mean", or "from-to" (first and second extreme).

        Raises
        ------
        InputError
            If `bins` or `kind` is invalid.
        """
        problems = Problems()
        if bins < 1 or bins != int(bins):
            problems.add("matrix", f"bins is {bins!r}, must be a whole number above 0")
        kinds = ("range-mean", "from-to")
        if kind not in kinds:
            problems.add("matrix", f"kind is {kind!r}{suggest(kind, kinds)}")
        problems.raise_if_any()
        x, y = self.range, self.mean
        if kind == "from-to":
            up = self.rising
            x = self.mean - np.where(up, 0.5, -0.5) * self.range
            y = self.mean + np.where(up, 0.5, -0.5) * self.range
            low = float(min(x.min(initial=np.inf), y.min(initial=np.inf)))
            high = float(max(x.max(initial=-np.inf), y.max(initial=-np.inf)))
            spans = [(low, high), (low, high)] if len(x) else [(0.0, 1.0), (0.0, 1.0)]
        else:
            means = (float(y.min()), float(y.max())) if len(y) else (0.0, 1.0)
            spans = [(0.0, _positive(float(x.max(initial=0.0)))), means]
        edges = []
        for low, high in spans:
            if not high > low:  # a single value: classes centred about it
                low, high = low - 0.5 * _positive(abs(low)), high + 0.5 * _positive(abs(high))
            edges.append(np.linspace(low, high, bins + 1))
        counts, _, _ = np.histogram2d(x, y, bins=edges, weights=self.count)
        return RainflowMatrix(kind, edges[0], edges[1], counts, self.residue)

    def levels(self, count: int = 64) -> tuple[Array, Ints]:
        """Return levels (count,) and the number of upward crossings of each (count,).

        Examples
        --------
        >>> rainflow([0, 2, 0, 2, 0], residue="half").levels(3)
        (array([0., 1., 2.]), array([0, 2, 2]))
        """
        t = self.turning
        if len(t) < 2:
            return np.array(t), np.zeros(len(t), dtype=np.int64)
        low, high = t[:-1], t[1:]
        up = high > low
        levels = np.linspace(t.min(), t.max(), count)
        begun = np.searchsorted(np.sort(low[up]), levels, side="left")
        passed = np.searchsorted(np.sort(high[up]), levels, side="left")
        return levels, np.asarray(begun - passed, dtype=np.int64)

    def exceedance(self) -> tuple[Array, Array]:
        """Return amplitudes (nc,), descending, and the number of cycles of at least each."""
        order = np.argsort(self.range)[::-1]
        return self.amplitude[order], np.cumsum(self.count[order])

    def times(self, repeats: float) -> Cycles:
        """Return the cycles with their numbers multiplied by `repeats`."""
        return replace(self, count=self.count * repeats)

    def _csv(self) -> Rows:
        """Return range, mean, count and samples of each cycle."""
        head = ("range (Pa)", "mean (Pa)", "count", "from", "to", f"residue: {self.residue}")
        rows = zip(
            self.range.tolist(),
            self.mean.tolist(),
            self.count.tolist(),
            self.from_index.tolist(),
            self.to_index.tolist(),
            strict=True,
        )
        return head, rows

    def __str__(self) -> str:
        lines = [
            f"{self.total:g} cycles (rainflow; residue of {len(self.open)} turning points:"
            f" {self.residue})"
        ]
        if len(self):
            lines.append("  range (MPa)   mean (MPa)      cycles")
            order = np.argsort(self.range, kind="stable")[::-1]
            for k in order[:10]:
                lines.append(
                    f"{self.range[k] / 1e6:13.6g}{self.mean[k] / 1e6:13.6g}{self.count[k]:12g}"
                )
            if len(self) > 10:
                lines.append(f"  and {len(self) - 10} smaller ones")
        return "\n".join(lines)


def check_history(series: ArrayLike, where: str = "history") -> Array:
    """Return the samples (nt,) of a history if they are valid.

    Raises
    ------
    InputError
        If there are fewer than two samples, or values that are not finite.
    """
    try:
        x = np.asarray(series, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(Problem(where, "is not a sequence of numbers")) from None
    problem = ""
    if x.ndim != 1:
        problem = f"has shape {x.shape}, must be one column (nt,)"
    elif len(x) == 0:
        problem = "is empty"
    elif len(x) == 1:
        problem = "has one sample; cycles need a history"
    elif not np.all(np.isfinite(x)):
        bad = np.flatnonzero(~np.isfinite(x))
        problem = (
            f"sample {bad[0]} is {x[bad[0]]} ({len(bad)} of {len(x)} are not finite); remove or"
            " interpolate these samples first"
        )
    if problem:
        raise InputError(Problem(where, problem))
    return x


def rainflow(series: ArrayLike, *, residue: str | None = None) -> Cycles:
    """Return the cycles of a history by the rainflow method.

    Four-point rule: of turning points S1..S4 the inner range ``|S2 - S3|`` is a closed cycle if it
    lies within S1 and S4. S2 and S3 are removed and the search continues; the remaining turning
    points are the residue. With ``residue="half"`` the ranges of the residue are half cycles, as in
    ASTM E1049-85, 5.4.4.

    Parameters
    ----------
    series : (nt,) array_like
        History, Pa.
    residue : str
        "half", "repeat" or "ignore"; mandatory.

    Returns
    -------
    Cycles

    Raises
    ------
    InputError
        If the rule is missing, or the history is empty, has one sample or values that are not
        finite.

    Examples
    --------
    >>> rainflow([0.0, 100e6, 0.0, 100e6, 0.0], residue="repeat").sums()
    {100000000.0: 2.0}
    """
    rule = check_residue(residue)
    x = check_history(series)
    values, index = turning_points(x)
    pairs, rest = count_turning(values)
    whole, left = len(pairs), values[rest]
    if rule == "half":
        pairs = np.concatenate([pairs, np.stack([rest[:-1], rest[1:]], axis=1)])
    elif rule == "repeat":
        again = close(left, left)[0]
        # indices into two copies of the residue, one after the other
        pairs = np.concatenate([pairs, rest[again % len(rest)]])
        whole = len(pairs)
    closed = np.full(len(pairs), 0.5)
    closed[:whole] = 1.0
    first, second = pairs.T
    a, b = values[first], values[second]
    ranges = np.abs(b - a)
    places = index[first], index[second]
    return Cycles(ranges, 0.5 * (a + b), closed, *places, rule, values, left, b > a)


def turning_points(x: Array) -> tuple[Array, Ints]:
    """Return the turning points (nr,) of a history and their indices (nr,), both ends included.

    The index of a plateau is its first sample; a constant history has one turning point.
    """
    kept = np.ones(len(x), dtype=bool)
    np.not_equal(x[1:], x[:-1], out=kept[1:])
    index = kept.nonzero()[0]
    y = x[index]
    if len(y) > 2:
        rises = y[1:] > y[:-1]
        turns = np.ones(len(y), dtype=bool)
        np.not_equal(rises[1:], rises[:-1], out=turns[1:-1])
        index, y = index[turns], y[turns]
    return y, index.astype(np.int64, copy=False)


def close(first: Array, second: Array) -> tuple[Ints, Ints]:
    """Return the cycles that two residues in sequence close, by the four-point rule.

    Returns
    -------
    pairs : (nc, 2) int array
        Indices into ``[first, second]`` of the extremes of each cycle.
    rest : (nr,) int array
        Indices of the remaining turning points.
    """
    values, index = turning_points(np.concatenate([first, second]))
    pairs, rest = count_turning(values)
    return index[pairs], index[rest]


def count_turning(values: Array) -> tuple[Ints, Ints]:
    """Return closed cycles (nc, 2) and residue (nr,) of turning points, as indices into them."""
    _, pairs, _, rest = count_cycles(values)
    return pairs, rest


def _positive(size: float) -> float:
    return size if size > 0.0 else 1.0
