"""Expressions of coordinates, states, time and signals, of which equations of states consist."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.complexstep import is_stepping
from jousto.base.errors import InputError, Problem
from jousto.base.numbers import set_fields
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.signals.base import Constant, Jet, Law, Signal


class Expression(Signal):
    """Number that depends on the motion: an operation on other expressions, or a leaf.

    Expressions add, subtract, multiply, divide and raise to powers, also with numbers and signals
    of time. A comparison with `where` takes one of two branches.

    Parameters
    ----------
    operation : str
        Operation of the engine, or the kind of a leaf: "number", "time", "gravity", "value",
        "rate", "signal", "state", "output", "named" for a state or output of the block of a name,
        or "delayed" for what a block delays.
    parts : tuple of Expression
        Operands.
    of : object
        What a leaf refers to: a number, a coordinate, a signal, or a block and a name.
    """

    live = True
    operation: str
    operands: tuple[Expression, ...]
    of: Any

    def __init__(self, operation: str, parts: tuple[Expression, ...] = (), of: Any = None) -> None:
        set_fields(self, operation=operation, operands=parts, of=of)

    def __repr__(self) -> str:
        return f"<Expression: {self}>"

    def __str__(self) -> str:
        if self.operation in ("state", "output"):
            return f"{self.of[0].name}.{self.of[1]}"
        if self.operation == "named":
            return f"{self.of[0]}.{self.of[1]}"
        if self.operation == "number":
            return repr(self.of)
        inner = ", ".join(map(str, self.operands)) or getattr(self.of, "name", "")
        return f"{self.operation}({inner})"

    def jet(self, t: Array) -> Jet:
        """Raise InputError: the value depends on the motion."""
        raise InputError(
            Problem(str(self), "depends on the motion and has no value as a function of time")
        )

    @property
    def law(self) -> Law:
        """Law of the value in the engine; its place is known when the model is compiled."""
        return Law("network", {})

    def combined(self, operation: str, *items: Any) -> Any:
        """Return an operation on expressions, signals and numbers, else NotImplemented."""
        parts = [expression(item) for item in items]
        if any(part is None for part in parts):
            return NotImplemented
        return Expression(operation, tuple(part for part in parts if part is not None))

    def __add__(self, other: Any) -> Any:
        return self.combined("add", self, other)

    def __radd__(self, other: Any) -> Any:
        return self.combined("add", other, self)

    def __sub__(self, other: Any) -> Any:
        return self.combined("subtract", self, other)

    def __rsub__(self, other: Any) -> Any:
        return self.combined("subtract", other, self)

    def __mul__(self, other: Any) -> Any:
        return self.combined("multiply", self, other)

    def __rmul__(self, other: Any) -> Any:
        return self.combined("multiply", other, self)

    def __truediv__(self, other: Any) -> Any:
        return self.combined("divide", self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return self.combined("divide", other, self)

    def __pow__(self, other: Any) -> Any:
        return self.combined("power", self, other)

    def __neg__(self) -> Any:
        return self.combined("subtract", 0.0, self)

    def __bool__(self) -> bool:
        raise InputError(
            Problem(str(self), "has no truth value before the run; take where(x, if_positive, "
                    "otherwise)")
        )  # fmt: skip


def expression(item: Any) -> Expression | None:
    """Return a number, signal or coordinate as an expression; None for anything else."""
    if isinstance(item, Expression):
        return item
    if isinstance(item, Constant):
        return Expression("number", of=plain(item.value))
    if isinstance(item, Signal):
        return Expression("signal", of=item)
    if isinstance(item, Coordinate):
        return value(item)
    if isinstance(item, bool) or not isinstance(item, int | float | complex | np.number):
        return None
    return Expression("number", of=plain(item))


def plain(x: Any) -> float | complex:
    """Return a number as a float, or complex where it has a derivative in a complex step."""
    return complex(x) if np.iscomplexobj(x) and is_stepping() else float(np.real(x))


def leaves_of(roots: Iterable[Expression]) -> Iterator[Expression]:
    """Yield the leaves of expressions, each once."""
    stack, seen = list(roots), set[int]()
    while stack:
        at = stack.pop()
        if id(at) in seen:
            continue
        seen.add(id(at))
        stack += at.operands
        if not at.operands:
            yield at


def value(coordinate: Coordinate) -> Expression:
    """Return the value of a coordinate, m or rad, as an expression."""
    return Expression("value", of=coordinate)


def rate(coordinate: Coordinate) -> Expression:
    """Return the rate of a coordinate, m/s or rad/s, as an expression."""
    return Expression("rate", of=coordinate)


def rate_of(x: Any) -> Expression:
    """Return the rate of a coordinate whose value is given."""
    if not isinstance(x, Expression) or x.operation != "value":
        raise InputError(Problem("rate", f"of {x!r}: must be of a coordinate"))
    return rate(x.of)


time = Expression("time")
"""Time, s."""
gravity = tuple(Expression("gravity", of=axis) for axis in range(3))
"""Acceleration of free fall along the axes of the world frame, m/s2."""


def _function(operation: str, *items: Any) -> Expression:
    made = time.combined(operation, *items)
    if made is NotImplemented:
        raise InputError(Problem(operation, f"of {items!r}: must be numbers or expressions"))
    assert isinstance(made, Expression)
    return made


def sqrt(x: Any) -> Expression:
    """Return the square root of an expression."""
    return _function("sqrt", x)


def exp(x: Any) -> Expression:
    """Return the exponential of an expression."""
    return _function("exp", x)


def log(x: Any) -> Expression:
    """Return the natural logarithm of an expression."""
    return _function("log", x)


def sin(x: Any) -> Expression:
    """Return the sine of an expression, rad."""
    return _function("sin", x)


def cos(x: Any) -> Expression:
    """Return the cosine of an expression, rad."""
    return _function("cos", x)


def atan(x: Any) -> Expression:
    """Return the arc tangent of an expression, rad."""
    return _function("atan", x)


def tanh(x: Any) -> Expression:
    """Return the hyperbolic tangent of an expression."""
    return _function("tanh", x)


def edge_flow(dp: Any, transition: float) -> Expression:
    """Return ``dp/(dp^2 + t^2)^(1/4)``, t a number: laminar below t, then ``sqrt(dp)``."""
    return _function("edge", dp, transition)


def minimum(a: Any, b: Any) -> Expression:
    """Return the smaller one of two expressions."""
    return _function("minimum", a, b)


def maximum(a: Any, b: Any) -> Expression:
    """Return the larger one of two expressions."""
    return _function("maximum", a, b)


def where(x: Any, positive: Any, otherwise: Any) -> Expression:
    """Return one expression where x > 0, and another one elsewhere."""
    return _function("select", x, positive, otherwise)


def clip(x: Any, low: Any, high: Any) -> Expression:
    """Return an expression within two limits."""
    return minimum(maximum(x, low), high)


def absolute(x: Any) -> Expression:
    """Return the magnitude of an expression."""
    return where(x, x, _function("subtract", 0.0, x))


def linear(rows: Array, terms: Sequence[Expression]) -> list[Expression]:
    """Return the sums of terms with the factors of each row (count x terms); zeros are left out."""
    made = []
    for row in rows:
        total: Any = Expression("number", of=0.0)
        for factor, term in zip(row, terms, strict=True):
            if factor != 0.0:
                total = total + factor * term
        made.append(total)
    return made


def smooth_step(x: Any) -> Expression:
    """Return 0 for x <= 0, 1 for x >= 1 and ``3 x^2 - 2 x^3`` between them."""
    z = clip(x, 0.0, 1.0)
    made: Expression = z * z * (3.0 - 2.0 * z)
    return made
