"""Materials by name, with the source of every value."""

from __future__ import annotations

import re

from jousto.base.errors import InputError, Problem, suggest
from jousto.materials.material import Material

_EC3 = "EN 1993-1-1, 3.2.6; density EN 1991-1-1, table A.4"
_EC3_4 = "EN 1993-1-4, 2.1.3; density EN 10088-1, annex"
_EC9 = "EN 1999-1-1, 3.2.5"
_GJL = "EN 1561, annex A (E is the middle of the range it gives, which falls with stress)"
_GJS = "EN 1563, annex"
_MIL = "MIL-HDBK-5J (2003), table "
_CRAWFORD = (
    "R. J. Crawford, Plastics Engineering (3rd ed., 1998), table 1.5, short-term at 23 deg C (it"
    " creeps); nu: typical of the family"
)
_KSI, _LB_IN3 = 6.894757e6, 27679.905  # Pa and kg/m^3

# name: (E in Pa, nu, rho in kg/m^3, source)
_TABLE: dict[str, tuple[float, float, float, str]] = {
    # steels
    **dict.fromkeys(("S235", "S275", "S355", "S420", "S460", "S690"), (210e9, 0.3, 7850.0, _EC3)),
    "AISI 4130": (29.0e3 * _KSI, 0.32, 0.283 * _LB_IN3, _MIL + "2.3.1.0"),
    "AISI 4340": (29.0e3 * _KSI, 0.32, 0.283 * _LB_IN3, _MIL + "2.3.1.0"),
    "1.4301": (200e9, 0.3, 7900.0, _EC3_4),
    "1.4404": (200e9, 0.3, 8000.0, _EC3_4),
    "1.4462": (200e9, 0.3, 7800.0, _EC3_4),
    # aluminium
    **dict.fromkeys(
        ("EN AW-5083", "EN AW-6060", "EN AW-6061", "EN AW-6082", "EN AW-7020"),
        (70e9, 0.3, 2700.0, _EC9),
    ),
    "EN AW-2024": (10.5e3 * _KSI, 0.33, 0.100 * _LB_IN3, _MIL + "3.2.4.0"),
    "EN AW-7075": (10.3e3 * _KSI, 0.33, 0.101 * _LB_IN3, _MIL + "3.7.6.0"),
    # cast iron
    "EN-GJL-200": (100e9, 0.26, 7150.0, _GJL),
    "EN-GJL-250": (110e9, 0.26, 7200.0, _GJL),
    "EN-GJL-300": (122e9, 0.26, 7250.0, _GJL),
    "EN-GJS-400-15": (169e9, 0.275, 7100.0, _GJS),
    "EN-GJS-500-7": (169e9, 0.275, 7100.0, _GJS),
    "EN-GJS-600-3": (174e9, 0.275, 7200.0, _GJS),
    "EN-GJS-700-2": (176e9, 0.275, 7200.0, _GJS),
    # titanium and magnesium
    "Ti-6Al-4V": (16.0e3 * _KSI, 0.31, 0.160 * _LB_IN3, _MIL + "5.4.1.0"),
    "AZ31B": (6.5e3 * _KSI, 0.35, 0.0639 * _LB_IN3, _MIL + "4.2.1.0"),
    # polymers
    "PA66": (2.8e9, 0.39, 1140.0, _CRAWFORD),
    "PA66-GF30": (
        9.5e9,
        0.38,
        1370.0,
        "R. J. Crawford, Plastics engineering, Encyclopedia of Physical Science and Technology"
        " (3rd ed., 2001), table I, dry, along the fibres (it creeps and is softer across and when"
        " moist); rho: mixture of 30 % glass by weight; nu: typical of the family",
    ),
    "POM": (2.8e9, 0.37, 1420.0, _CRAWFORD),
    "PEEK": (3.8e9, 0.38, 1300.0, _CRAWFORD),
    "ABS": (2.2e9, 0.37, 1040.0, _CRAWFORD),
    "PC": (
        345.0 * _KSI,
        0.37,
        0.043 * _LB_IN3,
        "Engineers Edge, typical properties of plastics (extruded, 23 deg C, short-term: it"
        " creeps); nu: typical of the family",
    ),
    "PE-HD": (
        156.0 * _KSI,
        0.42,
        0.035 * _LB_IN3,
        "Engineers Edge, typical properties of plastics (23 deg C, short-term: it creeps); nu:"
        " typical of the family",
    ),
}
# thermal expansion in 1/K, from the same sources (of stainless steels EN 10088-1, 20 to 100 deg C)
_ALPHA = {
    _EC3: 12e-6,
    _EC9: 23e-6,
    "1.4301": 16e-6,
    "1.4404": 16e-6,
    "1.4462": 13e-6,
}
_ALIASES = {"steel": "S355", "aluminium": "EN AW-6082", "titanium": "Ti-6Al-4V"}


def material(name: str) -> Material:
    """Return a material of the library.

    The elastic constants are those at room temperature; those of polymers apply to short times,
    since polymers creep. Capital letters, blanks, hyphens and a leading ``EN``, ``EN AW`` or
    ``AISI`` may be left out.

    Parameters
    ----------
    name : str
        One of :func:`materials`, or ``steel``, ``aluminium``, ``titanium``.

    Returns
    -------
    Material
        Material with its ``source``.

    Raises
    ------
    InputError
        If the library has no such material; the message suggests similar names.

    Examples
    --------
    >>> steel = material("S355")
    >>> steel.E, steel.nu, steel.rho
    (210000000000.0, 0.3, 7850.0)
    >>> material("gjs 400-15").name, material("7075").source
    ('EN-GJS-400-15', 'MIL-HDBK-5J (2003), table 3.7.6.0')
    """
    keys = {_key(known): known for known in _TABLE}
    keys |= {_key(alias): known for alias, known in _ALIASES.items()}
    if _key(str(name)) not in keys:
        raise InputError(
            Problem(
                "material",
                f"the library has no '{name}'{suggest(name, (*_TABLE, *_ALIASES))}; "
                "jo.materials.names() lists all of them",
            )
        )
    found = keys[_key(str(name))]
    E, nu, rho, source = _TABLE[found]
    alpha = _ALPHA.get(found, _ALPHA.get(source))
    return Material(E=E, nu=nu, rho=rho, name=found, source=source, alpha=alpha)


def names() -> tuple[str, ...]:
    """Return the names of all materials of the library.

    Examples
    --------
    >>> "Ti-6Al-4V" in names()
    True
    """
    return tuple(_TABLE)


def by_name(value: object) -> str:
    """Return a hint for messages if a text is the name of a library material, else an empty text.

    >>> by_name("S355"), by_name(7850.0)
    ("; get it from the library by jo.material('S355')", '')
    """
    return f"; get it from the library by jo.material({value!r})" if isinstance(value, str) else ""


def _key(name: str) -> str:
    letters = re.sub(r"[\s\-_.]", "", name.lower())
    return re.sub(r"^(enaw|aisi|en)(?=.)", "", letters)
