"""Result of a search for hot spots: the spots and the proved bounds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.base.object_repr import described
from jousto.base.ranking import TIE
from jousto.recovery.fields.criteria import Criterion
from jousto.recovery.fields.field import StressField
from jousto.recovery.hotspots.interval_bounds import Between
from jousto.recovery.hotspots.search import Proof

EARLY = 0.05  # first part of the time span that may contain the start-up transient


@described
@dataclass(frozen=True, eq=False)
class HotSpot:
    """Site with the instant at which its criterion is largest.

    Attributes
    ----------
    rank : int
        Rank from 1, the largest value.
    body, site : str
        Name of the body and label of the site, such as ``e1.a.top``.
    node : int
        Number of the node from 0; -1 if it is not known.
    position : (3,) array
        Undeformed position, part frame, m.
    time : float
        Instant, s.
    value : float
        Value of the criterion with its sign, Pa or m/m.
    tensor : (6,) array
        Stress (strain) at the instant, ``[11 22 33 12 23 13]`` in the axes of the field.
    normal : (3,) array
        Normal of the plane with the normal stress of largest magnitude at the instant.
    between : float
        Bound of the criterion at the site between stored instants, with its sign, Pa or m/m; nan
        if it is not known.
    mesh : float
        Estimated error of the stress by the mesh, Pa: difference between the elements around the
        site at the instant, see `place_errors`; nan if it is not known (beams have no mesh).
    """

    rank: int
    body: str
    site: str
    node: int
    position: Array
    time: float
    value: float
    tensor: Array
    normal: Array
    between: float = np.nan
    mesh: float = np.nan

    def _facts(self) -> str:
        at = f"{self.site} of {self.body!r}, {self.time:g} s"
        return f"{self.value:.6g} at {at}, rank {self.rank}"


@dataclass(frozen=True, eq=False)
class Found:
    """Base of `HotSpots` with its data; see there."""

    spots: tuple[HotSpot, ...]
    criterion: Criterion
    extreme: str
    separation: float
    start: float
    end: float
    fields: tuple[StressField, ...]
    certificates: dict[str, Proof]
    gaps: dict[str, Between | None]

    def __len__(self) -> int:
        return len(self.spots)

    def __iter__(self) -> Iterator[HotSpot]:
        return iter(self.spots)

    def __getitem__(self, index: int) -> HotSpot:
        return self.spots[index]

    @property
    def unit(self) -> str:
        """Unit of the values: Pa or m/m."""
        return self.fields[0].unit

    @property
    def pruned(self) -> int:
        """Number of sites excluded by their bound over the whole run."""
        return sum(c.pruned for c in self.certificates.values())

    @property
    def visited(self) -> int:
        """Number of sites that were evaluated, most of them only at knots of windows."""
        return sum(c.visited for c in self.certificates.values())

    @property
    def bound(self) -> float:
        """Upper bound of the ranked value at all sites except hot spots and their neighbours.

        In a search for the smallest values, the ranked value is minus the value. The bound is -inf
        if there are no other sites.
        """
        return max((c.bound for c in self.certificates.values()), default=-np.inf)

    @property
    def bound_between(self) -> float:
        """Upper bound of the ranked value at all sites between stored instants; nan if unknown.

        The bound is valid for a motion that is smooth from one stored instant to the next, see
        `between`.
        """
        known = [gap.bound for gap in self.gaps.values() if gap is not None]
        return max(known) if known and len(known) == len(self.gaps) else np.nan

    @property
    def certified(self) -> bool:
        """Whether no other site exceeds the last hot spot by more than round-off, 1e-9."""
        ranked = [self._ranked(spot.value) for spot in self.spots]
        margin = max((c.margin for c in self.certificates.values()), default=0.0)
        return not ranked or self.bound <= min(ranked) + margin + TIE * abs(min(ranked))

    @property
    def early(self) -> float | None:
        """End of the first part of the time span, s, if most hot spots are in it; else None.

        These hot spots may be due to the start-up transient.
        """
        limit = self.start + EARLY * (self.end - self.start)
        soon = sum(spot.time <= limit for spot in self.spots)
        return limit if self.end > self.start and 2 * soon > len(self.spots) else None

    def _ranked(self, value: float) -> float:
        return {"largest": value, "smallest": -value, "magnitude": abs(value)}[self.extreme]

    def field(self, spot: HotSpot) -> StressField:
        """Return the field at the site of a hot spot over the whole run."""
        return next(f for f in self.fields if f.name == spot.body).only(spot.site)

    def history(self, spot: HotSpot | int, criterion: Criterion | None = None) -> Array:
        """Return a criterion (nt,) over the whole run at a hot spot, or at ``self[k]``.

        Parameters
        ----------
        spot : HotSpot or int
        criterion : str or Plane, optional
            Another criterion than that of the search.
        """
        chosen = self.spots[spot] if isinstance(spot, int) else spot
        return self.field(chosen).values(criterion or self.criterion)[:, 0]
