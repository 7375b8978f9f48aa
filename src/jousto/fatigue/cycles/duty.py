"""Duty cycles: events of the life of a part with their numbers of repetitions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.object_repr import described
from jousto.fatigue.cycles.rainflow import (
    Cycles,
    check_history,
    check_residue,
    close,
    count_turning,
    rainflow,
    turning_points,
)
from jousto.recovery.fields.field import StressField

TRANSITIONS = ("separate", "sequence", "worst")
"""Rules for the transitions between the events of a duty cycle."""

_EXPLAIN = (
    'give "separate" (each event is counted alone; cycles from the peak of one event to the valley'
    ' of another are neglected), "sequence" (the events follow in this order, each with all its'
    ' repetitions before the next) or "worst" (any order: the highest peak of all pairs with the'
    " lowest valley)"
)


@described
@dataclass(frozen=True, eq=False)
class DutyEvent:
    """Event of a duty cycle: stress histories with a number of repetitions.

    Parameters
    ----------
    source : StressField or (nt,) array_like
        Stress of a body during the event, Pa; an array is the history of a single site.
    repeats : float
        Number of repetitions in one duty cycle.
    name : str
        Name in tables.
    duration : float, optional
        Duration of one repetition, s; the default for a field is the time of its run.

    Raises
    ------
    InputError
        If the repeats are not positive, or the source is neither a field nor an array.
    """

    source: Any
    repeats: float = 1.0
    name: str = ""
    duration: float | None = None

    def __post_init__(self) -> None:
        where = f"event '{self.name}'" if self.name else "event"
        problems = Problems()
        wanted = "a positive number"
        problems.number(where, "repeats", self.repeats, "", wanted, lambda x: x > 0.0)
        if self.duration is not None:
            problems.positive(where, "duration", self.duration, "s")
        problems.raise_if_any()
        if not isinstance(self.source, StressField):
            object.__setattr__(self, "source", check_history(self.source, where))

    @property
    def seconds(self) -> float:
        """Duration of one repetition, s; 1 if it is not known."""
        if self.duration is not None:
            return float(self.duration)
        if isinstance(self.source, StressField):
            return float(self.source.time[-1] - self.source.time[0]) or 1.0
        return 1.0


@explained
@described
@dataclass(frozen=True, eq=False, init=False)
class DutyCycle:
    """Events with their numbers of repetitions and the rule for the transitions between them.

    Parameters
    ----------
    events : sequence of DutyEvent, or of tuples (source, repeats) or (source, repeats, name)
        Fields of the same sites, from one or several results; or histories of one site.
    transitions : str
        "separate", "sequence" or "worst"; needed if there are several events.

        * separate: each event is counted alone, by the residue rule. Cycles between the peak of
          one event and the valley of another are neglected; exact if the stress returns to zero
          between events.
        * sequence: all repetitions of the first event, then of the second ...; the result is the
          exact rainflow count of the whole history, of any length.
        * worst: any order. Cycles that close within an event are counted; the open peaks and
          valleys of all events are paired, the highest with the lowest (as ASME III, NB-3222.4
          sums ranges). This is an upper bound of the damage of all orders for a curve without
          limit and without mean stress correction; with an endurance limit, cut-off or correction
          compare with "separate". For ``residue="repeat"``.

    Raises
    ------
    InputError
        If transitions are missing, or the events have different sites or types.

    Examples
    --------
    >>> lift, stop = [0, 80e6, 0], [0, -60e6, 0]
    >>> duty = DutyCycle([(lift, 1000, "lift"), (stop, 10, "stop")], transitions="worst")
    >>> duty.cycles(residue="repeat").sums()
    {80000000.0: 990.0, 140000000.0: 10.0}
    """

    events: tuple[DutyEvent, ...]
    transitions: str

    def __init__(self, events: Iterable[Any], *, transitions: str | None = None) -> None:
        where = "DutyCycle"
        problems = Problems()
        made: list[DutyEvent] = []
        for i, item in enumerate(events):
            if isinstance(item, tuple | list) and 1 < len(item) < 4 and not np.isscalar(item[0]):
                made.append(DutyEvent(*item))
            elif isinstance(item, DutyEvent):
                made.append(item)
            else:
                problems.add(where, f"events[{i}] must be a DutyEvent or (field, repeats)")
        if not made and not problems.found:
            problems.add(where, "has no events; give one or more (field, repeats)")
        if len(made) > 1 and transitions is None:
            problems.add(where, f"transitions is missing: {_EXPLAIN}")
        elif transitions is not None and transitions not in TRANSITIONS:
            hint = suggest(transitions, TRANSITIONS)
            problems.add(where, f"transitions is {transitions!r}{hint}: {_EXPLAIN}")
        if transitions == "sequence":
            for i, event in enumerate(made):
                if event.repeats != int(event.repeats):
                    problems.add(
                        where,
                        f"events[{i}] is repeated {event.repeats:g} times; a sequence needs whole"
                        " numbers",
                    )
        fields = [event.source for event in made if isinstance(event.source, StressField)]
        if fields and len(fields) != len(made):
            problems.add(where, "some events are fields, others single histories; give one kind")
        for i, other in enumerate(fields[1:], start=1):
            if other.labels != fields[0].labels:
                problems.add(
                    where,
                    f"events[{i}] with {other.ns} sites and events[0] with {fields[0].ns} sites"
                    " differ; all events must be of the same part and sites",
                )
        problems.raise_if_any()
        object.__setattr__(self, "events", tuple(made))
        object.__setattr__(self, "transitions", transitions or "separate")

    @property
    def duration(self) -> float:
        """Duration of one duty cycle, s."""
        return float(sum(event.seconds * event.repeats for event in self.events))

    @property
    def field(self) -> StressField:
        """Field of the first event, for the sites and their names.

        Raises
        ------
        InputError
            If the events are histories of one site.
        """
        source = self.events[0].source
        if not isinstance(source, StressField):
            raise InputError(Problem("DutyCycle", "its events are histories, not fields"))
        return source

    def cycles(self, *, residue: str | None = None) -> Cycles:
        """Return the cycles of the duty cycle of a single site.

        Parameters
        ----------
        residue : str
            "half", "repeat" or "ignore", see `rainflow`.

        Raises
        ------
        InputError
            If the events are fields of several sites, or the residue rule is missing.
        """
        rule = check_residue(residue, "DutyCycle")
        check_duty(self, rule)
        histories = []
        for event in self.events:
            if isinstance(event.source, StressField):
                raise InputError(
                    Problem("DutyCycle", "its events are fields; use damage_field or site_cycles")
                )
            histories.append(event.source)
        return count_duty(histories, [e.repeats for e in self.events], self.transitions, rule)

    def __str__(self) -> str:
        lines = [f"duty cycle of {self.duration:.6g} s, transitions: {self.transitions}"]
        for i, event in enumerate(self.events):
            name = event.name or f"event {i + 1}"
            lines.append(f"  {name}: {event.repeats:g} times {event.seconds:.6g} s")
        return "\n".join(lines)


def check_duty(duty: DutyCycle, residue: str) -> None:
    """Raise InputError if the residue rule does not fit the rule for transitions."""
    if duty.transitions == "worst" and residue != "repeat":
        raise InputError(
            Problem(
                "DutyCycle",
                f'residue is {residue!r}, but transitions="worst" closes all cycles and needs'
                ' residue="repeat"',
            )
        )


def count_duty(
    histories: Sequence[Array],
    repeats: Sequence[float],
    transitions: str,
    residue: str,
) -> Cycles:
    """Return the cycles of one site over a duty cycle; see `DutyCycle`.

    Parameters
    ----------
    histories : sequence of (nt,) array
        Stress in each event, Pa.
    repeats : sequence of float
    transitions, residue : str
    """
    if len(histories) == 1 and transitions != "sequence":
        cycles = rainflow(histories[0], residue=residue)
        return cycles if repeats[0] == 1.0 else cycles.times(repeats[0])
    if transitions == "sequence":
        return _sequence(histories, [int(n) for n in repeats], residue)
    within = "ignore" if transitions == "worst" else residue
    each = [rainflow(x, residue=within).times(n) for x, n in zip(histories, repeats, strict=True)]
    if transitions == "worst":
        return _worst(each, repeats)
    return _joined(
        np.concatenate([c.range for c in each]),
        np.concatenate([c.mean for c in each]),
        np.concatenate([c.count for c in each]),
        residue,
    )


def _joined(ranges: Array, means: Array, counts: Array, residue: str) -> Cycles:
    nowhere = np.full(len(ranges), -1, dtype=np.int64)
    rising = np.zeros(len(ranges), dtype=bool)
    return Cycles(ranges, means, counts, nowhere, nowhere, residue, rising=rising)


def _sequence(histories: Sequence[Array], repeats: Sequence[int], residue: str) -> Cycles:
    """Return the cycles of events in sequence: those closed in an event, then in the residues."""
    found: list[tuple[Array, Array, float]] = []

    def add(values: Array, pairs: Any, times: float) -> None:
        a, b = values[pairs[:, 0]], values[pairs[:, 1]]
        found.append((np.abs(b - a), 0.5 * (a + b), times))

    open_ = np.zeros(0)
    for x, n in zip(histories, repeats, strict=True):
        values, _ = turning_points(x)
        pairs, rest = count_turning(values)
        add(values, pairs, float(n))
        own = values[rest]
        last: tuple[Any, Any] = (None, None)
        for done in range(1, n + 1):
            joined = np.concatenate([open_, own])
            pairs, rest = close(open_, own)
            open_ = joined[rest]
            now = (joined[pairs].tolist(), open_.tolist())
            if now == last:  # all further repetitions close the same cycles
                add(joined, pairs, float(n - done + 1))
                break
            add(joined, pairs, 1.0)
            last = now
    if residue == "repeat":
        pairs, _ = close(open_, open_)
        add(np.concatenate([open_, open_]), pairs, 1.0)
    elif residue == "half" and len(open_) > 1:
        k = np.arange(len(open_) - 1)
        add(open_, np.stack([k, k + 1], axis=1), 0.5)
    counts = np.concatenate([np.full(len(r), times) for r, _, times in found])
    return _joined(
        np.concatenate([r for r, _, _ in found]),
        np.concatenate([m for _, m, _ in found]),
        counts,
        residue,
    )


def _worst(each: Sequence[Cycles], repeats: Sequence[float]) -> Cycles:
    """Return the cycles of events in any order: open peaks and valleys paired by size.

    In any order of the events each remaining cycle has one of the open peaks and one of the open
    valleys; of all pairings the sorted one has the largest sum of a convex function of the ranges.
    """
    ranges, means, counts = ([getattr(c, n) for c in each] for n in ("range", "mean", "count"))
    peaks: list[list[float]] = []
    valleys: list[list[float]] = []
    for cycles, n in zip(each, repeats, strict=True):
        points = cycles.open.tolist()
        for i, value in enumerate(points):
            beside = points[i - 1] if i else points[1] if len(points) > 1 else value
            if value >= beside:
                peaks.append([value, n])
            if value <= beside:
                valleys.append([value, n])
    peaks.sort(key=lambda p: -p[0])
    valleys.sort(key=lambda p: p[0])
    i = j = 0
    while i < len(peaks) and j < len(valleys):
        n = min(peaks[i][1], valleys[j][1])
        if peaks[i][0] > valleys[j][0]:
            ranges.append(np.array([peaks[i][0] - valleys[j][0]]))
            means.append(np.array([0.5 * (peaks[i][0] + valleys[j][0])]))
            counts.append(np.array([n]))
        peaks[i][1] -= n
        valleys[j][1] -= n
        i += peaks[i][1] <= 0.0
        j += valleys[j][1] <= 0.0
    return _joined(np.concatenate(ranges), np.concatenate(means), np.concatenate(counts), "repeat")
