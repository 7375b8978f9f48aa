"""Limit states: functions of named values that are positive where nothing fails."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import (
    InputError,
    JoustoError,
    Problem,
    Problems,
    UnknownNameError,
    suggest,
)
from jousto.base.names import check_name
from jousto.base.object_repr import described
from jousto.design.reliability.errors import LimitStateError

SHOWN = 6  # variables in a message
BATCH = 100_000  # points of a sampling per batch
FEW = 10_000  # points per batch of limit states that take one point at a time
MOST_REASONS = 20  # different reasons for missing values that are counted
LARGEST = 1e150  # largest valid magnitude of a value: its square is still a double


class Values(np.ndarray[Any, np.dtype[np.float64]]):
    """Array of values with names: ``x[0]``, ``x["F"]``, ``R, F = x``, ``f(**x)``.

    One row for each variable, one column for each point.
    """

    names: tuple[str, ...] = ()

    def __array_finalize__(self, other: Any) -> None:
        # results of arithmetic have no names
        self.names = ()

    def __getitem__(self, key: Any) -> Any:
        plain = self.view(np.ndarray)
        if not isinstance(key, str):
            return plain[key]
        if key not in self.names:
            message = f"no value {key!r}{suggest(key, self.names)}"
            raise UnknownNameError(Problem("limit state", message))
        return plain[self.names.index(key)]

    def keys(self) -> tuple[str, ...]:
        """Return the names in their order."""
        return self.names

    def __reduce__(self) -> Any:
        return named, (self.names, np.array(self))

    def __repr__(self) -> str:
        if self.ndim != 1 or not self.names:
            return repr(self.view(np.ndarray))
        return "<Values: " + format_values(self) + ">"


def named(names: Sequence[str], values: ArrayLike) -> Values:
    """Return values together with their names, as `Values`."""
    x = np.array(values, dtype=np.float64).view(Values)
    x.names = tuple(names)
    return x


def format_values(x: Values) -> str:
    """Return the first values as a text such as ``R = 1.2, F = 3``."""
    pairs = [f"{name} = {x[name]:.6g}" for name in x.names[:SHOWN]]
    return ", ".join(pairs) + (", ..." if len(x.names) > SHOWN else "")


@explained
@described
@dataclass(frozen=True, eq=False)
class LimitState:
    """Limit state: a function of the random variables; ``G(x) <= 0`` is failure.

    Parameters
    ----------
    function : callable
        ``function(x)`` returns G, with failure if ``G <= 0``; x has values by name and by index
        (`Values`).
    gradient : callable or True, optional
        ``gradient(x)`` returns the derivatives of G by the values, an array in their order, or a
        dictionary whose missing entries are zero. True if the function returns both, ``G, dG``.
        None: differences.
    vectorised : bool
        The function also takes many points at once, an array of values for each name, and returns
        an array; then sampling and differences call it once for a whole batch.
    name : str, optional
        Name in messages and results; by default that of the function.
    step : float
        Step of differences, in standard deviations. Results with numerical noise need larger steps,
        about the root of their relative error.
    differences : {"forward", "central"}
        n or 2 n calls for each gradient.
    variables : sequence of Random, Nataf, Rosenblatt or JointDistribution, optional
        The random variables, for analyses without this argument.

    Examples
    --------
    >>> def strength(x):
    ...     return x["R"] - x["F"] / 2.0
    >>> LimitState(strength, gradient=lambda x: {"R": 1.0, "F": -0.5})
    <LimitState 'strength': its gradient is given>
    """

    function: Callable[..., Any]
    gradient: Callable[..., Any] | bool | None = None
    vectorised: bool = False
    name: str = ""
    step: float = 1e-5
    differences: Literal["forward", "central"] = "forward"
    variables: Any = None

    def __post_init__(self) -> None:
        problems = Problems()
        given: Any = self.function
        if not callable(given):
            problems.add("limit state", f"function is {given!r}, must be a function of the values")
        if not (self.gradient is None or self.gradient is True or callable(self.gradient)):
            message = f"gradient is {self.gradient!r}, must be a function, True or None"
            problems.add("limit state", message)
        if self.differences not in ("forward", "central"):
            found = repr(self.differences)
            problems.add("limit state", f"differences is {found}, must be 'forward' or 'central'")
        problems.positive("limit state", "step", self.step, "")
        if self.name:
            check_name(problems, "limit state", self.name)
        problems.raise_if_any()
        if not self.name:
            own = getattr(self.function, "__name__", "")
            object.__setattr__(self, "name", own if own.isidentifier() else "G")

    @property
    def batch(self) -> int:
        """Number of points per batch of a sampling."""
        return BATCH if self.vectorised else FEW

    def _facts(self) -> str:
        how = (
            f"{self.differences} differences" if self.gradient is None else "its gradient is given"
        )
        return how + (", vectorised" if self.vectorised else "")


def as_limit(given: LimitState | Callable[..., Any], name: str = "") -> LimitState:
    """Convert a callable to a LimitState."""
    if isinstance(given, LimitState):
        return given
    if name and callable(given):
        return LimitState(given, name=name)
    return LimitState(given)


def format_error(error: Exception) -> str:
    """Return an error as one line; errors from outside jousto with their class."""
    text = " / ".join(str(error).splitlines())
    kind = "" if isinstance(error, JoustoError) and text else type(error).__name__
    return ": ".join(filter(None, (kind, text)))


class Counted:
    """Limit state with checks of its values and a count of its calls.

    Parameters
    ----------
    limit : LimitState
        The function.
    names : sequence of str
        Names of the random variables, followed by those of fixed values.
    """

    def __init__(self, limit: LimitState, names: Sequence[str]) -> None:
        self.limit = limit
        self.names = tuple(names)
        self.calls = 0
        self.gradients = 0
        self.reasons: dict[str, int] = {}  # reasons for missing values with their numbers
        self._slope: tuple[bytes, Any] | None = None

    @property
    def where(self) -> str:
        """Name of the limit state in messages."""
        return f"limit state '{self.limit.name}'"

    def value(self, x: Array) -> float:
        """Return G at one point.

        Raises
        ------
        LimitStateError
            If the function fails or returns no finite number.
        """
        point = named(self.names, x)
        self.calls += 1
        found = self._ask(self.limit.function, point)
        if self.limit.gradient is True:
            try:
                found, slope = found
            except (TypeError, ValueError):
                raise self._wrong("must return its value and its gradient", point) from None
            self._slope = (point.tobytes(), slope)
        return self._number(found, point)

    def _ask(self, function: Callable[..., Any], point: Values) -> Any:
        try:
            return function(point)
        except Exception as error:
            raise self._wrong(f"failed: {format_error(error)}", point) from error

    def _wrong(self, what: str, point: Values) -> LimitStateError:
        message = f"{self.where}: {what}, at {format_values(point)}"
        if what in self.reasons or len(self.reasons) < MOST_REASONS:
            self.reasons[what] = self.reasons.get(what, 0) + 1
        return LimitStateError(message, {name: float(point[name]) for name in point.names})

    def _no_number(self, g: float, x: Array) -> LimitStateError:
        """Return the reason for a value that is not finite, from the function where it has one."""
        point = named(self.names, x)
        why = getattr(self.limit.function, "why", None)
        reason = why(point) if callable(why) else ""
        return self._wrong(f"failed: {reason}" if reason else f"returned {g}", point)

    def _number(self, found: Any, point: Values) -> float:
        try:
            array = np.asarray(found)
            if array.size != 1 or array.dtype.kind not in "fiub":
                raise TypeError
            g = float(array.reshape(()))
        except (TypeError, ValueError):
            raise self._wrong(f"returned {found!r:.60}, must be one number", point) from None
        if not np.isfinite(g):
            raise self._no_number(g, np.asarray(point))
        if abs(g) > LARGEST:
            raise self._wrong(f"returned {g:g}, no double has its square: scale it", point)
        return g

    def values(self, X: Array, *, lenient: bool = False) -> Array:
        """Return G at the columns of X; NaN where it failed if `lenient`."""
        if self.limit.vectorised:
            points = named(self.names, X)
            self.calls += X.shape[1]
            try:
                found = self.limit.function(points)
                g = np.asarray(found[0] if self.limit.gradient is True else found, np.float64)
                g = np.broadcast_to(g, X.shape[1:])
            except Exception as error:
                message = f"failed for {X.shape[1]} points at once: {format_error(error)}"
                raise self._wrong(message, named(self.names, X[:, 0])) from error
            for x, value in zip(X.T, g, strict=True):
                if not np.isfinite(value):
                    nothing = self._no_number(float(value), x)
                    if not lenient:
                        raise nothing
            return np.where(np.isfinite(g), g, np.nan)
        out = np.empty(X.shape[1])
        for k, x in enumerate(X.T):
            try:
                out[k] = self.value(x)
            except LimitStateError:
                if not lenient:
                    raise
                out[k] = np.nan
        return out

    @property
    def has_gradient(self) -> bool:
        """Whether the limit state has a gradient of its own."""
        return self.limit.gradient is not None

    def gradient_x(self, x: Array) -> Array:
        """Return the limit state's own gradient ``dG/dx`` (n,)."""
        point = named(self.names, x)
        self.gradients += 1
        if self.limit.gradient is True:
            if self._slope is None or self._slope[0] != point.tobytes():
                self.value(x)
            assert self._slope is not None
            found = self._slope[1]
        else:
            assert callable(self.limit.gradient)
            found = self._ask(self.limit.gradient, point)
        if isinstance(found, Mapping):
            for key in found:
                if key not in self.names:
                    message = f"its gradient has {key!r}{suggest(key, self.names)}"
                    raise InputError(Problem(self.where, message))
            found = [found.get(name, 0.0) for name in self.names]
        try:
            slope = np.array(found, dtype=np.float64).reshape(-1)
        except (TypeError, ValueError):
            raise self._wrong(f"its gradient is {found!r:.60}, no numbers", point) from None
        if slope.shape != (len(self.names),):
            message = f"its gradient has {slope.size} numbers, must have {len(self.names)}"
            raise InputError(Problem(self.where, message))
        if not np.all(np.isfinite(slope)):
            raise self._wrong(f"its gradient is {slope}", point)
        return slope

    def differences(
        self, to_x: Callable[[Array], Array], u: Array, g: float, steps: Array
    ) -> Array:
        """Return the gradient of ``G(to_x(u))`` by u, from differences."""
        n = len(u)
        out = np.empty(n)
        sides = (1.0, -1.0) if self.limit.differences == "central" else (1.0,)
        moves = np.concatenate([side * np.diag(steps) for side in sides], axis=1)
        found = self.values(to_x(u[:, None] + moves))
        out = found[:n] - (g if len(sides) == 1 else found[n:])
        return np.asarray(out / (steps * len(sides)))
