"""Hot spots of 1e5 places over 1e5 instants with 20 modes: the proof's price against brute force.

    python benchmarks/hotspots.py [places instants]

Two fields of stress over a plate: one with notches, as parts have, and one that is nowhere worse
than elsewhere, the worst case for a bound. The path is the response of twenty damped modes to
noise. Brute force is `StressField.envelope` on a slice of the places, scaled to all of them. All
times are processor time.
"""

from __future__ import annotations

import sys
import time

import numpy as np
from scipy.signal import lfilter

from jousto.recovery.fields.build import field_from
from jousto.recovery.hotspots.hot_spots import hot_spots
from jousto.reduction.fields.stress import StressModes

MODES = 20
SLICE = 100  # places of the brute force


def path(nt: int, dt: float = 1e-4) -> np.ndarray:
    """Return the response (nt, MODES) of modes of 5 Hz and upwards, each 30 % higher, to noise."""
    rng = np.random.default_rng(1)
    p = np.empty((nt, MODES))
    for j, f in enumerate(5.0 * 1.3 ** np.arange(MODES)):
        w, damping = 2 * np.pi * f, 0.02
        # exact poles of the damped oscillator
        r, turn = np.exp(-damping * w * dt), w * np.sqrt(1 - damping**2) * dt
        x = lfilter([1.0], [1.0, -2 * r * np.cos(turn), r * r], rng.normal(size=nt))
        p[:, j] = x / x.std() / (1 + j) ** 1.5
    return p


def plate(ns: int, notches: bool) -> StressModes:
    """Return stress modes like waves over a plate of 2 m x 0.3 m, with or without notches."""
    rng = np.random.default_rng(2)
    x = rng.random((ns, 3)) * [2.0, 0.3, 0.02]
    S = np.empty((ns, 6, MODES))
    for j in range(MODES):
        for c in range(6):
            wave = 2.0 * (1 + 0.5 * j) * rng.normal(size=3)
            S[:, c, j] = np.cos(x @ wave + 6.0 * rng.random()) * (1.0 if c == 0 else 0.3)
    S *= 1e7 * np.sqrt(1.0 + np.arange(MODES))
    if notches:
        factor = np.ones(ns)
        for centre in rng.random((12, 3)) * [2.0, 0.3, 0.02]:
            away = np.linalg.norm(x - centre, axis=1)
            factor += 2.0 * np.exp(-((away / 0.02) ** 2))
        S *= factor[:, None, None]
    axes = np.broadcast_to(np.eye(3), (ns, 3, 3))
    return StressModes(tuple(f"n{k}" for k in range(ns)), x, axes, S)


def copy_rate() -> float:
    """Return the bytes read and written per second by a copy of 256 MB."""
    a = np.ones(1 << 25)
    b = np.empty_like(a)
    best = np.inf
    for _ in range(5):
        start = time.process_time()
        np.copyto(b, a)
        best = min(best, time.process_time() - start)
    return 2 * a.nbytes / best


def main(ns: int, nt: int) -> int:
    """Search, compare and print; return 0 if the search found what brute force found."""
    p, t = path(nt), 1e-4 * np.arange(nt)
    copied = copy_rate()
    print(f"{ns} places, {nt} instants, {MODES} modes; a copy moves {copied / 1e9:.1f} GB/s")
    good = True
    for name, notches in (("with notches", True), ("nowhere worse than elsewhere", False)):
        field = field_from(plate(ns, notches), p, t)
        start = time.process_time()
        found = hot_spots(field, count=10, separation=0.02)
        searched = time.process_time() - start
        proof = next(iter(found.certificates.values()))
        few = field.take(np.arange(0, ns, max(1, ns // SLICE)))
        brute = np.inf
        for _ in range(2):
            start = time.process_time()
            envelope = few.envelope("von-mises")
            brute = min(brute, (time.process_time() - start) * ns / few.ns)
        # the same places by the search
        own = hot_spots(few, count=few.ns)
        order = np.sort(envelope.max)[::-1]
        good &= bool(np.allclose([spot.value for spot in own], order, rtol=1e-12))
        good &= found.certified
        values = float(ns) * nt
        # what a criterion per place and instant would write, 8 bytes each
        print(f"{name}:")
        print(f"  search                {searched:8.2f} s, largest {found[0].value / 1e6:.2f} MPa")
        print(f"  brute force           {brute:8.1f} s, {brute / searched:.0f} times as long")
        print(f"  pruned over the run   {100 * proof.pruned / ns:8.2f} % of the places")
        print(f"  known to the end      {proof.complete:8d} places")
        worked = 100 * (proof.knots + proof.full) / values
        print(f"  values worked out     {worked:8.4f} %, those of windows included")
        rate = 8 * values / searched
        print(f"  values decided        {rate / 1e9:8.1f} GB/s, {rate / copied:.2f} of the copy")
    print("the search finds what brute force finds" if good else "THE SEARCH IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sizes = [int(float(x)) for x in sys.argv[1:3]] or [100_000, 100_000]
    sys.exit(main(sizes[0], sizes[-1]))
