"""Solids whose stress is known in closed form: geometry, load, supports, the exact values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse.linalg as spl
from numpy.typing import NDArray

from jousto.materials.material import Material
from jousto.parts.loads import Pressure, SurfaceLoad, Traction
from jousto.parts.part import Part
from jousto.parts.solids.stress import SolidStress
from parts.grids import grid

Array = NDArray[np.float64]
STEEL = Material(E=210e9, nu=0.3, rho=7850.0, name="steel")
DEPTH = 0.01


@dataclass(frozen=True)
class Solved:
    """A solved problem: the part, displacements (nn, 3) in m and stress (nn, 6) in Pa."""

    part: Part
    d: Array
    s: Array

    @property
    def size(self) -> int:
        """Degrees of freedom."""
        return 3 * len(self.part.nodes)


def solve(part: Part, fixed: NDArray[np.bool_], load: Array, given: Array | None = None) -> Solved:
    """Solve ``K d = f`` with displacements prescribed where fixed (nn, 3)."""
    d = np.where(fixed, 0.0 if given is None else given, 0.0).reshape(-1)
    free = np.flatnonzero(~fixed.reshape(-1))
    K = part.K.tocsr()
    d[free] = spl.spsolve(K[free][:, free].tocsc(), (load - K @ d)[free])
    assert isinstance(part.stress, SolidStress)
    return Solved(part, d.reshape(-1, 3), part.stress.evaluate(d))


def near(value: Array, wanted: float) -> NDArray[np.bool_]:
    return np.asarray(np.abs(value - wanted) < 1e-9)


def named(mesh: Any, **sets: NDArray[np.bool_]) -> Any:
    """The mesh with node sets where these are true."""
    for name, mask in sets.items():
        mesh = mesh.with_set(name, np.flatnonzero(mask))
    return mesh


def planes(part: Part, *, x: bool = True, y: bool = True) -> NDArray[np.bool_]:
    """Symmetry about x = 0 and y = 0, plane strain: no motion along z."""
    fixed = np.zeros(part.nodes.shape, dtype=bool)
    fixed[:, 2] = near(part.nodes[:, 2], 0.0) | near(part.nodes[:, 2], DEPTH)
    fixed[:, 0] = x & near(part.nodes[:, 0], 0.0)
    fixed[:, 1] = y & near(part.nodes[:, 1], 0.0)
    return fixed


# -- thick cylinder ----------------------------------------------------------------------------

BORE, OUTSIDE, INSIDE_PRESSURE = 0.1, 0.2, 1e8


def cylinder(kind: str, layers: int) -> Solved:
    """A quarter of a thick cylinder in plane strain under inner pressure."""

    def bend(x: Array) -> Array:
        r, angle = BORE + x[:, 1] * (OUTSIDE - BORE), 0.5 * np.pi * (1.0 - x[:, 0])
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), DEPTH * x[:, 2]])

    mesh = grid(kind, (2 * layers, layers, 1), bend=bend)
    r = np.hypot(mesh.nodes[:, 0], mesh.nodes[:, 1])
    part = Part.solid(named(mesh, bore=near(r, BORE)), STEEL)
    return solve(part, planes(part), part.load(Pressure("bore", INSIDE_PRESSURE)))


def lame(r: Array) -> tuple[Array, Array, Array]:
    """Radial stress, hoop stress and radial displacement of Lame's cylinder in plane strain."""
    a = INSIDE_PRESSURE * BORE**2 / (OUTSIDE**2 - BORE**2)
    b = a * OUTSIDE**2
    nu = STEEL.nu
    return a - b / r**2, a + b / r**2, (1 + nu) / STEEL.E * ((1 - 2 * nu) * a * r + b / r)


# -- hole in a wide plate ----------------------------------------------------------------------

HOLE, PULL = 0.01, 1e8


def kirsch_displacement(x: Array) -> Array:
    """Displacements (nn, 3) in plane strain; Kirsch 1898 in Kolosov's form."""
    r, angle = np.hypot(x[:, 0], x[:, 1]), np.arctan2(x[:, 1], x[:, 0])
    k, a = 3.0 - 4.0 * STEEL.nu, HOLE
    c, s, c3, s3 = np.cos(angle), np.sin(angle), np.cos(3 * angle), np.sin(3 * angle)
    u = r / a * (k + 1) * c + 2 * a / r * ((1 + k) * c + c3) - 2 * (a / r) ** 3 * c3
    v = r / a * (k - 3) * s + 2 * a / r * ((1 - k) * s + s3) - 2 * (a / r) ** 3 * s3
    return PULL * a / (8.0 * STEEL.G) * np.column_stack([u, v, 0.0 * u])


def wide_plate(kind: str, layers: int) -> Solved:
    """A quarter ring cut out of Kirsch's infinite plate, held on its outside as there."""
    far = 4.0 * HOLE

    def bend(x: Array) -> Array:
        r, angle = HOLE * (far / HOLE) ** x[:, 1], 0.5 * np.pi * (1.0 - x[:, 0])
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), DEPTH * x[:, 2]])

    mesh = grid(kind, (2 * layers, layers, 1), bend=bend)
    part = Part.solid(mesh, STEEL)
    fixed = planes(part)
    fixed[near(np.hypot(part.nodes[:, 0], part.nodes[:, 1]), far), :2] = True
    return solve(part, fixed, np.zeros(part.K.shape[0]), kirsch_displacement(part.nodes))


# -- plates of finite width --------------------------------------------------------------------


def strip(kind: str, layers: int, *, width: float, radius: float, notch: bool) -> Solved:
    """A quarter of a strip along x with a hole in its middle, or with two half-round notches.

    Between the arc and the outside runs a fan of elements, finer towards the arc.
    """
    half, length = 0.5 * width, 1.5 * width

    def bend(x: Array) -> Array:
        t, s = x[:, 0], x[:, 1] ** 1.7
        angle = 0.5 * np.pi * t
        arc = radius * np.column_stack([np.sin(angle), np.cos(angle)])
        # along the far side: across the strip's end and back along its edge
        outside = np.where(
            t[:, None] < 0.5,
            np.column_stack([2.0 * t * length, np.full(len(t), half)]),
            np.column_stack([np.full(len(t), length), half * 2.0 * (1.0 - t)]),
        )
        flat = arc + s[:, None] * (outside - arc)
        flat[:, 1] = half - flat[:, 1] if notch else flat[:, 1]
        z = DEPTH * (1.0 - x[:, 2] if notch else x[:, 2])
        return np.column_stack([flat, z])

    mesh = grid(kind, (4 * layers, 2 * layers, 1), bend=bend)
    part = Part.solid(named(mesh, end=near(mesh.nodes[:, 0], length)), STEEL)
    return solve(part, planes(part), part.load(Traction("end", (PULL, 0.0, 0.0))))


def howland(ratio: float) -> float:
    """Peak over gross stress at a hole of diameter ratio * width in a strip.

    Howland, Phil. Trans. R. Soc. A 229 (1930) 49-86, in the form that Pilkey, *Peterson's Stress
    Concentration Factors* (1997), chart 4.1 gives it.
    """
    rest = 1.0 - ratio
    return 0.284 + 2.0 / rest - 0.600 * rest + 1.32 * rest**2


def semicircular_notches(ratio: float) -> float:
    """Peak over net stress at two half-round notches whose depths are ratio * width together.

    Pilkey, *Peterson's Stress Concentration Factors* (1997), chart 2.4.
    """
    return 3.065 - 3.472 * ratio + 1.009 * ratio**2 + 0.405 * ratio**3


# -- cantilever --------------------------------------------------------------------------------

LENGTH, HEIGHT, BREADTH, TIP = 1.0, 0.1, 0.05, 1e4


def cantilever(kind: str, counts: tuple[int, int, int], nu: float = 0.0) -> Solved:
    """A clamped bar under a force across its end; without contraction beam theory is close."""
    mesh = grid(kind, counts, (LENGTH, BREADTH, HEIGHT))
    part = Part.solid(
        named(mesh, tip=near(mesh.nodes[:, 0], LENGTH)), Material(E=210e9, nu=nu, rho=7850.0)
    )
    fixed = np.zeros(part.nodes.shape, dtype=bool)
    fixed[near(part.nodes[:, 0], 0.0)] = True
    return solve(part, fixed, part.load(SurfaceLoad("tip", (0.0, 0.0, -TIP))))


def on_arc(solved: Solved, radius: float, centre: tuple[float, float] = (0.0, 0.0)) -> Any:
    """Skin stress on the arc: the angle from x of each site, and the stress (ns, 6)."""
    x = solved.part.nodes[:, :2] - centre
    skin = solved.part.surface_stress(np.flatnonzero(near(np.hypot(x[:, 0], x[:, 1]), radius)))
    place = skin.positions[:, :2] - centre
    return np.arctan2(place[:, 1], place[:, 0]), skin.evaluate(solved.d.reshape(-1))


def hoop(angle: Array, s: Array) -> Array:
    """Stress around the z axis at an angle from x."""
    c, n = np.cos(angle), np.sin(angle)
    return np.asarray(s[:, 0] * n**2 + s[:, 1] * c**2 - 2.0 * s[:, 3] * c * n)
