"""Distributions in text, such as ``lognormal(mean=1 kN, sd=100 N)``, as those of scipy.stats."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

from jousto.base.errors import InputError, Problem, suggest
from jousto.base.expressions import NONE, ExpressionError, Quantity, evaluate

CALL = re.compile(r"\s*([A-Za-z]\w*)\s*\((.*)\)\s*", re.S)
EULER = 0.57721566490153286  # mean of the standard Gumbel distribution
SPREAD = ("sd", "cov")


def _normal(mean: float, sd: float) -> Any:
    from scipy import stats

    return stats.norm(mean, sd)


def _lognormal(mean: float, sd: float) -> Any:
    from scipy import stats

    zeta = math.sqrt(math.log1p((sd / mean) ** 2))
    return stats.lognorm(s=zeta, scale=mean / math.sqrt(1.0 + (sd / mean) ** 2))


def _gumbel(mean: float, sd: float) -> Any:
    from scipy import stats

    scale = sd * math.sqrt(6.0) / math.pi
    return stats.gumbel_r(mean - EULER * scale, scale)


def _uniform(low: float, high: float) -> Any:
    from scipy import stats

    return stats.uniform(low, high - low)


def _triangular(low: float, mode: float, high: float) -> Any:
    from scipy import stats

    return stats.triang((mode - low) / (high - low), low, high - low)


def _weibull(scale: float, shape: float) -> Any:
    from scipy import stats

    return stats.weibull_min(shape, scale=scale)


MADE: dict[str, tuple[Callable[..., Any], tuple[str, ...]]] = {
    "normal": (_normal, ("mean", "sd")),
    "lognormal": (_lognormal, ("mean", "sd")),
    "gumbel": (_gumbel, ("mean", "sd")),
    "uniform": (_uniform, ("low", "high")),
    "triangular": (_triangular, ("low", "mode", "high")),
    "weibull": (_weibull, ("scale", "shape")),
}
"""Distributions by name with their numbers; ``cov=`` may stand for ``sd = cov * mean``."""


def is_distribution(thing: Any) -> bool:
    """Return whether something is a distribution like those of scipy.stats."""
    return all(callable(getattr(thing, name, None)) for name in ("ppf", "rvs", "mean", "std"))


def read_distribution(text: str, mean: float, exponents: tuple[float, ...], where: str) -> Any:
    """Return the distribution of a text.

    Parameters
    ----------
    text : str
        Such as ``normal(sd=2 mm)``.
    mean : float
        The mean where the text names none.
    exponents : tuple
        Those of the parameter; plain numbers are in its SI unit.
    where : str
        For messages.

    Raises
    ------
    InputError
        Everything that is wrong with it.

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
    """Return what is impossible in the numbers of a distribution."""
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
