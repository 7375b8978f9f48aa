"""The worst places of the cast link arm while it lifts 2.5 t, proved, and their histories.

The arm is that of ``link_arm.py``. Its stress is known at thousands of nodes and hundreds of
instants; the search works out a small share of these values and proves by bounds that no other
place is worse. Brute force over all of them must find the same places. The bound is put to the
test, too: the largest stress of every place that the search left out must lie below it.

The whole chain on the command line:

    jousto run examples/link_arm.yaml -o link_arm.h5
    jousto hotspots link_arm.h5 --separation "60 mm" --histories spots.h5 -o spots.png
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from link_arm import LENGTH, lift, reduced_arm

import jousto as jo

APART, COUNT = 0.06, 6  # m, places


def brute_force(field: jo.recovery.StressField, criterion: str) -> tuple[np.ndarray, list[int]]:
    """Return the largest value at every place and the worst ones that lie apart."""
    largest = field.envelope(criterion).max
    left, chosen = largest.copy(), []
    for _ in range(COUNT):
        k = int(np.argmax(left))
        chosen.append(k)
        left[np.linalg.norm(field.positions - field.positions[k], axis=1) <= APART] = -np.inf
    return largest, chosen


def main(out: Path) -> int:
    """Lift, search, check against brute force and draw; return 0 if the proof holds."""
    out.mkdir(parents=True, exist_ok=True)
    arm = reduced_arm()[1]
    run = lift(arm, arm.stress.nearest((0.5 * LENGTH, 0.09, 0.0)))
    good = True
    for criterion in ("von-mises", "principal-1"):
        found = jo.hot_spots(run, criterion=criterion, count=COUNT, separation=APART)
        field = found.fields[0]
        largest, chosen = brute_force(field, criterion)
        same = [spot.site for spot in found] == [field.labels[k] for k in chosen]
        off = max(abs(s.value / largest[k] - 1) for s, k in zip(found, chosen, strict=True))
        # everything but the hot spots and what is near one
        far = np.ones(field.ns, dtype=bool)
        for k in chosen:
            far &= np.linalg.norm(field.positions - field.positions[k], axis=1) > APART
        below = largest[far].max() <= found.bound <= found[-1].value
        print(found, end="\n\n")
        print(f"brute force finds {'the same places' if same else 'OTHER PLACES'}, ", end="")
        print(f"values differ by {off:.1e}; the worst place that is left out has ", end="")
        print(f"{largest[far].max() / 1e6:.4f} MPa, its bound is {found.bound / 1e6:.4f} MPa\n")
        good &= same and off < 1e-12 and below and found.certified
        name = criterion.replace("-", "_")
        jo.plot(found, run, path=out / f"hotspots_{name}.png")
    print("the proof holds" if good else "THE PROOF IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
