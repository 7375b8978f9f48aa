"""FlexibilityAdvice: which bodies of a machine must be flexible, with numbers."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.errors import InputError, Problem, suggest
from jousto.base.files import Rows, Tabular, written
from jousto.base.object_repr import described
from jousto.design.flexibility.body_advice import (
    FLEXIBLE,
    BodyAdvice,
    ModesAdvice,
    ReadingAdvice,
    percent,
    shown,
)

LISTED = 6
"""Number of readings of a body in the printed table."""
HEAD = (
    "body",
    "change",
    "verdict",
    "reading",
    "unit",
    "e_inf",
    "no range",
    "difference",
    "peak",
    "lag (s)",
    "e_inf after lag",
    "damage ratio",
    "estimated difference",
    "estimated e_inf",
    "first frequency (Hz)",
    "highest frequency of loads (Hz)",
    "static deflection (m)",
    "steps",
    "seconds (s)",
)


@described
@dataclass(frozen=True, eq=False)
class FlexibilityAdvice(Tabular):
    """Advice on the bodies of a machine.

    Attributes
    ----------
    machine : str
        Name of the mechanism.
    bodies : tuple of BodyAdvice
    from_rigid : bool
        Whether only the machine with all bodies rigid was simulated: estimates alone.
    steps, seconds : float
        Steps and duration, s, of the run of the given machine; with `from_rigid` of the rigid one.
    """

    machine: str
    bodies: tuple[BodyAdvice, ...]
    from_rigid: bool
    steps: float
    seconds: float

    def _facts(self) -> str:
        return ", ".join(f"{one.body} {one.verdict}" for one in self.bodies)

    def __getitem__(self, body: str) -> BodyAdvice:
        """Return the advice on a body; an unknown name is an `InputError` with the nearest one."""
        known = {one.body: one for one in self.bodies}
        if body not in known:
            message = f"no advice on a body '{body}'{suggest(body, known)}"
            raise InputError(Problem(f"advice on '{self.machine}'", message))
        return known[body]

    @property
    def flexible(self) -> tuple[str, ...]:
        """Names of the bodies that must be flexible."""
        return tuple(one.body for one in self.bodies if one.verdict == FLEXIBLE)

    def table(self, count: int = LISTED) -> list[list[str]]:
        """Return the rows of the printed table, the header first."""
        head = ["body", "reading", "e_inf", "peak", "lag", "after lag", "life", "estimate"]
        rows = [head]
        for body in self.bodies:
            rows += [
                [body.body if k == 0 else "", *_cells(one)]
                for k, one in enumerate(body.ranked[:count])
            ]
        return rows

    def recommendations(self) -> list[str]:
        """Return a sentence for each body, with the numbers behind it."""
        return [line for body in self.bodies for line in self._recommended(body)]

    def _recommended(self, body: BodyAdvice) -> Iterator[str]:
        reasons = "; ".join(body.reasons())
        if self.from_rigid:
            verb = "make" if body.verdict == FLEXIBLE else "leave"
            yield f"{verb} '{body.body}' {body.verdict}: {reasons} (estimate)"
        elif body.verdict == FLEXIBLE:
            yield f"leave '{body.body}' flexible: {reasons}"
        else:
            yield f"make '{body.body}' rigid: {reasons}; {self._saved(body.steps, body.seconds)}"
        if body.failed and body.readings:
            yield f"'{body.body}': {body.failed}"
        if body.modes is not None and body.verdict == FLEXIBLE:
            yield from self._modes(body, body.modes)

    def _modes(self, body: BodyAdvice, modes: ModesAdvice) -> Iterator[str]:
        n = len(modes.energy)
        if modes.failed:
            yield f"'{body.body}' with {len(modes.kept)} of {n} modes: {modes.failed}"
        elif modes.left_out:
            worst = max(modes.readings, key=lambda one: one.worst, default=None)
            lost = "" if worst is None else f", largest loss {percent(worst.worst)} of "
            lost += "" if worst is None else worst.reading
            kept = ", ".join(str(k + 1) for k in modes.kept)
            bad = any(one.exceeds(body.limit, body.life_limit) for one in modes.readings)
            verb = "do not leave out modes" if bad else "keep modes"
            what = "" if bad else f" {kept} of {n}"
            yield (
                f"'{body.body}': {verb}{what}: a run with {len(modes.kept)} of {n}{lost}; "
                f"{self._saved(modes.steps, modes.seconds)}"
            )

    def _saved(self, steps: float, seconds: float) -> str:
        saved = 1.0 - seconds / self.seconds if self.seconds > 0.0 else 0.0
        word = "saves" if saved >= 0.0 else "costs"
        return (
            f"{word} {percent(abs(saved))} of {self.seconds:.3g} s "
            f"({steps:.0f} steps, {self.steps:.0f} before)"
        )

    def __str__(self) -> str:
        rows = self.table()
        widths = [max(map(len, cells)) for cells in zip(*rows, strict=True)]
        lines = [
            "  ".join(
                cell.ljust(w) if k < 2 else cell.rjust(w)
                for k, (cell, w) in enumerate(zip(row, widths, strict=True))
            ).rstrip()
            for row in rows
        ]
        lines += [""]
        for body in self.bodies:
            if np.isfinite(body.first):
                lines.append(_frequencies(body))
        hidden = sum(max(0, len(body.readings) - LISTED) for body in self.bodies)
        if hidden:
            lines.append(f"{hidden} readings with smaller losses are in the table of a file")
        lines += ["", *self.recommendations()]
        return "\n".join(lines)

    def _csv(self) -> Rows:
        return HEAD, (row for body in self.bodies for row in _rows(body))

    def to_json(self, path: str | Path) -> Path:
        """Write the same table as JSON, a list of mappings; numbers that do not exist are null.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        rows = [
            {key: _plain(value) for key, value in zip(HEAD, row, strict=True)}
            for body in self.bodies
            for row in _rows(body)
        ]
        table = {
            "machine": self.machine,
            "from rigid": self.from_rigid,
            "steps": _plain(self.steps),
            "seconds (s)": self.seconds,
            "recommendations": self.recommendations(),
            "readings": rows,
        }
        target = Path(path)
        with written(target) as beside:
            text = json.dumps(table, indent=1, ensure_ascii=False, allow_nan=False)
            beside.write_text(text + "\n", encoding="utf-8")
        return target


def _frequencies(body: BodyAdvice) -> str:
    text = (
        f"{body.body}: first frequency {body.first:.4g} Hz, loads up to {body.highest:.3g} Hz "
        f"(r = {body.ratio:.3g}), static deflection {shown(body.deflection, 'm')}"
    )
    if np.isfinite(body.bound):
        return f"{text}, at most {shown(body.bound * body.deflection, 'm')} in a smooth stroke"
    return f"{text}; the loads contain its frequency"


def _cells(one: ReadingAdvice) -> list[str]:
    loss = one.measured
    measured = ["", "", "", ""]
    if loss is not None:
        error = shown(loss.difference, one.unit) if loss.absolute else percent(loss.error)
        shifted = "" if loss.absolute else percent(loss.shifted)
        measured = [error, percent(loss.peak), f"{1e3 * loss.lag:.3g} ms", shifted]
    life = "" if np.isnan(one.life) else f"{one.life:.3g}"
    share = one.estimated_share
    estimate = "" if np.isnan(share) else percent(share) if np.isfinite(share) else "no bound"
    return [one.reading, *measured, life, estimate]


def _rows(body: BodyAdvice) -> Iterator[list[Any]]:
    """Yield the rows of the table of a file: with the body rigid, then with fewer modes."""
    facts = [body.first, body.highest, body.deflection]
    for one in body.readings:
        yield [body.body, "rigid", body.verdict, *_numbers(one), *facts, body.steps, body.seconds]
    if not body.readings:
        blank = ["", ""] + [float("nan")] * 9
        yield [body.body, "rigid", body.verdict, *blank, *facts, body.steps, body.seconds]
    modes = body.modes
    for one in () if modes is None else modes.readings:
        change = f"{len(modes.kept)} of {len(modes.energy)} modes" if modes else ""
        cost = [modes.steps, modes.seconds] if modes else []
        yield [body.body, change, body.verdict, *_numbers(one), *facts, *cost]


def _numbers(one: ReadingAdvice) -> list[Any]:
    loss, nan = one.measured, float("nan")
    measured: list[Any] = [nan, "", nan, nan, nan, nan]
    if loss is not None:
        error = [loss.error, "yes" if loss.absolute else "no", loss.difference]
        measured = [*error, loss.peak, loss.lag, loss.shifted]
    return [one.reading, one.unit, *measured, one.life, one.estimate, one.estimated_share]


def _plain(value: Any) -> Any:
    """Return a value of JSON, which has neither NaN nor infinity."""
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value
