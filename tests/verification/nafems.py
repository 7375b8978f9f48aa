"""Two benchmarks of NAFEMS, *The Standard NAFEMS Benchmarks* (1990): LE1 and LE10.

Both are a quarter of an elliptic plate with an elliptic hole, ``(x/2)^2 + y^2 = 1`` inside and
``(x/3.25)^2 + (y/2.75)^2 = 1`` outside, in m; the wanted stress is that along y at D = (2, 0).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.materials.material import Material
from jousto.parts.loads import Pressure
from jousto.parts.part import Part
from parts.grids import grid
from verification.statics import Array, Solved, named, near, solve

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
LE1, LE10 = 92.7e6, -5.38e6
"""Published stress s22 at D, Pa."""


@dataclass(frozen=True)
class Plate:
    """A solved plate and the nodes at D."""

    solved: Solved
    at: Array

    @property
    def nodes(self) -> Array:
        """Stress s22 of the nodes at D, Pa."""
        return self.solved.s[self.at, 1]

    def skin(self, on: str) -> float:
        """Stress s22 at D of the free skin, Pa."""
        skin = self.solved.part.surface_stress(on)
        away = np.linalg.norm(skin.positions - self.solved.part.nodes[self.at[0]], axis=1)
        assert away.min() < 1e-9
        return float(skin.evaluate(self.solved.d.reshape(-1))[int(np.argmin(away)), 1])


def ellipses(kind: str, counts: tuple[int, int, int], bottom: float, top: float) -> Part:
    """The quarter plate; `counts` around, outwards and through the thickness."""

    def bend(x: Array) -> Array:
        angle = 0.5 * np.pi * (1.0 - x[:, 0])
        c, s = np.cos(angle), np.sin(angle)
        hole, rim = np.column_stack([2.0 * c, s]), np.column_stack([3.25 * c, 2.75 * s])
        flat = hole + x[:, 1:2] * (rim - hole)
        return np.column_stack([flat, bottom + (top - bottom) * x[:, 2]])

    mesh = grid(kind, counts, bend=bend)
    x = mesh.nodes
    rim = near((x[:, 0] / 3.25) ** 2 + (x[:, 1] / 2.75) ** 2, 1.0)
    return Part.solid(named(mesh, rim=rim, top=near(x[:, 2], top)), STEEL)


def le10(kind: str, counts: tuple[int, int, int] = (6, 6, 2)) -> Plate:
    """Thick plate, 0.6 m, under 1 MPa from above; its rim is held, in the middle upwards, too."""
    part = ellipses(kind, counts, -0.3, 0.3)
    x = part.nodes
    fixed = np.stack([near(x[:, 0], 0.0), near(x[:, 1], 0.0), np.zeros(len(x), dtype=bool)], axis=1)
    rim = np.array(part.node_sets["rim"])
    fixed[rim, :2] = True
    fixed[rim, 2] = near(x[rim, 2], 0.0)
    solved = solve(part, fixed, part.load(Pressure("top", 1e6)))
    away = np.linalg.norm(x - [2.0, 0.0, 0.3], axis=1)
    return Plate(solved, np.flatnonzero(away < 1e-9))


def le1(kind: str, counts: tuple[int, int, int] = (6, 4, 1)) -> Plate:
    """Membrane, 0.1 m, pulled outwards by 10 MPa at its rim; plane stress."""
    part = ellipses(kind, counts, 0.0, 0.1)
    x = part.nodes
    fixed = near(x, 0.0)
    solved = solve(part, fixed, part.load(Pressure("rim", -10e6)))
    return Plate(solved, np.flatnonzero(np.linalg.norm(x[:, :2] - [2.0, 0.0], axis=1) < 1e-9))
