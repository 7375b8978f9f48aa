"""Strain and stress at a place from the grids of a rosette."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import LARGE_STRAIN, Problems, strain_remedy, warn
from jousto.base.object_repr import described
from jousto.mechanism.sensors.gauge import NU_CALIBRATION
from jousto.mechanism.sensors.rosette import ANGLES, KINDS

LARGE_STRESS = 1.5e9
"""von Mises stress, Pa, above which the unit of the strains is probably wrong."""


@described
@dataclass(frozen=True, eq=False)
class RosetteState:
    """Plane strain and stress of the surface under a rosette, x along grid a.

    All arrays have the shape of one grid's values. ``sd`` contains the standard deviation of each
    quantity by name, if the noise of the grids was given.

    Attributes
    ----------
    exx, eyy, gxy : array
        Strains, m/m, engineering shear; y is 90 deg counterclockwise of grid a.
    e1, e2 : array
        Principal strains, m/m, e1 the larger.
    sxx, syy, txy : array
        Stresses, Pa.
    s1, s2 : array
        Principal stresses in the plane, Pa.
    angle : array
        Angle from grid a to the direction of e1 and s1, counterclockwise, rad, within +-pi/2.
        Undefined (nan) where e1 = e2.
    shear : array
        Largest shear stress in the plane, (s1 - s2)/2, Pa.
    von_mises : array
        ``sqrt(sxx^2 - sxx syy + syy^2 + 3 txy^2)``, Pa.
    sd : dict of str to array
        Standard deviations.
    """

    exx: Array
    eyy: Array
    gxy: Array
    e1: Array
    e2: Array
    sxx: Array
    syy: Array
    txy: Array
    s1: Array
    s2: Array
    angle: Array
    shear: Array
    von_mises: Array
    sd: dict[str, Array]

    @property
    def vague(self) -> bool:
        """Whether the (first) angle is undefined: e1 = e2, or its deviation reaches 90 deg."""
        angle, sd = np.ravel(self.angle), np.ravel(self.sd.get("angle", 0.0))
        return bool(len(angle) and not (np.isfinite(angle[0]) and sd[0] < 0.5 * np.pi))

    def __str__(self) -> str:
        """Return a table of the values; for a history the values at the first instant."""

        def text(name: str, factor: float, unit: str) -> str:
            value = factor * np.ravel(getattr(self, name))[0]
            if name == "angle" and self.vague:
                return f"{name:>10} {'undefined':>12}: e1 = e2 within the noise"
            line = f"{name:>10} {value:12.4f} {unit}"
            if name in self.sd:
                line += f"  +- {factor * np.ravel(self.sd[name])[0]:.4f}"
            return line

        lines = [text(name, 1e6, "um/m") for name in ("exx", "eyy", "gxy", "e1", "e2")]
        lines += [
            text(name, 1e-6, "MPa") for name in ("sxx", "syy", "txy", "s1", "s2", "von_mises")
        ]
        lines.append(text("angle", 180.0 / np.pi, "deg from grid a"))
        return "\n".join(lines)


@explained
def rosette_state(
    e: ArrayLike,
    *,
    E: float,
    nu: float,
    kind: str = "45",
    transverse: float = 0.0,
    noise: float | ArrayLike | None = None,
) -> RosetteState:
    """Return strains, stresses and principal values from the grids of a rosette.

    ``e(t) = exx cos^2 t + eyy sin^2 t + gxy sin t cos t`` is solved for the strains; for a
    rectangular rosette ``exx = ea, eyy = ec, gxy = 2 eb - ea - ec``. Principal strains ``(exx +
    eyy)/2 +- sqrt((exx - eyy)^2 + gxy^2)/2`` at ``tan 2a = gxy/(exx - eyy)``; stress of a free
    surface ``sxx = E (exx + nu eyy)/(1 - nu^2)`` and so on.

    Parameters
    ----------
    e : (..., 3) array_like
        Strains of grids a, b, c, m/m; two strains for a tee, whose grids lie along the principal
        directions.
    E, nu : float
        Young's modulus, Pa, and Poisson's ratio.
    kind : {"45", "60", "90"}
        Kind of the rosette, as in `Rosette`.
    transverse : float
        Transverse sensitivity K of the grids, which is corrected: they measure ``(e + K
        e_across)/(1 - 0.285 K)``.
    noise : float or (3,) array_like, optional
        Standard deviation of each grid, m/m, of independent errors; the standard deviations of all
        results follow to first order.

    Raises
    ------
    InputError
        With all problems, also for strains above 0.5 m/m, which are probably in um/m.

    Warns
    -----
    JoustoWarning
        Strains beyond 1 %, von Mises stress beyond 1.5 GPa, E below 1 GPa: likely other units.

    Examples
    --------
    >>> print(rosette_state([200e-6, 80e-6, -50e-6], E=210e9, nu=0.3))
           exx     200.0000 um/m
           eyy     -50.0000 um/m
           gxy      10.0000 um/m
            e1     200.1000 um/m
            e2     -50.1000 um/m
           sxx      42.6923 MPa
           syy       2.3077 MPa
           txy       0.8077 MPa
            s1      42.7085 MPa
            s2       2.2915 MPa
     von_mises      41.6100 MPa
         angle       1.1453 deg from grid a
    """
    problems = Problems()
    where = "rosette"
    if str(kind) not in KINDS:
        problems.add(where, f"kind is {kind!r}, must be '45', '60' (delta) or '90' (tee)")
    problems.positive(where, "E", E, "Pa")
    problems.number(where, "nu", nu, "", "in (-1, 0.5]", lambda x: -1.0 < x <= 0.5)
    problems.number(where, "transverse", transverse, "", "below 0.5", lambda x: abs(x) < 0.5)
    problems.raise_if_any()
    angles = np.radians(ANGLES[KINDS[str(kind)]])
    m = len(angles)
    values = np.asarray(e, dtype=np.float64)
    if values.shape[-1:] != (m,):
        problems.add(where, f"e has shape {values.shape}, the last must be {m}: a value per grid")
    elif values.size and not np.nanmax(np.abs(values), initial=0.0) <= 0.5:
        big = float(np.nanmax(np.abs(values)))
        problems.add(where, f"a strain is {big:g} m/m: it was likely given in {strain_remedy(big)}")
    spread = None if noise is None else np.broadcast_to(np.asarray(noise, dtype=np.float64), (m,))
    if spread is not None and not np.all(spread >= 0.0):
        problems.add(where, f"noise is {noise!r} m/m, must not be negative")
    problems.raise_if_any()

    # grid strains from [exx eyy gxy], including the transverse sensitivity
    T = np.stack([np.cos(angles) ** 2, np.sin(angles) ** 2, np.sin(angles) * np.cos(angles)], 1)
    K = transverse
    T = ((1.0 - K) * T + K * np.array([1.0, 1.0, 0.0])) / (1.0 - NU_CALIBRATION * K)
    inverse = np.zeros((3, m))
    inverse[: min(m, 3)] = np.linalg.inv(T[:, :m])
    strain = values @ inverse.T
    found = _derived(strain, E, nu)
    sd: dict[str, Array] = {}
    if spread is not None:
        sd = _deviations(lambda x: _derived(x @ inverse.T, E, nu), values, spread)
    if E < 1e9:
        warn(where, f"E = {E:g} Pa is softer than most plastics; was it given in MPa or GPa?")
    big = float(np.nanmax(np.abs(values), initial=0.0))
    high = float(np.nanmax(found["von_mises"], initial=0.0))
    if big > LARGE_STRAIN:
        warn(where, f"a strain is {big:.4g} m/m: it was likely given in {strain_remedy(big)}")
    elif high > LARGE_STRESS:
        warn(
            where,
            f"a stress is {high / 1e6:.4g} MPa, beyond most steels: were strains in percent, or is "
            "E of another material?",
        )
    return RosetteState(**found, sd=sd)


def _derived(strain: Array, E: float, nu: float) -> dict[str, Array]:
    exx, eyy, gxy = np.moveaxis(strain, -1, 0)
    middle, radius = 0.5 * (exx + eyy), 0.5 * np.hypot(exx - eyy, gxy)
    factor = E / (1.0 - nu**2)
    sxx, syy = factor * (exx + nu * eyy), factor * (eyy + nu * exx)
    txy = 0.5 * E / (1.0 + nu) * gxy
    e1, e2 = middle + radius, middle - radius
    s1, s2 = factor * (e1 + nu * e2), factor * (e2 + nu * e1)
    with np.errstate(invalid="ignore"):
        same = radius <= 1e-12 * np.abs(middle)
    angle = np.where(same, np.nan, 0.5 * np.arctan2(gxy, exx - eyy))
    von_mises = np.sqrt(sxx**2 - sxx * syy + syy**2 + 3.0 * txy**2)
    return {
        "exx": exx, "eyy": eyy, "gxy": gxy, "e1": e1, "e2": e2,
        "sxx": sxx, "syy": syy, "txy": txy, "s1": s1, "s2": s2,
        "angle": angle, "shear": 0.5 * (s1 - s2), "von_mises": von_mises,
    }  # fmt: skip


def _deviations(
    derived: Callable[[Array], dict[str, Array]], values: Array, spread: Array
) -> dict[str, Array]:
    """Return standard deviations to first order, by central differences."""
    size = max(float(np.nanmax(np.abs(values), initial=0.0)), 1e-9)
    step = 1e-6 * size
    variance: dict[str, Array] = {}
    for i, s in enumerate(spread):
        aside = np.zeros(values.shape[-1])
        aside[i] = step
        up, down = derived(values + aside), derived(values - aside)
        for key in up:
            change = up[key] - down[key]
            if key == "angle":  # difference of angles modulo 180 deg
                change = (change + 0.5 * np.pi) % np.pi - 0.5 * np.pi
            slope = change / (2.0 * step)
            variance[key] = variance.get(key, np.zeros(slope.shape)) + (slope * s) ** 2
    return {key: np.sqrt(value) for key, value in variance.items()}
