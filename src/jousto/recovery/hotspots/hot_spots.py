"""Hot spots: sites with the largest values of a criterion over a run, with a certificate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.object_repr import described
from jousto.base.ranking import TIE, ranking
from jousto.recovery.fields.build import stress_field
from jousto.recovery.fields.criteria import Criterion, evaluate, rotate_tensors, tensor, weights
from jousto.recovery.fields.field import StressField
from jousto.recovery.hotspots.exhaustive_beams import search_all, upper_bound
from jousto.recovery.hotspots.interval_bounds import Between, bounds_between, largest_between
from jousto.recovery.hotspots.measures import Measure, measure
from jousto.recovery.hotspots.report import certificate_lines, head, row, shown_value
from jousto.recovery.hotspots.search import Places, Proof, search
from jousto.recovery.hotspots.search_result import Found, HotSpot
from jousto.recovery.hotspots.write import write_histories, write_spots
from jousto.simulation.results.solution import Solution


@described
@dataclass(frozen=True, eq=False)
class HotSpots(Found):
    """Sites with the largest values of a criterion over a run, in order, with a certificate.

    Attributes
    ----------
    spots : tuple of HotSpot
    criterion : str or Plane
    extreme : str
        Ranking: "largest", "smallest" or "magnitude".
    separation : float
        Smallest distance of two hot spots of a body, m; the largest of all bodies.
    start, end : float
        First and last instant of the search, s.
    fields : tuple of StressField
        Fields of the bodies over the whole run.
    certificates : mapping of str to Proof
        Proved bounds at the stored instants, by body.
    gaps : mapping of str to Between or None
        Bounds between the stored instants, by body; None if they are not known.
    """

    def _facts(self) -> str:
        named = self.criterion if isinstance(self.criterion, str) else "plane"
        facts = [f"{len(self.spots)} places by {named}"]
        if self.spots:
            worst = self.spots[0]
            value = shown_value(worst.value, self.unit)
            facts.append(f"worst {value} at {worst.site} of {worst.body!r}, {worst.time:g} s")
        return ", ".join([*facts, "certified" if self.certified else "not certified"])

    def to_csv(self, path: str | Path) -> Path:
        """Write the table of hot spots with all digits, in SI units; return the path.

        Raises
        ------
        InputError
            If the path does not end with .csv or cannot be written.
        """
        return write_spots(self, path)

    def write_histories(self, path: str | Path) -> Path:
        """Write criterion and components of every hot spot over the whole run; return the path.

        Parameters
        ----------
        path : path
            File that ends with .csv, or with .h5 for one group per hot spot.

        Raises
        ------
        InputError
            For another ending, a path that cannot be written, or a table of bodies whose fields
            have different instants.
        """
        return write_histories(self, path)

    def table(self) -> list[list[str]]:
        """Return the rows of the printed table, the header first; MPa, mm and s."""
        several = len(self.fields) > 1
        return [head(self, several), *(row(self, spot, several) for spot in self.spots)]

    def certificate(self) -> str:
        """Certificate of the search as a text: what it proves."""
        return "\n".join(certificate_lines(self))

    def __str__(self) -> str:
        rows = self.table()
        widths = [max(len(line[k]) for line in rows) for k in range(len(rows[0]))]
        texts = [
            "  ".join(
                cell.ljust(w) if k in _left(self) else cell.rjust(w)
                for k, (cell, w) in enumerate(zip(line, widths, strict=True))
            ).rstrip()
            for line in rows
        ]
        return "\n".join([*texts, *certificate_lines(self)])

    def advice(self) -> str:
        """Advice for hot spots at the start of the run; empty if most are later."""
        limit = self.early
        if limit is None:
            return ""
        return (
            f"most of the largest values are in the first {limit - self.start:.3g} s, which may "
            "be the start-up transient; search from a later time (start=, --from), start from the "
            "equilibrium, or let the drives begin smoothly"
        )


def _left(found: HotSpots) -> tuple[int, ...]:
    return (1, 2) if len(found.fields) > 1 else (1,)


@explained
def hot_spots(
    source: StressField | Sequence[StressField] | Solution,
    *,
    bodies: Sequence[str] | str | None = None,
    count: int = 10,
    criterion: Criterion = "von-mises",
    separation: float | None = None,
    start: float | None = None,
    end: float | None = None,
    extreme: str | None = None,
) -> HotSpots:
    """Return the sites with the largest values of a criterion over a run, with a certificate.

    The certificate covers the stored instants; `HotSpots.bound_between` is a bound between them
    by the stored velocities.

    The stress is ``s(t) = S p(t)``, and a criterion changes by at most ``|G S (p - p')|``. An upper
    bound at a site over the run is ``sqrt(lmax(Q)) max |z|`` with ``Q = L^T S^T V S L`` and the
    whitened path z, ``p = L z``. A bound in a window of time follows from the values at its ends
    and the deviation of the path from the chord between them. Branch and bound evaluates only the
    sites and instants whose bound exceeds the values found so far; all bounds include rounding
    errors.

    Parameters
    ----------
    source : StressField, sequence of StressField or Solution
        Fields to search, or a run with all its bodies that have stress.
    bodies : str or sequence of str, optional
        Names of the bodies of a run to search.
    count : int
        Number of hot spots.
    criterion : str or Plane
        See `evaluate`.
    separation : float
        Smallest distance of two hot spots of a body, m. The first hot spot is the site of the
        largest value, the second the largest of the sites further away than this, and so on.
        Among sites of equal values up to round-off (1e-9) the first label is taken.
    start, end : float, optional
        First and last instant, s; None: all stored instants.
    extreme : "largest", "smallest" or "magnitude", optional
        Extreme of the search. None: the largest von Mises, shear and first principal stress, the
        smallest third principal stress, and the largest magnitude of all other criteria.

    Returns
    -------
    HotSpots
        Hot spots; printed as a table with the certificate.

    Raises
    ------
    InputError
        For an unknown body or criterion, coordinates that are not numbers, no instant in the
        window, or components in world axes.

    Examples
    --------
    ``print(hot_spots(run, count=5, separation=0.02))``
    """
    fields = _fields(source, bodies)
    _check(fields, count, criterion, separation)
    sought = measure(criterion, extreme, strain=fields[0].strain)
    spots: list[tuple[float, HotSpot]] = []
    certificates: dict[str, Proof] = {}
    gaps: dict[str, Between | None] = {}
    spans = []
    for field in fields:
        part = field.during(start, end)
        spans.append((float(part.time[0]), float(part.time[-1])))
        found = _searched(part, criterion, sought, count, separation)
        certificates[field.name] = found.certificate
        gaps[field.name] = bounds_between(part, sought)
        for place, instant, ranked in zip(found.places, found.instants, found.ranked, strict=True):
            spots.append((float(ranked), _spot(part, int(place), int(instant), criterion)))
    # hot spots of all bodies; the bound of a body includes its omitted hot spots
    names = [f"{spot.body} {spot.site}" for _, spot in spots]
    order = ranking([ranked for ranked, _ in spots], names).tolist()
    for k in order[count:]:
        ranked, spot = spots[k]
        known = certificates[spot.body]
        certificates[spot.body] = replace(known, bound=max(known.bound, ranked + known.margin))
    listed = (replace(spots[k][1], rank=r) for r, k in enumerate(order[:count], 1))
    chosen = tuple(_bounded(spot, fields, sought, start, end) for spot in listed)
    return HotSpots(
        chosen,
        criterion,
        sought.extreme,
        max(proof.separation for proof in certificates.values()),
        min(first for first, _ in spans),
        max(last for _, last in spans),
        fields,
        certificates,
        gaps,
    )


def worst_places(
    fields: Sequence[StressField],
    *,
    count: int,
    criterion: Criterion,
    separation: float | None = None,
    extreme: str | None = None,
) -> list[HotSpot]:
    """Return the hot spots of `hot_spots` without a certificate, in less time.

    A criterion at a site is at most ``sum_j |G S_j| max |p_j|``. Bodies are searched in descending
    order of this bound, until `count` sites exceed the bound of the next body.
    """
    _check(tuple(fields), count, criterion, separation)
    sought = measure(criterion, extreme, strain=fields[0].strain)
    bounds = np.array([upper_bound(field, sought) for field in fields])
    best: list[tuple[float, HotSpot]] = []
    for k in np.argsort(-bounds, kind="stable").tolist():
        if len(best) >= count and bounds[k] + TIE * abs(bounds[k]) < best[count - 1][0]:
            break
        found = _searched(fields[k], criterion, sought, count, separation)
        for place, instant, ranked in zip(found.places, found.instants, found.ranked, strict=True):
            best.append((float(ranked), _spot(fields[k], int(place), int(instant), criterion)))
        best.sort(key=lambda one: -one[0])
    names = [f"{spot.body} {spot.site}" for _, spot in best]
    order = ranking([ranked for ranked, _ in best], names).tolist()
    return [best[k][1] for k in order[:count]]


def _searched(
    part: StressField,
    criterion: Criterion,
    sought: Measure,
    count: int,
    separation: float | None,
) -> Places:
    """Return the hot spots of one body."""
    apart = section_size(part) if separation is None else float(separation)
    if part.columns is not None:
        return search_all(part, criterion, sought, count=count, separation=apart)
    return search(
        part.S,
        part.p,
        part.positions,
        sought,
        count=count,
        separation=apart,
        labels=part.labels,
    )


def _bounded(
    spot: HotSpot,
    fields: tuple[StressField, ...],
    sought: Measure,
    start: float | None,
    end: float | None,
) -> HotSpot:
    """Return a hot spot with its bound between the stored instants."""
    own = next(field for field in fields if field.name == spot.body)
    part = own.only(spot.site).during(start, end)
    return replace(spot, between=largest_between(part, 0, sought))


def section_size(field: StressField) -> float:
    """Return the largest distance between sites of one node, m; 0 for solids."""
    nodes = field.modes.nodes
    if nodes is None or not len(nodes):
        return 0.0
    _, group, count = np.unique(nodes, return_inverse=True, return_counts=True)
    middle = np.stack([np.bincount(group, weights=x) / count for x in field.positions.T], axis=1)
    known = (nodes >= 0) & (count[group] > 1)
    away = np.linalg.norm(field.positions - middle[group], axis=1)
    # twice the radius, since the sites of two beams at an angle are on circles about their node
    return float(2.0 * (1.0 + 1e-6) * away[known].max(initial=0.0))


def _fields(
    source: StressField | Sequence[StressField] | Solution, bodies: Sequence[str] | str | None
) -> tuple[StressField, ...]:
    """Return the fields of the search from a run or from fields."""
    if isinstance(source, Solution):
        wanted = [bodies] if isinstance(bodies, str) else list(bodies or ())
        problems = Problems()
        # of a file, beams are read only for names that no body has
        if unknown := [name for name in wanted if name not in source.body_names]:
            names = [*source.body_names, *(beam.name for beam in source.beams)]
            for name in (x for x in unknown if x not in names):
                problems.add(source.where, f"no body '{name}'{suggest(name, names)}")
        problems.raise_if_any()
        known = wanted or list(source.stressed)
        if not known:
            raise InputError(
                Problem(
                    source.where,
                    "no body of this run has stress data; parts of beams and of solids have it, "
                    "rigid bodies and parts from matrices do not",
                )
            )
        return tuple(stress_field(source, name) for name in dict.fromkeys(known))
    if bodies is not None:
        raise InputError(Problem("hot_spots", "bodies= is for a run; a field has one body"))
    fields: tuple[Any, ...] = (source,)
    if isinstance(source, list | tuple):
        fields = tuple(source)
    if not fields or not all(isinstance(field, StressField) for field in fields):
        raise InputError(
            Problem("hot_spots", f"source is {source!r}, must be a run or fields from stress_field")
        )
    return fields


def _check(
    fields: tuple[StressField, ...], count: int, criterion: Criterion, separation: float | None
) -> None:
    problems = Problems()
    number: Any = count
    if isinstance(number, bool) or not isinstance(number, int | np.integer) or number < 1:
        problems.add("hot_spots", f"count is {count!r}, must be a whole number of at least 1")
    apart: Any = 0.0 if separation is None else separation
    if not isinstance(apart, int | float | np.number) or not 0.0 <= apart < np.inf:
        problems.add("hot_spots", f"separation is {separation!r}, must be a length >= 0 in m")
    names = [field.name for field in fields]
    for name in sorted({name for name in names if names.count(name) > 1}):
        problems.add("hot_spots", f"body '{name}' is given more than once")
    if len({field.strain for field in fields}) > 1:
        problems.add("hot_spots", "fields of stress and strain cannot be searched together")
    problems.raise_if_any()
    if weights(criterion) is not None and any(field.A is not None for field in fields):
        raise InputError(
            Problem(
                "hot_spots",
                f"{criterion} in world axes changes with the rotation of the body and has no "
                'bound; use the axes of the part, stress_field(..., frame="body")',
            )
        )


def _spot(field: StressField, place: int, instant: int, criterion: Criterion) -> HotSpot:
    on = slice(None)
    if field.columns is not None:
        on = slice(int(field.columns[place]), int(field.columns[place]) + field.S.shape[2])
    s = np.asarray(field.S[place] @ field.p[instant, on])
    if field.A is not None:
        s = rotate_tensors(s, field.A[instant], field.strain)
    values, vectors = np.linalg.eigh(tensor(s, field.strain))
    normal = vectors[:, int(np.argmax(np.abs(values)))]
    normal = normal * (1.0 if normal[int(np.argmax(np.abs(normal)))] >= 0.0 else -1.0)
    nodes = field.modes.nodes
    mesh = np.nan if field.strain else field.modes.mesh_error(place, field.p[instant, on])
    return HotSpot(
        rank=0,
        body=field.name,
        site=field.labels[place],
        node=-1 if nodes is None else int(nodes[place]),
        position=field.positions[place],
        time=float(field.time[instant]),
        value=float(evaluate(s, criterion, field.strain)),
        tensor=s,
        normal=normal,
        mesh=mesh,
    )
