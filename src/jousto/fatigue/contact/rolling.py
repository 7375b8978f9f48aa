"""Fatigue life of the material below a rolling contact under variable normal forces."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import Problems, warn
from jousto.base.object_repr import described
from jousto.fatigue.contact.contact import SHALLOW, HertzContact, rolling_contact
from jousto.fatigue.multiaxial.planes import DangVan, Findley, critical_plane

BELOW = np.concatenate([np.linspace(0.08, 1.2, 15), np.linspace(1.4, 4.0, 6)])
LINE_DEPTHS = np.concatenate([[0.0, 0.0025, 0.005, 0.01, 0.02, 0.04, 0.06], BELOW])
POINT_DEPTHS = np.concatenate([[SHALLOW], BELOW])


@described
@dataclass(frozen=True, eq=False)
class RollingLife:
    """Damage at depths below a rolling contact.

    Attributes
    ----------
    depth : (nd,) array
        Depths below the surface, m.
    damage : (nd,) array
        Miner's sum of all passes; zero for Dang Van's criterion.
    utilisation : (nd,) array
        Largest value of the criterion over all passes, divided by its limit: b of Dang Van, or
        for Findley the amplitude at the knee of the S-N curve.
    passes : float
        Number of passes of all forces.
    """

    depth: Array
    damage: Array
    utilisation: Array
    passes: float

    @property
    def worst(self) -> float:
        """Depth of the largest damage, m; without damage, depth of the largest utilisation."""
        by = self.damage if self.damage.max() > 0.0 else self.utilisation
        return float(self.depth[int(np.argmax(by))])

    @property
    def life(self) -> float:
        """Number of passes to crack initiation; inf without damage."""
        top = float(self.damage.max())
        return np.inf if top == 0.0 else self.passes / top

    @property
    def safety(self) -> float:
        """Safety factor on the stress, the inverse of the largest utilisation."""
        return float(1.0 / self.utilisation.max())

    def __str__(self) -> str:
        return (
            f"rolling contact: {self.passes:g} passes, worst {1e3 * self.worst:.3g} mm deep, "
            f"damage {self.damage.max():.4g}, life {self.life:.4g} passes, "
            f"stress at {100 * self.utilisation.max():.3g} % of the limit"
        )


@lru_cache(maxsize=16)
def _relative(
    unit: HertzContact, friction: float, criterion: Findley | DangVan
) -> tuple[float, ...]:
    """Return values of the criterion at the relative depths, for unit size and pressure."""
    depths = LINE_DEPTHS if unit.kind == "line" else POINT_DEPTHS
    roll = rolling_contact(unit, depths, friction=friction, samples=101)
    return tuple(critical_plane(s, criterion).value for s in roll.stress)


@explained
def rolling_life(
    contact: HertzContact,
    forces: ArrayLike | None,
    criterion: Findley | DangVan,
    sn: Any = None,
    *,
    pressures: ArrayLike | None = None,
    counts: ArrayLike | None = None,
    friction: float = 0.0,
    depths: ArrayLike | None = None,
) -> RollingLife:
    """Return damage and life of the material below a rolling contact.

    Every pass is one cycle. Pressure and size of the contact are proportional to ``F^(1/2)`` (line)
    or ``F^(1/3)`` (point) of the force F, so that the criterion is evaluated once at relative
    depths and scaled to every force.

    Parameters
    ----------
    contact : HertzContact
        Contact under any force.
    forces : (k,) array_like or None
        Normal force of each pass, N, or of each class of passes with `counts`; None with
        `pressures`.
    criterion : Findley or DangVan
    sn : SN, optional
        S-N curve of alternating tension, for Findley.
    pressures : (k,) array_like, optional
        Largest pressure of each pass, Pa, in place of its force: see `rolling_passes`.
    counts : (k,) array_like, optional
        Number of passes with each force; None is 1 each.
    friction : float
        Ratio of tangential to normal traction.
    depths : (nd,) array_like, optional
        Depths, m; None takes depths for the largest force: from the surface for a line contact,
        from 0.04 times the short half axis, the smallest possible depth, for a point contact.

    Warns
    -----
    JoustoWarning
        If the largest damage is at the smallest depth, and is larger or unknown above it.

    Raises
    ------
    InputError
        For forces that are not positive, counts of another length, or a missing S-N curve.
    """
    problems = Problems()
    power = 0.5 if contact.kind == "line" else 1.0 / 3.0
    if (forces is None) == (pressures is None):
        problems.add("rolling life", "give either forces or pressures")
        problems.raise_if_any()
    if pressures is not None:
        p = problems.array("rolling life", "pressures", pressures, (None,))
        problems.raise_if_any()
        assert p is not None
        forces = contact.force * (np.maximum(p, 0.0) / contact.p0) ** (1.0 / power)
    F = problems.array("rolling life", "forces", forces, (None,))
    n = None if F is None else len(F)
    c = problems.array(
        "rolling life", "counts", np.ones(n or 0) if counts is None else counts, (n,)
    )
    if F is not None and (not len(F) or F.min() < 0.0 or F.max() <= 0.0):
        problems.add("rolling life", "forces must be one or more positive numbers, N")
    if c is not None and len(c) and c.min() < 0.0:
        problems.add("rolling life", "counts must not be negative")
    if isinstance(criterion, Findley) and sn is None:
        problems.add("rolling life", "Findley needs an S-N curve: sn=...")
    problems.raise_if_any()
    assert F is not None and c is not None

    # a single contact of unit pressure and size
    size = contact.a if contact.kind == "line" else min(contact.a, contact.b)
    along = round(contact.a / size, 9)
    across = round(contact.b / size, 9) if contact.kind == "point" else 1.0
    unit = replace(contact, p0=1.0, a=along, b=across, force=1.0, approach=0.0)
    value = np.array(_relative(unit, friction, criterion))
    if isinstance(criterion, Findley):
        value = criterion.equivalent(value)
        limit = float(np.ravel(sn.S_D)[0])
    else:
        limit = criterion.b

    scale = (F / contact.force) ** power
    grid = LINE_DEPTHS if contact.kind == "line" else POINT_DEPTHS
    z = size * scale.max() * grid if depths is None else np.atleast_1d(np.asarray(depths))
    used = scale > 0.0
    with np.errstate(divide="ignore"):
        relative = np.asarray(z)[:, None] / (size * scale[None, used])
    # constant above the first depth of a point contact; proportional to 1/z below the last depth
    each = np.interp(relative, grid, value)
    far = relative > grid[-1]
    each = np.where(far, value[-1] * grid[-1] / np.maximum(relative, 1e-300), each)
    stress = each * contact.p0 * scale[None, used]
    damage = np.zeros(len(z))
    if isinstance(criterion, Findley):
        damage = np.array([float(sn.damage(row, c[used])) for row in stress])
    life = RollingLife(np.asarray(z), damage, stress.max(axis=1) / limit, float(c.sum()))
    # smallest depth with known stress: the first of the grid for a point, the surface for a line
    least = max(float(life.depth.min()), size * scale.max() * grid[0])
    if len(z) > 1 and 0.0 < life.worst <= least:
        at = life.worst / (size * scale.max())
        above = value[grid <= at].max(initial=0.0)
        if contact.kind == "point" and at <= grid[0]:
            remedy = "the stress of a point contact is not computed nearer to the surface"
        elif above > 1.05 * np.interp(at, grid, value):
            remedy = "the damage above it is larger; give depths nearer to the surface"
        else:
            return life
        warn(
            "rolling life",
            f"the largest damage is at the smallest depth, {1e3 * life.worst:.3g} mm; {remedy}",
        )
    return life


@explained
def rolling_passes(angle: ArrayLike, values: ArrayLike, *, at: float = 0.0) -> Array:
    """Return the values at the instants at which a point of a wheel passes the contact.

    Parameters
    ----------
    angle : (nt,) array_like
        Angle of the wheel, rad, unwrapped, such as of a `CoordinateSensor`.
    values : (nt,) array_like
        Force or pressure of the contact at the same instants, such as of a `ContactPressureSensor`.
    at : float
        Angle of the point ahead of the contact at angle 0, rad.

    Returns
    -------
    (k,) array
        One value for each pass.

    Raises
    ------
    InputError
        For arrays of different lengths, or a wheel that does not make a turn.

    Examples
    --------
    >>> angle = np.linspace(0.0, 6 * np.pi, 301)
    >>> rolling_passes(angle, 100.0 + angle, at=np.pi).round(3).tolist()
    [103.142, 109.425, 115.708]
    """
    problems = Problems()
    phi = problems.array("rolling passes", "angle", angle, (None,))
    y = problems.array("rolling passes", "values", values, (None if phi is None else len(phi),))
    problems.raise_if_any()
    assert phi is not None and y is not None
    turned = np.abs(phi - phi[0]) if len(phi) else phi
    if len(phi) < 2 or np.any(np.diff(turned) < 0.0):
        problems.add("rolling passes", "the wheel must turn in one direction")
        problems.raise_if_any()
    first = at % (2.0 * np.pi)
    where = np.arange(first, turned[-1], 2.0 * np.pi)
    if not len(where):
        problems.add(
            "rolling passes", f"the point does not pass: the wheel turns by {turned[-1]:.4g} rad"
        )
        problems.raise_if_any()
    return np.asarray(np.interp(where, turned, y))
