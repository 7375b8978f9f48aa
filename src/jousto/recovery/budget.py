"""Error budget of a stress at one site: errors of modes, step, mesh and stored instants."""

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
"""Terms of the budget, and the way to determine each."""


@dataclass(frozen=True)
class ErrorBudget:
    """Error estimates of the stress at a site, term by term.

    Attributes
    ----------
    place : str
        Body and label of the site.
    criterion : str
        Name of the criterion.
    value : float
        Stress (strain) at the site, Pa (m/m).
    unit : str
        Unit: Pa or m/m.
    terms : dict of str to float
        Error by "modes", "step", "mesh" and "instants", Pa (m/m); nan if it is not known.
    """

    place: str
    criterion: str
    value: float
    unit: str
    terms: dict[str, float]

    @property
    def known(self) -> float:
        """Sum of the known terms, an upper bound of their total error, Pa or m/m."""
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
        return budget_text(self)


def budget_text(budget: ErrorBudget, *, residual: bool = False) -> str:
    """Return a budget as a text, for a stress with or without residual stress."""
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
    """Return the error budget of the stress of a hot spot.

    A term is the change of the largest value at the site, over the same time span, in a run with
    one refinement alone. The term "instants" is the bound by the stored velocities, see
    `HotSpot.between`. For parts of solids the term "mesh" is by default the difference between the
    elements around the site, see `HotSpot.mesh`. The sum is an upper bound of the error if the
    terms are independent of each other.

    Parameters
    ----------
    found : HotSpots
        Hot spots of a run.
    rank : int
        Rank of the hot spot, from 1.
    step, modes, mesh : Solution or StressField, optional
        Run (or its field of the body) with a shorter step, with more modes (or with residual
        stress), or with a finer mesh, where the nearest site is compared; everything else
        unchanged.
    part : (Part, ReducedPart), optional
        Part of the body, for the error of the mesh, if the run does not contain it.

    Raises
    ------
    InputError
        If there is no such hot spot, or the other run has no such body or site.

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
    """Return the largest ranked value of another run at the site of a hot spot."""
    own = found.field(spot)
    if isinstance(other, Solution):
        other = stress_field(other, spot.body, strain=own.strain, frame=own.frame)
    away = np.linalg.norm(other.positions - spot.position, axis=1)
    here = np.flatnonzero(away <= away.min() + 1e-9)
    # for several sites at one position: the same section point or material
    same = [k for k in here if other.labels[k] == spot.site]
    place = int(same[0] if same else here[0])
    values = other.take([place]).during(found.start, found.end).values(found.criterion)
    return float(ranked(values[:, 0]).max())


def _scatter(found: HotSpots, spot: HotSpot, part: Part, reduced: ReducedPart) -> float:
    """Return the difference of the stress between the elements around a hot spot, Pa."""
    field = found.field(spot)
    instant = int(np.searchsorted(field.time, spot.time))
    if part.solids is None or found.unit != "Pa":
        return float("nan")
    n = reduced.modes.shape[2]
    d = reduced.modes[: len(part.nodes)].reshape(-1, n) @ field.p[instant, :n]
    place = SolidStress.everywhere(part.solids).index(spot.site)
    return float(place_errors(part, d)[place, 0])
