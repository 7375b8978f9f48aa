"""Order of measured instants: sorted and repaired, or refused after a restart of the clock."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import Problems

BACK = 5.0
"""Length of a backward jump, in usual steps, that indicates a restart of the clock."""

AGAIN = 3
"""Number of repeated samples that indicates a restart of the clock."""

DAY = 86400.0
"""Length of a day, s."""


def ordered(
    problems: Problems, where: str, t: Array, channels: dict[str, Array], repair: bool
) -> tuple[Array, dict[str, Array], list[str]]:
    """Return time and channels in order; add problems of their order, or repair it."""
    notes: list[str] = []
    unknown = ~np.isfinite(t)
    if unknown.any():
        sentence = f"{np.count_nonzero(unknown)} instants have no time"
        if not repair:
            problems.add(where, f"{sentence}; repair=True leaves them out")
        notes.append(f"{sentence} and were left out")
        t = t[~unknown]
        channels = {name: x[~unknown] for name, x in channels.items()}
    nights = _midnights(t)
    if len(nights):
        i = int(nights[0])
        sentence = (
            f"time runs over midnight {len(nights)} times, first from {t[i]:.6g} s to "
            f"{t[i + 1]:.6g} s at sample {i + 1}"
        )
        if not repair:
            problems.add(where, f"{sentence}; repair=True counts on from there")
        notes.append(f"{sentence}: a day was added")
        t = t.copy()
        for night in nights:
            t[night + 1 :] += DAY
    starts = restarts(t)
    if len(starts):
        named = ", ".join(f"{i} ({t[i - 1]:.6g} to {t[i]:.6g} s)" for i in starts[:3])
        more = ", ..." if len(starts) > 3 else ""
        problems.add(
            where,
            f"the clock restarts: {len(starts) + 1} blocks, new ones at sample {named}{more}; "
            "they are separate records, which cannot be merged: split the file there, "
            "or give rate= if the samples follow each other without a pause",
        )
        return t, channels, notes
    back = np.flatnonzero(np.diff(t) < 0.0)
    kept, first = np.unique(t, return_index=True)
    again = np.setdiff1d(np.arange(len(t)), first)
    if len(back):
        i = int(back[0])
        sentence = (
            f"time runs backwards {len(back)} times, first from {t[i]:.6g} s to {t[i + 1]:.6g} s "
            f"at sample {i + 1}"
        )
        if not repair:
            problems.add(where, f"{sentence}; repair=True sorts the samples")
        notes.append(f"{sentence}: sorted")
    if len(again):
        i = int(again[0])
        sentence = f"{len(again)} instants come twice, first {t[i]:.6g} s at sample {i}"
        if not repair:
            problems.add(where, f"{sentence}; repair=True keeps the first of each")
        notes.append(
            f"{sentence}: the first of each was kept, {len(again)} of {len(t)} samples dropped"
        )
    if len(t) < 2:
        problems.add(where, f"has {len(t)} instants, must have two or more")
    if not notes or problems.found:
        return t, channels, notes
    return kept, {name: x[first] for name, x in channels.items()}, notes


def restarts(t: Array) -> list[int]:
    """Return the samples at which the clock restarts; late samples do not count.

    At a restart, time jumps back by more than `BACK` usual steps and then repeats earlier instants,
    or ends before them. Packets in the wrong order, in contrast, fill gaps.
    """
    steps = np.diff(t)
    if not np.any(steps > 0.0):
        return []
    usual = float(np.median(steps[steps > 0.0]))
    jumps = np.flatnonzero(steps < -BACK * usual) + 1
    out: list[int] = []
    seen = np.sort(t[: jumps[0]]) if len(jumps) else t
    for k, i in enumerate(jumps):
        end = int(jumps[k + 1]) if k + 1 < len(jumps) else len(t)
        block = t[i:end]
        through = block[block <= t[i - 1]]
        if len(through) >= AGAIN:
            low, high = through.min(), through.max()
            n = np.searchsorted(seen, high, "right") - np.searchsorted(seen, low, "left")
            if n >= AGAIN or (high < seen[0] and len(through) == len(block)):
                out.append(int(i))
        seen = np.sort(np.concatenate([seen, block]))
    return out


def _midnights(t: Array) -> NDArray[np.intp]:
    """Return the samples before midnight, where a time of day returns to zero."""
    steps = np.diff(t)
    if not np.any(steps > 0.0) or t.min() < 0.0 or t.max() >= DAY + 1.0:
        return np.empty(0, dtype=np.intp)
    usual = float(np.median(steps[steps > 0.0]))
    return np.flatnonzero((steps < -0.5 * DAY) & (np.abs(steps + DAY) <= BACK * usual))
