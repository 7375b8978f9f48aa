"""Damage on planes: rainflow count of shear along directions in a plane, or of normal stress."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.base.files import Rows, Tabular
from jousto.base.object_repr import described
from jousto.base.ranking import ranking
from jousto.fatigue.local.strain_life import Residue
from jousto.fatigue.multiaxial.planes import (
    DangVan,
    FatemiSocie,
    Findley,
    NormalStress,
    PlaneCriterion,
    _history,
    _places,
    normals,
    plane_rows,
)
from jousto.materials.strength.strain_life import StrainLife
from jousto.mechanism.sensors.damage_rule import RESIDUES
from jousto.model.native.planes import PlaneCounter, StrainCurve

AT_ONCE = 64
"""Number of sites whose histories are in memory at the same time."""


@described
@dataclass(frozen=True, eq=False)
class PlaneDamage(Tabular):
    """Damage on the plane of the largest damage of each site.

    Attributes
    ----------
    labels : tuple of str
    damage : (ns,) array
        Miner's sum of one pass of the history.
    normal : (ns, 3) array
        Plane of the largest damage.
    criterion : object
    residue : str
        Residue rule of the count.
    """

    labels: tuple[str, ...]
    damage: Array
    normal: Array
    criterion: PlaneCriterion
    residue: str
    sn: str = field(default="")

    @property
    def life(self) -> Array:
        """Number of repetitions of the history to failure, (ns,)."""
        with np.errstate(divide="ignore"):
            return np.asarray(1.0 / self.damage)

    def table(self, rows: int = 10) -> str:
        """Return a table of the sites with the largest damage."""
        width = max(12, *(len(label) for label in self.labels))
        lines = [
            f"{self.criterion}, residue '{self.residue}', {self.sn}",
            f"{'site':>{width}} {'damage':>11} {'life':>11}  plane",
            f"{'':>{width}} {'':>11} {'passes':>11}",
        ]
        for i in ranking(self.damage, self.labels)[:rows]:
            normal = " ".join(f"{x:6.3f}" for x in self.normal[i])
            lines.append(
                f"{self.labels[i]:>{width}} {self.damage[i]:11.4g} {self.life[i]:11.4g}  {normal}"
            )
        return "\n".join(lines)

    def _csv(self) -> Rows:
        """Return the table of damage, life and plane of all sites."""
        columns = (self.damage.tolist(), self.life.tolist(), *self.normal.T.tolist())
        head = ("site", "damage", "life (passes)", "n1", "n2", "n3", f"residue: {self.residue}")
        return head, zip(self.labels, *columns, strict=True)

    def __str__(self) -> str:
        return self.table()


@explained
def plane_damage(
    stress: Any,
    criterion: PlaneCriterion,
    sn: Any,
    *,
    residue: Residue,
    mean: Any = None,
    sites: Sequence[str] | str | None = None,
    step: float = 10.0,
) -> PlaneDamage:
    """Return the largest damage over all planes at each site, by counting cycles on every plane.

    On every plane the shear stress is resolved in directions `step` apart and counted by rainflow;
    each cycle has the largest normal stress during it. For `NormalStress` the normal stress of each
    plane is counted. If the shear vector rotates in its plane, the amplitude along a direction may
    be up to 13 % (``1 - sqrt(3)/2``, equilateral triangle) below the radius of the smallest circle
    of `critical_plane`. Among planes of equal damage to 1e-9, such as those along a bar, the normal
    nearest to the first axis is chosen, then to the second.

    Parameters
    ----------
    stress : StressField or (ns, nt, 6) array_like
        Stress field, or histories of several sites, Pa.
    criterion : Findley, FatemiSocie or NormalStress
    sn : SN or StrainLife
        S-N curve of alternating tension for `Findley` and `NormalStress`, strain-life curve for
        `FatemiSocie`.
    residue : {"half", "repeat", "ignore"}
        Rule for cycles that do not close; mandatory, see `local_cycles`.
    mean : mean stress correction, optional
        Correction, for `NormalStress` only.
    sites : sequence of str, optional
        Labels of the sites; None takes all.
    step : float
        Angle between planes, and between directions in a plane, degrees.

    Raises
    ------
    InputError
        For an unknown residue rule, a curve that does not fit the criterion, or an invalid history.
    """
    problems = Problems()
    if residue not in RESIDUES:
        problems.add(
            "plane damage", f"residue is {residue!r}, must be one of {', '.join(RESIDUES)}"
        )
    strain = isinstance(criterion, FatemiSocie)
    if strain != isinstance(sn, StrainLife):
        wanted = "a StrainLife" if strain else "an S-N curve"
        problems.add(
            "plane damage",
            f"{type(criterion).__name__} needs {wanted}, not {type(sn).__name__}",
        )
    if isinstance(criterion, DangVan):
        problems.add(
            "plane damage", "Dang Van's criterion has no damage; use multiaxial for its safety"
        )
    if mean is not None and not isinstance(criterion, NormalStress):
        problems.add(
            "plane damage",
            f"mean= is for NormalStress; {type(criterion).__name__} includes the mean stress",
        )
    problems.number("plane damage", "step", step, "deg", "in [1, 45]", lambda d: 1.0 <= d <= 45.0)
    problems.raise_if_any()

    labels, histories = _places(stress, sites)
    n = normals(math.radians(step))
    counter = _counter(criterion, sn, residue, mean, n, np.radians(np.arange(0.0, 180.0, step)))
    found: list[tuple[float, int]] = []
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        while several := [_history(next_) for next_ in islice(histories, AT_ONCE)]:
            found += pool.map(counter.worst, several)
    name = getattr(sn, "name", "") or str(sn)
    damage = np.array([worst for worst, _ in found])
    return PlaneDamage(labels, damage, n[[i for _, i in found]], criterion, residue, name)


def _counter(
    criterion: PlaneCriterion, curve: Any, residue: Residue, mean: Any, n: Array, angles: Array
) -> PlaneCounter:
    """Return the counter of cycles along angles (l,) in planes of normals n (m, 3)."""
    turns = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rows = plane_rows(n)
    if isinstance(criterion, FatemiSocie):
        slope = min(-1.0 / curve.b, -1.0 / curve.c)
        lives = StrainCurve(lambda x: criterion.cycles(x, curve), criterion.G, slope)
        k = criterion.k / criterion.S_y
        return PlaneCounter("strain", k, rows, turns, lives, residue=residue)
    if isinstance(criterion, Findley):
        return PlaneCounter("findley", criterion.k, rows, turns, curve, residue=residue)
    return PlaneCounter("normal", 0.0, rows, turns, curve, residue=residue, mean=mean)
