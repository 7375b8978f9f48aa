"""Model file with other values of its parameters; everything else stays, comments too."""

from __future__ import annotations

import re
from collections.abc import Mapping

import yaml

from jousto.base.errors import InputError, Problem
from jousto.base.expressions import ExpressionError, measure, read_quantity
from jousto.base.units import UnitError

NUMBER = re.compile(r"\s*([-+]?(?:\d[\d_]*\.?[\d_]*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*")


def with_values(text: str, values: Mapping[str, float], name: str = "model") -> str:
    """Return the text of a model file with new values of parameters, each in its own unit.

    Parameters
    ----------
    text : str
        YAML or JSON text.
    values : mapping of str to float
        Values in SI by name.
    name : str
        Name of the file, for messages.

    Raises
    ------
    InputError
        With all parameters that the file does not have, or whose value is no number.

    Examples
    --------
    >>> print(with_values("parameters: {k: 2 kN/m, c: 1}  # measured", {"k": 2345.0}))
    parameters: {k: 2.345 kN/m, c: 1}  # measured
    """
    problems: list[Problem] = []
    places = _places(text)
    pieces: list[tuple[int, int, str]] = []
    for key, value in values.items():
        if key not in places:
            problems.append(Problem(name, f"parameters: the text has no value of {key!r}"))
            continue
        first, last = places[key]
        new = _written(text[first:last], value)
        if new is None:
            message = f"parameters: {key} is {text[first:last]!r}, which is no number with a unit"
            problems.append(Problem(name, message))
            continue
        pieces.append((first, last, new))
    if problems:
        raise InputError(problems)
    for first, last, new in sorted(pieces, reverse=True):
        text = text[:first] + new + text[last:]
    return text


def _places(text: str) -> dict[str, tuple[int, int]]:
    """Return where the value of each parameter stands in a text."""
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    found: dict[str, tuple[int, int]] = {}
    for key, value in _pairs(root):
        if key.value != "parameters":
            continue
        for name, entry in _pairs(value):
            inner = {own.value: node for own, node in _pairs(entry)}
            node = inner.get("value", entry)
            if isinstance(node, yaml.ScalarNode):
                found[name.value] = node.start_mark.index, node.end_mark.index
    return found


def _pairs(node: yaml.Node | None) -> list[tuple[yaml.Node, yaml.Node]]:
    """Return the entries of a mapping; none of another node."""
    return node.value if isinstance(node, yaml.MappingNode) else []


def _written(old: str, value: float) -> str | None:
    """Return a value as text in the unit and between the quotes of the old text, or None."""
    quote = old[0] if old[:1] in "\"'" and old[-1:] == old[:1] else ""
    inner = old[1:-1] if quote else old
    match = NUMBER.fullmatch(inner)
    if match is None:
        return None
    unit = match[2]
    try:
        factor = measure(unit)[0] if unit else 1.0
        same = read_quantity(inner).value
    except (UnitError, ExpressionError):
        return None
    number = float(match[1].replace("_", ""))
    if unit and abs(number * factor - same) > 1e-9 * abs(same):
        return None  # a unit with an offset
    return f"{quote}{value / factor:.9g}{' ' + unit if unit else ''}{quote}"
