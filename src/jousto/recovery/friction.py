"""Stress due to friction: difference of runs with and without the friction of the joints."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, warn
from jousto.base.files import write_table
from jousto.base.object_repr import described
from jousto.base.ranking import ranking
from jousto.mechanism.event import Event
from jousto.mechanism.forces.friction import Friction
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.loads import ForceSensor
from jousto.recovery.fields.build import field_from, stress_field
from jousto.recovery.fields.criteria import evaluate
from jousto.recovery.fields.field import StressField
from jousto.recovery.fields.places import Sites
from jousto.recovery.shape import find_body
from jousto.reduction.reduced import ReducedPart
from jousto.simulation.results.events import FRICTION_CHANGES
from jousto.simulation.results.solution import Solution

BLOCK_BYTES = 32 << 20  # memory of stress values at a time, bytes
SAME = 1e-9  # difference of instants, s or relative, below which they are equal


@dataclass(frozen=True)
class Transition:
    """Stick-slip transition, with the change of the stress of a body after it.

    Attributes
    ----------
    time : float
        Instant of the transition, s.
    friction, joint : str
        Names of the friction and of its joint.
    change : str
        "sticks", "slips forward" or "slips backward".
    site : str
        Site with the largest change of the stress due to friction until the next transition.
    jump : float
        Von Mises stress of this change, Pa; nan if no instant is stored until the next transition.
    at : float
        Instant of the largest change, s.
    stress : float
        Von Mises stress at this site and instant, with friction, Pa.
    """

    time: float
    friction: str
    joint: str
    change: str
    site: str
    jump: float
    at: float
    stress: float

    def __str__(self) -> str:
        if np.isnan(self.jump):
            return (
                f"{self.time:.6g} s: {self.friction} ({self.joint}) {self.change}; between"
                " stored instants, its stress is not known"
            )
        return (
            f"{self.time:.6g} s: {self.friction} ({self.joint}) {self.change}; {self.site} by"
            f" {self.jump / 1e6:.4g} MPa at {self.at:.6g} s, then {self.stress / 1e6:.4g} MPa"
        )


@described
@dataclass(frozen=True, eq=False)
class FrictionStress:
    """Stress of a body with friction, without friction, and the difference.

    Attributes
    ----------
    body : str
        Name of the body.
    with_friction, without_friction, due : StressField
        Stress fields at the same instants; `due` is the difference of the components.
    transitions : tuple of Transition
        Stick-slip transitions in the order of time; empty for the regularised law.
    """

    body: str
    with_friction: StressField
    without_friction: StressField
    due: StressField
    transitions: tuple[Transition, ...] = field(default=())

    @property
    def time(self) -> Array:
        """Instants (nt,), s."""
        return self.due.time

    def history(self, site: str | int) -> Array:
        """Return the stress due to friction at a site, (nt, 6), Pa."""
        return self.due.history(site)

    def change(self, criterion: Any = "von-mises", sites: Sites = None) -> Array:
        """Return the criterion with friction minus the criterion without, (nt, ns), Pa.

        For a stress component it is the component of `due`.
        """
        return np.asarray(
            self.with_friction.values(criterion, sites)
            - self.without_friction.values(criterion, sites)
        )

    def peaks(self, count: int = 10) -> tuple[Transition, ...]:
        """Return the transitions with the largest changes of the stress, in descending order.

        Transitions with equal changes, as in a periodic motion, are in the order of time.
        """
        order = ranking([np.nan_to_num(t.jump) for t in self.transitions])[:count]
        return tuple(self.transitions[i] for i in order)

    def table(self, count: int = 10) -> list[dict[str, Any]]:
        """Return the sites with the largest stress due to friction, in descending order.

        A row has the site, its position, m, the largest von Mises stress due to friction, Pa, its
        instant, s, and the largest von Mises stresses with and without friction, Pa.
        """
        due = self.due.envelope("von-mises")
        rubbed = self.with_friction.envelope("von-mises")
        smooth = self.without_friction.envelope("von-mises")
        order = ranking(due.max, due.labels)[:count]
        return [
            {
                "site": self.due.labels[i],
                "position": tuple(float(x) for x in self.due.positions[i]),
                "due": float(due.max[i]),
                "time": float(due.max_time[i]),
                "with": float(rubbed.max[i]),
                "without": float(smooth.max[i]),
            }
            for i in order
        ]

    def to_csv(self, path: str | Path, count: int | None = None) -> None:
        """Write the table of sites and, below it, the table of transitions."""
        head = ["site", "x (m)", "y (m)", "z (m)", "due to friction (Pa)", "at (s)"]
        head += ["with friction (Pa)", "without friction (Pa)"]
        rows: list[list[Any]] = [
            [row["site"], *row["position"]]
            + [row[key] for key in ("due", "time", "with", "without")]
            for row in self.table(self.due.ns if count is None else count)
        ]
        if self.transitions:
            rows.append([])
            rows.append(
                ["time (s)", "friction", "joint", "change", "site", "jump (Pa)", "at (s)"]
                + ["von Mises (Pa)"]
            )
        rows += [
            [t.time, t.friction, t.joint, t.change, t.site, t.jump, t.at, t.stress]
            for t in self.transitions
        ]
        write_table(path, head, rows)

    def __str__(self) -> str:
        lines = [
            f"stress of {self.body} due to friction, von Mises, MPa, {len(self.time)} instants"
            f" from {self.time[0]:g} to {self.time[-1]:g} s",
            f"  {'site':<16} {'friction':>10} {'at s':>10} {'with':>10} {'without':>10}",
        ]
        lines += [
            f"  {row['site']:<16} {row['due'] / 1e6:>10.4g} {row['time']:>10.4g}"
            f" {row['with'] / 1e6:>10.4g} {row['without'] / 1e6:>10.4g}"
            for row in self.table()
        ]
        if self.transitions:
            lines.append(f"{len(self.transitions)} transitions between stick and slip, the largest")
            lines += [f"  {t}" for t in self.peaks()]
        return "\n".join(lines)


@explained
def friction_stress(
    with_run: Solution,
    without_run: Solution,
    body: str,
    *,
    reduced: ReducedPart | None = None,
    sites: Sites = None,
    start: float | None = None,
    end: float | None = None,
    window: float | None = None,
) -> FrictionStress:
    """Return the stress of a body due to the friction of joints.

    Two runs of a machine, with and without friction, are compared at the instants of the first.
    The modal coordinates of the second run are interpolated to these instants by cubics through
    values and rates. The stress is linear in them, so that the difference of the components is
    exact. Each stick-slip transition is listed with the site whose stress due to friction changes
    most until the next transition, or within `window`.

    Parameters
    ----------
    with_run, without_run : Solution
        Results with and without friction; see `without_friction`.
    body : str
        Name of a flexible body of both runs.
    reduced, sites
        As for `stress_field`.
    start, end : float, optional
        First and last instant, s.
    window : float, optional
        Longest time after a transition to search, s; None is up to the next transition.

    Raises
    ------
    InputError
        If the time spans of the runs do not overlap, or their bodies differ.

    Warns
    -----
    JoustoWarning
        If the first run lost no energy to friction, or the second run lost some.
    """
    where = f"friction stress of '{body}'"
    rubbed = stress_field(with_run, body, reduced=reduced, sites=sites)
    other = stress_field(without_run, body, reduced=reduced, sites=sites)
    problems = Problems()
    if rubbed.S.shape != other.S.shape or not np.allclose(
        rubbed.S, other.S, rtol=1e-9, atol=1e-9 * float(np.abs(rubbed.S).max(initial=0.0))
    ):
        problems.add(
            where, "the two runs have different parts of this name; use runs of the same parts"
        )
    if window is not None:
        problems.number(where, "window", window, "s", "a positive number", lambda x: x > 0.0)
    first, last = _common(problems, where, with_run, without_run, start, end)
    problems.raise_if_any()
    _check_order(where, with_run, without_run)
    time = with_run.time
    near = SAME * max(1.0, abs(last))
    time = time[(time >= first - near) & (time <= last + near)]
    if not len(time):
        raise InputError(
            Problem(where, f"no instant of {with_run.where} from {first:g} to {last:g} s")
        )
    p, p0 = coordinates_at(with_run, body, time), coordinates_at(without_run, body, time)
    modes = rubbed.modes
    fields = [field_from(modes, x, time, name=body) for x in (p, p0, p - p0)]
    changes = [
        event
        for event in with_run.events
        if event.change in FRICTION_CHANGES and first <= event.time <= last
    ]
    transitions = tuple(
        _transition(
            (with_run, without_run),
            (fields[0], fields[2]),
            event,
            min(
                changes[k + 1].time if k + 1 < len(changes) else last,
                last if window is None else event.time + window,
            ),
        )
        for k, event in enumerate(changes)
    )
    return FrictionStress(body, fields[0], fields[1], fields[2], transitions)


def _common(
    problems: Problems,
    where: str,
    one: Solution,
    two: Solution,
    start: float | None,
    end: float | None,
) -> tuple[float, float]:
    """Return the first and last instant that both runs and the time window contain."""
    spans = [
        (float(run.time[0]), float(run.time[-1])) if run.nt else (1.0, 0.0) for run in (one, two)
    ]
    first = max(*(span[0] for span in spans), -np.inf if start is None else start)
    last = min(*(span[1] for span in spans), np.inf if end is None else end)
    if not first <= last:
        text = " and ".join(f"{a:g} to {b:g} s" for a, b in spans)
        asked = "" if start is None and end is None else " in the time that is asked for"
        problems.add(where, f"the runs, {text}, have no instants in common{asked}")
        return 0.0, 0.0
    return first, last


def _check_order(where: str, with_run: Solution, without_run: Solution) -> None:
    lost = [
        float(run.energy.friction[-1] - run.energy.friction[0]) for run in (with_run, without_run)
    ]
    if lost[1] > 1e-9 * abs(lost[0]) and lost[1] > 0.0:
        warn(
            where,
            f"the run without friction lost {lost[1]:.4g} J to friction; check the order of the "
            "runs",
        )
    elif lost[0] == 0.0:
        warn(where, "the run with friction lost no energy to friction: all friction sticks or is 0")


def coordinates_at(run: Solution, body: str, times: Array) -> Array:
    """Return modal coordinates (nt, n) at given instants, by cubics through values and rates."""
    shape = find_body(run, body)
    known = run.time
    p = run.q[:, shape.q_offset + 7 : shape.q_offset + 7 + shape.n]
    rate = run.v[:, shape.v_offset + 6 : shape.v_offset + 6 + shape.n]
    k = np.clip(np.searchsorted(known, times, side="right") - 1, 0, max(len(known) - 2, 0))
    if len(known) == 1:
        return np.repeat(p, len(times), axis=0)
    h = (known[k + 1] - known[k])[:, None]
    u = np.clip((times - known[k])[:, None] / np.where(h > 0.0, h, 1.0), 0.0, 1.0)
    between = (
        (1.0 + 2.0 * u) * (1.0 - u) ** 2 * p[k]
        + u * (1.0 - u) ** 2 * h * rate[k]
        + u**2 * (3.0 - 2.0 * u) * p[k + 1]
        - u**2 * (1.0 - u) * h * rate[k + 1]
    )
    # exact values at stored instants
    return np.where(u == 0.0, p[k], np.where(u == 1.0, p[k + 1], between))


def _transition(
    runs: tuple[Solution, Solution],
    fields: tuple[StressField, StressField],
    event: Any,
    until: float,
) -> Transition:
    """Return a transition with the largest change of the stress until the next one."""
    rubbed, due = fields
    time = due.time
    instants = np.array([event.time])
    before = coordinates_at(runs[0], due.name, instants) - coordinates_at(
        runs[1], due.name, instants
    )
    rows = np.flatnonzero((time >= event.time) & (time <= until + SAME))
    best = (-1.0, 0, 0)  # jump, row, place
    size = max(1, BLOCK_BYTES // (8 * 6 * max(due.ns, 1)))
    for first in range(0, len(rows), size):
        piece = rows[first : first + size]
        value = evaluate(np.einsum("scj,tj->tsc", due.S, due.p[piece] - before), "von-mises")
        top = int(np.argmax(value))
        if value.flat[top] > best[0]:
            best = float(value.flat[top]), int(piece[top // due.ns]), top % due.ns
    jump, row, place = best
    if jump < 0.0:  # nothing is stored until the next transition
        row, jump = int(np.argmin(np.abs(time - event.time))), float("nan")
    stress = evaluate(rubbed.S[place] @ rubbed.p[row], "von-mises")
    unknown = bool(np.isnan(jump))
    return Transition(
        time=event.time,
        friction=event.name,
        joint=event.joint,
        change=event.change,
        site="" if unknown else due.labels[place],
        jump=jump,
        at=float(time[row]),
        stress=float("nan") if unknown else float(stress),
    )


@explained
def without_friction(mechanism: Mechanism) -> Mechanism:
    """Return a mechanism without the friction of its joints.

    Sensors of friction forces, and events and damage sensors that use them, are removed too.

    Parameters
    ----------
    mechanism : Mechanism
        Mechanism with at least one `Friction`.

    Raises
    ------
    InputError
        If the mechanism has no friction, or a removed event switches a signal.
    """
    if not mechanism.frictions:
        raise InputError(Problem(f"mechanism '{mechanism.name}'", "has no friction to remove"))
    gone = {
        id(sensor)
        for sensor in mechanism.sensors
        if isinstance(sensor, ForceSensor) and isinstance(sensor.force, Friction)
    }
    gone |= {
        id(sensor)
        for sensor in mechanism.sensors
        if any(id(meter.sensor) in gone for meter in sensor.meters)
    }
    items = [
        item
        for item in mechanism.items
        if not isinstance(item, Friction)
        and id(item) not in gone
        and not (isinstance(item, Event) and id(item.watch) in gone)
    ]
    return Mechanism(*items, name=mechanism.name, core=mechanism.core)
