"""Geometrically exact beams at rest: rolled up, bent by an end load, a curved one, an experiment.

Four classics with known answers. A cantilever under an end moment bends to a circle, twice. Under
an end load it is Euler's elastica, known by elliptic integrals: elements converge with second
order, with ``bending=True`` with fourth. The 45 degree bend of Bathe and Bolourchi (1979) leaves
its plane. The Princeton beam (Dowell and Traybar 1975) is a thin strip loaded at an angle to its
sides; its reference is the benchmark of Obrezkov and others, Nonlinear Dynamics 109 (2022).
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import brentq
from scipy.special import ellipeinc, ellipkinc

import jousto as jo
from jousto.output.style import COLORS, STYLE

THIN = jo.mechanism.BeamSection((1e8, 1e8, 1e8, 1.0, 1.0, 1.0), 1.0, (2e-2, 1e-2, 1e-2))  # E I = 1
BEND = jo.mechanism.BeamSection(
    (1e7, 5e6 / 1.2, 5e6 / 1.2, 5e6 / 6, 1e7 / 12, 1e7 / 12), 1.0, (2e-2, 1e-2, 1e-2)
)
COUNTS = (2, 4, 8, 16)
ANGLES = np.arange(0, 91, 15)
# displacements along the soft and the stiff direction under 8.896 N, m
SOFT = (0.0, 0.042082, 0.079395, 0.108988, 0.129888, 0.142194, 0.146246)
STIFF = (0.010714, 0.010613, 0.010112, 0.008837, 0.006605, 0.003539, 0.0)


def follow(beam: jo.BeamBody, load: tuple, *, moment: bool = False, steps: int = 4) -> np.ndarray:
    """Nodes of a cantilever (steps + 1, n + 1, 3) while an end load grows."""
    kind = jo.Torque if moment else jo.Force
    wall = jo.ground.at(beam.nodes[0], axes=beam.frames[0], name="wall")
    mechanism = jo.Mechanism(
        beam,
        jo.Fixed("clamp", wall, beam["start"]),
        kind("load", beam["end"], load, signal=jo.Input("load")),
    )
    path = jo.simulation.load_path(jo.compile(mechanism), "load", to=1.0, steps=steps)
    return np.array([state.q.reshape(-1, 7)[:, :3] for state in path.states])


def straight(length: float, elements: int, *section, bending: bool = False) -> jo.BeamBody:
    """A beam along x."""
    ends = [(0.0, 0.0, 0.0), (length, 0.0, 0.0)]
    return jo.BeamBody("beam", ends, *section, elements=elements, bending=bending)


def elastica(load: float) -> np.ndarray:
    """End of a cantilever of length and E I 1 under an end load across (Bisshopp, Drucker 1945)."""

    def pieces(m: float) -> tuple[float, float]:
        turns = (np.arcsin(1.0 / np.sqrt(2.0 * m)), np.pi / 2)
        return tuple(np.diff([f(t, m) for t in turns])[0] for f in (ellipkinc, ellipeinc))

    m = brentq(lambda m: pieces(m)[0] - np.sqrt(load), 0.5 + 1e-12, 1.0 - 1e-12, xtol=1e-15)
    return np.array([np.sqrt(2.0 * (2.0 * m - 1.0) / load), 1.0 - 2.0 * pieces(m)[1] / load**0.5])


def errors() -> dict[bool, list[float]]:
    """Distance of the end from the elastica under P L^2 = 5 E I, by number of elements."""
    exact = elastica(5.0)
    out: dict[bool, list[float]] = {False: [], True: []}
    for bending, found in out.items():
        for n in COUNTS:
            end = follow(straight(1.0, n, THIN, bending=bending), (0.0, 5.0, 0.0))[-1, -1]
            found.append(float(np.linalg.norm(end[:2] - exact)))
    return out


def bend(elements: int) -> np.ndarray:
    """The 45 degree bend of radius 100 under 600 across its plane."""
    t = np.linspace(0.0, np.pi / 4, elements + 1)
    points = 100.0 * np.stack([np.sin(t), 1.0 - np.cos(t), 0.0 * t], axis=1)
    beam = jo.BeamBody("beam", points, BEND, up=(0, 0, 1))
    return follow(beam, (0.0, 0.0, 600.0), steps=6)


def princeton() -> np.ndarray:
    """Displacements (7, 3) of the end of the strip under 8.896 N at all angles, m."""
    metal = jo.Material(E=71.7e9, nu=0.31, rho=2700.0)
    strip = straight(0.508, 8, jo.Rectangle(12.3777e-3, 3.2024e-3), metal, bending=True)
    loads = 8.896 * np.array([(0.0, -np.cos(a), np.sin(a)) for a in np.radians(ANGLES)])
    ends = [follow(strip, tuple(load))[-1, -1] for load in loads]
    return np.array(ends) - (0.508, 0.0, 0.0)


def draw(rolled: np.ndarray, error: dict, shapes: np.ndarray, strip: np.ndarray) -> Figure:
    """The four classics side by side."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    figure, axes = plt.subplots(1, 4, figsize=(14.0, 3.5), layout="constrained")
    for ax in axes:
        ax.margins(0.05)
    for shape in rolled:
        axes[0].plot(*shape[:, :2].T, ".-", markersize=3, linewidth=1.2)
    axes[0].set(aspect="equal", xlabel="x / L", ylabel="y / L")
    axes[0].set_title("End moment, to two turns", **bold)
    for bending, found in error.items():
        label = "bending=True" if bending else "plain"
        axes[1].loglog(COUNTS, found, "o-", color=COLORS[int(bending)], label=label)
    axes[1].set(xlabel="elements", ylabel="error / L", xticks=COUNTS, xticklabels=COUNTS)
    axes[1].minorticks_off()
    axes[1].set_title("Elastica, PL²/EI = 5", **bold)
    axes[1].legend()
    for shape in shapes:
        axes[2].plot(shape[:, 0], shape[:, 2], ".-", color=COLORS[0], markersize=3, linewidth=1.2)
    axes[2].set(aspect="equal", xlabel="x", ylabel="z")
    axes[2].set_title("45 degree bend, 0 to 600", **bold)
    for k, (sign, wanted, label) in enumerate(((-1, STIFF, "stiff"), (1, SOFT, "soft"))):
        axes[3].plot(ANGLES, 1e3 * sign * strip[:, 1 + k], color=COLORS[k], label=label)
        axes[3].plot(ANGLES, 1e3 * np.array(wanted), "o", color=COLORS[k], markersize=4)
    axes[3].set(xlabel="angle of the load (degrees)", ylabel="mm")
    axes[3].set_title("Princeton beam, 8.9 N", **bold)
    axes[3].legend()
    return figure


def main(folder: Path) -> int:
    """Solve, check, draw."""
    warnings.simplefilter("ignore", jo.JoustoWarning)  # loads wait for their input
    rolled = follow(straight(1.0, 20, THIN), (0.0, 0.0, 4.0 * np.pi), moment=True, steps=8)
    assert abs(rolled[-1, -1]).max() < 1e-10
    error = errors()
    orders = {b: np.log2(e[2] / e[3]) for b, e in error.items()}
    assert abs(orders[False] - 2.0) < 0.1
    assert abs(orders[True] - 4.0) < 0.3
    shapes = bend(8)
    assert abs(shapes[-1, -1] - (47.23, 15.79, 53.37)).max() < 0.08  # Simo and Vu-Quoc (1986)
    strip = princeton()
    assert abs(strip[:, 2] - SOFT).max() < 1.5e-4
    print(f"elastica, 8 elements: {error[False][2]:.1e} of the length, {error[True][2]:.1e} with")
    print(f"bending=True; orders {orders[False]:.2f} and {orders[True]:.2f}")
    print("45 degree bend:", *np.round(shapes[-1, -1], 2))
    folder.mkdir(parents=True, exist_ok=True)
    with plt.style.context(STYLE):
        draw(rolled, error, shapes, strip).savefig(folder / "beam_benchmarks.png", dpi=130)
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "pictures")))
