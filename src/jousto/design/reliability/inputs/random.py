"""Random variables: a name and a distribution of SciPy or OpenTURNS."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, Literal

import numpy as np
from scipy.special import ndtr, ndtri

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.names import check_name
from jousto.base.object_repr import described
from jousto.design.studies.parameters.distributions import (
    SHAPED,
    are_moments,
    check_moments,
    distribution_from_moments,
)

ROOT = 2.0 * math.pi
# standard deviations; beyond 37.5 probabilities are below the smallest normal double
EDGES = (37.5, 35.0, 30.0, 20.0, 10.0)


def density(y: Array) -> Array:
    """Return the density of the standard normal distribution."""
    return np.asarray(np.exp(-0.5 * y * y) / math.sqrt(ROOT))


@dataclass(frozen=True, eq=False)
class Affine:
    """``x = loc + scale y``: a normal distribution, no cancellation in its tails."""

    loc: Any
    scale: Any

    def value(self, y: Array) -> Array:
        """Return ``F^-1(Phi(y))``."""
        return np.asarray(self.loc + self.scale * np.asarray(y))

    def normal(self, x: Array) -> Array:
        """Return ``Phi^-1(F(x))``."""
        return np.asarray((np.asarray(x) - self.loc) / self.scale)

    def slope(self, y: Array, x: Array) -> Array:
        """Return ``dx/dy``."""
        return np.broadcast_to(np.asarray(self.scale, dtype=np.float64), np.shape(y))


@dataclass(frozen=True, eq=False)
class Exponential:
    """``x = loc + scale exp(shape y)``: a lognormal distribution, no cancellation in its tails."""

    shape: Any
    loc: Any
    scale: Any

    def value(self, y: Array) -> Array:
        """Return ``F^-1(Phi(y))``."""
        return np.asarray(self.loc + self.scale * np.exp(self.shape * np.asarray(y)))

    def normal(self, x: Array) -> Array:
        """Return ``Phi^-1(F(x))``."""
        return np.asarray(np.log((np.asarray(x) - self.loc) / self.scale) / self.shape)

    def slope(self, y: Array, x: Array) -> Array:
        """Return ``dx/dy``."""
        return np.asarray(self.shape * (np.asarray(x) - self.loc))


@dataclass(frozen=True, eq=False)
class General:
    """Continuous distribution, defined by functions of arrays: cdf, quantiles and density."""

    below: Callable[[Array], Array]
    above: Callable[[Array], Array]
    low: Callable[[Array], Array]
    high: Callable[[Array], Array]
    density: Callable[[Array], Array]

    @cached_property
    def edge(self) -> float:
        """Largest |y| with finite quantiles; beyond it ``value`` is constant."""
        with np.errstate(all="ignore"):
            for y in EDGES:
                p = np.array([ndtr(-y)])
                if np.all(np.isfinite(self.low(p)) & np.isfinite(self.high(p))):
                    return y
        return EDGES[-1]

    def value(self, y: Array) -> Array:
        """Return ``F^-1(Phi(y))``, by the survival function in the upper tail."""
        y = np.clip(np.asarray(y, dtype=np.float64), -self.edge, self.edge)
        down = y <= 0.0
        if np.all(down):
            return np.asarray(self.low(ndtr(y)), dtype=np.float64)
        if not np.any(down):
            return np.asarray(self.high(ndtr(-y)), dtype=np.float64)
        low = self.low(ndtr(np.where(down, y, 0.0)))
        high = self.high(ndtr(-np.where(down, 0.0, y)))
        return np.asarray(np.where(down, low, high), dtype=np.float64)

    def normal(self, x: Array) -> Array:
        """Return ``Phi^-1(F(x))``."""
        p, q = self.below(x), self.above(x)
        return np.asarray(np.where(p <= 0.5, ndtri(p), -ndtri(q)), dtype=np.float64)

    def slope(self, y: Array, x: Array) -> Array:
        """Return ``dx/dy = phi(y) / f(x)``."""
        return np.asarray(density(np.asarray(y)) / self.density(x))


Law = Affine | Exponential | General


def scipy_parameters(distribution: Any) -> tuple[tuple[Any, ...], Any, Any]:
    """Return shape parameters, loc and scale of a frozen SciPy distribution."""
    shapes, loc, scale = distribution.dist._parse_args(*distribution.args, **distribution.kwds)
    return tuple(shapes), loc, scale


def law(distribution: Any) -> Law | None:
    """Return the functions of a continuous distribution; None if it is not continuous."""
    if _is_scipy(distribution):
        shapes, loc, scale = scipy_parameters(distribution)
        if distribution.dist.name == "norm":
            return Affine(loc, scale)
        if distribution.dist.name == "lognorm":
            return Exponential(shapes[0], loc, scale)
        d = distribution
        return General(d.cdf, d.sf, d.ppf, d.isf, d.pdf)
    if _is_openturns(distribution):
        return _openturns_law(distribution)
    return None


def _is_scipy(distribution: Any) -> bool:
    return hasattr(distribution, "dist") and all(
        hasattr(distribution, name) for name in ("cdf", "sf", "ppf", "isf", "pdf")
    )


def class_name(distribution: Any) -> str:
    """Return the family name of an OpenTURNS distribution."""
    inner = getattr(distribution, "getImplementation", lambda: distribution)()
    return str(inner.getClassName())


def _is_openturns(distribution: Any) -> bool:
    return hasattr(distribution, "computeCDF") and hasattr(distribution, "isContinuous")


def _openturns_law(distribution: Any) -> General:
    """Return the functions of an OpenTURNS distribution."""
    d = distribution

    def column(function: Callable[[float], float]) -> Callable[[Array], Array]:
        def of(x: Array) -> Array:
            try:
                found = [function(float(v)) for v in np.ravel(x)]
            except Exception as error:  # OpenTURNS and its dependencies raise plain exceptions
                message = f"{class_name(d)} of OpenTURNS failed: {error}"
                raise InputError(Problem("random variable", message)) from error
            return np.reshape(np.array(found, dtype=np.float64), np.shape(x))

        return of

    return General(
        below=column(d.computeCDF),
        above=column(d.computeComplementaryCDF),
        low=column(partial(quantile, d, tail=False)),
        high=column(partial(quantile, d, tail=True)),
        density=column(d.computePDF),
    )


def quantile(distribution: Any, p: float, tail: bool) -> float:
    """Return x of an OpenTURNS distribution with ``F(x) = p``, or ``1 - F(x) = p`` (upper tail).

    The root finding of OpenTURNS fails for some distributions, such as ``Beta(0.2, 2)``; bisection
    of the distribution function does not.
    """
    try:
        return float(distribution.computeScalarQuantile(p, tail))
    except RuntimeError:
        pass
    ends = distribution.getRange()
    low, high = float(ends.getLowerBound()[0]), float(ends.getUpperBound()[0])
    share = distribution.computeComplementaryCDF if tail else distribution.computeCDF
    while low < (middle := 0.5 * low + 0.5 * high) < high:
        if (share(middle) < p) is not tail:
            low = middle
        else:
            high = middle
    return high if tail else low


@explained
@described
@dataclass(frozen=True, eq=False)
class Random:
    """Random variable: a name and a distribution.

    Parameters
    ----------
    name : str
        Name of the variable in limit states.
    distribution : scipy.stats or OpenTURNS distribution
        Continuous, of one variable, with finite mean and deviation: ``scipy.stats.norm(50, 1)``,
        `distribution_from_moments`, ``openturns.Normal(50, 1)``.
    keep : {"deviation", "cov"}
        Constant moment if the mean is a design variable: the deviation, or the coefficient of
        variation (deviation over mean).

    Attributes
    ----------
    mean, deviation : float
        Moments in the unit of the variable.

    Raises
    ------
    InputError
        For a distribution that is discrete, has several variables or no finite moments.

    Examples
    --------
    >>> import scipy.stats
    >>> Random("F", scipy.stats.norm(75e3, 5e3))
    <Random 'F': norm, mean 75000, deviation 5000>
    """

    name: str
    distribution: Any
    keep: Literal["deviation", "cov"] = "deviation"
    law: Law = field(init=False, repr=False)
    mean: float = field(init=False)
    deviation: float = field(init=False)

    def __post_init__(self) -> None:
        problems = Problems()
        where = check_name(problems, "random variable", self.name)
        if self.keep not in ("deviation", "cov"):
            problems.add(where, f"keep is {self.keep!r}, must be 'deviation' or 'cov'")
        found = _checked(problems, where, self.distribution)
        problems.raise_if_any()
        assert found is not None
        for key, value in zip(("law", "mean", "deviation"), found, strict=True):
            object.__setattr__(self, key, value)

    @property
    def kind(self) -> str:
        """Family name of the distribution."""
        if _is_scipy(self.distribution):
            return str(self.distribution.dist.name)
        return class_name(self.distribution)

    def _facts(self) -> str:
        return f"{self.kind}, mean {self.mean:.6g}, deviation {self.deviation:.6g}"

    def moved(self, mean: float | None = None, deviation: float | None = None) -> Random:
        """Return the variable with another mean or standard deviation.

        Lognormal, Weibull and gamma distributions keep family and lower limit; all others are
        shifted and scaled.

        Parameters
        ----------
        mean : float, optional
            New mean; None keeps it.
        deviation : float, optional
            New deviation; None keeps the moment that `keep` selects.
        """
        new = self.mean if mean is None else float(mean)
        if deviation is None:
            deviation = self.deviation
            if self.keep == "cov" and self.mean != 0.0:
                deviation = self.deviation * abs(new / self.mean)
        if new == self.mean and deviation == self.deviation:
            return self
        return Random(self.name, _moved(self, new, float(deviation)), self.keep)


def _moved(variable: Random, mean: float, deviation: float) -> Any:
    d = variable.distribution
    stretch = deviation / variable.deviation
    if _is_scipy(d):
        shapes, loc, scale = scipy_parameters(d)
        if d.dist.name in SHAPED:
            return distribution_from_moments(SHAPED[d.dist.name], mean, deviation, start=float(loc))  # type: ignore[arg-type]
        return d.dist(*shapes, loc=mean - (variable.mean - loc) * stretch, scale=scale * stretch)
    if variable.kind == "LogNormal":
        import openturns

        start = d.getParameter()[2]
        return openturns.LogNormalMuSigma(mean, deviation, start).getDistribution()
    return d * stretch + (mean - variable.mean * stretch)


def _checked(problems: Problems, where: str, distribution: Any) -> tuple[Law, float, float] | None:
    """Return functions, mean and deviation of a distribution, and add its problems."""
    found = law(distribution)
    if found is None:
        hint = "must be a frozen distribution of scipy.stats or one of OpenTURNS"
        if hasattr(distribution, "pmf") or hasattr(distribution, "pdf"):
            hint += ", continuous and with its parameters: scipy.stats.norm(50, 1)"
        problems.add(where, f"distribution is {distribution!r}, {hint}")
        return None
    if _is_scipy(distribution):
        moments = check_moments(problems, where, distribution)
        return None if moments is None else (found, *moments)
    else:
        if distribution.getDimension() != 1 or not distribution.isContinuous():
            problems.add(where, "distribution must be continuous and of one variable")
            return None
        try:
            mean, deviation = distribution.getMean()[0], distribution.getStandardDeviation()[0]
        except Exception:  # OpenTURNS raises various exceptions where a moment does not exist
            mean = deviation = math.nan
    good = are_moments(problems, where, float(mean), float(deviation))
    return (found, float(mean), float(deviation)) if good else None


@explained
@described
@dataclass(frozen=True, eq=False)
class Conditional:
    """Random variable whose distribution depends on the variables before it.

    Parameters
    ----------
    name : str
        Name of the variable in limit states.
    distribution : callable
        ``distribution(x)`` returns the distribution of this variable for given values ``x["name"]``
        of the variables before it, which may be arrays.

    Examples
    --------
    Wind that turns stronger with height: ``Conditional("v", lambda x: norm(3 + 2 * x["h"], 1))``
    """

    name: str
    distribution: Callable[..., Any]

    def __post_init__(self) -> None:
        problems = Problems()
        where = check_name(problems, "random variable", self.name)
        given: Any = self.distribution
        if not callable(given):
            problems.add(where, f"distribution is {given!r}, must be a function of those before it")
        problems.raise_if_any()
