"""Distributions in text, such as ``lognormal(mean=1 kN, sd=100 N)``, as SciPy distributions."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from functools import partial
from typing import Any, Literal

import numpy as np

from jousto.base.arguments import explained
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.expressions import NONE, ExpressionError, Quantity, evaluate

CALL = re.compile(r"\s*([A-Za-z]\w*)\s*\((.*)\)\s*", re.S)
EULER = 0.57721566490153286  # mean of the standard Gumbel distribution
KINDS = ("normal", "lognormal", "uniform", "gumbel", "gumbel-min", "weibull", "gamma")
Kind = Literal["normal", "lognormal", "uniform", "gumbel", "gumbel-min", "weibull", "gamma"]
SHAPED = {"lognorm": "lognormal", "weibull_min": "weibull", "gamma": "gamma"}
"""SciPy distributions that begin at ``loc``, with a shape that follows from the moments."""


@explained
def distribution_from_moments(
    kind: Kind, mean: float, deviation: float, *, start: float = 0.0
) -> Any:
    """Return a SciPy distribution from its mean and standard deviation.

    Parameters
    ----------
    kind : {"normal", "lognormal", "uniform", "gumbel", "gumbel-min", "weibull", "gamma"}
        "gumbel" is for maxima (loads), "gumbel-min" and "weibull" are for minima (strengths).
    mean, deviation : float
        Both in the unit of the variable.
    start : float, optional
        Lower limit of a lognormal, Weibull or gamma distribution.

    Returns
    -------
    scipy.stats distribution
        Frozen; for `Random`.

    Raises
    ------
    InputError
        For an unknown kind, a deviation that is not positive or a mean that is not beyond the
        start.

    Examples
    --------
    >>> yield_stress = distribution_from_moments("lognormal", 300e6, 30e6)
    >>> print(f"{yield_stress.mean():.4g} {yield_stress.std():.4g}")
    3e+08 3e+07
    """
    problems = Problems()
    if kind not in KINDS:
        problems.add("distribution", f"kind is {kind!r}{suggest(kind, KINDS)}")
    problems.number("distribution", "mean", mean, "")
    problems.number("distribution", "start", start, "")
    problems.positive("distribution", "deviation", deviation, "")
    problems.raise_if_any()
    if kind in SHAPED.values() and not mean > start:
        message = f"mean is {mean:g}, must be beyond {start:g}, where a {kind} distribution begins"
        raise InputError(Problem("distribution", message))
    from scipy import stats

    ratio = deviation / (mean - start) if mean != start else 0.0
    if kind == "lognormal":
        square = math.log1p(ratio * ratio)
        scale = (mean - start) * math.exp(-0.5 * square)
        return stats.lognorm(math.sqrt(square), loc=start, scale=scale)
    if kind == "uniform":
        half = math.sqrt(3.0) * deviation
        return stats.uniform(mean - half, 2.0 * half)
    if kind in ("gumbel", "gumbel-min"):
        scale = deviation * math.sqrt(6.0) / math.pi
        law, side = (stats.gumbel_r, -1) if kind == "gumbel" else (stats.gumbel_l, 1)
        return law(mean + side * EULER * scale, scale)
    if kind == "weibull":
        shape = _weibull_shape(ratio)
        scale = (mean - start) / math.gamma(1.0 + 1.0 / shape)
        return stats.weibull_min(shape, loc=start, scale=scale)
    if kind == "gamma":
        return stats.gamma(1.0 / ratio**2, loc=start, scale=(mean - start) * ratio**2)
    return stats.norm(mean, deviation)


def _weibull_shape(ratio: float) -> float:
    """Return the Weibull exponent for a ratio of deviation to mean."""
    from scipy.optimize import brentq

    def miss(log_shape: float) -> float:
        k = math.exp(-log_shape)
        both = math.lgamma(1.0 + 2.0 * k) - 2.0 * math.lgamma(1.0 + k)
        return float(both - math.log1p(ratio * ratio))

    try:
        return math.exp(brentq(miss, -3.0, 12.0, xtol=1e-14))
    except ValueError:
        message = f"deviation / mean is {ratio:.3g}, outside the range of Weibull distributions"
        raise InputError(Problem("distribution", message)) from None


def _between(low: float, high: float) -> Any:
    from scipy import stats

    return stats.uniform(low, high - low)


def _triangular(low: float, mode: float, high: float) -> Any:
    from scipy import stats

    return stats.triang((mode - low) / (high - low), low, high - low)


def _weibull(scale: float, shape: float) -> Any:
    from scipy import stats

    return stats.weibull_min(shape, scale=scale)


MOMENTS, ENDS = ("mean", "sd"), ("low", "high")
MADE: dict[str, tuple[Callable[..., Any], tuple[str, ...]]] = {
    "normal": (partial(distribution_from_moments, "normal"), MOMENTS),
    "lognormal": (partial(distribution_from_moments, "lognormal"), MOMENTS),
    "gumbel": (partial(distribution_from_moments, "gumbel"), MOMENTS),
    "uniform": (_between, ENDS),
    "triangular": (_triangular, ("low", "mode", "high")),
    "weibull": (_weibull, ("scale", "shape")),
}
"""Distributions by name with their arguments; ``cov=`` may replace ``sd = cov * mean``."""


def is_distribution(thing: Any) -> bool:
    """Return whether an object has the methods of a SciPy distribution."""
    return all(callable(getattr(thing, name, None)) for name in ("ppf", "rvs", "mean", "std"))


def check_moments(problems: Problems, where: str, distribution: Any) -> tuple[float, float] | None:
    """Return mean and deviation of a SciPy distribution, or add a problem if they do not exist."""
    with np.errstate(all="ignore"):
        middle = distribution.ppf(0.5)
        mean, deviation = distribution.mean(), distribution.std()
    if np.ndim(mean):
        problems.add(where, "distribution has arrays as parameters, must have numbers")
    elif not math.isfinite(middle):
        message = "has no median: its parameters are impossible, such as a scale below 0"
        problems.add(where, f"distribution {message}")
    elif are_moments(problems, where, float(mean), float(deviation)):
        return float(mean), float(deviation)
    return None


def are_moments(problems: Problems, where: str, mean: float, deviation: float) -> bool:
    """Return whether mean and deviation are finite, and add a problem if they are not."""
    good = math.isfinite(mean) and math.isfinite(deviation) and deviation > 0.0
    if not good:
        message = (
            f"mean is {mean:g} and deviation {deviation:g}, both must be finite and the deviation "
            "positive; truncate a distribution with heavy tails at values that are possible"
        )
        problems.add(where, message)
    return good


def read_distribution(text: str, mean: float, exponents: tuple[float, ...], where: str) -> Any:
    """Return the distribution of a text.

    Parameters
    ----------
    text : str
        Text such as ``normal(sd=2 mm)``.
    mean : float
        Mean if the text contains none.
    exponents : tuple
        Exponents of the parameter's unit; plain numbers are in its SI unit.
    where : str
        Place in messages.

    Raises
    ------
    InputError
        With all problems.

    Examples
    --------
    >>> float(read_distribution("uniform(2 mm, 6 mm)", 0.0, (1, 0, 0, 0), "").mean())
    0.004
    """
    match = CALL.fullmatch(text)
    if match is None or match[1] not in MADE:
        found = f"no distribution {match[1]!r}" if match else f"{text!r} is no distribution"
        known = suggest(match[1] if match else text, MADE)
        raise InputError(Problem(where, found + known))
    make, names = MADE[match[1]]
    given: dict[str, float] = {}
    problems: list[Problem] = []
    for i, piece in enumerate(filter(str.strip, match[2].split(","))):
        key, equals, value = piece.partition("=")
        key = key.strip() if equals else (names[i] if i < len(names) else "")
        known_keys = (*names, "cov") if "sd" in names else names
        if key not in known_keys or key in given:
            what = f"{piece.strip()!r} is one too many" if not equals or key in given else ""
            message = what or f"{match[1]} has no {key!r}{suggest(key, known_keys)}"
            problems.append(Problem(where, message))
            continue
        try:
            number = evaluate(value if equals else piece, {})
        except ExpressionError as error:
            problems.append(Problem(where, f"{key}: {error}"))
            continue
        plain = key in ("cov", "shape")
        if number.exponents not in ((NONE,) if plain else (NONE, exponents)):
            wanted = "a plain number" if plain else Quantity(1.0, exponents).said
            problems.append(Problem(where, f"{key} is {number.said}, must be like {wanted}"))
        given[key] = number.value
    if "mean" in names:
        given.setdefault("mean", mean)
    if "cov" in given:
        given["sd"] = given.pop("cov") * abs(given["mean"])
    missing = [name for name in names if name not in given]
    if missing and not problems:
        problems.append(Problem(where, f"{match[1]} needs {' and '.join(missing)}"))
    if not problems:
        problems += (Problem(where, message) for message in _faults(match[1], given))
    if problems:
        raise InputError(problems)
    return make(*(given[name] for name in names))


def _faults(name: str, x: dict[str, float]) -> list[str]:
    """Return the problems of the arguments of a distribution."""
    found = []
    for key in ("sd", "scale", "shape"):
        if key in x and not x[key] > 0.0:
            found.append(f"{key} is {x[key]:g}, must be positive")
    if name == "lognormal" and not x["mean"] > 0.0:
        found.append(f"mean is {x['mean']:g}, must be positive")
    if "low" in x and not x["low"] < x["high"]:
        found.append(f"low is {x['low']:g}, must be below high, {x['high']:g}")
    elif "mode" in x and not x["low"] <= x["mode"] <= x["high"]:
        found.append(f"mode is {x['mode']:g}, must be between low and high")
    return found
