"""Strength factors of a part relative to a smooth specimen: surface, size, load and reliability."""

from __future__ import annotations

import math

import scipy

from jousto.base.arguments import explained
from jousto.base.errors import Problems, suggest

# FKM guideline (6th ed.), table 4.3.4: a_R and the smallest tensile strength R_m,N,min in MPa
ROUGHNESS: dict[str, tuple[float, float]] = {
    "steel": (0.22, 400.0),
    "cast-steel": (0.20, 400.0),
    "nodular-iron": (0.16, 400.0),
    "malleable-iron": (0.12, 350.0),
    "grey-iron": (0.06, 100.0),
    "aluminium": (0.22, 133.0),
    "cast-aluminium": (0.20, 133.0),
}
# Shigley's Mechanical Engineering Design, table 6-2 of an edition: a S_u^b, S_u in MPa
FINISHES: dict[int, dict[str, tuple[float, float]]] = {
    9: {
        "ground": (1.58, -0.085),
        "machined": (4.51, -0.265),
        "cold-drawn": (4.51, -0.265),
        "hot-rolled": (57.7, -0.718),
        "forged": (272.0, -0.995),
    },
    11: {
        "ground": (1.38, -0.067),
        "machined": (3.04, -0.217),
        "cold-drawn": (3.04, -0.217),
        "hot-rolled": (38.6, -0.650),
        "forged": (54.9, -0.758),
    },
}
# 9th ed., equation 6-26
LOADS = {"bending": 1.0, "axial": 0.85, "torsion": 0.59}


@explained
def roughness_factor(Rz: float, S_u: float, kind: str = "steel") -> float:
    """Return the factor of a rough surface on the endurance limit (FKM guideline, 4.3.2).

    ``K_R = 1 - a_R lg(Rz / 1 um) lg(2 S_u / S_min)``, 1 for polished surfaces (Rz up to 1 um)

    Parameters
    ----------
    Rz : float
        Mean roughness depth, m: 10e-6 is 10 um. Use 200 um for a rolling skin.
    S_u : float
        Tensile strength, Pa.
    kind : str
        "steel", "cast-steel", "nodular-iron", "malleable-iron", "grey-iron", "aluminium" or
        "cast-aluminium".

    Raises
    ------
    InputError
        If the kind is unknown, or a value impossible or in another unit.

    Examples
    --------
    >>> round(roughness_factor(20e-6, 700e6), 4)  # 1 - 0.22 lg 20 lg(1400/400)
    0.8443
    """
    where = "roughness_factor"
    problems = Problems()
    if kind not in ROUGHNESS:
        problems.add(where, f"no kind of material {kind!r}{suggest(kind, ROUGHNESS)}")
    depth = "from 0 to 1e-3 (SI: 20e-6 is 20 um)"
    problems.number(where, "Rz", Rz, "m", depth, lambda x: 0.0 <= x <= 1e-3)
    _strength(problems, where, S_u)
    problems.raise_if_any()
    a, least = ROUGHNESS[kind]
    if Rz <= 1e-6:
        return 1.0
    strength = max(2.0 * S_u / 1e6 / least, 1.0)
    return min(1.0, 1.0 - a * math.log10(Rz / 1e-6) * math.log10(strength))


@explained
def finish_factor(finish: str, S_u: float, *, edition: int = 11) -> float:
    """Return Marin's surface factor ``a S_u^b`` (Shigley, table 6-2), limited to 1.

    The 11th edition (Budynas and Nisbett 2020) has other fits to the tests than the 9th: the
    factors of machined surfaces are 10 % smaller at 400 MPa and 4 % smaller at 1600 MPa, those of
    forged surfaces 17 % smaller and 16 % larger.

    Parameters
    ----------
    finish : str
        "ground", "machined", "cold-drawn", "hot-rolled" or "forged".
    S_u : float
        Tensile strength, Pa.
    edition : {11, 9}
        Edition of the book with the table.

    Raises
    ------
    InputError
        If the finish or the edition is unknown, or the strength impossible.

    Examples
    --------
    >>> round(finish_factor("machined", 520e6, edition=9), 3)  # Shigley, 9th ed., example 6-3
    0.86
    >>> round(finish_factor("machined", 520e6), 3)
    0.783
    """
    where = "finish_factor"
    problems = Problems()
    if edition not in FINISHES:
        known = ", ".join(str(x) for x in sorted(FINISHES))
        problems.add(where, f"edition is {edition!r}, must be one of {known}")
    known_finishes = FINISHES[max(FINISHES)]
    if finish not in known_finishes:
        problems.add(where, f"no finish {finish!r}{suggest(finish, known_finishes)}")
    _strength(problems, where, S_u)
    problems.raise_if_any()
    a, b = FINISHES[edition][finish]
    return float(min(1.0, a * (S_u / 1e6) ** b))


def size_factor(diameter: float) -> float:
    """Return Marin's size factor of a round bar in bending or torsion (Shigley, eq. 6-20).

    ``1.24 d^-0.107`` for d = 2.79 to 51 mm, ``1.51 d^-0.157`` for d = 51 to 254 mm, 1 for smaller
    d.

    Parameters
    ----------
    diameter : float
        Diameter of a rotating bar, m. For bars that do not rotate use 0.37 d, for rectangles 0.808
        sqrt(h b) (table 6-3). Axial load has no size effect: leave the factor out.

    Raises
    ------
    InputError
        If the diameter is not between 0 and 254 mm.

    Examples
    --------
    >>> round(size_factor(0.032), 3), round(size_factor(0.37 * 0.032), 3)  # example 6-4: 0.858
    (0.856, 0.952)
    """
    problems = Problems()
    wanted = "above 0, at most 0.254 (SI: 0.032 is 32 mm)"
    problems.number("size_factor", "diameter", diameter, "m", wanted, lambda x: 0.0 < x <= 0.254)
    problems.raise_if_any()
    d = 1e3 * diameter
    if d < 2.79:
        return 1.0
    return float(min(1.0, 1.24 * d**-0.107 if d <= 51.0 else 1.51 * d**-0.157))


@explained
def load_factor(load: str) -> float:
    """Return the load factor relative to rotating bending (Shigley, eq. 6-26).

    Parameters
    ----------
    load : str
        "bending" 1, "axial" 0.85, "torsion" 0.59.

    Raises
    ------
    InputError
        If the load is unknown.
    """
    problems = Problems()
    if load not in LOADS:
        problems.add("load_factor", f"no load {load!r}{suggest(load, LOADS)}")
    problems.raise_if_any()
    return LOADS[load]


def reliability_factor(survival: float, variation: float = 0.08) -> float:
    """Return ``1 - variation z`` for a normal scatter of the endurance limit (Shigley, eq. 6-29).

    For the log-normal scatter of tests see `SN.at_survival`.

    Parameters
    ----------
    survival : float
        Probability of survival, 0.5 to below 1.
    variation : float
        Standard deviation / mean of the endurance limit, 8 % for steels.

    Raises
    ------
    InputError
        If the factor would not be positive, or the probability is out of range.

    Examples
    --------
    >>> [round(reliability_factor(p), 3) for p in (0.5, 0.9, 0.99, 0.999)]  # table 6-5
    [1.0, 0.897, 0.814, 0.753]
    """
    where = "reliability_factor"
    problems = Problems()
    wanted = "from 0.5 to below 1 (0.99, not 99)"
    problems.number(where, "survival", survival, "", wanted, lambda x: 0.5 <= x < 1.0)
    problems.number(where, "variation", variation, "", "from 0 to 0.5", lambda x: 0.0 <= x <= 0.5)
    problems.raise_if_any()
    factor = 1.0 - variation * float(scipy.special.ndtri(survival))
    if factor <= 0.0:
        problems.add(
            where,
            f"the factor is {factor:g}, must be positive: a normal scatter does "
            f"not apply to this survival",
        )
    problems.raise_if_any()
    return factor


def _strength(problems: Problems, where: str, S_u: float) -> None:
    wanted = "from 10e6 to 5e9 (SI: 500e6 is 500 MPa)"
    problems.number(where, "S_u", S_u, "Pa", wanted, lambda x: 1e7 <= x <= 5e9)
