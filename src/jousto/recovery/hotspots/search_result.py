"""What a search for hot spots has found, and what is proved of it."""

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

EARLY = 0.05  # share of the time in which a largest value may belong to the start


@described
@dataclass(frozen=True, eq=False)
class HotSpot:
    """One place and the instant at which its criterion is largest.

    Attributes
    ----------
    rank : int
        1 for the worst place.
    body, site : str
        Where: name of the body and label of the place, such as ``e1.a.top``.
    node : int
        Number of the node from 0, -1 if it is not known.
    position : (3,) array
        Undeformed, part frame, m.
    time : float
        When, s.
    value : float
        The criterion with its sign, Pa or m/m.
    tensor : (6,) array
        Stress (strain) then, ``[11 22 33 12 23 13]`` in the axes of the field.
    normal : (3,) array
        Normal of the critical plane then: that of the largest normal stress by magnitude.
    between : float
        What the criterion may reach there between stored instants, with its sign, Pa or m/m; nan
        if that is not known.
    mesh : float
        Estimated error of the stress by the mesh, Pa: by how much the elements around the place
        disagree then, see `place_errors`; nan if it is not known (beams have no mesh of solids).
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
    """What `HotSpots` are before they are shown or written; see there."""

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
        """Pa or m/m."""
        return self.fields[0].unit

    @property
    def pruned(self) -> int:
        """Places that were never looked at: the bound over the whole run leaves them out."""
        return sum(c.pruned for c in self.certificates.values())

    @property
    def visited(self) -> int:
        """Places that were looked at, most of them only window by window."""
        return sum(c.visited for c in self.certificates.values())

    @property
    def bound(self) -> float:
        """Nothing but the hot spots and their neighbours exceeds this, -inf if nothing is left.

        Ranked as the hot spots are: of the smallest values it is minus the value.
        """
        return max((c.bound for c in self.certificates.values()), default=-np.inf)

    @property
    def bound_between(self) -> float:
        """No listed place exceeds this between stored instants, nan if that is not known.

        Ranked as `bound` is. It holds for motion that is smooth from one stored instant to the
        next, see `between`.
        """
        known = [gap.bound for gap in self.gaps.values() if gap is not None]
        return max(known) if known and len(known) == len(self.gaps) else np.nan

    @property
    def certified(self) -> bool:
        """Whether nothing left out exceeds the last hot spot by more than round-off, 1e-9."""
        ranked = [self._ranked(spot.value) for spot in self.spots]
        margin = max((c.margin for c in self.certificates.values()), default=0.0)
        return not ranked or self.bound <= min(ranked) + margin + TIE * abs(min(ranked))

    @property
    def early(self) -> float | None:
        """End of the first part of the time in which most of them lie, s; None if they do not.

        They may then belong to the start of the run instead of the motion.
        """
        limit = self.start + EARLY * (self.end - self.start)
        soon = sum(spot.time <= limit for spot in self.spots)
        return limit if self.end > self.start and 2 * soon > len(self.spots) else None

    def _ranked(self, value: float) -> float:
        return {"largest": value, "smallest": -value, "magnitude": abs(value)}[self.extreme]

    def field(self, spot: HotSpot) -> StressField:
        """Return the field at one hot spot, over the whole run."""
        return next(f for f in self.fields if f.name == spot.body).only(spot.site)

    def history(self, spot: HotSpot | int, criterion: Criterion | None = None) -> Array:
        """Return a criterion over the whole run at a hot spot (or at ``self[k]``), (nt,).

        Parameters
        ----------
        spot : HotSpot or int
        criterion : str or Plane, optional
            Another one than the spots were sought by.
        """
        chosen = self.spots[spot] if isinstance(spot, int) else spot
        return self.field(chosen).values(criterion or self.criterion)[:, 0]
