"""Units of loggers and their SI equivalents."""

from __future__ import annotations

import math
import re

STRAIN = "m/m"

# label without blanks, lower case, micro sign as u: SI unit, factor, offset
UNITS: dict[str, tuple[str, float]] = {
    "m/m": (STRAIN, 1.0),
    "mm/mm": (STRAIN, 1.0),
    "strain": (STRAIN, 1.0),
    "e": (STRAIN, 1.0),
    "mm/m": (STRAIN, 1e-3),
    "um/m": (STRAIN, 1e-6),
    "umm/mm": (STRAIN, 1e-6),
    "ustrain": (STRAIN, 1e-6),
    "microstrain": (STRAIN, 1e-6),
    "ue": (STRAIN, 1e-6),
    "ustr": (STRAIN, 1e-6),
    "%": (STRAIN, 1e-2),
    "percent": (STRAIN, 1e-2),
    "permille": (STRAIN, 1e-3),
    "v/v": ("V/V", 1.0),
    "mv/v": ("V/V", 1e-3),
    "uv/v": ("V/V", 1e-6),
    "v": ("V", 1.0),
    "mv": ("V", 1e-3),
    "s": ("s", 1.0),
    "sec": ("s", 1.0),
    "sek": ("s", 1.0),
    "ms": ("s", 1e-3),
    "us": ("s", 1e-6),
    "min": ("s", 60.0),
    "h": ("s", 3600.0),
    "pa": ("Pa", 1.0),
    "kpa": ("Pa", 1e3),
    "mpa": ("Pa", 1e6),
    "gpa": ("Pa", 1e9),
    "n/mm2": ("Pa", 1e6),
    "bar": ("Pa", 1e5),
    "mbar": ("Pa", 1e2),
    "hpa": ("Pa", 1e2),
    "psi": ("Pa", 4.4482216152605 / 0.0254**2),
    "ksi": ("Pa", 4448.2216152605 / 0.0254**2),
    "n": ("N", 1.0),
    "kp": ("N", 9.80665),
    "kgf": ("N", 9.80665),
    "lbf": ("N", 4.4482216152605),
    "klbf": ("N", 4448.2216152605),
    "kip": ("N", 4448.2216152605),
    "kn": ("N", 1e3),
    "nm": ("N m", 1.0),
    "n*m": ("N m", 1.0),
    "knm": ("N m", 1e3),
    "ftlbf": ("N m", 4.4482216152605 * 0.3048),
    "lbfft": ("N m", 4.4482216152605 * 0.3048),
    "inlbf": ("N m", 4.4482216152605 * 0.0254),
    "lbfin": ("N m", 4.4482216152605 * 0.0254),
    "m": ("m", 1.0),
    "cm": ("m", 1e-2),
    "in": ("m", 0.0254),
    "inch": ("m", 0.0254),
    "ft": ("m", 0.3048),
    "mm": ("m", 1e-3),
    "um": ("m", 1e-6),
    "m/s": ("m/s", 1.0),
    "mm/s": ("m/s", 1e-3),
    "km/h": ("m/s", 1.0 / 3.6),
    "m/s2": ("m/s2", 1.0),
    "mm/s2": ("m/s2", 1e-3),
    "g": ("m/s2", 9.80665),
    "rad": ("rad", 1.0),
    "deg": ("rad", math.pi / 180.0),
    "rad/s": ("rad/s", 1.0),
    "deg/s": ("rad/s", math.pi / 180.0),
    "rpm": ("rad/s", math.pi / 30.0),
    "1/min": ("rad/s", math.pi / 30.0),
    "u/min": ("rad/s", math.pi / 30.0),
    "min-1": ("rad/s", math.pi / 30.0),
    "a": ("A", 1.0),
    "ma": ("A", 1e-3),
    "w": ("W", 1.0),
    "kw": ("W", 1e3),
    "degc": ("degC", 1.0),
    "c": ("degC", 1.0),
    "k": ("K", 1.0),
    "hz": ("Hz", 1.0),
    "khz": ("Hz", 1e3),
    "j": ("J", 1.0),
    "kg": ("kg", 1.0),
    "1": ("1", 1.0),
    "-": ("1", 1.0),
}


def parse_unit(label: str) -> tuple[str, float] | None:
    """Return the SI unit of a label and the factor to it; None for an unknown label.

    Examples
    --------
    >>> parse_unit("µm/m"), parse_unit("[%]"), parse_unit("furlong")
    (('m/m', 1e-06), ('m/m', 0.01), None)
    """
    return UNITS.get(_key(label))


def split_label(text: str) -> tuple[str, str | None]:
    """Return name and unit of a column heading such as ``g1 [um/m]``; None without a unit.

    Examples
    --------
    >>> split_label("Gauge 1 (µm/m)"), split_label("tip.x")
    (('Gauge 1', 'µm/m'), ('tip.x', None))
    """
    found = re.fullmatch(r"(.*)[\[({]([^\[\](){}]*)[\])}]", text.strip())
    if found and found[1].strip():
        return found[1].strip(), found[2].strip()
    return text.strip(), None


def _key(label: str) -> str:
    text = re.sub(r"[\s\[\](){}\"']", "", label).lower()
    # micro sign, mu, and the replacement character of a wrong encoding
    for sign in ("\u00b5", "\u03bc", "\ufffd"):
        text = text.replace(sign, "u")
    for sign, plain in (("\u03b5", "e"), ("\u00b0", "deg"), ("\u00b2", "2"), ("^", ""),
                        ("\u2030", "permille"), ("\u00b7", "*"), ("*", "*")):  # fmt: skip
        text = text.replace(sign, plain)
    return text
