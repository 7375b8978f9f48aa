"""Residuals of all experiments, weighted by the noise, and their derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.design.identification.bench import Bench
from jousto.design.identification.experiment import Comparison, Number
from jousto.design.identification.unknowns import Unknown
from jousto.design.studies.parameters.parameter import Parameter

Shown = list[tuple[Array, Array]]
"""Values and rates of every comparison at its instants."""


@dataclass(frozen=True, eq=False)
class Compared:
    """A comparison with the bench that runs its experiment, and its noise.

    Attributes
    ----------
    bench : int
        Number of the bench.
    about : Comparison
        The channel and the sensor.
    sd : (n,) array
        Standard deviation of the noise.
    """

    bench: int
    about: Comparison
    sd: Array


@dataclass(eq=False)
class Residuals:
    """Weighted residuals ``(gain h(t - shift) + bias - y) / sd`` of all comparisons, in a row.

    Attributes
    ----------
    benches : tuple of Bench
        Experiments with their machines.
    compared : tuple of Compared
        What is compared.
    unknowns : tuple of Unknown
        Sought numbers: first those of the model, then those of channels.
    failures : list of str
        Reasons of runs that failed.
    """

    benches: tuple[Bench, ...]
    compared: tuple[Compared, ...]
    unknowns: tuple[Unknown, ...]
    failures: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._places = {unknown.name: k for k, unknown in enumerate(self.unknowns)}

    @property
    def solver(self) -> Any:
        """Method of the runs over time; None if there are none."""
        return next((b.solver for b in self.benches if b.solver is not None), None)

    @property
    def sizes(self) -> list[int]:
        """Number of samples of each comparison."""
        return [len(one.about.y) for one in self.compared]

    def theta(self, u: Array) -> Array:
        """Return the values of coordinates."""
        return np.array([own.theta(x) for own, x in zip(self.unknowns, u, strict=True)])

    def _number(self, given: Number, theta: Array) -> float:
        """Return the value of a gain, a bias or a shift."""
        return float(theta[self._places[given.name]] if isinstance(given, Parameter) else given)

    def shown(self, points: Sequence[Array]) -> list[Shown | Exception]:
        """Return what all sensors show at points u, or the error of a run."""
        thetas = [self.theta(u) for u in points]
        each = [bench.results(thetas) for bench in self.benches]
        found: list[Shown | Exception] = []
        for k, theta in enumerate(thetas):
            results = [of[k] for of in each]
            bad = next((one for one in results if isinstance(one, Exception)), None)
            if bad is not None:
                found.append(bad)
                continue
            shown: Shown = []
            for one in self.compared:
                shift = self._number(one.about.shift, theta)
                shown.append(self.benches[one.bench].show(results[one.bench], one.about, shift))
            found.append(shown)
        return found

    def _residual(self, one: Compared, values: Array, theta: Array) -> Array:
        """Return the residuals of a comparison; 0 where the sensor shows nothing."""
        gain, bias = self._number(one.about.gain, theta), self._number(one.about.bias, theta)
        r = (gain * values + bias - one.about.y) / one.sd
        return np.where(np.isnan(values), 0.0, r)

    def values(self, u: Array) -> Array:
        """Return the residuals (n,) at u; infinite if the run fails, whose reason is kept."""
        (found,) = self.shown([u])
        if isinstance(found, Exception):
            self.failures.append(" / ".join(str(found).splitlines()))
            return np.full(sum(self.sizes), np.inf)
        return self.of(found, u)

    def of(self, shown: Shown, u: Array) -> Array:
        """Return the residuals of what the sensors show."""
        theta = self.theta(u)
        each = zip(self.compared, shown, strict=True)
        return np.concatenate([self._residual(one, values, theta) for one, (values, _) in each])

    def jacobian(self, u: Array, central: bool = False) -> Array:
        """Return dr/du (n, p): by differences of runs side by side, and exactly for channels.

        Parameters
        ----------
        u : (p,) array
        central : bool
            Whether to take central differences with a larger step instead of one-sided ones.
        """
        model = sorted({int(k) for bench in self.benches for k in bench.places})
        h = max(bench.steps[central] for bench in self.benches)
        steps = [h * self.unknowns[k].size for k in model]
        points = [u]
        for k, step in zip(model, steps, strict=True):
            for sign in (1.0, -1.0) if central else (1.0,):
                points.append(u.copy())
                points[-1][k] += sign * step
        found = self.shown(points)
        base = found[0]
        if isinstance(base, Exception):
            raise base
        J = np.zeros((sum(self.sizes), len(self.unknowns)))
        r = self.of(base, u)
        beside = iter(zip(points[1:], found[1:], strict=True))
        for k, step in zip(model, steps, strict=True):
            sides = [next(beside) for _ in range(2 if central else 1)]
            J[:, k] = self._slope(u, r, k, step, sides)
        self._channels(J, base, u)
        return J

    def _slope(
        self, u: Array, r: Array, k: int, step: float, sides: list[tuple[Array, Shown | Exception]]
    ) -> Array:
        """Return a column from the sides on which the machine runs."""
        good = [
            (at[k] - u[k], self.of(shown, at)) for at, shown in sides if isinstance(shown, list)
        ]
        if len(good) == 2:
            return np.asarray((good[0][1] - good[1][1]) / (good[0][0] - good[1][0]))
        if not good:
            at = u.copy()
            at[k] -= step
            (shown,) = self.shown([at])
            if isinstance(shown, Exception):
                raise shown
            good = [(at[k] - u[k], self.of(shown, at))]
        return np.asarray((good[0][1] - r) / good[0][0])

    def _channels(self, J: Array, shown: Shown, u: Array) -> None:
        """Fill the columns of gains, biases and shifts."""
        theta, first = self.theta(u), 0
        for one, (values, rate) in zip(self.compared, shown, strict=True):
            rows = slice(first, first + len(values))
            first = rows.stop
            there = np.isfinite(values)
            gain = self._number(one.about.gain, theta)
            slopes = (
                (one.about.gain, values),
                (one.about.bias, np.ones(len(values))),
                (one.about.shift, -gain * rate),
            )
            for given, slope in slopes:
                if isinstance(given, Parameter):
                    k = self._places[given.name]
                    chain = self.unknowns[k].slope(u[k])
                    J[rows, k] += np.where(there, slope / one.sd * chain, 0.0)

    def inside(self, u: Array) -> Array:
        """Return which samples (n,) lie within the run, for counting."""
        (found,) = self.shown([u])
        if isinstance(found, Exception):
            raise found
        return np.concatenate([np.isfinite(values) for values, _ in found])

    def with_noise(self, factors: Sequence[float]) -> Residuals:
        """Return a copy whose noise is multiplied by a factor for each comparison."""
        pairs = zip(self.compared, factors, strict=True)
        compared = tuple(replace(one, sd=one.sd * factor) for one, factor in pairs)
        return replace(self, compared=compared)

    def with_solver(self, solver: Any) -> Residuals:
        """Return a copy whose runs have another method or step."""
        return replace(self, benches=tuple(bench.with_solver(solver) for bench in self.benches))

    def until(self, share: float) -> Residuals:
        """Return a copy that compares only the first share of the time of each experiment."""
        benches = tuple(bench.until(share) for bench in self.benches)
        compared = []
        for one in self.compared:
            end = benches[one.bench].t_end
            keep = one.about.time <= (np.inf if end is None else end * (1.0 + 1e-9))
            about = replace(one.about, time=one.about.time[keep], y=one.about.y[keep])
            compared.append(replace(one, about=about, sd=one.sd[keep]))
        return replace(self, benches=benches, compared=tuple(compared))
