"""Numbers with units: exact conversion, dimension checks, sentences."""

from __future__ import annotations

import math
import subprocess
import sys
from decimal import Decimal

import pytest

from jousto.base import units
from jousto.base.units import KINDS, UnitError, parse_unit, quantity


@pytest.mark.parametrize(
    ("text", "unit", "expected"),
    [
        # the floats a Python user would write
        ("210 GPa", "Pa", 210e9),
        ("207 MPa", "Pa", 2.07e8),
        ("7.85 g/cm3", "kg/m3", 7850.0),
        ("7.85 g/cm^3", "kg/m3", 7850.0),
        ("7.85e-9 t/mm3", "kg/m3", 7850.0),
        ("7.85 g/cm³", "kg/m3", 7850.0),
        ("100 mm", "m", 0.1),
        ("100mm", "m", 0.1),
        ("0.3 mm", "m", 3e-4),
        (" -1.5 km ", "m", -1500.0),
        ("1 in", "m", 0.0254),
        ("3 ft", "m", 0.9144),
        ("2 min", "s", 120.0),
        ("5 ms", "s", 0.005),
        ("5 µs", "s", 5e-6),
        ("9.81 m/s2", "m/s2", 9.81),
        ("9.81 m s-2", "m/s2", 9.81),
        ("-1 g0", "m/s2", -9.80665),
        ("5 kN m", "N m", 5000.0),
        ("5 kNm", "N m", 5000.0),
        ("5 N·m", "N m", 5.0),
        ("5 J", "N m", 5.0),
        ("12 Nmm", "N m", 0.012),
        ("3 kg m^2", "kg m2", 3.0),
        ("3 kg mm2", "kg m2", 3e-6),
        ("1 kg m/s2", "N", 1.0),
        ("1 N/m2", "Pa", 1.0),
        ("1 bar", "Pa", 1e5),
        ("1 psi", "Pa", 6894.757293168361336723),
        ("1 ksi", "Pa", 6894757.293168361336723),
        ("1 lbf", "N", 4.4482216152605),
        ("1 lb", "kg", 0.45359237),
        ("2 h", "s", 7200.0),
        ("50 Hz", "Hz", 50.0),
        ("60 rpm", "Hz", 1.0),
        ("3 1/s", "1/s", 3.0),
        ("3 /s", "1/s", 3.0),
        ("2 %", "1", 0.02),
        ("1e3", "m", 1000.0),
        ("1e9", "Pa", 1e9),
        ("1_000", "m", 1000.0),
        (3, "m", 3.0),
        (0.5, "1", 0.5),
        # with pi, correctly rounded
        ("180 deg", "rad", math.pi),
        ("90°", "rad", math.pi / 2),
        ("1 turn", "rad", 2 * math.pi),
        ("60 rpm", "rad/s", 2 * math.pi),
        ("1 Hz", "rad/s", 2 * math.pi),
        ("360 deg/s", "rad/s", 2 * math.pi),
    ],
)
def test_conversion_is_exact(text, unit, expected):
    assert quantity(text, unit) == expected


@pytest.mark.parametrize(
    ("value", "unit", "sentence"),
    [
        ("210 GPa", "m", "expects a length (m), got 210 GPa (a pressure)"),
        ("3 mm", "kg/m3", "expects a density (kg/m3), got 3 mm (a length)"),
        ("3 m", "1", "expects a number, got 3 m (a length)"),
        ("5 %", "m", "expects a length (m), got 5 % (no unit at all)"),
        ("5 /s", "Hz", "expects a frequency (Hz), got 5 /s (a rate)"),
        ("5 m3", "m", "expects a length (m), got 5 m3"),
        ("210 Gpa", "Pa", "no unit 'Gpa'; did you mean 'GPa'?"),
        ("210 MPA", "Pa", "no unit 'MPA'; did you mean 'MPa'?"),
        ("3 furlong", "m", "no unit 'furlong'; known: mm, cm, m, "),
        ("3 )(", "m", "')(' is not a unit; a unit looks like mm, N m or kg/m3"),
        ("3 4", "m", "'4' is not a unit"),
        ("long", "m", "expects a length such as 3 or '3 m', got 'long'"),
        ("", "m", "expects a length such as 3 or '3 m', got ''"),
        (True, "m", "expects a length such as 3 or '3 m', got true"),
        (None, "m", "expects a length such as 3 or '3 m', got nothing"),
        ([1], "m", "expects a length such as 3 or '3 m', got a list of 1"),
        ({}, "1", "expects a number, got a mapping"),
        (math.nan, "m", "is nan, must be finite"),
        (-math.inf, "m", "is -inf, must be finite"),
        ("nan", "m", "is nan, must be finite"),
        ("1e999", "m", "is inf, must be finite"),
        ("1e999 mm", "m", "is inf, must be finite"),
        (10**400, "kg", "is too large, must be below 1e308"),
        ("1e999999999999999999999 g", "kg", "is too large, must be below 1e308"),
    ],
)
def test_wrong_quantities_say_why(value, unit, sentence):
    with pytest.raises(UnitError) as error:
        quantity(value, unit)
    assert str(error.value).startswith(sentence)


def test_all_kinds_differ_in_dimension():
    # but for a frequency, which is an angular velocity of full turns, and a torque per length
    dimensions = {unit: str(parse_unit(unit).dimensionality) for unit in KINDS}
    assert dimensions.pop("Hz") == dimensions["rad/s"]
    assert dimensions.pop("N m/m") == dimensions["N"]
    assert len(set(dimensions.values())) == len(dimensions)


def test_the_units_library_is_imported_for_units_only():
    code = (
        "import sys; from jousto.base.units import quantity; quantity('1e3', 'm');"
        "assert quantity('120 mm', 'm') == 0.12; assert quantity('210 GPa', 'Pa') == 2.1e11;"
        "assert 'pint' not in sys.modules; quantity('1 in', 'm'); assert 'pint' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(("text", "unit"), sorted(units.USUAL))
def test_usual_units_are_those_of_the_library(text: str, unit: str) -> None:
    factor = units.registry().convert(Decimal(1), units.parse_unit(text), units.parse_unit(unit))
    assert factor == units.USUAL[text, unit]
