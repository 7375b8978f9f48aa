"""Noise from data: innovation test and maximum likelihood."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize
from scipy.stats import chi2

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.object_repr import described
from jousto.measurement.twin.estimates import Estimates
from jousto.measurement.twin.kalman import Gain, first_gain, next_gain
from jousto.measurement.twin.observer import Observer
from jousto.measurement.twin.signals import LARGEST
from jousto.measurement.twin.smoother import smooth

TOLERANCE = 0.25
"""Relative error of the bands up to which the innovation test passes."""
FARTHEST = 8.0
"""Logarithm of the largest factor on a standard deviation."""


@described
@dataclass(frozen=True, eq=False)
class InnovationTest:
    """Comparison of the innovations of a filter with its noise.

    Attributes
    ----------
    size : float
        Mean square of the independent innovations: 1 for correct noise, more if bands are too
        narrow, less if they are too wide.
    low, high : float
        95 % interval of `size` for correct noise.
    whiteness : float
        Correlation of one innovation with the next; 0 for correct noise.
    limit : float
        Largest magnitude of `whiteness` that chance explains (95 %).
    channels : dict of str to float
        Root mean square of each channel's own innovations over the expected value.
    tolerance : float
        Share by which bands may be too narrow or too wide.
    """

    size: float
    low: float
    high: float
    whiteness: float
    limit: float
    channels: dict[str, float]
    tolerance: float = TOLERANCE

    def _facts(self) -> str:
        return f"{self.verdict}, {self.ratio:.3g} times, whiteness {self.whiteness:.2g}"

    @property
    def ratio(self) -> float:
        """Effect of the size: rms of the normalised innovations."""
        return float(np.sqrt(self.size))

    @property
    def largest_correlation(self) -> float:
        """Correlation r at which the band of a mean is too narrow by the tolerance.

        Innovations with autocorrelations r, r^2, .. have means with ``sqrt((1 + r) / (1 - r))``
        times the deviation of independent ones.
        """
        square = (1.0 + self.tolerance) ** 2
        return (square - 1.0) / (square + 1.0)

    @property
    def significant(self) -> tuple[bool, bool]:
        """Whether innovations differ significantly in size or whiteness, as in any long record."""
        return not self.low <= self.size <= self.high, abs(self.whiteness) > self.limit

    @property
    def relevant(self) -> tuple[bool, bool]:
        """Whether innovations differ in size or whiteness by more than the tolerance."""
        wide = 1.0 + self.tolerance
        return not 1.0 / wide <= self.ratio <= wide, abs(self.whiteness) > self.largest_correlation

    @property
    def passed(self) -> bool:
        """Whether no difference is both significant and above the tolerance."""
        return not any(a and b for a, b in zip(self.significant, self.relevant, strict=True))

    @property
    def verdict(self) -> str:
        """Conclusion for the bands, as a sentence."""
        if not self.passed:
            return "not in agreement with the noise"
        near = any(self.significant)
        return "close enough to the noise" if near else "in agreement with the noise"

    def __str__(self) -> str:
        lines = [
            f"innovations: {self.ratio:.3f} times as large as expected (allowed "
            f"{1.0 / (1.0 + self.tolerance):.2f} to {1.0 + self.tolerance:.2f}; mean square "
            f"{self.size:.3f}, by chance {self.low:.3f} to {self.high:.3f}), correlation "
            f"{self.whiteness:+.3f} (allowed +-{self.largest_correlation:.2f}, by chance "
            f"+-{self.limit:.3f}): {self.verdict}"
        ]
        lines += [f"  {name}: {ratio:.2f} of expected" for name, ratio in self.channels.items()]
        return "\n".join(lines)


@explained
def innovation_test(
    observed: Estimates, *, skip: int = 20, tolerance: float = TOLERANCE
) -> InnovationTest:
    """Return the test of innovations for independence and size.

    Mehra, IEEE Trans. Automatic Control 15 (1970) 175: with correct noise, innovations are white,
    and their mean square over their own covariance is chi-squared. A long record shows the errors
    of any model; therefore the verdict also depends on whether the bands are wrong by more than the
    tolerance.

    Parameters
    ----------
    observed : Estimates
        Estimates from `Observer.run`.
    skip : int
        Number of samples excluded at the start.
    tolerance : float
        Share by which bands may be too narrow or too wide: with 0.25, a band of 95 % may contain 88
        to 98.6 %.

    Raises
    ------
    InputError
        If fewer than ten samples are left, or the tolerance is not positive.
    """
    problems = Problems()
    problems.positive("innovation_test", "tolerance", tolerance, "")
    problems.raise_if_any()
    if len(observed) < skip + 10:
        raise InputError(
            Problem("innovation_test", f"{len(observed)} samples, needs {skip + 10} or more")
        )
    # without the balance equations, which free loads always satisfy
    measured = observed.observer.names
    scores = observed.scores[skip:, : len(measured)]
    good = np.isfinite(scores)
    number = int(good.sum())
    z = np.where(good, scores, 0.0)
    pairs = good[1:] & good[:-1]
    channels = observed.observer.channels
    ratios = {}
    for i, name in enumerate(measured):
        squares = []
        for k in range(skip, len(observed)):
            gain = observed.gains[k]
            if gain.mask[i]:
                own = float(channels.H[i] @ gain.predicted @ channels.H[i] + channels.R[i, i])
                squares.append(observed.innovations[k, i] ** 2 / own)
        ratios[name] = float(np.sqrt(np.mean(squares))) if squares else float("nan")
    return InnovationTest(
        size=float((z**2).sum() / number),
        low=float(chi2.ppf(0.025, number) / number),
        high=float(chi2.ppf(0.975, number) / number),
        whiteness=float((z[1:] * z[:-1] * pairs).sum() / max((z**2).sum(), 1e-300)),
        limit=float(1.96 / np.sqrt(max(int(pairs.sum()), 1))),
        channels=ratios,
        tolerance=float(tolerance),
    )


def tune(observer: Observer, time: Any, e: ArrayLike, *, rounds: int = 2) -> Observer:
    """Return the observer with the maximum-likelihood noise of a record.

    The steps alternate: mean, size and rate of every smooth load become those of the smoothed
    record, including its uncertainty (expectation maximisation); noise of the channels, model error
    and rates of rough loads become those of the largest likelihood of the innovations. Only the
    record is used.

    Parameters
    ----------
    observer : Observer
        Observer with start values of noise and rates, right within a factor of some hundred, and
        the balance, which remains unchanged: unknown loads always satisfy it, so that the record
        contains no information on its noise.
    time : (nt,) array_like
        Instants, s; a few hundred samples with typical motion suffice.
    e : (nt, ny) array_like
        Samples as for `Observer.run`.
    rounds : int
        Number of rounds.

    Raises
    ------
    InputError
        As for `Observer.run`.
    """
    found = observer
    if found.system.discrepancy <= 0.0:
        found = found.changed(discrepancy=0.25 * float(np.sqrt(np.mean(np.diag(found.noise)))))
    for turn in range(rounds):
        if any(load.smooth for load in found.system.loads):
            for _ in range(3 if turn == 0 else 1):
                found = _expected_loads(found, time, e)
        found = _likeliest(found, time, e, 1.0 if turn == 0 else 0.3)
    return found


def _expected_loads(observer: Observer, time: Any, e: ArrayLike) -> Observer:
    """Return the observer with means, sizes and rates of smooth loads from a record."""
    system = observer.system
    smoothed = smooth(observer.run(time, e))
    variances = np.einsum("mjj->mj", smoothed.P)[smoothed.which]
    a, a_variance = smoothed.loads, variances[:, system.places]
    slopes = slice(system.places.stop, system.places.stop + int(system.smooth.sum()))
    rate = np.sqrt(np.mean(smoothed.states[:, slopes] ** 2 + variances[:, slopes], axis=0))
    mean = a.mean(axis=0)
    size = np.sqrt(np.mean((a - mean) ** 2 + a_variance, axis=0))
    loads, at, slope = [], 0, 0
    for load in system.loads:
        k = len(load.components)
        if load.smooth:
            own = slice(at, at + k)
            loads.append(
                replace(load, mean=mean[own], size=size[own], rate=rate[slope : slope + k])
            )
            slope += k
        else:
            loads.append(load)
        at += k
    return observer.changed(loads=tuple(loads))


def _likeliest(observer: Observer, time: Any, e: ArrayLike, reach: float) -> Observer:
    """Return the observer with maximum-likelihood noise, model error and rates of rough loads."""
    observed = observer.run(time, e)
    # channels minus the effect of known forces, which does not depend on the noise
    before = np.vstack([observer._static_state(observed.forces[0])[None], observed.states[:-1]])
    predicted = [
        observer.channels.H @ (gain.F @ x + gain.Gu @ f)
        for gain, x, f in zip(observed.gains, before, _means(observed), strict=True)
    ]
    y = observed.innovations + np.array(predicted)
    steps = np.diff(observed.time, prepend=observed.time[0])
    system = observer.system
    rough = [i for i, load in enumerate(system.loads) if not load.smooth]

    def made(logs: Array) -> Observer:
        factors = np.exp(np.clip(logs, -FARTHEST, FARTHEST))
        rates = np.ones(len(system.loads))
        rates[rough] = factors[2:]
        discrepancy = min(factors[1] * system.discrepancy, 0.9 * LARGEST)
        return observer.changed(noise=factors[0], rates=rates, discrepancy=discrepancy)

    def cost(logs: Array) -> float:
        over = float(np.sum(np.maximum(np.abs(logs) - FARTHEST, 0.0)))
        try:
            return -_likelihood(made(logs), steps, y, observed.forces) + 1e3 * over
        except np.linalg.LinAlgError:  # far from the optimum
            return 1e30

    n = 2 + len(rough)
    simplex = np.vstack([np.zeros(n), reach * np.eye(n)])
    options: Any = {"initial_simplex": simplex, "xatol": 0.1, "fatol": 1.0, "maxfev": 20 * n}
    return made(minimize(cost, np.zeros(n), method="Nelder-Mead", options=options).x)


def _means(observed: Estimates) -> Array:
    """Return the known forces in each step (nt, nd)."""
    f = observed.forces[:, observed.observer.system.dynamic]
    return np.vstack([np.zeros_like(f[:1]), 0.5 * (f[:-1] + f[1:])])


def _likelihood(observer: Observer, steps: Array, y: Array, forces: Array) -> float:
    """Return the log-likelihood of channels y (nt, ny) without known offsets."""
    system, channels = observer.system, observer.channels
    d = system.dynamic
    x = observer._static_state(forces[0])
    total = 0.0
    gain: Gain | None = None
    for k, sample in enumerate(y):
        seen = np.isfinite(sample)
        last = gain
        if gain is None:
            gain = first_gain(system, channels, seen)
        else:
            gain = next_gain(gain, system, channels, observer._round_time(float(steps[k])), seen)
            x = gain.F @ x
            if system.nd:
                x = x + gain.Gu @ (0.5 * (forces[k - 1, d] + forces[k, d]))
        if gain is not last:
            H, log = channels.H[seen], float(np.log(np.diag(gain.whiten)).sum())
        innovation = sample[seen] - H @ x
        z = gain.whiten @ innovation
        total += log - 0.5 * float(z @ z)
        x = x + gain.K @ innovation
    return total
