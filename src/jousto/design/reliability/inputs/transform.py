"""Transformations of random variables to independent standard normal ones."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import scipy.linalg
from scipy.special import ndtr, ndtri

from jousto.base.arguments import explained
from jousto.base.arrays import Array, read_only
from jousto.base.errors import InputError, JoustoError, Problem, Problems, suggest
from jousto.base.names import check_name
from jousto.base.object_repr import described
from jousto.design.reliability.inputs.correlation import normal_correlation
from jousto.design.reliability.inputs.random import Conditional, Law, Random, class_name, law

Correlation = Mapping[tuple[str, str], float]
STENCIL = 1e-3  # relative step of fourth-order differences: error 1e-12
WHERE = "random variables"


class Transformation(ABC):
    """Transformation ``x = T(u)`` of independent standard normal u; arrays (n,) or (n, points)."""

    @property
    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """Names of the variables."""

    @abstractmethod
    def to_x(self, u: Array) -> Array:
        """Return the variables x of standard normal values u."""

    @abstractmethod
    def to_u(self, x: Array) -> Array:
        """Return the standard normal values u of variables x."""

    def jacobian(self, u: Array) -> Array:
        """Return ``dx/du`` (n, n) at one point by fourth-order differences."""
        n = len(u)
        shifts = np.array([1.0, -1.0, 2.0, -2.0])
        moves = np.concatenate([s * STENCIL * np.eye(n) for s in shifts], axis=1)
        a, b, c, d = np.split(self.to_x(u[:, None] + moves), 4, axis=1)
        return np.asarray((8.0 * (a - b) - (c - d)) / (12.0 * STENCIL))

    @property
    def randoms(self) -> tuple[Random, ...]:
        """Variables whose moments may be varied; empty where moments are not defined."""
        return ()

    def moved(self, moments: Mapping[str, tuple[float, float | None]]) -> Transformation:
        """Return the transformation with other means and deviations of some variables."""
        raise NotImplementedError

    @property
    def means(self) -> Array:
        """Means of the variables; medians where a mean does not exist."""
        if self.randoms:
            return np.array([one.mean for one in self.randoms])
        return self.to_x(np.zeros(len(self.names)))


@explained
@described
@dataclass(frozen=True, eq=False)
class Nataf(Transformation):
    """Correlated random variables: Nataf's model, a Gaussian copula.

    ``y_i = Phi^-1(F_i(x_i))``, ``u = L^-1 y``, ``L L^T = R_0``. R_0, the correlation of y that
    leads to the given correlation of x, is computed (A. Der Kiureghian and P.-L. Liu, *J. Eng.
    Mech.* 112 (1986) 85-104), here by Hermite series.

    Parameters
    ----------
    variables : sequence of Random
        Variables with different names.
    correlation : dict or (n, n) array, optional
        ``{("E", "I"): 0.4}`` or a matrix; pairs that are not named are independent.
    measure : {"pearson", "spearman", "normal"}
        Kind of the correlation: of the values, of their ranks, or R_0 itself.

    Attributes
    ----------
    normal : (n, n) array
        R_0.

    Raises
    ------
    InputError
        For a correlation that no variables with such distributions can have.
    """

    variables: Sequence[Random]
    correlation: Any = None
    measure: Literal["pearson", "spearman", "normal"] = "pearson"
    normal: Array = field(init=False)
    _root: Array = field(init=False, repr=False)
    _given: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        problems = Problems()
        variables = problems.several(WHERE, "variables", self.variables, Random)
        check_names(problems, [one.name for one in variables])
        if self.measure not in ("pearson", "spearman", "normal"):
            known = "'pearson', 'spearman' or 'normal'"
            problems.add("correlation", f"measure is {self.measure!r}, must be {known}")
        problems.raise_if_any()
        given = _matrix(problems, [one.name for one in variables], self.correlation)
        normal = np.eye(len(variables))
        if given is not None:
            normal = _normal(problems, variables, given, self.measure)
        problems.raise_if_any()
        assert given is not None
        root = _factor(variables, given, normal)
        facts = {"variables": variables, "normal": normal, "_root": root, "_given": given}
        for key, value in facts.items():
            frozen = read_only(value) if isinstance(value, np.ndarray) else value
            object.__setattr__(self, key, frozen)

    def _facts(self) -> str:
        pairs = int(np.count_nonzero(np.triu(self._given, 1)))
        names = ", ".join(self.names[:6]) + (", ..." if len(self.names) > 6 else "")
        return f"{names}; " + (f"{pairs} correlated pairs" if pairs else "independent")

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the variables."""
        return tuple(one.name for one in self.variables)

    @property
    def randoms(self) -> tuple[Random, ...]:
        """The variables."""
        return tuple(self.variables)

    def to_x(self, u: Array) -> Array:
        """Return the variables x of standard normal values u."""
        y = self._root @ u
        return np.array([one.law.value(row) for one, row in zip(self.variables, y, strict=True)])

    def to_u(self, x: Array) -> Array:
        """Return the standard normal values u of variables x."""
        pairs = zip(self.variables, x, strict=True)
        y = np.array([one.law.normal(np.asarray(row)) for one, row in pairs])
        return np.asarray(
            scipy.linalg.solve_triangular(self._root, y, lower=True, check_finite=False)
        )

    def jacobian(self, u: Array) -> Array:
        """Return ``dx/du = diag(phi(y) / f(x)) L``."""
        y = self._root @ u
        laws = [one.law for one in self.variables]
        slopes = [float(law.slope(y[i], law.value(y[i]))) for i, law in enumerate(laws)]
        return np.asarray(np.array(slopes)[:, None] * self._root)

    def moved(self, moments: Mapping[str, tuple[float, float | None]]) -> Nataf:
        """Return the transformation with other means and deviations of some variables."""
        new = [
            one.moved(*moments[one.name]) if one.name in moments else one for one in self.randoms
        ]
        if self.measure == "pearson":
            return Nataf(new, self._given, "pearson")
        return Nataf(new, self.normal, "normal")


@explained
@described
@dataclass(frozen=True, eq=False)
class Rosenblatt(Transformation):
    """Random variables that may each depend on those before: Rosenblatt's transformation.

    ``u_1 = Phi^-1(F_1(x_1))``, ``u_i = Phi^-1(F_i(x_i | x_1 .. x_i-1))`` (M. Rosenblatt, *Ann.
    Math. Stat.* 23 (1952) 470-472).

    Parameters
    ----------
    variables : sequence of Random or Conditional
        Variables in the order of their dependence.
    copula : OpenTURNS copula, optional
        Dependence of variables that are all Random.
    """

    variables: Sequence[Random | Conditional]
    copula: Any = None
    _maps: Any = field(init=False, repr=False, default=None)

    def __post_init__(self) -> None:
        problems = Problems()
        kinds: Any = (Random, Conditional)
        given: Any = self.variables
        variables: tuple[Any, ...] = ()
        if isinstance(given, kinds):
            variables = (given,)
        elif isinstance(given, list | tuple):
            variables = tuple(given)
        else:
            problems.add(WHERE, f"variables is {given!r}, must be a sequence of Random")
        for i, one in enumerate(variables):
            if not isinstance(one, kinds):
                problems.add(WHERE, f"variables[{i}] is {one!r}, must be a Random or Conditional")
        problems.raise_if_any()
        check_names(problems, [one.name for one in variables])
        if self.copula is not None:
            maps = _copula_maps(problems, variables, self.copula)
            object.__setattr__(self, "_maps", maps)
        problems.raise_if_any()
        object.__setattr__(self, "variables", variables)

    def _facts(self) -> str:
        about = type(self.copula).__name__ if self.copula is not None else ""
        given = sum(isinstance(one, Conditional) for one in self.variables)
        return f"{', '.join(self.names[:6])}; {about or f'{given} conditional'}"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the variables."""
        return tuple(one.name for one in self.variables)

    def _law(self, i: int, x: Array) -> Law:
        one = self.variables[i]
        if isinstance(one, Random):
            return one.law
        where = f"random variable '{one.name}'"
        from jousto.design.reliability.limit import format_values, named

        try:
            distribution = one.distribution(named(self.names[:i], x[:i]))
        except JoustoError:
            raise
        except Exception as error:
            if x.ndim == 2:  # the law of a Conditional may be a function of one point
                raise ValueError from error
            message = f"its distribution failed: {type(error).__name__}: {error}"
            raise InputError(Problem(where, message)) from error
        found = law(distribution)
        if found is None:
            message = f"its distribution is {distribution!r}, must be one of scipy or OpenTURNS"
            raise InputError(Problem(where, message))
        if not _is_sound(found):
            message = "the parameters of its distribution are impossible, such as a scale below 0"
            raise InputError(
                Problem(where, f"{message}, at {format_values(named(self.names[:i], x[:i]))}")
            )
        return found

    def to_x(self, u: Array) -> Array:
        """Return the variables x of standard normal values u."""
        u = np.asarray(u, dtype=np.float64)
        if self._maps is not None:
            y = ndtri(_call_openturns(self._maps[0], u))
            return np.array([one.law.value(r) for one, r in zip(self.variables, y, strict=True)])  # type: ignore[union-attr]
        return self._along(u, lambda law, row: law.value(row), given=False)

    def to_u(self, x: Array) -> Array:
        """Return the standard normal values u of variables x."""
        x = np.asarray(x, dtype=np.float64)
        if self._maps is not None:
            pairs = zip(self.variables, x, strict=True)
            y = np.array([one.law.normal(row) for one, row in pairs])  # type: ignore[union-attr]
            return _call_openturns(self._maps[1], np.asarray(ndtr(y)))
        return self._along(x, lambda law, row: law.normal(row), given=True)

    def _along(self, rows: Array, take: Any, *, given: bool) -> Array:
        """Apply a function to each variable's law and row; laws may depend on the rows before."""
        if rows.ndim == 2 and rows.shape[1] > 1:
            try:
                return self._chain(rows, take, given)
            # laws that accept a single point only
            except (TypeError, ValueError, NotImplementedError):
                columns = [self._chain(rows[:, k], take, given) for k in range(rows.shape[1])]
                return np.stack(columns, axis=1)
        if rows.ndim == 2:
            return self._chain(rows[:, 0], take, given)[:, None]
        return self._chain(rows, take, given)

    def _chain(self, rows: Array, take: Any, given: bool) -> Array:
        x = np.array(rows)
        out = np.empty_like(x)
        for i in range(len(self.variables)):
            out[i] = take(self._law(i, x), rows[i])
            if not given:
                x[i] = out[i]
        return out


@explained
@described
@dataclass(frozen=True, eq=False)
class JointDistribution(Transformation):
    """Random variables from a joint distribution of OpenTURNS, with its own transformation.

    OpenTURNS uses Nataf's transformation for normal copulas and Rosenblatt's for others.

    Parameters
    ----------
    variables : sequence of str
        Names of the components.
    distribution : openturns.Distribution
        Continuous.
    """

    variables: Sequence[str]
    distribution: Any
    _maps: Any = field(init=False, repr=False, default=None)

    def __post_init__(self) -> None:
        problems = Problems()
        given = self.variables
        names = (given,) if isinstance(given, str) else tuple(given)
        check_names(problems, names)
        d = self.distribution
        if not hasattr(d, "getInverseIsoProbabilisticTransformation"):
            problems.add(WHERE, f"distribution is {d!r}, must be one of OpenTURNS")
        elif d.getDimension() != len(names):
            message = f"{len(names)} names for a distribution of {d.getDimension()} variables"
            problems.add(WHERE, message)
        elif not d.isContinuous():
            problems.add(WHERE, "the distribution must be continuous")
        problems.raise_if_any()
        inverse = d.getInverseIsoProbabilisticTransformation()
        object.__setattr__(self, "variables", names)
        object.__setattr__(self, "_maps", (inverse, d.getIsoProbabilisticTransformation()))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the variables."""
        return tuple(self.variables)

    def _facts(self) -> str:
        return f"{', '.join(self.names[:6])}; {class_name(self.distribution)}"

    def to_x(self, u: Array) -> Array:
        """Return the variables x of standard normal values u."""
        return _call_openturns(self._maps[0], np.asarray(u, dtype=np.float64))

    def to_u(self, x: Array) -> Array:
        """Return the standard normal values u of variables x."""
        return _call_openturns(self._maps[1], np.asarray(x, dtype=np.float64))


def transformation(given: Any) -> Transformation:
    """Return a transformation from a transformation, a random variable or independent variables."""
    if isinstance(given, Transformation):
        return given
    if isinstance(given, Random):
        given = [given]
    if isinstance(given, list | tuple) and any(isinstance(one, Conditional) for one in given):
        return Rosenblatt(given)
    return Nataf(given)


def check_names(problems: Problems, names: Sequence[Any]) -> None:
    """Add a problem for repeated names and for an empty sequence."""
    if not names:
        problems.add(WHERE, "there are none")
    for name in names:
        if not isinstance(name, str):
            check_name(problems, "random variable", name)
    for name in sorted({name for name in names if isinstance(name, str) and names.count(name) > 1}):
        problems.add(WHERE, f"the name '{name}' occurs twice")


def _matrix(problems: Problems, names: Sequence[str], given: Any) -> Array | None:
    """Return the given correlation as a matrix, and add its problems."""
    n = len(names)
    R = np.eye(n)
    if given is None:
        return R
    if not isinstance(given, Mapping):
        found = problems.array("correlation", "matrix", given, (n, n))
        if found is None:
            return None
        if not np.allclose(found, found.T, atol=1e-12) or not np.allclose(np.diag(found), 1.0):
            problems.add("correlation", "matrix must be symmetric with ones on its diagonal")
            return None
        R = np.array(found)
    else:
        for pair, value in given.items():
            if not isinstance(pair, tuple) or len(pair) != 2 or pair[0] == pair[1]:
                problems.add("correlation", f"{pair!r} must be a pair of two names")
                continue
            unknown = [name for name in pair if name not in names]
            for name in unknown:
                hint = suggest(name, names)
                problems.add("correlation", f"no random variable {name!r}{hint}")
            if (
                problems.number("correlation", " and ".join(map(str, pair)), value, "")
                and not unknown
            ):
                i, j = (names.index(name) for name in pair)
                if R[i, j] not in (0.0, value):
                    problems.add("correlation", f"{pair[0]} and {pair[1]} is given twice")
                R[i, j] = R[j, i] = value
    for i, j in np.argwhere(np.triu(np.abs(R) >= 1.0, 1)):
        pair = f"{names[i]} and {names[j]}"
        problems.add("correlation", f"{pair} is {R[i, j]:g}, must be between -1 and 1")
    return R


def _normal(problems: Problems, variables: Sequence[Random], R: Array, measure: str) -> Array:
    """Return R_0, and add pairs whose correlation is impossible."""
    if measure == "normal":
        return R
    if measure == "spearman":
        R_0 = 2.0 * np.sin(np.pi * R / 6.0)
        np.fill_diagonal(R_0, 1.0)
        return np.asarray(R_0)
    R_0 = np.eye(len(R))
    for i, j in np.argwhere(np.triu(R, 1)):
        if abs(R[i, j]) >= 1.0:
            continue
        a, b = variables[i], variables[j]
        found, low, high = normal_correlation(a, b, float(R[i, j]))
        if found is None:
            problems.add(
                "correlation",
                f"{a.name} and {b.name} is {R[i, j]:g}: variables with these distributions have "
                f"correlations from {low:.4g} to {high:.4g}",
            )
        else:
            R_0[i, j] = R_0[j, i] = found
    return R_0


def _factor(variables: Sequence[Random], R: Array, R_0: Array) -> Array:
    """Return the Cholesky factor of R_0; raise InputError if R_0 is not positive definite."""
    try:
        return np.asarray(np.linalg.cholesky(R_0), dtype=np.float64)
    except np.linalg.LinAlgError:
        pass
    least, vectors = np.linalg.eigh(R_0)
    share = np.linalg.norm(vectors[:, least <= max(least[0], 0.0)], axis=1)
    names = [one.name for one, part in zip(variables, share, strict=True) if part > 0.1]
    own = "" if np.linalg.eigvalsh(R)[0] > 0 else " already as it is given,"
    message = (
        f"not possible{own} its least eigenvalue as that of normal variables is {least[0]:.3g}, "
        f"must be positive; the correlations among {', '.join(names)} contradict one another"
    )
    raise InputError(Problem("correlation", message))


def _copula_maps(problems: Problems, variables: Sequence[Any], copula: Any) -> Any:
    if any(isinstance(one, Conditional) for one in variables):
        problems.add(WHERE, "a copula is for variables that are all Random, not Conditional")
    elif not hasattr(copula, "isCopula") or not copula.isCopula():
        problems.add(WHERE, f"copula is {copula!r}, must be a copula of OpenTURNS")
    elif copula.getDimension() != len(variables):
        message = f"copula is of {copula.getDimension()} variables, there are {len(variables)}"
        problems.add(WHERE, message)
    else:
        return (
            copula.getInverseIsoProbabilisticTransformation(),
            copula.getIsoProbabilisticTransformation(),
        )
    return None


def _is_sound(law: Law) -> bool:
    """Return whether a distribution has a finite median and a positive density there."""
    origin = np.zeros(1)
    middle = law.value(origin)
    slope = law.slope(origin, middle)
    return bool(np.all(np.isfinite(middle)) and np.all(np.asarray(slope) > 0.0))


def _call_openturns(function: Any, rows: Array) -> Array:
    """Return a vectorised function of an OpenTURNS function of samples."""
    given = rows.tolist() if rows.ndim == 1 else np.ascontiguousarray(rows.T)
    try:
        return np.array(function(given), dtype=np.float64).T
    except RuntimeError as error:
        message = (
            f"a transformation of OpenTURNS failed: {error}; variables with Random and Nataf, or "
            "Random and Rosenblatt(..., copula=...), need no quantiles of OpenTURNS"
        )
        raise InputError(Problem(WHERE, message)) from error
