"""Places per second of `plane_damage`: rainflow on every plane through a place.

Histories of 1000 instants of six components that go their own ways; processor time of one core.
"""

from __future__ import annotations

import argparse
import os
import time

import numpy as np
from scipy.signal import lfilter

import jousto as jo


def histories(places: int, nt: int = 1000, seed: int = 0) -> np.ndarray:
    """Stress (places, nt, 6) up to 200 MPa: four narrow-band processes, mixed."""
    rng = np.random.default_rng(seed)
    w = lfilter([1.0], [1.0, -1.6, 0.8], rng.normal(size=(places, nt, 4)), axis=1)
    s = np.einsum("ntk,nkc->ntc", w, rng.normal(size=(places, 4, 6)))
    return 200e6 * s / np.abs(s).max(axis=(1, 2))[:, None, None]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--places", type=int, default=32)
    places = parser.parse_args().places
    stress = histories(places)
    steel = jo.SN(S_D=100e6, N_D=1e6, k=5)
    for criterion, curve in (
        (jo.fatigue.Findley(0.3), steel),
        (jo.fatigue.FatemiSocie(S_y=400e6, E=210e9), jo.fatigue.strain_life("sae-1045")),
        (jo.fatigue.NormalStress(), steel),
    ):
        jo.fatigue.plane_damage(stress[:1], criterion, curve, residue="half")
        wall, spent = time.perf_counter(), time.process_time()
        jo.fatigue.plane_damage(stress, criterion, curve, residue="half")
        wall, spent = time.perf_counter() - wall, time.process_time() - spent
        print(
            f"{type(criterion).__name__:<14} {places / spent:8.1f} places per second of a core, "
            f"{places / wall:8.1f} on {os.cpu_count()} processors"
        )


if __name__ == "__main__":
    main()
