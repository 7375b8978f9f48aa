"""Structural hot-spot stress of welds: surface stress extrapolated to the weld toe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array, Ints, Sparse, as_csr
from jousto.base.declare import Declared
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.fields import Choice, Label, field
from jousto.base.numbers import Number, Vector
from jousto.base.object_repr import describe
from jousto.mesh.reference import CORNERS, FACES, shape_functions
from jousto.parts.frames.stress import StressOperator
from jousto.parts.solids.stress import SolidStress

if TYPE_CHECKING:
    from jousto.parts.part import Part

Reading = Literal["fine", "coarse", "quadratic", "edge", "edge-coarse"]

READINGS: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "fine": ((0.4, 1.0), (1.67, -0.67)),
    "coarse": ((0.5, 1.5), (1.5, -0.5)),
    "quadratic": ((0.4, 0.9, 1.4), (2.52, -2.24, 0.72)),
    "edge": ((0.004, 0.008, 0.012), (3.0, -3.0, 1.0)),
    "edge-coarse": ((0.005, 0.015), (1.5, -0.5)),
}
"""Distances of the reading points from the toe, plate thicknesses (m for edges), and the weights of
their stresses: A. F. Hobbacher, Recommendations for Fatigue Design of Welded Joints and
Components, IIW 2016."""

SMOOTH = 0.5
"""Smallest cosine of the angle between neighbouring faces of one surface; smaller at a toe."""


@explained
def hot_spot_stress(stress: ArrayLike, reading: Reading = "fine") -> Array:
    """Return the structural hot-spot stress at a weld toe from stresses at its reading points.

    * ``fine``: ``1.67 s(0.4 t) - 0.67 s(1.0 t)``, elements of 0.4 t or less;
    * ``coarse``: ``1.50 s(0.5 t) - 0.50 s(1.5 t)``, one element through the plate;
    * ``quadratic``: ``2.52 s(0.4 t) - 2.24 s(0.9 t) + 0.72 s(1.4 t)``, steep bending;
    * ``edge``: ``3 s(4 mm) - 3 s(8 mm) + s(12 mm)``, toes on the edge of a plate (type b);
    * ``edge-coarse``: ``1.5 s(5 mm) - 0.5 s(15 mm)``.

    Parameters
    ----------
    stress : (m, ...) array_like
        Stresses at the reading points, the nearest first; from gauges or elements, any component.
    reading : str
        One of the five readings above.

    Raises
    ------
    InputError
        For an unknown reading, a wrong number of stresses, or one that is not finite.

    Examples
    --------
    >>> print(hot_spot_stress([120.0, 105.0]))
    130.05
    """
    _, weights = _reading("hot-spot stress", reading)
    s = np.asarray(stress, dtype=np.float64)
    if s.shape[:1] != (len(weights),):
        message = f"stress has shape {s.shape}, reading '{reading}' needs {len(weights)} stresses"
        raise InputError(Problem("hot-spot stress", message))
    if not np.all(np.isfinite(s)):
        raise InputError(Problem("hot-spot stress", "stresses must be finite numbers"))
    return np.asarray(np.tensordot(weights, s, axes=1))


def _reading(where: str, reading: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    if reading not in READINGS:
        raise InputError(Problem(where, f"reading is {reading!r}{suggest(reading, READINGS)}"))
    return READINGS[reading]


class ReadingWord(Choice):
    """Field with the name of a reading; a message suggests the nearest name."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the name, or report an unknown one."""
        if value not in self.words:
            problems.add(where, f"{self.name} is {value!r}{suggest(value, self.words)}")
        return value


class Triple(Vector):
    """Field with three numbers, stored as a tuple."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the three numbers as a tuple, or report wrong ones."""
        found = super().check(problems, where, value)
        return None if found is None else tuple(found.tolist())


class WeldToe(Declared, by_value=True):
    """Point on a weld toe for its structural hot-spot stress.

    Raises
    ------
    InputError
        With all values out of range.
    """

    kind = "weld toe"
    name: Label = field("Name of the stress site")
    at: Triple = field("Point on the toe, part frame", unit="m")
    away: Triple = field(
        "Direction in the surface of the plate, normal to the toe, away from the weld; part frame"
    )
    thickness: Number = field(
        "Plate thickness; not used by the readings of edges", unit="m", default=0.0
    )
    reading: ReadingWord = field(
        "Reading points and weights, see `hot_spot_stress`",
        words=tuple(READINGS),
        default="fine",
    )
    together = ("away", "thickness")
    __repr__ = describe

    def consistent(self, problems: Problems, where: str) -> None:
        """Add problems for a zero direction and a plate without thickness."""
        if not np.any(self.away):
            problems.add(where, "away is (0, 0, 0), must be a direction other than zero")
        if str(self.reading) in READINGS and not self.reading.startswith("edge"):
            problems.positive(where, "thickness", self.thickness, "m")

    @property
    def places(self) -> Array:
        """Reading points (m, 3), part frame, m."""
        distances, _ = READINGS[self.reading]
        scale = 1.0 if self.reading.startswith("edge") else self.thickness
        way = np.asarray(self.away) / np.linalg.norm(self.away)
        return np.asarray(np.asarray(self.at) + scale * np.array(distances)[:, None] * way)


@explained
def weld_stress(
    part: Part,
    toes: WeldToe | Sequence[WeldToe],
    *,
    add: StressOperator | SolidStress | None = None,
) -> StressOperator:
    """Return the structural hot-spot stress of weld toes as stress sites of a part of solids.

    The stress of the free surface (`Part.surface_stress`) is interpolated on the outer faces at
    the reading points of each toe and extrapolated to the toe. Axis 1 of a site is normal to the
    toe in the surface of the plate, axis 2 along the toe, axis 3 the outward normal: the FAT
    classes of fillet welds (FAT 90 or 100) apply to ``s11``. Faces beyond the toe, at an angle to
    the surface of the plate, are not used.

    Parameters
    ----------
    part : Part
        Part of solids.
    toes : WeldToe or sequence of them
        Weld toes.
    add : StressOperator or SolidStress, optional
        Further stress sites of the result, such as ``part.surface_stress()`` or ``part.stress``.

    Returns
    -------
    StressOperator
        Operator for ``part.with_stress``; reduction, results, sensors and fatigue refer to the
        toes by name.

    Raises
    ------
    InputError
        For a part without solids, a reading point off the surface, or a name used twice.
    """
    problems = Problems()
    every = problems.several("weld_stress", "toes", toes, WeldToe)
    where = f"part '{part.name}'"
    if part.solids is None:
        problems.add(where, "has no surface: only parts of solids (Part.solid) have one")
    names = [toe.name for toe in every] + ([] if add is None else list(add.sites))
    for name in sorted({name for name in names if names.count(name) > 1}):
        problems.add(where, f"stress site '{name}' is named more than once")
    problems.raise_if_any()

    rows: list[Sparse] = []
    axes: list[Array] = []
    constants: list[tuple[float, float] | None] = []
    for toe in every:
        row, axis, known = _site(part, toe, problems)
        rows.append(row)
        axes.append(axis)
        constants.append(known)
    problems.raise_if_any()
    matrix = as_csr(sp.vstack(rows, format="csr"))
    positions = np.array([toe.at for toe in every])
    both = [None if k is None else np.asarray(k) for k in constants]
    elasticity = None if any(k is None for k in both) else np.array(both)
    if add is not None:
        matrix = as_csr(sp.vstack([matrix, add.rows(add.sites)], format="csr"))
        positions = np.concatenate([positions, add.positions])
        axes += list(add.axes)
        if elasticity is not None:
            known_too = add.elasticity
            elasticity = None if known_too is None else np.concatenate([elasticity, known_too])
    return StressOperator(tuple(names), positions, np.array(axes), matrix, elasticity)


def _site(
    part: Part, toe: WeldToe, problems: Problems
) -> tuple[Sparse, Array, tuple[float, float] | None]:
    """Return rows (6, ndof), axes and material of a toe; add problems off the surface."""
    where = f"weld toe '{toe.name}'"
    _, weights = READINGS[toe.reading]
    away = np.asarray(toe.away) / np.linalg.norm(toe.away)
    total = sp.csr_array((6, part.K.shape[0]))
    axes: Array = np.eye(3)
    known: tuple[float, float] | None = None
    span = float(np.linalg.norm(toe.places[-1] - toe.at))
    assert part.solids is not None
    for place, weight in zip(toe.places, weights, strict=True):
        found = locate(part, place)
        if found is None or found.distance > 0.05 * span:
            how = "no face near" if found is None else f"{1e3 * found.distance:.3g} mm off"
            problems.add(
                where,
                f"the reading point {np.round(place, 6).tolist()} m is not on the surface ({how}); "
                "check at, away and thickness",
            )
            return as_csr(total), axes, known
        n = found.normal
        if found.edge:
            problems.add(
                where,
                f"the reading point {np.round(place, 6).tolist()} m lies on an edge of the part; "
                "move the toe a little onto the intended surface",
            )
            return as_csr(total), axes, known
        operator = part.surface_stress(_smooth_patch(part, found))
        share = np.zeros((6, 6 * len(operator.sites)))
        label = {int(s[1:].split(".")[0]): i for i, s in enumerate(operator.sites)}
        for node, N in zip(found.nodes, found.N, strict=True):
            i = label[int(part.solids.node_ids[node])]
            share[:, 6 * i : 6 * i + 6] += weight * N * np.eye(6)
            if operator.elasticity is not None:
                known = (float(operator.elasticity[i, 0]), float(operator.elasticity[i, 1]))
        # axes: normal to the toe in the surface, along the toe, outward normal
        first = away - (away @ n) * n
        first /= np.linalg.norm(first)
        axes = np.stack([first, np.cross(n, first), n], axis=1)
        total = total + sp.csr_array(_turn(axes) @ share) @ operator.matrix
    return as_csr(total), axes, known


@dataclass(frozen=True, eq=False)
class OnSurface:
    """Point on an outer face: nodes, shape functions, outward normal and distance, m.

    `edge` is True if a neighbouring face at an angle is equally near.
    """

    nodes: Ints
    N: Array
    normal: Array
    distance: float
    edge: bool = False


def locate(part: Part, place: ArrayLike) -> OnSurface | None:
    """Return the point on the surface of a part of solids nearest to a point (3,) in m."""
    x = np.asarray(place, dtype=np.float64)
    best: OnSurface | None = None
    others: list[tuple[Array, float]] = []
    assert part.solids is not None
    for block in part.solids.faces:
        k = block.shape[1]
        kind = FACES[k][0]
        corners = block[:, : 3 if CORNERS[kind] == "triangle" else 4]
        p = part.nodes[corners]
        low, high = p.min(axis=1), p.max(axis=1)
        size = np.linalg.norm(high - low, axis=1)
        gap = np.linalg.norm(np.maximum(np.maximum(low - x, x - high), 0.0), axis=1)
        near = np.flatnonzero(gap <= gap.min() + 0.5 * size)
        for face in block[near[np.argsort(gap[near])][:40]]:
            found = _nearest(part.nodes[face], kind, x)
            others.append(found[1:])
            if best is None or found[2] < best.distance:
                best = OnSurface(face, found[0], found[1], found[2])
    if best is None:
        return None
    reach = best.distance + 1e-6 * float(np.ptp(part.nodes[best.nodes], axis=0).max())
    edge = any(d <= reach and n @ best.normal < SMOOTH for n, d in others)
    return replace(best, edge=edge)


def _nearest(nodes: Array, kind: str, x: Array) -> tuple[Array, Array, float]:
    """Return shape functions, normal and distance of the point of a face nearest to x."""
    triangle = CORNERS[kind] == "triangle"
    u = np.full(2, 1.0 / 3.0 if triangle else 0.5)
    for _ in range(30):
        N, dN = shape_functions(kind, u[None])
        r = N[0] @ nodes - x
        J = dN[0, :2] @ nodes
        step = np.linalg.solve(J @ J.T, J @ r)
        u = np.clip(u - step, 0.0, 1.0)
        if triangle and u.sum() > 1.0:
            u -= 0.5 * (u.sum() - 1.0)
            u = np.clip(u, 0.0, 1.0)
        if np.abs(step).max() < 1e-12:
            break
    N, dN = shape_functions(kind, u[None])
    J = dN[0, :2] @ nodes
    normal = np.cross(J[0], J[1])
    distance = float(np.linalg.norm(N[0] @ nodes - x))
    return N[0], normal / np.linalg.norm(normal), distance


def _smooth_patch(part: Part, found: OnSurface) -> Ints:
    """Return the nodes of the faces that form one smooth surface with a face."""
    assert part.solids is not None
    mine = np.zeros(len(part.nodes), dtype=bool)
    mine[found.nodes] = True
    chosen = [found.nodes]
    for block in part.solids.faces:
        touching = block[mine[block].any(axis=1)]
        if not len(touching):
            continue
        corners = touching[:, : 3 if touching.shape[1] in (3, 6) else 4]
        p = part.nodes[corners]
        normal = np.cross(p[:, 1] - p[:, 0], p[:, -1] - p[:, 0])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        chosen.append(touching[normal @ found.normal > SMOOTH].ravel())
    return np.unique(np.concatenate(chosen)).astype(np.int64)


def _turn(axes: Array) -> Array:
    """Return the matrix (6, 6) from stress in part axes to stress in `axes` (columns), Voigt."""
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
    T = np.zeros((6, 6))
    for row, (a, b) in enumerate(pairs):
        for column, (i, j) in enumerate(pairs):
            T[row, column] = axes[i, a] * axes[j, b]
            if i != j:
                T[row, column] += axes[j, a] * axes[i, b]
    return T
