"""Identified: found values with their intervals, tests of the residuals, and what is not seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.errors import Problem, UnknownNameError, count, suggest
from jousto.base.object_repr import described
from jousto.design.identification.certainty import Certainty
from jousto.design.identification.residuals import Residuals
from jousto.design.identification.search import loss_at, search
from jousto.design.identification.unknowns import Unknown
from jousto.design.identification.whiteness import Whiteness
from jousto.design.studies.parameters.parameter import Parameter
from jousto.measurement.gauges.record import Record

PROBABILITY = 0.95
"""Probability of the intervals."""
TOGETHER = 0.95
"""Correlation from which two unknowns are named."""
CHANGE = 1e-5
"""Step of the derivatives of a number that depends on the values, in their sizes."""
VISIBLE = 1e-2
"""Share of a change along unseen directions up to which a number is seen."""
LIKELIHOOD = 3.841
"""Increase of 2 F at the ends of an interval of 95 %: a quantile of chi square."""
FARTHEST = 8.0
"""Distance in sizes (powers of e) beyond which an end of an interval is open."""
WHITE = 1e-3
"""Probability of the residuals below which the model or the noise is not as assumed."""


@described
@dataclass(frozen=True, eq=False)
class Fit:
    """One channel against its sensor at the found values.

    Attributes
    ----------
    experiment, channel, sensor, unit : str
        Names and the SI unit.
    time, measured, fitted : (n,) array
        Instants, s, the measurement, and what the model shows with gain, bias and shift.
    sd : (n,) array
        Standard deviation of the noise.
    test : Whiteness
        Tests of the residuals.
    outside : int
        Samples left out, since their shifted instant is outside of the run.
    """

    experiment: str
    channel: str
    sensor: str
    unit: str
    time: Array
    measured: Array
    fitted: Array
    sd: Array
    test: Whiteness
    outside: int

    def _facts(self) -> str:
        return f"{self.channel}, rms {self.test.rms:.3g} sd"


@described
@dataclass(frozen=True, eq=False)
class Identified:
    """Numbers of a model from measurements; see `identify`.

    ``found["stiffness"]`` is a value, ``found.interval("stiffness")`` its interval of 95 %.

    Attributes
    ----------
    unknowns : tuple of Unknown
        What was sought: parameters of the model, then gains, biases and shifts.
    u : (p,) array
        Found coordinates: logarithms of positive numbers, else the numbers.
    certainty : Certainty
        Covariance of u, and what is not seen.
    fits : tuple of Fit
        The compared channels.
    checks : tuple of Fit
        Channels of records that were not fitted.
    chi2 : float
        Sum of the squared residuals; their number less that of the unknowns is `dof`.
    dof : int
        Degrees of freedom.
    estimated : bool
        Whether the noise of a channel was estimated from its residuals.
    minima : tuple of (dict, float)
        Other minima that were found, with chi2 / dof.
    notes : tuple of str
        Warnings and remarks.
    runs, jacobians : int
        Runs of the machine, and Jacobians.
    seconds : float
        Wall time, s.
    """

    unknowns: tuple[Unknown, ...]
    u: Array
    certainty: Certainty
    fits: tuple[Fit, ...]
    checks: tuple[Fit, ...]
    chi2: float
    dof: int
    estimated: bool
    minima: tuple[tuple[dict[str, float], float], ...]
    notes: tuple[str, ...]
    runs: int
    jacobians: int
    seconds: float
    loss: str
    _residuals: Residuals

    # ---- values -------------------------------------------------------------------------------

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        return tuple(own.name for own in self.unknowns)

    @property
    def values(self) -> dict[str, float]:
        """Found values, SI."""
        return {own.name: own.theta(x) for own, x in zip(self.unknowns, self.u, strict=True)}

    def _place(self, name: str) -> int:
        if name not in self.names:
            message = f"no unknown {name!r}{suggest(name, self.names)}"
            raise UnknownNameError(Problem("identify", message))
        return self.names.index(name)

    def __getitem__(self, name: str) -> float:
        """Return a found value, SI.

        Raises
        ------
        InputError
            For an unknown name; close ones are suggested. A `KeyError`, too.
        """
        k = self._place(name)
        return self.unknowns[k].theta(self.u[k])

    @property
    def quantile(self) -> float:
        """Half width of an interval in standard deviations: Student's t if noise was estimated."""
        from scipy.stats import norm, t

        high = 0.5 + 0.5 * PROBABILITY
        return float(t.ppf(high, self.dof) if self.estimated else norm.ppf(high))

    def sd(self, name: str) -> float:
        """Return the standard deviation of a value, SI (linearised); nan if it is not seen."""
        k = self._place(name)
        return float(np.sqrt(self.certainty.covariance[k, k]) * self.unknowns[k].slope(self.u[k]))

    def interval(self, name: str) -> tuple[float, float]:
        """Return the interval of 95 % of a value; nan if it is not seen.

        It is symmetric in the logarithm of a positive number.
        """
        k = self._place(name)
        half = self.quantile * float(np.sqrt(self.certainty.covariance[k, k]))
        own, u = self.unknowns[k], self.u[k]
        low, high = own.ends
        return own.theta(max(u - half, low)), own.theta(min(u + half, high))

    def derived(self, function: Callable[[dict[str, float]], float]) -> tuple[float, float]:
        """Return a number that depends on the values, and its standard deviation (linearised).

        A combination of numbers may be seen though they are not: ``found.derived(lambda v:
        v["stiffness"] / v["mass"])``. The deviation is nan if the combination is not seen.

        Parameters
        ----------
        function : callable
            Number as a function of the values by name.
        """
        slopes = np.empty(len(self.u))
        sizes = np.array([own.size for own in self.unknowns])
        for k, size in enumerate(sizes):
            ends = []
            for sign in (1.0, -1.0):
                u = self.u.copy()
                u[k] += sign * CHANGE * size
                each = zip(self.unknowns, u, strict=True)
                ends.append(float(function({own.name: own.theta(x) for own, x in each})))
            slopes[k] = (ends[0] - ends[1]) / (2.0 * CHANGE * size)
        scaled = slopes * sizes
        hidden = np.linalg.norm(self.certainty.hidden.T @ scaled)
        seen = hidden <= VISIBLE * np.linalg.norm(scaled)
        variance = float(slopes @ self.certainty.within @ slopes)
        return float(function(self.values)), float(np.sqrt(variance)) if seen else float("nan")

    @property
    def correlation(self) -> Array:
        """Correlation (p, p) of the unknowns in u; nan for what is not seen."""
        C = self.certainty.covariance
        sd = np.sqrt(np.diag(C))
        return np.asarray(C / np.outer(sd, sd))

    @property
    def covariance(self) -> Array:
        """Covariance (p, p) of the values, SI (linearised)."""
        slopes = np.array([own.slope(x) for own, x in zip(self.unknowns, self.u, strict=True)])
        return np.asarray(self.certainty.covariance * np.outer(slopes, slopes))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters with found values, and their uncertainty as distribution.

        It is normal, or lognormal for positive numbers: for `study` and for reliability. Those that
        are not seen have none.
        """
        from scipy.stats import lognorm, norm

        found = []
        for k, own in enumerate(self.unknowns):
            value = own.theta(self.u[k])
            sd = float(np.sqrt(self.certainty.covariance[k, k]))
            made = None
            if np.isfinite(sd) and sd > 0.0:
                made = lognorm(sd, scale=value) if own.log else norm(value, sd)
            given = own.parameter
            found.append(replace(given, value=value, distribution=made))
        return tuple(found)

    def records(self) -> dict[str, Record]:
        """Return measured and fitted channels, ``x`` and ``x fitted``, of each experiment."""
        found: dict[str, Record] = {}
        for fit in (*self.fits, *self.checks):
            own = {fit.channel: fit.measured, f"{fit.channel} fitted": fit.fitted}
            units = dict.fromkeys(own, fit.unit)
            name = fit.experiment
            if name in found and np.array_equal(found[name].time, fit.time):
                own = {**found[name].channels, **own}
                units = {**found[name].units, **units}
            elif name in found:
                name = f"{fit.experiment}: {fit.channel}"
            found[name] = Record(fit.time, own, units, name)
        return found

    def profile(self, name: str, at: ArrayLike) -> Array:
        """Return the increase of ``2 F`` at values of an unknown, the others sought anew.

        Parameters
        ----------
        name : str
        at : (n,) array
            Values of the unknown, SI.

        Returns
        -------
        (n,) array
            Increases; the interval of 95 % by the likelihood is where they are below 3.841.
        """
        k = self._place(name)
        own, found = self.unknowns[k], []
        rest = [i for i in range(len(self.u)) if i != k]
        for theta in np.atleast_1d(np.asarray(at, dtype=float)):
            found.append(2.0 * (self._fixed(k, own.u(theta), self.u[rest]) - self._base))
        return np.array(found)

    def profile_interval(self, name: str) -> tuple[float, float]:
        """Return the interval of 95 % by the likelihood; an end without limit is infinite or 0.

        It is more right than the linearised interval for a number that is little sure.

        Parameters
        ----------
        name : str

        Raises
        ------
        InputError
            For an unknown name.
        """
        from scipy.optimize import brentq

        k = self._place(name)
        own, u = self.unknowns[k], self.u[k]
        rest = [i for i in range(len(self.u)) if i != k]
        sd = float(np.sqrt(self.certainty.within[k, k]))
        ends: list[float] = []

        def excess(x: float) -> float:
            return 2.0 * (self._fixed(k, x, self.u[rest]) - self._base) - LIKELIHOOD

        for sign, end in zip((-1.0, 1.0), own.ends, strict=True):
            step, inner, outer = sd, float(u), float(u)
            open_ = True
            while open_ and abs(outer - u) < FARTHEST * own.size and outer != end:
                inner, outer = outer, u + sign * step
                outer = max(outer, end) if sign < 0.0 else min(outer, end)
                open_ = excess(outer) < 0.0
                step *= 2.0
            if open_:
                far = np.inf if sign > 0.0 else (0.0 if own.log else -np.inf)
                ends.append(own.theta(end) if np.isfinite(end) else far)
            else:
                ends.append(own.theta(float(brentq(excess, inner, outer, xtol=1e-4 * sd))))
        return ends[0], ends[1]

    @property
    def _base(self) -> float:
        """``F`` at the found values."""
        return loss_at(self._residuals, self.u, self.loss)

    def _fixed(self, k: int, value: float, start: Array) -> float:
        """Return the least F over the other unknowns for a fixed coordinate."""
        fixed: Any = Fixed(self._residuals, k, value)
        if not len(start):
            return loss_at(self._residuals, np.array([value]), self.loss)
        return search(fixed, start, self.loss).F

    # ---- print --------------------------------------------------------------------------------

    def _facts(self) -> str:
        channels = count(len(self.fits), "channel")
        return f"{count(len(self.unknowns), 'unknown')} from {channels}, chi2/dof {self.ratio:.3g}"

    @property
    def ratio(self) -> float:
        """chi2 / dof: 1 for a right model and the right noise."""
        return self.chi2 / self.dof if self.dof > 0 else float("nan")

    def __str__(self) -> str:
        """Return tables of the values and of the channels, what is not seen, and the notes."""
        lines = [self.summary, *columns(self.table)]
        for _, rows in self.channel_tables:
            lines += columns(rows)
        return "\n".join([*lines, *self.doubts, *self.notes])

    @property
    def summary(self) -> str:
        """Numbers of unknowns, values, runs and Jacobians, chi2 / dof and time in one line."""
        n = self.dof + len(self.unknowns)
        work = f"{count(self.runs, 'run')}, {count(self.jacobians, 'Jacobian')}"
        sizes = f"{count(len(self.unknowns), 'unknown')} from {count(n, 'value')}"
        return f"{sizes}, chi2/dof {self.ratio:.4g}; {work}, {self.seconds:.2g} s"

    @property
    def troubled(self) -> bool:
        """Whether there are notes on what must be looked at before the values are used."""
        return any("left out" not in note for note in self.notes)

    @property
    def table(self) -> list[tuple[str, ...]]:
        """Table of the values: head and rows."""
        rows: list[tuple[str, ...]] = [
            ("unknown", "unit", "before", "after", "95 % interval", "seen by")
        ]
        for k, own in enumerate(self.unknowns):
            low, high = self.interval(own.name)
            shares = self.certainty.information[k]
            best = int(np.argmax(shares))
            seen = bool(self.certainty.seen[k])
            rows.append(
                (
                    own.name,
                    own.parameter.unit,
                    f"{own.start:.6g}",
                    f"{own.theta(self.u[k]):.6g}",
                    f"{low:.6g} to {high:.6g}" if seen else "not seen",
                    f"{self.fits[best].channel} {100 * shares[best]:.0f} %" if seen else "",
                )
            )
        return rows

    @property
    def channel_tables(self) -> list[tuple[str, list[tuple[str, ...]]]]:
        """Tables of the channels over time and of single values, with a title each."""
        found = []
        for title, fits in (("channel", self.fits), ("check", self.checks)):
            over = [fit for fit in fits if len(fit.time) > 1]
            single = [fit for fit in fits if len(fit.time) == 1]
            if over:
                rows = [(title, "sensor", "rms/sd", "explained", "Ljung-Box p")]
                found.append((title, rows + [self._channel(fit) for fit in over]))
            if single:
                rows = [(f"{title}: value", "unit", "measured", "computed", "difference/sd")]
                found.append((f"{title}: value", rows + [self._single(fit) for fit in single]))
        return found

    def _name(self, fit: Fit) -> str:
        several = len({one.experiment for one in (*self.fits, *self.checks)}) > 1
        return f"{fit.experiment}: {fit.channel}" if several else fit.channel

    def _channel(self, fit: Fit) -> tuple[str, ...]:
        test = fit.test
        share, p = f"{100 * test.explained:.6g} %", f"{test.p:.2g}"
        return self._name(fit), fit.sensor, f"{test.rms:.3f}", share, p

    def _single(self, fit: Fit) -> tuple[str, ...]:
        y, computed = float(fit.measured[0]), float(fit.fitted[0])
        apart = f"{(computed - y) / float(fit.sd[0]):.3f}"
        return self._name(fit), fit.unit, f"{y:.6g}", f"{computed:.6g}", apart

    @property
    def doubts(self) -> list[str]:
        """Sentences on what is not seen, on close correlations and on other minima."""
        lines = []
        if any(self.certainty.memory):
            lines.append("intervals allow for residuals that remember earlier ones")
        lines += [f"not seen: {one.text}" for one in self.certainty.unseen]
        rho = self.correlation
        for i in range(len(rho)):
            for j in range(i):
                if abs(rho[i, j]) > TOGETHER:
                    a, b = self.names[j], self.names[i]
                    lines.append(f"correlation of {a} and {b}: {rho[i, j]:+.3f}")
        for values, ratio in self.minima:
            at = ", ".join(f"{name} {value:.4g}" for name, value in values.items())
            lines.append(f"another minimum, chi2/dof {ratio:.4g}: {at}")
        return lines


class Fixed:
    """Residuals of all unknowns but one, which is fixed.

    Parameters
    ----------
    residuals : Residuals
    k : int
        Place of the fixed unknown.
    value : float
        Its coordinate.
    """

    def __init__(self, residuals: Residuals, k: int, value: float) -> None:
        self._of, self._k, self._value = residuals, k, value
        self.sizes, self.failures = residuals.sizes, residuals.failures
        self.unknowns = tuple(own for i, own in enumerate(residuals.unknowns) if i != k)

    def _whole(self, u: Array) -> Array:
        return np.insert(u, self._k, self._value)

    def values(self, u: Array) -> Array:
        """Return the residuals."""
        return self._of.values(self._whole(u))

    def jacobian(self, u: Array) -> Array:
        """Return their derivatives."""
        return np.delete(self._of.jacobian(self._whole(u)), self._k, axis=1)


def columns(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return rows of text in columns."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [f"{cell:{width}}" for cell, width in zip(row, widths, strict=True)]
        lines.append(f"  {'  '.join(cells)}".rstrip())
    return lines
