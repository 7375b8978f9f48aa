"""Arithmetic with units in text, such as ``2 * wall + 1 mm``, parsed by `ast`, never executed."""

from __future__ import annotations

import ast
import functools
import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.complexstep import SteppedText, magnitude, power, scalar, stepped
from jousto.base.errors import NotAnalytic, suggest
from jousto.base.units import KINDS, NUMBER, UnitError, converted, parse_unit, registry

BASE = ("m", "kg", "s", "rad")
DIMENSIONS = ("[length]", "[mass]", "[time]", "[angle]")
NONE = (0.0, 0.0, 0.0, 0.0)
LONGEST = 1000  # characters
# a number with its unit: 4 mm, 210 GPa, 12 mm4
WITH_UNIT = re.compile(
    r"(?<![\w.])((?>(?:\d[\d_]*\.?[\d_]*|\.\d[\d_]*)(?:[eE][-+]?\d+)?))\s*([^\W\d_]+[1-4²³⁴]?|[%°])"
)
UNIT = "unit of"


class ExpressionError(ValueError):
    """Error: text that is not an arithmetic expression, or quantities of inconsistent units."""


@dataclass(frozen=True)
class Quantity:
    """Number in SI units with the exponents of its units m, kg, s and rad.

    Examples
    --------
    >>> Quantity(0.004, (1, 0, 0, 0)).text
    '0.004 m'
    """

    value: float
    exponents: tuple[float, ...] = NONE

    @property
    def unit(self) -> str:
        """The SI unit, "1" of a plain number."""
        return unit_of(self.exponents)

    @property
    def text(self) -> str:
        """Quantity in the form of a model file."""
        if stepped(self.value):
            plain = Quantity(float(np.real(self.value)), self.exponents)
            return SteppedText(plain.text, float(np.imag(self.value)))
        return repr(self.value) + ("" if self.exponents == NONE else f" {self.unit}")

    @property
    def said(self) -> str:
        """Quantity as text for messages."""
        kind = KINDS.get(self.unit)
        shown = f"{self.value:g}" + ("" if self.exponents == NONE else f" {self.unit}")
        return f"{shown} ({kind})" if kind else shown


@functools.cache
def _known() -> dict[tuple[float, ...], str]:
    """Return the units of `KINDS` by exponents; the first one for equal exponents."""
    found: dict[tuple[float, ...], str] = {}
    for unit in KINDS:
        found.setdefault(measure(unit)[1], unit)
    return found


def unit_of(exponents: tuple[float, ...]) -> str:
    """Return the SI unit of a quantity with these exponents of m, kg, s and rad."""
    if exponents in _known():
        return _known()[exponents]
    pairs = zip(BASE, exponents, strict=True)
    return "*".join(f"{unit}**{power:g}" for unit, power in pairs if power)


@functools.cache
def measure(unit: str) -> tuple[float, tuple[float, ...]]:
    """Return the factor of a unit to SI and its exponents.

    Raises
    ------
    UnitError
        If there is no such unit.

    Examples
    --------
    >>> measure("MPa")
    (1000000.0, (-1.0, 1.0, -2.0, 0.0))
    """
    source = parse_unit(unit)
    powers = dict(source.dimensionality)
    exponents = tuple(float(powers.get(name, 0)) for name in DIMENSIONS)
    target = "*".join(f"{u}**{int(p)}" for u, p in zip(BASE, exponents, strict=True) if p)
    return float(registry().convert(1, source, parse_unit(target or "1"))), exponents


def read_quantity(value: Any) -> Quantity:
    """Return the quantity of a number or a text such as ``4 mm``.

    Raises
    ------
    ExpressionError
        If the value is neither.
    """
    if isinstance(value, str) and (match := NUMBER.fullmatch(value.strip())):
        try:
            exponents = measure(match[2])[1] if match[2] else NONE
            number = converted(value, unit_of(exponents)) if match[2] else float(match[1])
        except UnitError as error:
            raise ExpressionError(str(error)) from None
        return Quantity(number, exponents)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ExpressionError(f"expects a number or a quantity such as 4 mm, got {value!r}")
    if not math.isfinite(value):
        raise ExpressionError(f"is {value}, must be finite")
    return Quantity(float(value))


def evaluate(text: str, known: Mapping[str, Quantity], used: set[str] | None = None) -> Quantity:
    """Return the value of an expression.

    Numbers, names, ``+ - * / ** ( )``, the constant ``pi`` and the functions of `FUNCTIONS`;
    a number may be followed by a unit, and an unknown name may be a unit. The terms of a sum must
    have the same unit.

    Parameters
    ----------
    text : str
        The expression.
    known : mapping
        Quantities by name.
    used : set, optional
        Set to which the names in the text are added.

    Raises
    ------
    ExpressionError
        If the text cannot be evaluated.

    Examples
    --------
    >>> wall = Quantity(0.004, (1, 0, 0, 0))
    >>> evaluate("2 * wall + 1 mm", {"wall": wall}).text
    '0.009000000000000001 m'
    """
    if len(text) > LONGEST:
        raise ExpressionError(f"is longer than {LONGEST} characters")
    plain = WITH_UNIT.sub(_with_unit, text)
    try:
        tree = ast.parse(plain.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        hint = "; powers are written with **" if "^" in text else ""
        raise ExpressionError(f"{text.strip()!r} is not arithmetic{hint}") from None
    names: set[str] = set() if used is None else used
    try:
        found = _value(tree.body, known, names)
    except ZeroDivisionError:
        raise ExpressionError("divides by zero") from None
    except OverflowError:
        raise ExpressionError("is too large") from None
    except RecursionError:
        raise ExpressionError("is nested too deeply") from None
    if stepped(found.value) and np.isfinite(found.value):
        return found
    if isinstance(found.value, complex) or not math.isfinite(found.value):
        raise ExpressionError(f"is {found.value}, must be a finite number")
    return found


def _with_unit(match: re.Match[str]) -> str:
    """Return a number times ``UNIT @ its unit``."""
    return f"({match[1]} * ({UNIT!r} @ {match[2]!r}))"


def _value(node: ast.AST, known: Mapping[str, Quantity], used: set[str]) -> Quantity:
    if type(number := _said(node)) in (int, float):
        return Quantity(float(number))
    if isinstance(node, ast.Name):
        return _name(node.id, known, used)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.UAdd | ast.USub):
        x = _value(node.operand, known, used)
        return x if isinstance(node.op, ast.UAdd) else Quantity(-x.value, x.exponents)
    if isinstance(node, ast.BinOp):
        if isinstance(node.op, ast.MatMult) and _said(node.left) == UNIT:
            return _unit(str(_said(node.right)))
        return _operation(node.op, _value(node.left, known, used), _value(node.right, known, used))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        name = node.func.id
        if name not in FUNCTIONS:
            raise ExpressionError(f"no function {name!r}{suggest(name, FUNCTIONS)}")
        return _called(name, [_value(argument, known, used) for argument in node.args])
    raise ExpressionError(
        "only numbers, names, + - * / ** ( ) and functions such as sqrt(x) are allowed here"
    )


def _said(node: ast.AST) -> Any:
    return node.value if isinstance(node, ast.Constant) else None


def _unit(name: str) -> Quantity:
    try:
        return Quantity(*measure(name))
    except UnitError as error:
        raise ExpressionError(str(error)) from None


def _name(name: str, known: Mapping[str, Quantity], used: set[str]) -> Quantity:
    if name in known:
        used.add(name)
        return known[name]
    if name == "pi":
        return Quantity(math.pi)
    try:
        return Quantity(*measure(name))
    except UnitError:
        raise ExpressionError(f"no parameter {name!r}{suggest(name, known)}") from None


OPERATIONS: dict[type[ast.operator], tuple[Callable[[float, float], float], int]] = {
    ast.Add: (operator.add, 0),
    ast.Sub: (operator.sub, 0),
    ast.Mult: (operator.mul, 1),
    ast.Div: (operator.truediv, -1),
}


def _operation(sign: ast.operator, a: Quantity, b: Quantity) -> Quantity:
    if isinstance(sign, ast.Pow):
        if b.exponents != NONE:
            raise ExpressionError(f"the exponent is {b.said}, must be a plain number")
        exponents = tuple(x * np.real(b.value) for x in a.exponents)
        return Quantity(power(a.value, b.value), exponents)
    if type(sign) not in OPERATIONS:
        hint = "; powers are written with **" if isinstance(sign, ast.BitXor) else ""
        raise ExpressionError(f"only + - * / and ** are supported{hint}")
    work, sense = OPERATIONS[type(sign)]
    if not sense:
        _alike([a, b])
        return Quantity(work(a.value, b.value), a.exponents)
    pairs = zip(a.exponents, b.exponents, strict=True)
    return Quantity(work(a.value, b.value), tuple(x + sense * y for x, y in pairs))


def _alike(values: list[Quantity]) -> None:
    for other in values[1:]:
        if other.exponents != values[0].exponents:
            raise ExpressionError(f"{values[0].said} and {other.said} have different dimensions")


ANGLE = (0.0, 0.0, 0.0, 1.0)
FUNCTIONS: dict[str, Callable[..., float]] = {
    **{name: getattr(math, name) for name in ("sin", "cos", "tan", "exp", "log", "sqrt")},
    **{name: getattr(math, name) for name in ("asin", "acos", "atan", "floor", "ceil")},
    "abs": abs,
    "round": lambda x: float(round(x)),
    "min": min,
    "max": max,
}
"""Functions of expressions; sin, cos and tan take angles or plain numbers in rad."""


def _called(name: str, given: list[Quantity]) -> Quantity:
    many = name in ("min", "max")
    if (not given) or (len(given) != 1 and not many):
        raise ExpressionError(f"{name} takes {'one number or more' if many else 'one number'}")
    exponents = given[0].exponents
    if many:
        _alike(given)
    elif name == "sqrt":
        exponents = tuple(x / 2.0 for x in exponents)
    elif name != "abs":
        allowed = (NONE, ANGLE) if name in ("sin", "cos", "tan") else (NONE,)
        if exponents not in allowed:
            raise ExpressionError(f"{name} takes a plain number, got {given[0].said}")
        exponents = ANGLE if name in ("asin", "acos", "atan") else NONE
    values: list[Any] = [x.value for x in given]
    if stepped(*values):
        return Quantity(scalar(_stepped(name, values)), exponents)
    try:
        found = FUNCTIONS[name](values) if many else FUNCTIONS[name](values[0])
    except ValueError:
        raise ExpressionError(f"{name} of {given[0].said} does not exist") from None
    return Quantity(float(found), exponents)


def _stepped(name: str, values: list[Any]) -> Any:
    """Return a function of numbers with derivatives."""
    if name == "abs":
        return magnitude(values[0])
    if name in ("min", "max"):
        return FUNCTIONS[name](values, key=np.real)
    if name in ("floor", "ceil", "round"):
        raise NotAnalytic(f"{name}({np.real(values[0]):g}) has no derivative")
    names = {"asin": "arcsin", "acos": "arccos", "atan": "arctan"}
    return getattr(np, names.get(name, name))(values[0])
