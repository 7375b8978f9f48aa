"""How far spectral methods are from rainflow: damage ratios over spectra of many shapes.

A ratio is the damage of a method over that of rainflow cycles counted in a simulated Gaussian
history of the same spectrum, millions of peaks long; below 1 is the unsafe side. Prints least,
median and largest ratio for each method and slope of the S-N line, for one band and for two.
"""

from __future__ import annotations

import argparse

import numpy as np

import jousto as jo
from jousto.fatigue.cycles.rainflow import turning_points
from jousto.fatigue.random.spectral import METHODS, damage_of_moments, spectral_moments
from jousto.model.native.damage_meter import count_cycles

SLOPES = (3, 5, 7, 10)
SAMPLES = 12
"""Samples in a period of the highest frequency."""


def box(low: float, high: float, points: int = 40) -> tuple[np.ndarray, np.ndarray]:
    return np.linspace(low, high, points), np.ones(points)


def two(ratio: float, share: float) -> tuple[np.ndarray, np.ndarray]:
    """Two bands 20 % wide; `share` of the variance is in the upper one."""
    low, high = 0.9 / ratio, 0.9
    f, S = [], []
    for centre, part in ((low, 1.0 - share), (high, share)):
        width = 0.2 * centre
        edge = 1e-3 * width
        f += [centre - 0.5 * width - edge, centre - 0.5 * width, centre + 0.5 * width]
        f += [centre + 0.5 * width + edge]
        S += [0.0, part / width, part / width, 0.0]
    return np.array(f), np.array(S)


def resonances(*modes: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Displacement of oscillators (Hz, damping ratio, variance) under white noise."""
    f = np.unique(
        np.concatenate(
            [np.linspace(0.01, 1.0, 200)]
            + [c * (1 + z * np.linspace(-8, 8, 160)) for c, z, _ in modes]
        )
    )
    f = f[(f > 0.005) & (f <= 1.0)]
    S = np.zeros_like(f)
    for c, z, variance in modes:
        r = f / c
        own = 1.0 / ((1 - r * r) ** 2 + (2 * z * r) ** 2)
        S += variance * own / np.trapezoid(own, f)
    return f, S


def waves(peak: float, gamma: float) -> tuple[np.ndarray, np.ndarray]:
    """Pierson and Moskowitz's spectrum, with JONSWAP's peak."""
    f = np.concatenate([np.linspace(0.4 * peak, 3 * peak, 300), np.linspace(3.05 * peak, 1.0, 60)])
    width = np.where(f <= peak, 0.07, 0.09)
    bump = gamma ** np.exp(-0.5 * ((f - peak) / (width * peak)) ** 2)
    return f, f**-5.0 * np.exp(-1.25 * (peak / f) ** 4) * bump


def spectra() -> dict[str, dict[str, tuple[np.ndarray, np.ndarray]]]:
    """Spectra by kind; frequencies to 1 Hz."""
    ramp = np.geomspace(0.02, 1.0, 200)
    one = {f"box {a:g} to 1": box(a, 1.0) for a in (0.9, 0.7, 0.5, 0.3, 0.1, 0.01)}
    one |= {f"f^-{n}": (ramp, ramp**-n) for n in (1, 2, 3)}
    one |= {
        "oscillator, 2 %": resonances((0.3, 0.02, 1.0)),
        "oscillator, 10 %": resonances((0.3, 0.1, 1.0)),
        "oscillator, 40 %": resonances((0.2, 0.4, 1.0)),
        "Pierson-Moskowitz": waves(0.15, 1.0),
        "JONSWAP": waves(0.15, 3.3),
    }
    several = {
        f"two bands 1:{ratio}, {100 * share:g} % above": two(ratio, share)
        for ratio in (2, 4, 10, 30)
        for share in (0.02, 0.1, 0.3, 0.6, 0.9)
    }
    several |= {
        "two modes, 1 : 3": resonances((0.25, 0.02, 0.6), (0.75, 0.02, 0.4)),
        "two modes, 1 : 7": resonances((0.1, 0.02, 0.8), (0.7, 0.02, 0.2)),
        "three modes": resonances((0.08, 0.02, 0.6), (0.3, 0.02, 0.3), (0.8, 0.02, 0.1)),
    }
    return {"one band": one, "several bands": several}


def peaks(x: np.ndarray) -> np.ndarray:
    """Turning points of a smooth history, by the parabola through three samples."""
    _, index = turning_points(x)
    index = index[(index > 0) & (index < len(x) - 1)]
    before, at, after = x[index - 1], x[index], x[index + 1]
    bend = before - 2.0 * at + after
    return at - 0.125 * (before - after) ** 2 / bend


def counted(f: np.ndarray, S: np.ndarray, parts: int, n: int, seed: int) -> list[np.ndarray]:
    """Ranges of the cycles that each of several histories closes when it goes round."""
    found = []
    for part in range(parts):
        _, x = jo.fatigue.synthesise(f, S, n / SAMPLES, rate=SAMPLES, seed=1000 * seed + part)
        turning = peaks(x)
        # from the largest peak round to it: all cycles close but the largest, two halves
        turning = np.roll(turning, -int(np.argmax(turning)))
        cycles, _, rest, _ = count_cycles(np.append(turning, turning[0]))
        assert len(rest) == 3
        found.append(np.append(np.abs(cycles[:, 1] - cycles[:, 0]), rest[0] - rest[1]))
    return found


def ratios(
    f: np.ndarray, S: np.ndarray, slopes: tuple[int, ...] = SLOPES, parts: int = 8, seed: int = 0
) -> tuple[dict[tuple[str, int], float], dict[int, float], float]:
    """Return method over rainflow for each method and slope, its standard error, irregularity."""
    n = 1 << 20
    S = S / np.trapezoid(S, f)  # variance 1
    moments = spectral_moments(f, S)
    sizes = [0.5 * ranges for ranges in counted(f, S, parts, n, seed)]
    out, error = {}, {}
    for k in slopes:
        each = np.array([np.sum(a**k) * SAMPLES / n for a in sizes])  # in a second, of 1/N = a^k
        error[k] = float(each.std(ddof=1) / np.sqrt(parts) / each.mean())
        curve = jo.SN(S_D=1e6, N_D=1e6, k=k)
        scaled = moments * 1e12  # in Pa: an rms of 1 MPa
        for method in METHODS:
            rate = damage_of_moments(scaled, curve, method=method).damage * 1e6
            out[method, k] = rate / each.mean()
    irregular = moments[2] / np.sqrt(moments[0] * moments[3])
    return out, error, float(irregular)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parts", type=int, default=40, help="histories of a million samples")
    parts = parser.parse_args().parts
    for kind, shapes in spectra().items():
        table: dict[tuple[str, int], list[float]] = {}
        worst = dict.fromkeys(SLOPES, 0.0)
        print(f"\n{kind}: {len(shapes)} spectra, {parts} x {1 << 20} samples")
        for seed, (name, (f, S)) in enumerate(shapes.items()):
            found, error, irregular = ratios(f, S, parts=parts, seed=seed)
            shown = " ".join(f"{found['dirlik', k]:.3f}({100 * error[k]:.1f}%)" for k in SLOPES)
            shown += "  " + " ".join(f"{found['tovo-benasciutti', k]:.3f}" for k in SLOPES)
            print(f"  {name:<30} irregularity {irregular:.3f}  {shown}", flush=True)
            for key, value in found.items():
                table.setdefault(key, []).append(value)
            worst = {k: max(worst[k], error[k]) for k in SLOPES}
        print("largest standard error", {k: round(worst[k], 4) for k in SLOPES})
        for method in METHODS:
            row = [np.quantile(table[method, k], [0, 0.5, 1]) for k in SLOPES]
            print(f"| {method} | " + " | ".join(f"{a:.2f} {b:.2f} {c:.2f}" for a, b, c in row))


if __name__ == "__main__":
    main()
