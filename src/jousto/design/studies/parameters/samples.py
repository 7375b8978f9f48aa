"""Samples: the points of a study, as arrays (n, np)."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, MissingFileError, Problem, Problems, suggest
from jousto.base.expressions import ExpressionError, read_quantity
from jousto.base.files import check_text
from jousto.design.studies.parameters.parameter import Parameter

Parameters = Sequence[Parameter]
MOST = 1_000_000
"""Maximum number of points: a million cheap ones take a quarter of an hour and 1 GB."""


def _as_parameters(parameters: Parameters) -> tuple[Parameter, ...]:
    """Return the parameters as a tuple; raise InputError for other objects."""
    problems = Problems()
    found = problems.several("samples", "parameters", parameters, Parameter)
    problems.raise_if_any()
    return found


def _scale_to_ranges(parameters: Parameters, u: Array) -> Array:
    """Return values from numbers in [0, 1]: quantiles of the distribution, else within bounds."""
    problems = [
        Problem(f"parameter '{p.name}'", "has neither bounds nor a distribution to sample")
        for p in parameters
        if p.bounds is None and p.distribution is None
    ]
    if problems:
        raise InputError(problems)
    x = np.empty_like(u)
    for k, p in enumerate(parameters):
        if p.distribution is not None:
            x[:, k] = p.distribution.ppf(np.clip(u[:, k], 1e-16, 1.0 - 1e-16))
            if p.bounds is not None:
                x[:, k] = np.clip(x[:, k], *p.bounds)
        else:
            low, high = p.bounds  # type: ignore[misc]
            x[:, k] = low + (high - low) * u[:, k]
    return x


def _count(count: Any) -> int:
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or count < 1:
        raise InputError(Problem("samples", f"count is {count!r}, must be a whole number from 1"))
    check_count("samples", int(count))
    return int(count)


def check_count(where: str, *factors: float) -> None:
    """Raise InputError for a number of points beyond `MOST`, before any is created.

    Raises
    ------
    InputError
        With the largest number of points in the message.
    """
    total = math.prod(factors)
    if total > MOST:
        message = f"{total:.4g} points, a study takes {MOST:,} at most; split it, or take fewer"
        raise InputError(Problem(where, message))


def _draw_points(
    parameters: Parameters,
    count: Any,
    seed: int,
    draw: Callable[[int, int, np.random.Generator], Array],
) -> Array:
    """Return values of points in the unit cube that `draw` creates."""
    some = _as_parameters(parameters)
    return _scale_to_ranges(some, draw(_count(count), len(some), np.random.default_rng(seed)))


@explained
def grid(parameters: Parameters, levels: int | Mapping[str, int | ArrayLike] = 10) -> Array:
    """Return all combinations of values of the parameters.

    Parameters
    ----------
    parameters : sequence of Parameter
        The columns; the last one changes fastest.
    levels : int or dict
        Number of values between the bounds (for all parameters, or by name), or the values by name.
        Parameters that a dictionary does not name keep their nominal value.

    Returns
    -------
    (n, np) array

    Raises
    ------
    InputError
        For unknown names, and for a number of values if the parameter has no bounds.
    """
    parameters = _as_parameters(parameters)
    axes: list[Array] = []
    problems: list[Problem] = []
    names = [p.name for p in parameters]
    given = levels if isinstance(levels, Mapping) else dict.fromkeys(names, levels)
    for name in given:
        if name not in names:
            problems.append(Problem("grid", f"no parameter {name!r}{suggest(name, names)}"))
    for p in parameters:
        value: Any = given.get(p.name, [p.value])
        if np.ndim(value):
            axes.append(np.asarray(value, dtype=float).ravel())
        elif p.bounds is None:
            problems.append(Problem(f"parameter '{p.name}'", "has no bounds for a grid"))
        else:
            axes.append(np.linspace(*p.bounds, _count(value)))
    if problems:
        raise InputError(problems)
    check_count("grid", *map(len, axes))
    return np.stack([x.ravel() for x in np.meshgrid(*axes, indexing="ij")], axis=1)


@explained
def latin_hypercube(parameters: Parameters, count: int, *, seed: int = 0) -> Array:
    """Return a Latin hypercube: one point in each of `count` strata of every parameter.

    Parameters
    ----------
    parameters : sequence of Parameter
        Parameters with a distribution (strata of equal probability) or bounds.
    count : int
        Number of points.
    seed : int
        Seed of the random numbers; equal seeds give equal points.

    Returns
    -------
    (n, np) array
    """
    from scipy.stats import qmc

    return _draw_points(
        parameters, count, seed, lambda n, k, rng: qmc.LatinHypercube(k, rng=rng).random(n)
    )


@explained
def sobol(parameters: Parameters, count: int, *, seed: int = 0) -> Array:
    """Return the first points of a scrambled Sobol sequence; a power of two is best.

    Parameters
    ----------
    parameters : sequence of Parameter
        Parameters with a distribution or bounds.
    count : int
        Number of points.
    seed : int
        Seed of the scrambling.

    Returns
    -------
    (n, np) array
    """
    from scipy.stats import qmc

    def first(n: int, k: int, rng: np.random.Generator) -> Array:
        return np.asarray(qmc.Sobol(k, rng=rng).random_base2((n - 1).bit_length())[:n])

    return _draw_points(parameters, count, seed, first)


@explained
def random_samples(parameters: Parameters, count: int, *, seed: int = 0) -> Array:
    """Return independent random points (Monte Carlo).

    Parameters
    ----------
    parameters : sequence of Parameter
        Parameters with a distribution or bounds.
    count : int
        Number of points.
    seed : int
        Seed of the random numbers; equal seeds give equal points.

    Returns
    -------
    (n, np) array
    """
    return _draw_points(parameters, count, seed, lambda n, k, rng: rng.random((n, k)))


@explained
def read_samples(path: str | Path, parameters: Parameters) -> Array:
    """Return the points of a CSV file.

    Parameters
    ----------
    path : path
        CSV file. Its first line contains names, ``wall`` or ``wall (mm)``; parameters without a
        column keep their nominal value. Values may have units.
    parameters : sequence of Parameter
        Parameters of the study, the columns of the result.

    Returns
    -------
    (n, np) array

    Raises
    ------
    InputError
        With all problems of the file and their lines.
    """
    name, parameters = str(path), _as_parameters(parameters)
    check_text(Path(path))
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise MissingFileError(Problem(name, "no such file")) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(Problem(name, f"cannot be read: {error}")) from None
    rows = [row for row in csv.reader(text.splitlines()) if any(cell.strip() for cell in row)]
    if len(rows) < 2:
        raise InputError(Problem(name, "needs a line with names and a line for each point"))
    known = {p.name: k for k, p in enumerate(parameters)}
    problems: list[Problem] = []
    places: list[tuple[int, int, str]] = []
    for column, cell in enumerate(rows[0]):
        head, _, unit = cell.strip().partition("(")
        if head.strip() in known:
            places.append((column, known[head.strip()], unit.rstrip(") ")))
        else:
            tail = suggest(head.strip(), known)
            problems.append(Problem(f"{name}:1", f"no parameter {head.strip()!r}{tail}"))
    x = np.tile([p.value for p in parameters], (len(rows) - 1, 1)).astype(float)
    for line, row in enumerate(rows[1:]):
        for column, k, unit in places:
            cell = row[column].strip() if column < len(row) else ""
            try:
                x[line, k] = _number(cell, unit, parameters[k])
            except ExpressionError as error:
                problems.append(Problem(f"{name}:{line + 2}", f"{parameters[k].name}: {error}"))
    if problems:
        raise InputError(problems)
    return x


def _number(cell: str, unit: str, parameter: Parameter) -> float:
    """Return the value of a cell in SI."""
    found = read_quantity(cell)
    plain = read_quantity(0).exponents
    if unit and found.exponents == plain:
        found = read_quantity(f"{cell} {unit}")
    if found.exponents not in (plain, parameter.exponents):
        raise ExpressionError(f"is {found.said}, must be in {parameter.unit}")
    return found.value
