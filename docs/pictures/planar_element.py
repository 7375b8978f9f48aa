"""Draw the planar beam element: its two positions, and the strains of a section.

.venv/bin/python docs/pictures/planar_element.py FOLDER

After figures 1 and 2 of Makinen, Marjamaki and Pajunen; the positions are those of one soft element
in equilibrium, and the strains those that its resultants have.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import jousto as jo
from jousto.output.style import COLORS, STYLE
from jousto.planar import PlanarBeam, PlanarLoad, PlanarSection, PlanarSupport, load_steps

SECTION = PlanarSection(EA=200.0, GA=120.0, EI=60.0, mass=1.0, rotary=1.0)
NODES = np.array([[1.0, 0.5], [3.0, 1.3]])
TURN, SHIFT = 0.35, np.array([1.6, 0.9])  # rad, m
SIZE, HALF = 0.45, 0.3  # arrows and sections
TITLE = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 10}


def solved() -> tuple[np.ndarray, np.ndarray]:
    """Displacements of both nodes (2, 3) and the strains eps, gam, kap in the middle."""
    frame = jo.planar.PlanarFrame(
        NODES,
        [PlanarBeam(0, 1, SECTION)],
        supports=[PlanarSupport(0, rotation=True)],
        loads=[PlanarLoad(1, force=(18.0, 30.0), moment=-24.0)],
    )
    path = load_steps(frame, np.linspace(0.0, 1.0, 21))
    stiffness = np.array([SECTION.EA, SECTION.GA, SECTION.EI])
    # moved as a whole: the strains stay
    c, s = np.cos(TURN), np.sin(TURN)
    now = path.positions[-1] @ np.array([[c, s], [-s, c]]) + SHIFT
    u = np.column_stack([now - NODES, path.displacements[-1, :, 2] + TURN])
    return u, path.resultants[-1, 0] / stiffness


def arrow(axes: Axes, at: np.ndarray, way: np.ndarray, text: str, color: str) -> None:
    """Draw an arrow with its name at the head."""
    axes.annotate("", at + way, at, arrowprops={"arrowstyle": "-|>", "color": color, "lw": 1.4})
    axes.annotate(text, at + 1.18 * way, ha="center", va="center", color=color)


def freedoms(axes: Axes, at: np.ndarray, k: int) -> None:
    """Draw the two displacements and the rotation of node k, from 0."""
    arrow(axes, at, np.array([SIZE, 0.0]), f"$u_{{{3 * k + 1}}}$", COLORS[1])
    arrow(axes, at, np.array([0.0, SIZE]), f"$u_{{{3 * k + 2}}}$", COLORS[1])
    arc = np.linspace(2.0, 4.2, 30)
    axes.plot(at[0] + 0.16 * np.cos(arc), at[1] + 0.16 * np.sin(arc), color=COLORS[1])
    place = at + np.array([-0.32, 0.05])
    axes.annotate(f"$u_{{{3 * k + 3}}}$", place, ha="center", va="center", color=COLORS[1])


def positions(axes: Axes, now: np.ndarray) -> None:
    """Draw the initial position (dashed), the current one, and the directions of the nodes."""
    axes.plot(*NODES.T, "--o", color="0.5", mfc="w")
    axes.plot(*now.T, "-o", color=COLORS[0], lw=2.5)
    for k, (a, b) in enumerate(zip(NODES, now, strict=True)):
        axes.plot([a[0], b[0]], [a[1], b[1]], ":", color="0.6", lw=1.0)
        freedoms(axes, b, k)
        axes.annotate(f"{k + 1}", a + (0.05, -0.2), color="0.4")
    axes.set(xlim=(0.7, 4.9), ylim=(0.1, 4.4), xlabel="X", ylabel="Y")
    axes.set_title("Initial (dashed) and current position", **TITLE)


def angle(axes: Axes, at: np.ndarray, size: float, value: float, text: str) -> None:
    """Draw an angle from the X axis with its name."""
    axes.plot([at[0], at[0] + size + 0.3], [at[1], at[1]], ":", color="0.6", lw=1.0)
    arc = np.linspace(0.0, value, 30)
    axes.plot(at[0] + size * np.cos(arc), at[1] + size * np.sin(arc), color="0.5", lw=1.0)
    place = at + (size + 0.09) * np.array([np.cos(value / 2), np.sin(value / 2)])
    axes.annotate(text, place, va="center")


def section(axes: Axes, now: np.ndarray, u: np.ndarray, strains: np.ndarray) -> None:
    """Draw the section in the middle before and now, its normal, and the tangent of the axis."""
    eps, gam, kap = strains
    start = NODES[1] - NODES[0]
    first = np.arctan2(start[1], start[0])
    theta = first + u[:, 2].mean()
    normal = np.array([np.cos(theta), np.sin(theta)])
    across = np.array([-normal[1], normal[0]])
    tangent = (now[1] - now[0]) / np.hypot(*start)  # x' = (1 + eps) n + gam t
    assert np.allclose(tangent, (1.0 + eps) * normal + gam * across, atol=1e-9)
    middle, before = now.mean(axis=0), NODES.mean(axis=0)
    # initial position
    axes.plot(*NODES.T, "--", color="0.5")
    side = HALF * np.array([-np.sin(first), np.cos(first)])
    axes.plot(*np.array([before - side, before + side]).T, "--", color="0.5", lw=2.0)
    angle(axes, before, 0.6, first, r"$\theta_{in}$")
    # current position
    axes.plot(*now.T, "-", color=COLORS[0], lw=2.5)
    axes.plot(*np.array([middle - HALF * across, middle + HALF * across]).T, color="0.2", lw=3.0)
    angle(axes, middle, 0.5, theta, r"$\theta$")
    corner = middle + (1.0 + eps) * normal
    axes.plot(*np.array([middle, corner]).T, ":", color=COLORS[1])
    arrow(axes, middle, normal, "", COLORS[1])
    arrow(axes, middle, tangent, "", COLORS[2])
    arrow(axes, corner, gam * across, "", COLORS[3])
    axes.annotate(r"$\mathbf{n}$", middle + 0.85 * normal + (0.04, -0.2), color=COLORS[1])
    axes.annotate(r"$(1+\varepsilon)\,\mathbf{n}$", corner + (0.06, -0.12), color=COLORS[1])
    axes.annotate(r"$\gamma\,\mathbf{t}$", corner + (0.02, 0.12), color=COLORS[3])
    place = middle + 0.75 * tangent + (-0.22, 0.08)
    axes.annotate("x'", place, color=COLORS[2], fontweight="bold")
    values = rf"$\varepsilon$ = {eps:.3f}, $\gamma$ = {gam:.3f}, $\kappa$ = {kap:.3f} /m"
    axes.set(xlim=(0.8, 4.9), ylim=(0.3, 4.1), xlabel="X")
    axes.set_title(f"Section of its middle: {values}", **TITLE)


def main(folder: Path) -> None:
    """Draw both."""
    u, strains = solved()
    now = NODES + u[:, :2]
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(11, 4.6), layout="constrained")
        positions(axes[0], now)
        section(axes[1], now, u, strains)
        for one in axes:
            one.set_aspect("equal")
            one.grid(visible=False)
        figure.savefig(folder / "planar_element.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
