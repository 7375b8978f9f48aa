"""Formulas as text, such as ``(voltage - R*current)/L``, as expressions."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from typing import Any

from jousto.base.errors import InputError, suggest
from jousto.mechanism.states import expression as e

FUNCTIONS: dict[str, Callable[..., Any]] = {
    f.__name__: f
    for f in (
        *(e.sqrt, e.exp, e.log, e.sin, e.cos, e.atan, e.tanh),
        *(e.minimum, e.maximum, e.where, e.clip, e.absolute, e.smooth_step),
    )
}
FUNCTIONS["rate"] = e.rate_of
"""Functions that a formula may contain, by name."""
OPERATORS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
    ast.Pow: lambda a, b: a**b,
}
MOST = 10_000
"""Largest number of characters of a formula."""


class FormulaError(ValueError):
    """What is wrong with a formula."""


def formula(
    text: str,
    names: Mapping[str, Any],
    refer: Callable[[str, str], Any],
) -> e.Expression:
    """Return the expression of a formula.

    A formula has numbers, names, ``name.part``, ``+ - * / **`` and the functions of `FUNCTIONS`;
    nothing else is evaluated.

    Parameters
    ----------
    text : str
        The formula.
    names : mapping
        Expressions by name; ``time`` and ``pi`` are known.
    refer : callable
        Returns the expression of ``name.part``, given both.

    Raises
    ------
    FormulaError
        If the text is no formula, or a name is unknown.
    """
    if len(text) > MOST:
        raise FormulaError(f"has {len(text)} characters, at most {MOST} are allowed")
    try:
        tree = ast.parse(text.strip(), mode="eval").body
        made = _made(tree, {"time": e.time, "pi": 3.141592653589793, **names}, refer)
    except SyntaxError as error:
        raise FormulaError(f"{text!r} is no formula: {error.msg}") from None
    except (RecursionError, MemoryError):
        raise FormulaError("has too many brackets") from None
    except ZeroDivisionError:
        raise FormulaError(f"{text!r} divides by 0") from None
    found = e.expression(made)
    if found is None:
        raise FormulaError(f"{text!r} is no number")
    return found


def _made(node: ast.expr, names: Mapping[str, Any], refer: Callable[[str, str], Any]) -> Any:
    match node:
        case ast.Constant(value=int() | float() as found) if not isinstance(found, bool):
            return float(found)
        case ast.Name(id=name):
            if name not in names:
                known = (*names, *FUNCTIONS)
                raise FormulaError(f"nothing is called {name!r}{suggest(name, known)}")
            return names[name]
        case ast.Attribute(value=ast.Name(id=name), attr=part):
            return refer(name, part)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATORS:
            return OPERATORS[type(op)](_made(left, names, refer), _made(right, names, refer))
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_made(operand, names, refer)
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            return _made(operand, names, refer)
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]):
            return _called(name, [_made(one, names, refer) for one in args])
    raise FormulaError(
        f"{ast.unparse(node)!r} is not allowed: take numbers, names, + - * / ** and "
        f"{', '.join(FUNCTIONS)}"
    )


def _called(name: str, items: list[Any]) -> Any:
    if name not in FUNCTIONS:
        raise FormulaError(f"no function {name!r}{suggest(name, FUNCTIONS)}")
    try:
        return FUNCTIONS[name](*items)
    except InputError as error:
        raise FormulaError("; ".join(f"{x.where} {x.message}" for x in error.problems)) from None
    except TypeError:
        raise FormulaError(f"{name} has {len(items)} arguments, another number is needed") from None
