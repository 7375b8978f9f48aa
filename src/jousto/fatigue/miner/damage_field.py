"""Damage field: damage, life and safety at all stress sites of a body."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array, Index
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.files import Rows, Tabular
from jousto.base.object_repr import described
from jousto.base.ranking import ranking
from jousto.base.rounding import SHARE
from jousto.base.voigt import PAIRS
from jousto.fatigue.cycles.duty import DutyCycle, check_duty, count_duty
from jousto.fatigue.cycles.rainflow import Cycles, check_residue
from jousto.fatigue.miner.damage import (
    _sum,
    check_stress,
    duration_text,
    equivalents,
    proportional,
    reference,
    stress_safety,
)
from jousto.fatigue.miner.spectrum import Spectrum
from jousto.materials.strength.mean_stress import MeanStress
from jousto.materials.strength.sn import SN
from jousto.recovery.fields.criteria import Criterion, Plane, check_criterion
from jousto.recovery.fields.field import StressField
from jousto.recovery.fields.planes import half_sphere
from jousto.recovery.hotspots.bounds import prepare
from jousto.recovery.hotspots.exhaustive_beams import largest
from jousto.recovery.hotspots.measures import measure

CRITICAL_PLANE = "critical-plane"
MEMORY = 64 << 20
"""Memory of the histories counted at a time, bytes."""
SHOWN = 10  # number of sites in a table


@described
@dataclass(frozen=True, eq=False)
class DamageField(Tabular):
    """Damage, life and safety at all stress sites of a body.

    Attributes
    ----------
    body : str
        Name of the body.
    labels : tuple of str
        Labels of the ns sites.
    positions : (ns, 3) array
        Positions of the sites, part frame, m.
    nodes : (ns,) int array or None
        Nodes of the sites, from 0.
    damage : (ns,) array
        Miner's sum of one repetition of the history or duty cycle.
    safety : (ns,) array
        Factor on all stresses with which the required life has the allowable sum; a lower bound
        where cycles were not counted.
    peak : (ns,) array
        Stress of the largest magnitude, with its sign, Pa; an upper bound of the magnitude where
        `exact` is False.
    counted : (ns,) bool array
        Whether cycles were counted. They are not where the largest stress, or an upper bound of
        it, is below the endurance limit.
    normals : (ns, 3) array or None
        For the criterion "critical-plane": normal of the plane with the largest damage.
    duration, required, allowable : float
        Duration of the history, s; required life, s; allowable Miner's sum.
    criterion : str or Plane
        Stress that was counted.
    residue, transitions : str
        Residue rule, and rule for transitions between events.
    sn : SN
        S-N curve.
    mean : MeanStress or None
        Mean stress correction.
    exact : (ns,) bool array
        Whether the peak was computed exactly.
    """

    body: str
    labels: tuple[str, ...]
    positions: Array
    nodes: NDArray[np.int64] | None
    damage: Array
    safety: Array
    peak: Array
    counted: NDArray[np.bool_]
    normals: Array | None
    duration: float
    required: float
    allowable: float
    criterion: Criterion
    residue: str
    transitions: str
    sn: SN
    mean: MeanStress | None
    exact: NDArray[np.bool_]

    def _facts(self) -> str:
        facts = f"{len(self)} places of {self.body!r}, residue {self.residue!r}"
        for worst in self.worst(1):
            damage, life, safety = self.at(worst)
            facts += f"; {worst}: damage {damage:.4g}, life {life:.4g} s, safety {safety:.3g}"
        return facts

    def __len__(self) -> int:
        return len(self.labels)

    @property
    def life(self) -> Array:
        """Life (ns,), s: ``allowable duration / damage``; inf without damage."""
        with np.errstate(divide="ignore"):
            return np.asarray(self.allowable * self.duration / self.damage)

    @property
    def pruned(self) -> int:
        """Number of sites without damage because of their largest stress."""
        return int(np.count_nonzero(~self.counted))

    def cycles(self, source: StressField | DutyCycle, site: str | None = None) -> Cycles:
        """Return the cycles of a site of the source; None: the site of the largest damage."""
        label = self.worst(1)[0] if site is None else site
        criterion = self.criterion
        if self.normals is not None:
            normal = self.normals[self.labels.index(label)]
            criterion = Plane(normal) if np.any(normal) else "signed-principal"
        return site_cycles(source, label, criterion=criterion, residue=self.residue)

    def worst(self, count: int = SHOWN) -> list[str]:
        """Return the labels of the sites with the largest damage, then the lowest safety."""
        return [self.labels[i] for i in self._order()[:count]]

    def at(self, site: str) -> tuple[float, float, float]:
        """Return damage, life (s) and safety of a site.

        Raises
        ------
        InputError
            If there is no such site.
        """
        if site not in self.labels:
            raise InputError(Problem("damage", f"no site '{site}'{suggest(site, self.labels)}"))
        i = self.labels.index(site)
        return float(self.damage[i]), float(self.life[i]), float(self.safety[i])

    def _order(self) -> NDArray[np.intp]:
        return ranking(self.damage, self.labels, then=-self.safety)

    def table(self, count: int = SHOWN) -> list[tuple[str, ...]]:
        """Return a header and the sites of the largest damage as rows of texts."""
        rows: list[tuple[str, ...]] = [
            ("site", "position (mm)", "peak (MPa)", "damage", "life", self.safety_of)
        ]
        for i in self._order()[:count]:
            place = " ".join(f"{1e3 * x:.4g}" for x in self.positions[i])
            some = abs(self.peak[i]) > SHARE * self.sn.S_D  # larger than round-off
            least = "" if some and self.counted[i] else "> "
            rows.append(
                (
                    self.labels[i],
                    place,
                    f"{'' if self.exact[i] else '< '}{self.peak[i] / 1e6:.5g}" if some else "0",
                    f"{self.damage[i]:.5g}",
                    duration_text(float(self.life[i])),
                    f"{least}{min(float(self.safety[i]), 1.0 / SHARE):.4g}",
                )
            )
        return rows

    @property
    def once(self) -> bool:
        """Whether the safety is that of one repetition, because no required life was given."""
        return self.required == self.duration

    @property
    def safety_of(self) -> str:
        """Heading of the safety in tables: of one repetition, or for the required life."""
        return f"safety {'of one pass' if self.once else 'for the life required'}"

    def head(self) -> list[tuple[str, str]]:
        """Return the settings of the assessment as pairs of name and text."""
        mean = "not corrected" if self.mean is None else str(self.mean)
        required = f", required {duration_text(self.required)}"
        if self.once:
            required = " once; the safety is that of one repetition, required=... gives another"
        return [
            ("body", f"{self.body}, {len(self)} places, {self.pruned} below the endurance limit"),
            ("stress", f"{self.criterion}, mean stress: {mean}"),
            ("S-N curve", str(self.sn)),
            ("cycles", f"rainflow, residue: {self.residue}, transitions: {self.transitions}"),
            (
                "history",
                f"{duration_text(self.duration)}{required}, damage allowed {self.allowable:g}",
            ),
        ]

    def __str__(self) -> str:
        rows = self.table()
        widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        lines = [f"{name:10s} {text}" for name, text in self.head()]
        lines += [
            "  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip()
            for row in rows
        ]
        return "\n".join(lines)

    def _csv(self) -> Rows:
        """Return the table of damage, life and safety of all sites."""
        head = ["site", "node", "x (m)", "y (m)", "z (m)", "peak (Pa)", "damage", "life (s)"]
        head += [self.safety_of, "counted"]
        head += [f"{self.criterion}; residue: {self.residue}; S-N: {self.sn.name or self.sn}"]
        nodes: Sequence[Any] = [""] * len(self) if self.nodes is None else self.nodes.tolist()
        rows = zip(
            self.labels,
            nodes,
            *self.positions.T.tolist(),
            self.peak.tolist(),
            self.damage.tolist(),
            self.life.tolist(),
            self.safety.tolist(),
            self.counted.astype(int).tolist(),
            strict=True,
        )
        return head, rows


def special_normals(history: Array) -> Array:
    """Return unit normals (12, 3) of special planes, in addition to a grid.

    These are the principal directions at the instants of the largest and the smallest principal
    stress, the principal directions of the difference of both tensors, and the coordinate axes.

    Parameters
    ----------
    history : (nt, 6) array
        Stress components, Pa.
    """
    T = history[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]
    principal = np.linalg.eigvalsh(T)
    high, low = T[int(np.argmax(principal[:, 2]))], T[int(np.argmin(principal[:, 0]))]
    vectors = [np.linalg.eigh(x)[1].T for x in (high, low, high - low)]
    return np.concatenate([*vectors, np.eye(3)])


def _around(normal: Array, angle: float) -> Array:
    """Return six unit normals (6, 3) at an angle, rad, from a normal."""
    across = np.linalg.svd(normal[None])[2][1:]
    turn = np.arange(6) * (np.pi / 3.0)
    ring = np.cos(turn)[:, None] * across[0] + np.sin(turn)[:, None] * across[1]
    return np.asarray(np.cos(angle) * normal + np.sin(angle) * ring)


@explained
def damage_field(
    source: StressField | DutyCycle,
    sn: SN,
    *,
    criterion: Criterion = "signed-von-mises",
    residue: str | None = None,
    mean: MeanStress | None = None,
    required: float | None = None,
    allowable: float = 1.0,
    survival: float | None = None,
    planes: int = 200,
) -> DamageField:
    """Return damage, life and safety at all stress sites of a body.

    Cycles are not counted where the largest stress is below the endurance limit or cut-off of the
    curve, since no amplitude, corrected for its mean, exceeds the largest stress. The bounds of
    `hot_spots` exclude most of these sites without computing their stress.

    Parameters
    ----------
    source : StressField or DutyCycle
        Stress of a run (`stress_field`), or a duty cycle of several runs.
    sn : SN
        S-N curve.
    criterion : str or Plane
        Stress that is counted: "signed-von-mises", "signed-principal", a component such as
        "s11", a `Plane`, or "critical-plane": the normal stress on the plane of the largest
        damage. "von-mises" is not allowed: it has no sign, so that a full reversal would be two
        small cycles.
    residue : str
        "half", "repeat" or "ignore", see `rainflow`.
    mean : MeanStress, optional
        Mean stress correction.
    required : float, optional
        Required life for the safety, s; None is one repetition of the history.
    allowable : float
        Allowable Miner's sum.
    survival : float, optional
        Probability of survival of the results; None: that of the curve.
    planes : int
        Number of normals on a half-sphere for "critical-plane". The coordinate axes and the
        principal directions at the extreme instants are added, and the best normal is refined to
        about a degree. Exact for constant principal directions, otherwise approximate.

    Raises
    ------
    InputError
        If the residue rule is missing, the criterion has no sign, or a value is invalid.

    Warns
    -----
    JoustoWarning
        If stresses and curve seem to be in different units, or a stress is above S_u.
    """
    where = "damage_field"
    rule = check_residue(residue, where)
    if not isinstance(source, StressField | DutyCycle):
        raise InputError(
            Problem(
                where,
                f"source is {source!r}, must be a StressField or a DutyCycle: "
                "jo.stress_field(run, body)",
            )
        )
    duty = source if isinstance(source, DutyCycle) else DutyCycle([(source, 1.0)])
    check_duty(duty, rule)
    field = duty.field
    problems = Problems()
    problems.positive(where, "allowable", allowable, "")
    if required is not None:
        problems.positive(where, "required", required, "s")
    if planes < 3 or planes != int(planes):
        problems.add(where, f"planes is {planes!r}, must be a whole number from 3 on")
    if field.strain:
        problems.add(where, "source is a field of strain, must be stress: strain=False")
    if criterion in ("von-mises", "max-shear"):
        problems.add(
            where,
            f"{criterion!r} has no sign: a full reversal would count as two cycles of half the"
            ' amplitude; take "signed-von-mises", "signed-principal" or "critical-plane"',
        )
    problems.raise_if_any()
    if criterion != CRITICAL_PLANE:
        check_criterion(criterion, field.strain)
    for event in duty.events:
        if event.source.nt < 2:
            raise InputError(
                Problem(where, "a field has one instant; give one of two or more instants")
            )
    curve = sn if survival is None or survival == sn.survival else sn.at_survival(survival)
    work = _Work(duty, reference(curve, mean), mean, criterion, rule)
    wanted = duty.duration if required is None else required
    share = allowable * duty.duration / wanted

    ns = field.ns
    damages, safety = np.zeros(ns), np.full(ns, np.inf)
    peak, counted, exact = np.zeros(ns), np.ones(ns, dtype=bool), np.ones(ns, dtype=bool)
    normals = np.zeros((ns, 3)) if criterion == CRITICAL_PLANE else None
    largest = 0.0
    limit = work.curve.S_limit
    directions = half_sphere(planes)
    bound = work.bounds() if limit > 0.0 else None
    candidates = np.arange(ns) if bound is None else np.flatnonzero(bound >= limit)
    if bound is not None:
        left = bound < limit
        counted[left], peak[left], safety[left] = False, bound[left], limit / bound[left]
        exact[left] = False
    for places, histories in work.chunks(candidates):
        peak[places] = _farthest(np.concatenate([_farthest(h)[None] for h in histories]))
        top = np.abs(peak[places])
        for column, i in enumerate(places.tolist()):
            if top[column] < limit:
                counted[i] = False
                safety[i] = limit / top[column] if top[column] > 0.0 else math.inf
                continue
            if normals is None:
                columns = [h[:, column] for h in histories]
                damages[i], safety[i], amplitude = work.count(columns, share)
            else:
                damages[i], safety[i], amplitude, normals[i] = work.plane(i, directions, share)
            largest = max(largest, amplitude)
    if not np.all(np.isfinite(peak)):
        bad = field.labels[int(np.argmin(np.isfinite(peak)))]
        raise InputError(Problem(where, f"the stress at {bad} is not finite"))
    check_stress(curve, largest, float(np.abs(peak).max(initial=0.0)), mean, where)
    nodes = field.modes.nodes
    return DamageField(
        field.name,
        field.labels,
        field.positions,
        None if nodes is None else np.asarray(nodes, dtype=np.int64),
        damages,
        safety,
        peak,
        counted,
        normals,
        duty.duration,
        wanted,
        allowable,
        criterion,
        rule,
        duty.transitions if len(duty.events) > 1 else "none",
        curve,
        mean,
        exact,
    )


def _farthest(values: Array) -> Array:
    """Return the value of the largest magnitude, with its sign, of each column of (nt, k)."""
    at = np.argmax(np.abs(values), axis=0)
    return np.asarray(values[at, np.arange(values.shape[1])])


def site_cycles(
    source: StressField | DutyCycle,
    site: str,
    *,
    criterion: Criterion = "signed-von-mises",
    residue: str | None = None,
) -> Cycles:
    """Return the cycles of a stress site, as `damage_field` counts them.

    Parameters
    ----------
    source, criterion, residue
        As for `damage_field`; for a critical plane give its `Plane`.
    site : str
        Label of the site.

    Raises
    ------
    InputError
        If there is no such site, or the residue rule is missing.
    """
    rule = check_residue(residue, "site_cycles")
    duty = source if isinstance(source, DutyCycle) else DutyCycle([(source, 1.0)])
    check_duty(duty, rule)
    histories = [event.source.values(criterion, sites=[site])[:, 0] for event in duty.events]
    return count_duty(histories, [e.repeats for e in duty.events], duty.transitions, rule)


class _Work:
    """Counting of the sites of a duty cycle, with curve, criterion and rules."""

    def __init__(
        self,
        duty: DutyCycle,
        curve: SN,
        mean: MeanStress | None,
        criterion: Criterion,
        residue: str,
    ) -> None:
        self.duty, self.curve, self.mean = duty, curve, mean
        self.criterion, self.residue = criterion, residue
        self.repeats = [event.repeats for event in duty.events]
        self.fields: list[StressField] = [event.source for event in duty.events]

    @property
    def bounding(self) -> Criterion:
        """Criterion whose largest magnitude is an upper bound of all amplitudes."""
        return "signed-principal" if self.criterion == CRITICAL_PLANE else self.criterion

    def bounds(self) -> Array | None:
        """Return upper bounds (ns,) of the stress in all events, Pa; None for rotating axes."""
        if any(f.A is not None for f in self.fields):
            return None
        sought = measure(self.bounding, "magnitude")
        found = [
            prepare(f.S, f.p, sought).whole() if f.columns is None else largest(f, self.bounding)
            for f in self.fields
        ]
        return np.asarray(np.max(found, axis=0))

    def chunks(self, chosen: Index) -> Iterator[tuple[Index, list[Array]]]:
        """Yield indices of sites and their stress histories (nt, sites) in each event."""
        rows = sum(f.nt for f in self.fields)
        width = max(1, min(len(chosen), MEMORY // (8 * rows)))
        for start in range(0, len(chosen), width):
            places = chosen[start : start + width]
            size = 16 * rows * len(places)
            yield places, [f.take(places).values(self.bounding, memory=size) for f in self.fields]

    def cycles(self, histories: Sequence[Array]) -> Cycles:
        """Return the cycles of one site."""
        return count_duty(histories, self.repeats, self.duty.transitions, self.residue)

    def count(self, histories: Sequence[Array], share: float) -> tuple[float, float, float]:
        """Return damage, safety and the largest amplitude of one site."""
        cycles = self.cycles(histories)
        if not len(cycles):
            return 0.0, math.inf, 0.0
        largest = float(cycles.amplitude.max())
        if proportional(self.mean):
            S = equivalents(cycles, self.mean)
            spectrum = Spectrum(S, cycles.count, self.curve)
            return spectrum.damage(), spectrum.factor(share), largest
        D = _sum(cycles, self.curve, self.mean)
        return D, stress_safety(cycles, self.curve, self.mean, allowable=share), largest

    def plane(
        self, place: int, directions: Array, share: float
    ) -> tuple[float, float, float, Array]:
        """Return damage, safety, amplitude and normal of the plane with the largest damage."""
        histories = [f.take([place]).history(None)[:, 0] for f in self.fields]
        best = (-1.0, math.inf, 0.0, directions[0])

        def tried(
            n: Array, best: tuple[float, float, float, Array]
        ) -> tuple[float, float, float, Array]:
            w = np.stack([n[:, i] * n[:, j] * (1.0 if i == j else 2.0) for i, j in PAIRS])
            sigma = [h @ w for h in histories]
            for k in range(len(n)):
                D, f, a = self.count([s[:, k] for s in sigma], share)
                if (D, -f) > (best[0], -best[1]):
                    best = (D, f, a, n[k])
            return best

        best = tried(np.concatenate([special_normals(np.concatenate(histories)), directions]), best)
        step = 1.0 / math.sqrt(
            len(directions)
        )  # half of the spacing of the normals, rad: 4 degrees for 200
        for _ in range(3):
            best = tried(_around(best[3], step), best)
            step /= 2.0
        return best
