"""Limit state as a function of independent standard normal variables."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.design.reliability.inputs.transform import Transformation, transformation
from jousto.design.reliability.limit import Counted, LimitState, Values, as_limit, named

FARTHEST = 1e6  # standard deviations, farthest start of an iteration


class Space:
    """Limit state ``g(u) = G(T(u), fixed)`` with its gradient and a count of its calls.

    Parameters
    ----------
    limit : LimitState or callable
        G.
    variables : Transformation or sequence of Random, optional
        T; None: the variables of the limit state.
    fixed : dict of float, optional
        Values beside the random ones.
    """

    def __init__(
        self,
        limit: LimitState | Callable[..., Any],
        variables: Any,
        fixed: dict[str, float] | None = None,
        counted: Counted | None = None,
    ) -> None:
        self.limit = as_limit(limit)
        given = self.limit.variables if variables is None else variables
        if given is None:
            message = "no random variables are given, and the limit state has none of its own"
            raise InputError(Problem(f"limit state '{self.limit.name}'", message))
        self.variables: Transformation = transformation(given)
        self.fixed = dict(fixed or {})
        self.n = len(self.variables.names)
        self.names = (*self.variables.names, *self.fixed)
        self.counted = counted or Counted(self.limit, self.names)

    @property
    def calls(self) -> int:
        """Number of calls of the function."""
        return self.counted.calls

    @property
    def gradients(self) -> int:
        """Number of calls of the given gradient."""
        return self.counted.gradients

    def x(self, u: Array) -> Array:
        """Return the values of all variables at points (n,) or (n, points)."""
        x = self.variables.to_x(u)
        if not self.fixed:
            return x
        fixed = np.array(list(self.fixed.values())).reshape(-1, *[1] * (x.ndim - 1))
        return np.concatenate([x, np.broadcast_to(fixed, (len(fixed), *x.shape[1:]))])

    def values(self, u: Array) -> Values:
        """Return the values of all variables at a point, with names."""
        return named(self.names, self.x(u))

    def g(self, u: Array) -> float:
        """Return the limit state g at a point."""
        return self.counted.value(self.x(u))

    def g_columns(self, U: Array, *, lenient: bool = False) -> Array:
        """Return the limit state g at the columns of U."""
        return self.counted.values(self.x(U), lenient=lenient)

    def gradient(self, u: Array, g: float) -> Array:
        """Return ``dg/du`` at a point with known g."""
        if self.counted.has_gradient:
            slope = self.counted.gradient_x(self.x(u))
            return np.asarray(self.variables.jacobian(u).T @ slope[: self.n])
        steps = np.full(self.n, self.limit.step)
        return self.counted.differences(self.x, u, g, steps)

    @property
    def blur(self) -> float:
        """Relative error of gradients by differences; a merit cannot resolve smaller moves."""
        if self.counted.has_gradient:
            return 0.0
        step = self.limit.step
        return 10.0 * (step if self.limit.differences == "forward" else step * step)

    def gradient_x(self, u: Array, slope: Array) -> Array:
        """Return ``dG/dx`` of the random variables at a point from ``dg/du``."""
        return np.asarray(np.linalg.solve(self.variables.jacobian(u).T, slope))

    def start(self, start: Any) -> Array:
        """Return the start of an iteration, from values by name or, for None, the medians.

        Raises
        ------
        InputError
            If a value is missing, unknown or outside of its distribution.
        """
        if start is None:
            return np.zeros(self.n)
        where = "start"
        names = self.variables.names
        if isinstance(start, Values) or hasattr(start, "keys"):
            keys = tuple(start.keys())
            wrong = [n for n in names if n not in keys] + [k for k in keys if k not in self.names]
            if wrong:
                message = f"needs a value for each of {', '.join(names)}; wrong: {', '.join(wrong)}"
                raise InputError(Problem(where, message))
            start = [start[name] for name in names]
        try:
            x = np.array(start, dtype=np.float64)
        except (TypeError, ValueError):
            x = np.zeros(0)
        if x.shape != (self.n,):
            raise InputError(Problem(where, f"must be {self.n} numbers: {', '.join(names)}"))
        with np.errstate(all="ignore"):
            u = self.variables.to_u(x)
        for name, value, y in zip(names, x, u, strict=True):
            if not np.isfinite(y):
                message = f"{name} is {value:g}, outside of its distribution"
                raise InputError(Problem(where, message))
            if abs(y) > FARTHEST:
                message = f"{name} is {value:g}, {abs(y):.2g} standard deviations from its median"
                raise InputError(Problem(where, message))
        return u
