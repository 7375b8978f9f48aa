"""The error budget of a stress: what modes, step, mesh and instants may be worth at one place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.rounding import difference
from jousto.base.units import shown_unit
from jousto.parts.mesh_error import place_errors
from jousto.parts.solids.stress import SolidStress
from jousto.recovery.fields.build import stress_field
from jousto.recovery.fields.field import StressField
from jousto.recovery.hotspots.hot_spots import HotSpots
from jousto.recovery.hotspots.measures import RANKS
from jousto.recovery.hotspots.search_result import HotSpot
from jousto.simulation.results.solution import Solution

if TYPE_CHECKING:
    from jousto.parts.part import Part
    from jousto.reduction.reduced import ReducedPart

Finer: TypeAlias = Solution | StressField

HOW = {
    "instants": "store velocities, or instants closer together",
    "step": "compare with a run of half the step",
    "modes": "compare with a run of more modes",
    "mesh": "compare with a run of a finer mesh; the part has no mesh of solids, or was reduced "
    "without it",
}
"""The terms, and how one that is not known becomes known."""


@dataclass(frozen=True)
class ErrorBudget:
    """What the stress of a place may be wrong by, term by term.

    Attributes
    ----------
    place : str
        Body and label.
    criterion : str
    value : float
        The stress (strain) in question, Pa (m/m).
    unit : str
        Pa or m/m.
    terms : dict of str to float
        Of "modes", "step", "mesh" and "instants", each refined alone; Pa (m/m), nan where it is not
        known.
    """

    place: str
    criterion: str
    value: float
    unit: str
    terms: dict[str, float]

    @property
    def known(self) -> float:
        """Sum of the known terms: no less than their error together, Pa or m/m."""
        return float(sum(x for x in self.terms.values() if np.isfinite(x)))

    @property
    def unknown(self) -> tuple[str, ...]:
        """Names of the terms that are not known."""
        return tuple(name for name, x in self.terms.items() if not np.isfinite(x))

    def __repr__(self) -> str:
        return f"<ErrorBudget: {self._sentence}>"

    @property
    def _sentence(self) -> str:
        unit, factor = shown_unit(self.unit)
        size = abs(self.value)
        texts = [
            f"{name} {100.0 * x / size if size > 0.0 else np.inf:.2g} %"
            for name, x in self.terms.items()
            if np.isfinite(x)
        ]
        known = ", ".join(texts)
        if len(texts) > 1:
            known += f", together {100.0 * self.known / size if size > 0.0 else np.inf:.2g} %"
        missing = f"not known: {', '.join(self.unknown)}" if self.unknown else ""
        value = f"{factor * self.value:.4g} {unit}"
        return (
            f"{self.place}, {self.criterion} {value}: {'; '.join(filter(None, (known, missing)))}"
        )

    def __str__(self) -> str:
        return told(self)


def told(budget: ErrorBudget, *, residual: bool = False) -> str:
    """Return a budget in words, of a stress that has or has not the residual stress in it."""
    how = HOW if residual else HOW | {"modes": f"{HOW['modes']}, or with the residual stress"}
    first = f"error budget of {budget._sentence}"
    return "\n".join([first, *(f"  {name}: {how[name]}" for name in budget.unknown)])


@explained
def error_budget(
    found: HotSpots,
    rank: int = 1,
    *,
    step: Finer | None = None,
    modes: Finer | None = None,
    mesh: Finer | None = None,
    part: tuple[Part, ReducedPart] | None = None,
) -> ErrorBudget:
    """Return what the stress of a hot spot may be wrong by.

    Each term is what changes at that place when one thing alone is refined: largest value over the
    same time, there against here. Besides, of "instants" it is what the stored velocities leave
    open, see `HotSpot.between`, and of "mesh", of parts of solids, by how much the elements around
    the place disagree, see `HotSpot.mesh`. The sum is no less than the error where the terms do not
    act on one another.

    Parameters
    ----------
    found : HotSpots
    rank : int
        Which hot spot, from 1.
    step, modes, mesh : Solution or StressField, optional
        A run (or its field of that body) with a shorter step, with more modes (or with the
        residual stress), of a finer mesh, where the nearest place counts; all else as it was.
    part : (Part, ReducedPart), optional
        What the body was made of, for the mesh, where the run does not have it.

    Raises
    ------
    InputError
        If there is no such hot spot, or the other run has no such body or place.

    Examples
    --------
    ``print(jo.recovery.error_budget(found, step=half, modes=many))``
    """
    if not 1 <= rank <= len(found):
        message = f"rank is {rank}, must be from 1 to {len(found)}"
        raise InputError(Problem("error_budget", message))
    spot = found[rank - 1]
    ranked = RANKS[found.extreme]
    own = float(ranked(np.asarray(spot.value)))

    def change(other: Finer | None) -> float:
        return (
            float("nan")
            if other is None
            else abs(difference(_peak(found, spot, other, ranked), own))
        )

    terms = {"modes": change(modes), "step": change(step), "mesh": change(mesh)}
    if mesh is None:
        terms["mesh"] = spot.mesh if part is None else _scatter(found, spot, *part)
    terms["instants"] = max(difference(float(ranked(np.asarray(spot.between))), own), 0.0)
    if np.isnan(spot.between):
        terms["instants"] = float("nan")
    return ErrorBudget(
        f"'{spot.body}' {spot.site}", str(found.criterion), spot.value, found.unit, terms
    )


def _peak(found: HotSpots, spot: HotSpot, other: Finer, ranked: Callable[[Array], Array]) -> float:
    """Return the largest ranked value of another run at the place of a hot spot."""
    own = found.field(spot)
    if isinstance(other, Solution):
        other = stress_field(other, spot.body, strain=own.strain, frame=own.frame)
    away = np.linalg.norm(other.positions - spot.position, axis=1)
    here = np.flatnonzero(away <= away.min() + 1e-9)
    # the same point of a section, or the same material, of several at one place
    same = [k for k in here if other.labels[k] == spot.site]
    place = int(same[0] if same else here[0])
    values = other.take([place]).during(found.start, found.end).values(found.criterion)
    return float(ranked(values[:, 0]).max())


def _scatter(found: HotSpots, spot: HotSpot, part: Part, reduced: ReducedPart) -> float:
    """Return by how much the elements around a hot spot disagree then."""
    field = found.field(spot)
    instant = int(np.searchsorted(field.time, spot.time))
    if part.solids is None or found.unit != "Pa":
        return float("nan")
    n = reduced.modes.shape[2]
    d = reduced.modes[: len(part.nodes)].reshape(-1, n) @ field.p[instant, :n]
    place = SolidStress.everywhere(part.solids).index(spot.site)
    return float(place_errors(part, d)[place, 0])
