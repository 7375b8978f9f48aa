"""Units in strings such as ``210 GPa``, ``7.85 g/cm3`` or ``30 deg``, converted to SI.

The vocabulary is small and closed: SI prefixes and the units used for mechanisms. Angle is a
separate dimension, so that ``60 rpm`` is 1 Hz as a frequency and 6.28 rad/s as an angular velocity.
Conversion uses decimal arithmetic: ``7.85 g/cm3`` is exactly the float 7850.0. The units library is
imported when the first unit occurs.
"""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Callable
from decimal import Decimal
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.complexstep import SteppedText, scalar, stepped
from jousto.base.errors import Problems, suggest

if TYPE_CHECKING:
    import pint

# definitions in pint's notation; the first name is the full one, then the symbol
DEFINITIONS = """
micro- = 1e-6 = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
kilo- = 1e3 = k-
mega- = 1e6 = M-
giga- = 1e9 = G-
meter = [length] = m = metre
gram = [mass] = g
second = [time] = s = sec
radian = [angle] = rad
degree = 0.01745329251994329576923690768489 radian = deg
revolution = 6.283185307179586476925286766559 radian = rev = turn
minute = 60 second = min
hour = 60 minute = h
day = 24 hour
year = 365.2425 day
hertz = revolution / second = Hz
rpm = revolution / minute
tonne = 1000 kilogram = t
newton = kilogram * meter / second ** 2 = N
pascal = newton / meter ** 2 = Pa
bar = 100000 pascal
joule = newton * meter = J
newton_meter = newton * meter = Nm
newton_millimeter = newton * millimeter = Nmm
inch = 0.0254 meter = in
foot = 12 inch = ft
pound = 0.45359237 kilogram = lb
pound_force = 4.4482216152605 newton = lbf
psi = pound_force / inch ** 2
ksi = 1000 psi
standard_gravity = 9.80665 meter / second ** 2 = g0
percent = 0.01
kelvin = [temperature] = K
watt = joule / second = W
liter = 0.001 meter ** 3 = l = L = litre
ampere = [current] = A
volt = watt / ampere = V
ohm = volt / ampere
henry = volt * second / ampere = H
farad = ampere * second / volt = F
cycle = 1 = cycles
"""

# quantity of a field, by its SI unit; also used in messages for the quantity of a value
KINDS = {
    "m": "a length",
    "kg": "a mass",
    "s": "a time",
    "rad": "an angle",
    "1": "a number",
    "m/s": "a velocity",
    "rad/s": "an angular velocity",
    "m/s2": "an acceleration",
    "N": "a force",
    "N m": "a torque",
    "Pa": "a pressure",
    "kg/m3": "a density",
    "m2": "an area",
    "m4": "a second moment of area",
    "kg m2": "a moment of inertia",
    "Hz": "a frequency",
    "1/s": "a rate",
    "N/m": "a stiffness or a force per length",
    "N m/m": "a torque per length",
    "kg/m": "a mass per length",
    "kg m": "a moment of inertia per length",
    "N m/rad": "an angular stiffness",
    "N s/m": "a damping",
    "N m s/rad": "an angular damping",
    "N/rad": "a force for a turn",
    "N s": "a torque for a velocity",
    "N s/rad": "a force for an angular velocity",
}

NAMED = KINDS.keys() - {"1"}

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254, "inch": 0.0254, "ft": 0.3048}
"""Length units of files, m."""

BASES = {
    "[length]": "m",
    "[mass]": "kg",
    "[time]": "s",
    "[angle]": "rad",
    "[temperature]": "K",
    "[current]": "A",
}
"""SI units of the dimensions."""

SHOWN = {"Pa": ("MPa", 1e-6), "m/m": ("um/m", 1e6), "V/V": ("mV/V", 1e3)}

COMMON = ("mm", "cm", "m", "g", "kg", "t", "ms", "s", "min", "h", "day", "year", "rad", "deg",
          "rpm", "Hz", "kHz", "N", "kN", "MN", "Nm", "kNm", "Nmm", "Pa", "kPa", "MPa", "GPa",
          "bar", "psi", "ksi", "in", "ft", "lb", "lbf", "J", "percent", "g0", "kg/m3", "g/cm3",
          "m/s", "m/s2", "rad/s", "deg/s", "kg m2", "mm4")  # fmt: skip

NUMBER = re.compile(r"\s*([-+]?(?:\d[\d_]*\.?[\d_]*|\.\d[\d_]*)(?:[eE][-+]?\d+)?)\s*(.*)", re.S)
# units of most files, converted without the parser, which is slow to import
USUAL = {
    (text, unit): Decimal(factor)
    for text, unit, factor in (
        *(("m", "m", "1"), ("cm", "m", "0.01"), ("mm", "m", "0.001")),
        *(("s", "s", "1"), ("ms", "s", "0.001"), ("g", "kg", "0.001"), ("kg", "kg", "1")),
        *(("Pa", "Pa", "1"), ("MPa", "Pa", "1e6"), ("GPa", "Pa", "1e9")),
        *(("N", "N", "1"), ("kN", "N", "1e3"), ("N m", "N m", "1"), ("kg/m3", "kg/m3", "1")),
    )
}
WHOLE = 2**53  # whole numbers below are exact floats
TOO_LARGE = "is too large, must be below 1e308"
SUPERSCRIPTS = str.maketrans("⁻¹²³⁴", "-1234")


def kind_of(unit: str) -> str:
    """Return the name of the quantity that has an SI unit, for messages.

    Examples
    --------
    >>> kind_of("kg/m3"), kind_of("N/m3")
    ('a density', 'a number in N/m3')
    """
    return KINDS.get(unit, f"a number in {unit}")


@functools.cache
def vocabulary() -> frozenset[str]:
    """Return all words for units, with their prefixes."""
    lines = [line.split(" = ") for line in DEFINITIONS.splitlines() if line]
    prefixes = {word.strip("-") for words in lines for word in words if word.endswith("-")}
    names = {word for words in lines for word in (words[0], *words[2:]) if word[-1] != "-"}
    return frozenset(["", *(prefix + name for prefix in ("", *prefixes) for name in names)])


def check_unit(problems: Problems, where: str, unit: str) -> None:
    """Report unknown words in the unit of a field."""
    for word in re.findall(r"[^\W\d_]+", unit):
        if word not in vocabulary():
            problems.add(
                where, f"its unit is {unit!r}: unknown unit {word!r}{suggest(word, COMMON)}"
            )


def shown_unit(unit: str) -> tuple[str, float]:
    """Return the unit for display and the factor from the SI unit to it.

    Examples
    --------
    >>> shown_unit("Pa"), shown_unit("N")
    (('MPa', 1e-06), ('N', 1.0))
    """
    return SHOWN.get(unit, (unit, 1.0))


class UnitError(ValueError):
    """Error: a string that is not a number with a unit of the right dimension."""


@functools.cache
def registry() -> pint.UnitRegistry[Decimal]:
    """Return the registry of the allowed units, created at first use."""
    import pint

    made: pint.UnitRegistry[Decimal] = pint.UnitRegistry(None, non_int_type=Decimal)
    made.load_definitions([line for line in DEFINITIONS.splitlines() if line])
    return made


@functools.cache
def parse_unit(text: str) -> Any:
    """Return the pint unit of a text such as ``g/cm3``, ``kg m^2``, ``°`` or ``%``.

    Raises
    ------
    UnitError
        If the text contains unknown units.
    """
    import pint

    plain = text.replace("%", "percent").replace("°", "deg").replace("µ", "u").replace("μ", "u")
    plain = re.sub("[·⋅×]", "*", plain).replace("^", "**")
    # cm3, cm³ and s-1 are powers; g0 is not
    plain = re.sub(r"([A-Za-z])([-⁻]?[¹²³⁴]|-?[1-9])", _power, plain)
    if plain.startswith("/"):
        plain = "1" + plain
    try:
        return registry().parse_units("" if plain == "1" else plain)
    except pint.errors.UndefinedUnitError as error:
        names: Any = error.unit_names
        bad = names if isinstance(names, str) else next(iter(names))
        raise UnitError(f"no unit {bad!r}{suggest(bad, COMMON)}") from None
    except Exception:
        # the parser of the library raises many types of errors for text that is no unit
        raise UnitError(f"{text!r} is not a unit; a unit looks like mm, N m or kg/m3") from None


def _power(match: re.Match[str]) -> str:
    return f"{match.group(1)}**{match.group(2).translate(SUPERSCRIPTS)}"


def quantity(value: Any, unit: str) -> float:
    """Return a number, or a string with or without a unit, as a finite float in SI.

    Parameters
    ----------
    value : int, float or str
        Numbers and strings without a unit are in `unit`.
    unit : str
        SI unit of the field.

    Raises
    ------
    UnitError
        If the value is not a number, not finite, or of another dimension.

    Examples
    --------
    >>> quantity("7.85 g/cm3", "kg/m3"), quantity("60 rpm", "Hz"), quantity(0.5, "m")
    (7850.0, 1.0, 0.5)
    """
    kind = type(value)
    if kind is float or (kind is int and abs(value) < WHOLE):
        if math.isfinite(value):
            return float(value)
    elif kind is str:
        return _of_text(value, unit)
    return _quantity(value, unit)


@functools.lru_cache(1024)
def _of_text(text: str, unit: str) -> float:
    """Return `quantity` of a text; cached, since texts repeat within a model."""
    return _quantity(text, unit)


def _quantity(value: Any, unit: str) -> float:
    kind = kind_of(unit)
    example = "" if unit == "1" else f" such as 3 or '3 {unit}'"
    if isinstance(value, str):
        match = NUMBER.match(value.strip())
        if match is None and value.strip().lower().lstrip("+-.") in ("nan", "inf", "infinity"):
            raise UnitError(f"is {value}, must be finite")
        if match is None:
            raise UnitError(f"expects {kind}{example}, got {value!r}")
        digits, unit_text = match.groups()
        if unit_text:
            number = _convert(value.strip(), digits, unit_text, unit)
            if isinstance(value, SteppedText):
                factor = _convert(f"1 {unit_text}", "1", unit_text, unit)
                return scalar(np.complex128(number + 1j * value.slope * factor))
            return number
        value = float(digits)
    if stepped(value):
        return scalar(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise UnitError(f"expects {kind}{example}, got {describe(value)}")
    try:
        number = float(value)
    except OverflowError:
        raise UnitError(TOO_LARGE) from None
    if not math.isfinite(number):
        raise UnitError(f"is {number}, must be finite")
    return number


def converted(text: str, unit: str) -> float:
    """Return a number with a unit, converted to another unit of the same dimension.

    >>> converted("2 mm2", "m**2")
    2e-06
    """
    match = NUMBER.fullmatch(text.strip())
    if match is None:
        raise UnitError(f"expects a number with a unit, got {text!r}")
    source, target = parse_unit(match[2]), parse_unit(unit)
    return _checked(match[1], lambda x: registry().convert(x, source, target))


def in_si(text: str) -> float:
    """Return a number with any unit in SI.

    >>> in_si("2 bar"), in_si("60 l/min"), in_si("-3")
    (200000.0, 0.001, -3.0)

    Raises
    ------
    UnitError
        If the text is not a number, with a known unit or without one.
    """
    match = NUMBER.fullmatch(text.strip())
    if match is None:
        raise UnitError(f"expects a number with a unit, got {text!r}")
    if not match[2]:
        return _checked(match[1], lambda x: x)
    unit = parse_unit(match[2])
    base = parse_unit(" ".join(f"{BASES[key]}**{n}" for key, n in unit.dimensionality.items()))
    return _checked(match[1], lambda x: registry().convert(x, unit, base))


def _convert(text: str, number: str, unit_text: str, unit: str) -> float:
    usual = USUAL.get((unit_text, unit))
    if usual is not None:
        return _checked(number, lambda x: x * usual)
    source, target = parse_unit(unit_text), parse_unit(unit)
    if source.dimensionality != target.dimensionality:
        found = next(
            (k for u, k in KINDS.items() if parse_unit(u).dimensionality == source.dimensionality),
            None,
        )
        if found == "a number":
            found = "no unit at all"
        got = f"got {text}" + (f" ({found})" if found else "")
        raise UnitError(f"expects {kind_of(unit)}{f' ({unit})' if unit in NAMED else ''}, {got}")
    return _checked(number, lambda x: registry().convert(x, source, target))


def _checked(number: str, convert: Callable[[Decimal], Any]) -> float:
    """Return a converted number as a finite float."""
    try:
        found = float(convert(Decimal(number.replace("_", ""))))
    except ArithmeticError:
        raise UnitError(TOO_LARGE) from None
    if not math.isfinite(found):
        raise UnitError(f"is {found}, must be finite")
    return found


def describe(value: Any) -> str:
    """Return the type of a value from a file, in the words of a user."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    return repr(value)
