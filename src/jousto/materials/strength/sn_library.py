"""S-N curves by name, with the source of every value; and estimates from the tensile strength."""

from __future__ import annotations

import re
from dataclasses import replace

from jousto.base.arguments import explained
from jousto.base.errors import InputError, Problem, Problems, suggest, warn
from jousto.materials.library import material
from jousto.materials.strength.sn import SN
from jousto.materials.strength.welds import CLASSES, SHEAR_CLASSES, STANDARDS, fat_class

_DOWLING = (
    "N. E. Dowling, Mechanical Behavior of Materials (4th ed., 2013), table 9.1: unnotched axial"
    " specimens, fully reversed, stress amplitude sf' (2 N)^b; no endurance limit was found"
)
# name: (S_u in Pa, sigma_f' in Pa, b)
_BASQUIN: dict[str, tuple[float, float, float]] = {
    "SAE 1015 normalized": (415e6, 1020e6, -0.138),
    "Man-Ten hot rolled": (557e6, 1089e6, -0.115),
    "RQC-100": (758e6, 938e6, -0.0648),
    "SAE 4142 450 HB": (1757e6, 1937e6, -0.0762),
    "AISI 4340 aircraft": (1172e6, 1758e6, -0.0977),
    "2024-T4": (476e6, 900e6, -0.102),
    "Ti-6Al-4V aged": (1233e6, 2030e6, -0.104),
}
# kind: ratio f of fully reversed limit to tensile strength, knee, slopes above and below
_FKM: dict[str, tuple[float, float, float, float | None]] = {
    "steel": (0.45, 1e6, 5.0, None),
    "stainless-steel": (0.40, 1e6, 5.0, None),
    "forging-steel": (0.40, 1e6, 5.0, None),
    "cast-steel": (0.34, 1e6, 5.0, None),
    "nodular-iron": (0.34, 1e6, 5.0, None),
    "malleable-iron": (0.30, 1e6, 5.0, None),
    "grey-iron": (0.30, 1e6, 5.0, None),
    "aluminium": (0.30, 1e6, 5.0, 15.0),
    "cast-aluminium": (0.30, 1e6, 5.0, 15.0),
}
# smallest tensile strength in Pa, and kind, of materials of the library
_STRENGTH: dict[str, tuple[float, str]] = {
    "S235": (360e6, "steel"),
    "S275": (410e6, "steel"),
    "S355": (470e6, "steel"),
    "EN-GJL-200": (200e6, "grey-iron"),
    "EN-GJL-250": (250e6, "grey-iron"),
    "EN-GJL-300": (300e6, "grey-iron"),
    "EN-GJS-400-15": (400e6, "nodular-iron"),
    "EN-GJS-500-7": (500e6, "nodular-iron"),
    "EN-GJS-600-3": (600e6, "nodular-iron"),
    "EN-GJS-700-2": (700e6, "nodular-iron"),
}


@explained
def estimate_sn(strength: float | str, kind: str = "steel", *, rule: str = "elementary") -> SN:
    """Return an S-N curve estimated from the tensile strength (FKM guideline, 4.2 and 4.4).

    The fully reversed limit is 0.45 S_u of steel, 0.40 of stainless and forging steel, 0.34 of
    cast steel and nodular iron, 0.30 of other irons and of aluminium, at 1e6 cycles with k = 5,
    for a smooth specimen, survival 97.5 %; below the knee aluminium has k = 15 for any rule except
    "elementary". Use test data if available.

    Parameters
    ----------
    strength : float or str
        Tensile strength in Pa; or the name of a library material, structural steels (least values
        of EN 10025-2, plates of 3 to 100 mm) and cast irons (EN 1561, EN 1563).
    kind : str
        "steel", "stainless-steel", "forging-steel", "cast-steel", "nodular-iron",
        "malleable-iron", "grey-iron", "aluminium", "cast-aluminium"; known for named materials.
    rule : str
        Rule below the knee, see `SN`.

    Raises
    ------
    InputError
        If kind or material is unknown.

    Examples
    --------
    >>> curve = estimate_sn("S355")
    >>> round(curve.S_D / 1e6, 1), curve.N_D, curve.k
    (211.5, 1000000.0, 5.0)
    """
    problems = Problems()
    name = ""
    if isinstance(strength, str):
        known = material(strength).name
        if known not in _STRENGTH:
            problems.add(
                "estimate_sn",
                f"no tensile strength of '{known}' is known; give it in Pa"
                f"{suggest(known, _STRENGTH)}",
            )
            problems.raise_if_any()
        name = known
        strength, kind = _STRENGTH[known]
    if kind not in _FKM:
        problems.add("estimate_sn", f"no kind of material {kind!r}{suggest(kind, _FKM)}")
    problems.positive("estimate_sn", "strength", strength, "Pa")
    problems.raise_if_any()
    f, N_D, k, k2 = _FKM[kind]
    return SN(
        f * strength,
        N_D,
        k,
        rule,
        k2=k2 if rule == "haibach" else None,
        survival=0.975,
        S_u=strength,
        name=f"{name or kind} (estimate)",
        source=f"FKM guideline (6th ed.), tables 4.2.1 and 4.4.3: {f:g} of the tensile strength",
    )


def sn_curve(name: str, *, rule: str | None = None) -> SN:
    """Return an S-N curve by name.

    Parameters
    ----------
    name : str
        One of `sn_curves`; a weld class ``fat71`` (IIW), ``fat71-en``, ``fat80-shear``,
        ``fat100-shear-en``; or a material with known strength such as ``S355`` (an estimate).
        Capital letters, blanks, dots and hyphens are ignored.
    rule : str, optional
        Rule below the knee; None for the rule of the curve.

    Raises
    ------
    InputError
        If there is no curve of that name.

    Warns
    -----
    JoustoWarning
        If a weld class is in neither standard; `fat_class` accepts any number.

    Examples
    --------
    >>> print(sn_curve("fat71"))
    FAT 71 iiw: S_D 20.76 MPa (amplitude) at 1e+07 cycles, k 3, haibach (5), survival 97.7 %
    >>> round(float(sn_curve("AISI 4340 aircraft").amplitude(1e6)) / 1e6, 1)
    426.0
    """
    text = _key(str(name))
    found: SN | None = None
    weld = re.fullmatch(r"fat(\d+(?:\.\d+)?)(.*)", re.sub(r"[\s\-_]", "", str(name).lower()))
    keys = {_key(known): known for known in _BASQUIN}
    if weld:
        rest = weld.group(2)
        standard = next((s for s in STANDARDS if rest.endswith(s)), "")
        kind = rest.removesuffix(standard)
        if kind in ("", "shear"):
            found = fat_class(float(weld.group(1)), standard or "iiw", shear=kind == "shear")
            _tell_no_class(float(weld.group(1)), shear=kind == "shear")
    elif text in keys:
        S_u, sf, b = _BASQUIN[keys[text]]
        found = SN.basquin(sf, b, S_u=S_u, name=keys[text], source=_DOWLING)
    else:
        named = {_key(known): known for known in _STRENGTH}
        if text in named:
            found = estimate_sn(named[text])
    if found is None:
        known_names = (*_BASQUIN, "fat71", "fat71-en", "fat80-shear", *_STRENGTH)
        raise InputError(
            Problem("S-N curve", f"the library has no '{name}'{suggest(name, known_names)}")
        )
    if rule is not None and rule != found.rule:
        change = {"k2": None, "N_cut": None} if rule != "haibach" else {}
        found = replace(found, rule=rule, **change)  # type: ignore[arg-type]
    return found


def _tell_no_class(number: float, *, shear: bool) -> None:
    """Warn about a number that is not a FAT class, such as 17 in place of 71."""
    classes = SHEAR_CLASSES if shear else CLASSES
    if number in classes:
        return
    below = [str(c) for c in classes if c < number][-1:]
    above = [str(c) for c in classes if c > number][:1]
    warn(
        "S-N curve",
        f"there is no FAT class {number:g} of {'shear' if shear else 'direct'} stress in"
        f" IIW-2259-15 or EN 1993-1-9, nearest: {' and '.join(below + above)}; the curve for "
        f"{number:g} MPa is used. To avoid this warning give the number: {{fat: {number:g}}} in a "
        f"file, jo.fatigue.fat_class({number:g}) in Python",
    )


def sn_curves() -> tuple[str, ...]:
    """Return the names of the measured S-N curves, without weld classes and estimates.

    Examples
    --------
    >>> "RQC-100" in sn_curves()
    True
    """
    return tuple(_BASQUIN)


def _key(name: str) -> str:
    return re.sub(r"[\s\-_.]", "", name.lower())
