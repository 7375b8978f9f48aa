"""Damage at every place of a body."""

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
from jousto.fatigue.cycles.duty import DutyCycle, check_duty, count_duty
from jousto.fatigue.cycles.rainflow import Cycles, check_residue
from jousto.fatigue.miner.damage import (
    _sum,
    check_stress,
    equivalents,
    proportional,
    reference,
    stress_safety,
    told,
)
from jousto.fatigue.miner.spectrum import Spectrum
from jousto.materials.strength.mean_stress import MeanStress
from jousto.materials.strength.sn import SN
from jousto.recovery.fields.criteria import Criterion, Plane, check_criterion
from jousto.recovery.fields.field import StressField
from jousto.recovery.hotspots.bounds import prepare
from jousto.recovery.hotspots.exhaustive_beams import largest
from jousto.recovery.hotspots.measures import measure

CRITICAL_PLANE = "critical-plane"
MEMORY = 64 << 20
"""Bytes of the histories that are counted at a time."""

SHOWN = 10  # places in a table


@described
@dataclass(frozen=True, eq=False)
class DamageField(Tabular):
    """Damage, life and safety at every place of a body.

    Attributes
    ----------
    body : str
        Name of the body.
    labels : tuple of str
        Places (ns).
    positions : (ns, 3) array
        Where they are, part frame, m.
    nodes : (ns,) int array or None
        Their nodes from 0.
    damage : (ns,) array
        Miner's sum of the history or duty cycle, once.
    safety : (ns,) array
        Factor on all stresses with which the allowable sum is reached in the required life. Of
        pruned places a lower bound.
    peak : (ns,) array
        Stress of the largest magnitude, with its sign, Pa; where it is not `exact` an upper bound
        of the magnitude.
    counted : (ns,) bool array
        Whether cycles were counted. Those of other places are all below the endurance limit: the
        largest magnitude of their stress is, by a bound or worked out.
    normals : (ns, 3) array or None
        Of the criterion "critical-plane", the normal of the plane with the largest damage.
    duration, required, allowable : float
        Of the history, s; life required, s; Miner's sum allowed.
    criterion : str or Plane
        The stress that was counted.
    residue, transitions : str
        How it was counted.
    sn : SN
        The curve.
    mean : MeanStress or None
        The mean stress correction.
    exact : (ns,) bool array
        Whether the peak was worked out.
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
        """Life (ns,), s: ``allowable duration / damage``; inf for ever."""
        with np.errstate(divide="ignore"):
            return np.asarray(self.allowable * self.duration / self.damage)

    @property
    def pruned(self) -> int:
        """Places that cannot be damaged, by their largest stress."""
        return int(np.count_nonzero(~self.counted))

    def cycles(self, source: StressField | DutyCycle, site: str | None = None) -> Cycles:
        """Return the cycles of a place, the worst one if None, of the source it was made from."""
        label = self.worst(1)[0] if site is None else site
        criterion = self.criterion
        if self.normals is not None:
            normal = self.normals[self.labels.index(label)]
            criterion = Plane(normal) if np.any(normal) else "signed-principal"
        return site_cycles(source, label, criterion=criterion, residue=self.residue)

    def worst(self, count: int = SHOWN) -> list[str]:
        """Return the labels of the places with the largest damage, then the least safety."""
        return [self.labels[i] for i in self._order()[:count]]

    def at(self, site: str) -> tuple[float, float, float]:
        """Return damage, life (s) and safety of a place.

        Raises
        ------
        InputError
            If there is no such place.
        """
        if site not in self.labels:
            raise InputError(Problem("damage", f"no site '{site}'{suggest(site, self.labels)}"))
        i = self.labels.index(site)
        return float(self.damage[i]), float(self.life[i]), float(self.safety[i])

    def _order(self) -> NDArray[np.intp]:
        return ranking(self.damage, self.labels, then=-self.safety)

    def table(self, count: int = SHOWN) -> list[tuple[str, ...]]:
        """Return the head and the worst places as rows of text."""
        rows: list[tuple[str, ...]] = [
            ("site", "position (mm)", "peak (MPa)", "damage", "life", self.safety_of)
        ]
        for i in self._order()[:count]:
            place = " ".join(f"{1e3 * x:.4g}" for x in self.positions[i])
            some = abs(self.peak[i]) > SHARE * self.sn.S_D  # more than rounding
            least = "" if some and self.counted[i] else "> "
            rows.append(
                (
                    self.labels[i],
                    place,
                    f"{'' if self.exact[i] else '< '}{self.peak[i] / 1e6:.5g}" if some else "0",
                    f"{self.damage[i]:.5g}",
                    told(float(self.life[i])),
                    f"{least}{min(float(self.safety[i]), 1.0 / SHARE):.4g}",
                )
            )
        return rows

    @property
    def once(self) -> bool:
        """Whether the safety is that of one pass of the history, for no life was required."""
        return self.required == self.duration

    @property
    def safety_of(self) -> str:
        """What the safety is of."""
        return f"safety {'of one pass' if self.once else 'for the life required'}"

    def head(self) -> list[tuple[str, str]]:
        """Return how it was counted, as pairs of name and text."""
        mean = "not corrected" if self.mean is None else str(self.mean)
        required = f", required {told(self.required)}"
        if self.once:
            required = " once, which the safety is for; give the life required for that of a life"
        return [
            ("body", f"{self.body}, {len(self)} places, {self.pruned} below the endurance limit"),
            ("stress", f"{self.criterion}, mean stress: {mean}"),
            ("S-N curve", str(self.sn)),
            ("cycles", f"rainflow, residue: {self.residue}, transitions: {self.transitions}"),
            ("history", f"{told(self.duration)}{required}, damage allowed {self.allowable:g}"),
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
        """Return every place with its damage, life and safety."""
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


def half_sphere(count: int) -> Array:
    """Return unit normals (count, 3) spread evenly over half a sphere (Fibonacci's spiral)."""
    k = np.arange(count) + 0.5
    z = k / count
    turn = np.pi * (1.0 + 5.0**0.5) * k
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)


PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))  # of the six components


def special_normals(history: Array) -> Array:
    """Return unit normals (12, 3) that a grid would miss.

    The principal directions at the instants of the largest and the smallest principal stress, those
    of the change between the two, and the coordinate axes.

    Parameters
    ----------
    history : (nt, 6) array
        Components of the stress.
    """
    T = history[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]
    principal = np.linalg.eigvalsh(T)
    high, low = T[int(np.argmax(principal[:, 2]))], T[int(np.argmin(principal[:, 0]))]
    vectors = [np.linalg.eigh(x)[1].T for x in (high, low, high - low)]
    return np.concatenate([*vectors, np.eye(3)])


def _around(normal: Array, angle: float) -> Array:
    """Return six unit normals (6, 3) at an angle (rad) from one."""
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
    """Return damage, life and safety at every place of a body.

    Places whose largest stress is below the endurance limit or cut-off of the curve are not
    counted: no amplitude, corrected for its mean, is larger than the largest stress. Most of them
    are found by the bounds of `hot_spots`, without working out their stress.

    Parameters
    ----------
    source : StressField or DutyCycle
        Stress of a run (`stress_field`), or several with their repeats.
    sn : SN
        The S-N curve.
    criterion : str or Plane
        The stress that is counted: "signed-von-mises", "signed-principal", a component such as
        "s11", a `Plane`, or "critical-plane": the normal stress on the plane where it does most
        damage. "von-mises" has no sign, so that a full reversal looks like two small cycles; it is
        refused.
    residue : str
        "half", "repeat" or "ignore", see `rainflow`.
    mean : MeanStress, optional
        Mean stress correction.
    required : float, optional
        Life required, s, for the safety; once through the history if None.
    allowable : float
        Miner's sum that is allowed.
    survival : float, optional
        Probability of survival at which it is valid; that of the curve if None.
    planes : int
        Normals tried for "critical-plane", spread over half a sphere, besides the coordinate axes
        and the principal directions at the extreme instants; the best is refined to about a
        degree. Exact where the principal axes stand still; else a search, not a proof.

    Raises
    ------
    InputError
        If the residue rule is missing, the criterion makes no cycles, or a value is impossible.

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
        problems.add(where, "counts stress, not strain: make the field with strain=False")
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
            raise InputError(Problem(where, "a field has one instant; cycles need a history"))
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
    """Return of each column of (nt, k) the value of the largest magnitude, with its sign."""
    at = np.argmax(np.abs(values), axis=0)
    return np.asarray(values[at, np.arange(values.shape[1])])


def site_cycles(
    source: StressField | DutyCycle,
    site: str,
    *,
    criterion: Criterion = "signed-von-mises",
    residue: str | None = None,
) -> Cycles:
    """Return the cycles of one place, as `damage_field` counts them.

    Parameters
    ----------
    source, criterion, residue
        As for `damage_field`; of a critical plane give its `Plane`.
    site : str
        Label of the place.

    Raises
    ------
    InputError
        If there is no such place, or the residue rule is missing.
    """
    rule = check_residue(residue, "site_cycles")
    duty = source if isinstance(source, DutyCycle) else DutyCycle([(source, 1.0)])
    check_duty(duty, rule)
    histories = [event.source.values(criterion, sites=[site])[:, 0] for event in duty.events]
    return count_duty(histories, [e.repeats for e in duty.events], duty.transitions, rule)


class _Work:
    """Counts the places of a duty cycle one after the other."""

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
        """The criterion whose magnitude no amplitude exceeds."""
        return "signed-principal" if self.criterion == CRITICAL_PLANE else self.criterion

    def bounds(self) -> Array | None:
        """Return bounds (ns,) of the largest stress in all events, Pa; None in turning axes."""
        if any(f.A is not None for f in self.fields):
            return None
        sought = measure(self.bounding, "magnitude")
        found = [
            prepare(f.S, f.p, sought).whole() if f.columns is None else largest(f, self.bounding)
            for f in self.fields
        ]
        return np.asarray(np.max(found, axis=0))

    def chunks(self, chosen: Index) -> Iterator[tuple[Index, list[Array]]]:
        """Yield places and the stress (nt, places) in each event, whole histories."""
        rows = sum(f.nt for f in self.fields)
        width = max(1, min(len(chosen), MEMORY // (8 * rows)))
        for start in range(0, len(chosen), width):
            places = chosen[start : start + width]
            size = 16 * rows * len(places)
            yield places, [f.take(places).values(self.bounding, memory=size) for f in self.fields]

    def cycles(self, histories: Sequence[Array]) -> Cycles:
        """Return the cycles of one place."""
        return count_duty(histories, self.repeats, self.duty.transitions, self.residue)

    def count(self, histories: Sequence[Array], share: float) -> tuple[float, float, float]:
        """Return damage, safety and the largest amplitude of one place."""
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
        """Return damage, safety, largest amplitude and normal of the plane with most damage."""
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
        step = 1.0 / math.sqrt(len(directions))  # 4 degrees of 200
        for _ in range(3):
            best = tried(_around(best[3], step), best)
            step /= 2.0
        return best
