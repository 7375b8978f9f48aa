"""Natural frequencies of a portal frame of three bodies joined by fixed joints.

Two columns and a beam are reduced one by one (Craig-Bampton) and joined as bodies. With all modes
of each the frame has the frequencies of one finite element model of the whole; with few it is
stiffer, and its frequencies fall towards them from above as modes are added (Rayleigh, Ritz).
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import scipy.linalg

import jousto as jo
from jousto.output.style import COLORS, STYLE

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
SECTION = jo.Rectangle(0.06, 0.04)
HEIGHT, WIDTH = 1.0, 1.5  # m
KEPT = (0, 1, 2, 4, 6, 8, 12, 16, 20, 24, 30)  # fixed-interface modes; 18 and 30 are all
TEN = 10


def whole() -> np.ndarray:
    """First ten natural frequencies (Hz) of the finite element model, its feet clamped."""
    corners = [(0, 0, 0), (0, 0, HEIGHT), (WIDTH, 0, HEIGHT), (WIDTH, 0, 0)]
    # the narrow side of the columns as those of the bodies below stand
    ups = [(-1, 0, 0), (0, 0, 1), (1, 0, 0)]
    members = [
        jo.Member(a, b, SECTION, STEEL, n, orientation=up)
        for a, b, n, up in zip(corners, corners[1:], (4, 6, 4), ups, strict=False)
    ]
    part = jo.Part.from_members(members)
    free = np.flatnonzero(part.nodes[:, 2] > 1e-9)
    dofs = (6 * free[:, None] + np.arange(6)).ravel()
    K, M = (matrix.toarray()[np.ix_(dofs, dofs)] for matrix in (part.K, part.M))
    values = scipy.linalg.eigh(K, M, eigvals_only=True)[:TEN]
    return np.sqrt(values) / (2 * np.pi)


def frame(modes: int) -> jo.Mechanism:
    """The same of three bodies with so many fixed-interface modes each."""

    def reduced(length: float, elements: int) -> jo.ReducedPart:
        part = jo.Part.beam(length, SECTION, elements, STEEL)
        every = 6 * (elements - 1)
        return jo.reduce(part, jo.CraigBampton(("start", "end"), modes=min(modes, every)))

    up, across = reduced(HEIGHT, 4), reduced(WIDTH, 6)
    left = jo.FlexibleBody("left", up, orientation=jo.Rotate((0, 1, 0), degrees=-90.0))
    beam = jo.FlexibleBody("beam", across, position=(0, 0, HEIGHT))
    turned = jo.Rotate((0, 1, 0), degrees=90.0)
    right = jo.FlexibleBody("right", up, position=(WIDTH, 0, HEIGHT), orientation=turned)
    joints = [
        jo.Fixed("left foot", jo.ground["origin"], left["start"]),
        jo.Fixed("left corner", left["end"], beam["start"]),
        jo.Fixed("right corner", beam["end"], right["start"]),
        jo.Fixed("right foot", jo.ground.at((WIDTH, 0, 0)), right["end"]),
    ]
    return jo.Mechanism(left, beam, right, *joints, name="portal")


def draw(errors: np.ndarray, path: Path) -> None:
    """Relative error of the frequencies against the modes kept."""
    with plt.style.context(STYLE):
        figure, ax = plt.subplots(figsize=(6.4, 3.9), layout="constrained")
        drawn = ((0, "o-"), (2, "s-"), (5, "^-"), (9, "d-"))
        for (k, style), color in zip(drawn, COLORS, strict=False):
            label = f"frequency {k + 1}"
            ax.semilogy(KEPT, np.maximum(errors[:, k], 1e-12), style, label=label, color=color)
        ax.set_title("Frequencies of the frame lie above those of the whole", loc="left")
        ax.set(xlabel="fixed-interface modes of each body", ylabel="relative error")
        ax.legend()
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Compare and draw; return 0 if the frequencies fall to those of the whole."""
    out.mkdir(parents=True, exist_ok=True)
    exact = whole()
    found = []
    with warnings.catch_warnings():
        # a pair of equal frequencies may be cut in two; its error is what is shown
        warnings.filterwarnings("ignore", message=".*have the same frequency")
        for modes in KEPT:
            found.append(jo.modes(jo.compile(frame(modes))).frequencies[:TEN])
    errors = np.array(found) / exact - 1
    for modes, row in zip(KEPT, errors, strict=True):
        print(f"{modes:3} modes each: worst of ten {row.max():9.2e}, first {row[0]:9.2e}")
    draw(errors, out / "portal_frame.png")
    good = errors.min() > -1e-8 and np.diff(errors, axis=0).max() < 1e-8 and errors[-1].max() < 1e-6
    print("the frame is that of the whole" if good else "THE FRAME IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
