"""Draw a planar beam element whose nodes lie off its axis, and the forces that they take over.

.venv/bin/python docs/pictures/offset_element.py FOLDER

After figure 3 of Makinen, Marjamaki and Pajunen. The element is a soft one in equilibrium; the ends
of its axis are the slaves of its nodes, and `jousto.planar` computes both.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from planar_element import SECTION, TITLE, arrow, freedoms

import jousto as jo
from jousto.output.style import COLORS, STYLE
from jousto.planar import PlanarBeam, PlanarLoad, PlanarSupport, load_steps

NODES = np.array([[0.5, 0.9], [3.1, 0.9]])  # m
ARMS = np.array([[0.0, -0.7], [0.4, -0.7]])  # from node to axis, m
LOAD = (14.0, 6.0, -14.0)  # N, N, N m on node 2
AXIS, ARM, GREY = COLORS[0], COLORS[1], "0.5"
TURN, SHIFT = 0.3, np.array([0.95, 1.15])  # of the whole current position, to see both; rad, m
FORCE = 0.055  # m/N of the arrows
Sides = tuple[tuple[float, float], tuple[float, float]]  # of two texts from their places, m


def solved() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Positions of nodes and of ends of the axis (2, 2), forces on ends and on nodes (2, 3)."""
    frame = jo.planar.PlanarFrame(
        NODES,
        [PlanarBeam(0, 1, SECTION, offset_a=tuple(ARMS[0]), offset_b=tuple(ARMS[1]))],
        supports=[PlanarSupport(0, rotation=True)],
        loads=[PlanarLoad(1, force=LOAD[:2], moment=LOAD[2])],
    )
    path = load_steps(frame, np.linspace(0.0, 1.0, 21))
    system, still = frame.system, np.zeros(frame.system.size)
    point = system.evaluate(path.q[-1], still, still, system.at_factor(1.0))
    ends = point.slaves.u.reshape(-1, 3)[2:, :2]  # after those of the nodes
    forces = point.inner.reshape(-1, 3)[2:]
    on_nodes = system.elimination.force(path.q[-1], point.inner).reshape(-1, 3)
    assert np.allclose(on_nodes[1], LOAD, atol=1e-6)
    return (
        *map(moved, (path.positions[-1], NODES + ARMS + ends)),
        turned(forces),
        turned(on_nodes),
    )


def turned(vectors: np.ndarray) -> np.ndarray:
    """Return vectors, with moments in a third column or without, turned as a whole."""
    c, s = np.cos(TURN), np.sin(TURN)
    return np.column_stack([vectors[:, :2] @ np.array([[c, s], [-s, c]]), vectors[:, 2:]])


def moved(places: np.ndarray) -> np.ndarray:
    """Return places turned and shifted as a whole, which changes no strain."""
    return turned(places) + SHIFT


def shape(axes: Axes, nodes: np.ndarray, ends: np.ndarray, color: str, line: str) -> None:
    """Draw the axis, the arms to it and the nodes."""
    axes.plot(*ends.T, line, color=color, lw=2.4 if line == "-" else 1.2)
    for node, end in zip(nodes, ends, strict=True):
        axes.plot(*np.array([node, end]).T, line, color=ARM if line == "-" else GREY, lw=1.6)
    axes.plot(*ends.T, "o", color=color, mfc="w", ms=5)
    axes.plot(*nodes.T, "s", color=ARM if line == "-" else GREY, ms=6)


def positions(axes: Axes, nodes: np.ndarray, ends: np.ndarray) -> None:
    """Draw both positions with the displacements of the nodes and the arm of node 1."""
    shape(axes, NODES, NODES + ARMS, GREY, "--")
    shape(axes, nodes, ends, AXIS, "-")
    for k, node in enumerate(nodes):
        freedoms(axes, node, k)
    middle = NODES[0] + 0.5 * ARMS[0]
    axes.annotate("arm (X, Y)", middle + (0.08, 0.0), color="0.4", va="center")
    axes.annotate("R(θ) (X, Y)", 0.5 * (nodes[0] + ends[0]) + (0.1, 0.0), color=ARM, va="center")
    axes.annotate("node, master", NODES[1] + (0.15, 0.0), color="0.4", va="center")
    axes.annotate("end of the axis, slave", ends[1] + (0.1, -0.38), color=AXIS, ha="right")
    axes.set_title("Nodes beside the axis: initial (dashed), current", **TITLE)


def forces(axes: Axes, places: np.ndarray, values: np.ndarray, color: str, texts: Sides) -> None:
    """Draw the force at each place, with its components and its moment beside it."""
    for place, (fx, fy, moment), side in zip(places, values, texts, strict=True):
        arrow(axes, place, FORCE * np.array([fx, fy]), "", color)
        text = f"({fx:.1f}, {fy:.1f}) N\n{moment:.1f} N m"
        axes.annotate(text, place + side, color=color, va="center", ha="center")


def main(folder: Path) -> None:
    """Draw the element, and its forces on the ends of the axis and on the nodes."""
    nodes, ends, on_ends, on_nodes = solved()
    with plt.rc_context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(11, 5.0), layout="constrained")
        positions(left, nodes, ends)
        shape(right, nodes, ends, AXIS, "-")
        forces(right, ends, on_ends, AXIS, ((0.6, -0.25), (-0.2, -0.35)))
        forces(right, nodes, on_nodes, ARM, ((0.25, 0.35), (-0.5, 0.3)))
        right.set_title("F on the axis, F$_m$ = B$^T$ F on the nodes", **TITLE)
        for axes in (left, right):
            axes.set_aspect("equal")
            axes.set(xlim=(-0.1, 5.4), ylim=(-0.1, 4.0), xlabel="X")
            axes.grid(visible=False)
        figure.savefig(folder / "offset_element.png", dpi=110)
        plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
