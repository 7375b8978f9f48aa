"""Arithmetic with units in text."""

from __future__ import annotations

import math

import pytest

from jousto.base.expressions import ExpressionError, Quantity, evaluate, read_quantity

KNOWN = {
    "wall": Quantity(0.004, (1.0, 0.0, 0.0, 0.0)),
    "n": Quantity(3.0),
    "turn": Quantity(math.pi / 6, (0.0, 0.0, 0.0, 1.0)),
}


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [
        ("wall * 2", 0.008, "m"),
        ("-wall + 1 mm", -0.003, "m"),
        ("n ** 2 - 1e3", -991.0, "1"),
        ("7.85 g/cm3", 7850.0, "kg/m3"),
        ("100 N / (wall * wall)", 6.25e6, "Pa"),
        ("sqrt(wall * wall)", 0.004, "m"),
        ("sin(turn)", 0.5, "1"),
        ("sin(30 deg) + cos(0)", 1.5, "1"),
        ("max(wall, 5 mm, 0.1 cm)", 0.005, "m"),
        ("pi * wall**4 / 64", math.pi * 0.004**4 / 64, "m4"),
        ("60 rpm", 2 * math.pi, "rad/s"),
        ("50 %", 0.5, "1"),
        ("asin(1 / 2) - turn", 0.0, "rad"),
        ("round(n / 2)", 2.0, "1"),
        ("2 mm * 3 kg", 0.006, "kg m"),
    ],
)
def test_value_and_unit(text: str, value: float, unit: str) -> None:
    found = evaluate(text, KNOWN)
    assert found.value == pytest.approx(value, rel=1e-14, abs=1e-15)
    assert found.unit == unit


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("wal", "no parameter 'wal'; did you mean 'wall'?"),
        ("wall + 1", "0.004 m (a length) and 1 (a number) have different dimensions"),
        ("wall ^ 2", "powers are written with **"),
        ("2 foo", "no unit 'foo'"),
        ("sine(1)", "no function 'sine'; did you mean 'sin'?"),
        ("sin(wall)", "sin takes a plain number, got 0.004 m (a length)"),
        ("2 ** wall", "the exponent is 0.004 m (a length), must be a plain number"),
        ("1 / (n - 3)", "divides by zero"),
        ("9 ** 9 ** 9", "is too large"),
        ("(-1) ** 0.5", "must be a finite number"),
        ("sqrt(-1)", "does not exist"),
        ("1 +", "is not arithmetic"),
        ("n if n else n", "only numbers, names"),
        ("sqrt(1, 2)", "sqrt takes one number"),
        ("min()", "min takes one number or more"),
        ("n % 2", "only + - * / and ** are supported"),
        ("(" * 400 + "1" + ")" * 400, "is"),
        ("1 + " * 500, "longer than 1000"),
    ],
)
def test_what_is_wrong_is_said(text: str, message: str) -> None:
    with pytest.raises(ExpressionError) as error:
        evaluate(text, KNOWN)
    assert message in str(error.value)


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')",
        "n.__class__",
        "[n for n in (1, 2)]",
        "lambda: 1",
        "n[0]",
        "'a' * 3",
        "(n := 2)",
        "{1: 2}",
        "n < 2",
        "n and n",
        "f'{n}'",
        "True",
        "sqrt(*[1])",
        "max(n, key=abs)",
        "1j",
    ],
)
def test_nothing_but_arithmetic_is_done(text: str) -> None:
    with pytest.raises(ExpressionError):
        evaluate(text, KNOWN)


def test_a_parameter_hides_a_unit() -> None:
    assert evaluate("2 * m", {}).unit == "m"
    assert evaluate("2 * m + 1 m / (1 m)", {"m": Quantity(3.0)}).value == 7.0


def test_a_quantity_has_any_unit() -> None:
    assert read_quantity("4 mm") == Quantity(0.004, (1.0, 0.0, 0.0, 0.0))
    assert read_quantity("2 N mm/K".replace("/K", "")).text == "0.002 N m"
    assert read_quantity(3) == Quantity(3.0)
    for wrong in ("4 foo", "mm", True, None, [1], float("nan")):
        with pytest.raises(ExpressionError):
            read_quantity(wrong)
