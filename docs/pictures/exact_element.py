"""Draw an element of an exact beam in space: its nodes, its end frames and the frame in its middle.

.venv/bin/python docs/pictures/exact_element.py FOLDER

One very soft element at rest under a force and a torque. The middle frame and the strains drawn
follow from the ends by the equations of docs/exact-beam-elements.md; they are those of the engine.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from planar_element import TITLE, arrow
from scipy.spatial.transform import Rotation

import jousto as jo
from jousto.output.style import COLORS, STYLE

SECTION = jo.mechanism.BeamSection((200.0, 50.0, 50.0, 60.0, 60.0, 60.0), 1.0, (1.0, 0.5, 0.5))
LENGTH, ARM = 2.0, np.array([0.0, 0.0, 0.45])  # m; from node to axis
FORCE, TORQUE = (14.0, 14.0, 14.0), (26.0, -8.0, 14.0)  # N, N m
SIZE = 0.42  # of the axes of a frame, m
Frame = tuple[np.ndarray, Rotation]  # origin and orientation
AXES = (COLORS[1], COLORS[2], COLORS[3])
# picture axes, to the right and up, in x, y, z: seen from the front, the right and above
VIEW = np.array([[0.94, -0.12], [0.34, 0.33], [0.0, 0.94]])


def solved() -> tuple[list[Frame], np.ndarray]:
    """Place and orientation of both nodes at rest, and the strains of the element."""
    points = [(0, 0, 0), (LENGTH, 0, 0)]
    beam = jo.BeamBody("beam", points, SECTION, elements=1, up=(0, 0, 1), offset=tuple(ARM[1:]))
    load = jo.Input("load")
    machine = jo.Mechanism(
        beam,
        jo.Fixed("wall", jo.ground["origin"], beam["start"]),
        jo.Force("force", beam["end"], FORCE, signal=load),
        jo.Torque("torque", beam["end"], TORQUE, signal=load),
        jo.mechanism.SectionSensor("strains", beam, element="e1", quantity="strains"),
    )
    path = jo.simulation.load_path(jo.compile(machine), "load", to=1.0, steps=10)
    q = path.states[-1].q.reshape(2, 7)
    frames = [(row[:3], Rotation.from_quat(row[3:], scalar_first=True)) for row in q]
    return frames, path["strains"][-1]


def middle(a: Frame, b: Frame) -> tuple[Frame, np.ndarray]:
    """Return the middle frame of two ends, and the strains Gamma and kappa in it."""
    turn = a[1].inv() * b[1]
    half = a[1] * Rotation.from_rotvec(0.5 * turn.as_rotvec())
    gamma = half.inv().apply(b[0] - a[0]) / LENGTH - np.array([1.0, 0.0, 0.0])
    return (0.5 * (a[0] + b[0]), half), np.r_[gamma, turn.as_rotvec() / LENGTH]


def seen(places: np.ndarray) -> np.ndarray:
    """Return the picture (2,) or (n, 2) of places or vectors in space, by parallel projection."""
    return np.asarray(places @ VIEW)


def triad(axes: Axes, frame: Frame, name: str) -> None:
    """Draw the three axes of a frame with its name."""
    at = seen(frame[0])
    for number, (axis, color) in enumerate(zip(frame[1].as_matrix().T, AXES, strict=True)):
        arrow(axes, at, SIZE * seen(axis), f"{name}{number + 1}", color)


def beam(axes: Axes, nodes: np.ndarray, ends: np.ndarray, line: str, color: str) -> None:
    """Draw the axis between the ends, and the arms from the nodes."""
    axes.plot(*seen(ends).T, line, color=color, lw=2.4 if line == "-" else 1.2)
    for pair in zip(nodes, ends, strict=True):
        axes.plot(*seen(np.array(pair)).T, line, color="0.45", lw=1.4)
    axes.plot(*seen(ends).T, "o", color=color, mfc="w", ms=5)
    axes.plot(*seen(nodes).T, "s", color="0.35", ms=6)


def title(strains: np.ndarray) -> str:
    """Return the strains as text."""
    parts = zip(("Γ", "κ"), strains.reshape(2, 3), strict=True)
    texts = [f"{name} = ({x:.2f}, {y:.2f}, {z:.2f})" for name, (x, y, z) in parts]
    return f"Strains of the middle frame m: {', '.join(texts)} /m"


def main(folder: Path) -> None:
    """Draw the element before and under its load."""
    nodes, strains = solved()
    ends = [(place + turn.apply(ARM), turn) for place, turn in nodes]
    centre, found = middle(*ends)
    assert np.allclose(found, strains, atol=1e-9)  # the equations of the page are the engine's
    start = np.array([[0.0, 0.0, 0.0], [LENGTH, 0.0, 0.0]])
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(9, 4.6))
        beam(axes, start, start + ARM, "--", "0.6")
        beam(axes, np.array([n[0] for n in nodes]), np.array([e[0] for e in ends]), "-", COLORS[0])
        for frame, name in zip((*ends, centre), "abm", strict=True):
            triad(axes, frame, name)
        for (place, _), name in zip(nodes, ("node a", "node b"), strict=True):
            axes.annotate(name, seen(place) + (0.07, -0.02), color="0.35", va="center")
        axes.set_axis_off()
        axes.set_aspect("equal")
        axes.margins(0.12, 0.05)
        low, high = axes.get_ylim()
        axes.set_ylim(low, high + 1.1 * SIZE)  # for the axes of frame b
        axes.set_title(title(strains), **TITLE)
        figure.savefig(folder / "exact_element.png", dpi=160, bbox_inches="tight", pad_inches=0.12)
        plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
