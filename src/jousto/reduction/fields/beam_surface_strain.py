"""Strain on the surface of beams at any position along an element, from section points."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from jousto.base.arrays import Array
from jousto.reduction.fields.stress import StressModes

SAME = 1e-6
"""Largest distance of coincident section points / size of the section."""
_KNOWN: WeakKeyDictionary[StressModes, list[Element]] = WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class Element:
    """Beam element reconstructed from its stress sites.

    Attributes
    ----------
    name : str
        Such as ``e3``.
    points : tuple of str
        Names of the section points at both ends.
    a, b : tuple of int
        Stress sites of these points at end a and end b.
    origin : (3,) array
        Site of the first point at end a, m.
    axes : (3, 3) array
        Columns are the axes of the element, part frame.
    length : float
        Distance of the ends, m.
    yz : (m, 2) array
        Section points relative to the first one, m.
    """

    name: str
    points: tuple[str, ...]
    a: tuple[int, ...]
    b: tuple[int, ...]
    origin: Array
    axes: Array
    length: float
    yz: Array

    @property
    def size(self) -> float:
        """Largest distance of two section points along an axis, m."""
        return float(np.ptp(self.yz, axis=0).max())

    @cached_property
    def box(self) -> tuple[Array, Array]:
        """Smallest and largest coordinates of the section points, element axes, m."""
        low, high = self.yz.min(axis=0), self.yz.max(axis=0)
        return np.array([0.0, *low]), np.array([self.length, *high])

    def nearest(self, local: Array) -> Array:
        """Return the point of the box nearest to a point in element axes."""
        low, high = self.box
        return np.minimum(np.maximum(local, low), high)

    def gap(self, x: Array) -> float:
        """Return the distance of a point from the box, m."""
        local = self.axes.T @ (x - self.origin)
        return math.dist(local, self.nearest(local))


@dataclass(frozen=True, eq=False)
class Fibre:
    """Position on the surface of a beam.

    Attributes
    ----------
    element : Element
    s : float
        Position along the element, 0 at end a, 1 at end b.
    shares : (m,) array
        Weights of the section points; their sum is one.
    exact : bool
        Whether the position is a named section point, where shear stress is known, too.
    x : (3,) array
        Position, part frame, m.
    distance : float
        Distance from the requested point, m.
    """

    element: Element
    s: float
    shares: Array
    exact: bool
    x: Array
    distance: float

    def sites(self, s: float | None = None) -> dict[int, float]:
        """Return stress sites and their weights at the relative length s."""
        at = self.s if s is None else s
        e = self.element
        out: dict[int, float] = {}
        for i, j, w in zip(e.a, e.b, self.shares, strict=True):
            if w != 0.0:
                out[i] = out.get(i, 0.0) + (1.0 - at) * w
                out[j] = out.get(j, 0.0) + at * w
        return {i: w for i, w in out.items() if w != 0.0}


def elements(stress: StressModes) -> list[Element]:
    """Return the beam elements whose stress sites have labels like ``e3.a.top``, ``e3.b.top``."""
    if stress not in _KNOWN:
        _KNOWN[stress] = _elements(stress)
    return _KNOWN[stress]


def _elements(stress: StressModes) -> list[Element]:
    index = {label: i for i, label in enumerate(stress.labels)}
    groups: dict[str, list[tuple[str, int, int]]] = {}
    for label, i in index.items():
        element, mark, point = label.partition(".a.")
        j = index.get(f"{element}.b.{point}")
        if mark and j is not None:
            groups.setdefault(element, []).append((point, i, j))
    out = []
    for name, rows in groups.items():
        points, a, b = (tuple(column) for column in zip(*rows, strict=True))
        first = stress.positions[a[0]]
        axes = stress.axes[a[0]]
        along = stress.positions[b[0]] - first
        yz = (stress.positions[list(a)] - first) @ axes[:, 1:]
        length = float(np.linalg.norm(along))
        out.append(Element(name, points, a, b, first, axes, length, yz))
    return out


def nearest_fibre(beams: list[Element], x: Array) -> Fibre:
    """Return the position inside the outline of section points nearest to x (3,), m.

    Axial stress is linear over a section, ``s11 = N/A + My z/Iy - Mz y/Iz``, so that three points
    that are not on a line determine it everywhere.
    """
    gaps = np.array([element.gap(x) for element in beams])
    best = _on(beams[int(np.argmin(gaps))], x)
    # skip elements whose box is farther away; among equal distances the first element counts
    near = np.flatnonzero(gaps <= best.distance * (1.0 + 1e-9) + 1e-12)
    best = _on(beams[near[0]], x)
    for i in near[1:]:
        other = _on(beams[i], x)
        if other.distance < best.distance * (1.0 - 1e-9) - 1e-15:
            best = other
    return best


def _on(element: Element, x: Array) -> Fibre:
    """Return the position on an element that is nearest to x."""
    along, *yz = element.nearest(element.axes.T @ (x - element.origin))
    shares, exact = _shares(element, np.array(yz))
    foot = element.origin + element.axes @ np.array([along, *(shares @ element.yz)])
    distance = float(np.linalg.norm(foot - x))
    return Fibre(element, float(along / element.length), shares, exact, foot, distance)


def _shares(element: Element, yz: Array) -> tuple[Array, bool]:
    """Return the weights of the section points at (y, z), and whether (y, z) is one of them."""
    away = np.linalg.norm(element.yz - yz, axis=1)
    i = int(np.argmin(away))
    if away[i] <= SAME * max(element.size, 1e-300) or len(element.yz) == 1:
        return np.eye(len(element.yz))[i], True
    # weights of least norm, exact for values linear over the section
    A = np.vstack([np.ones(len(element.yz)), element.yz.T / element.size])
    target = np.array([1.0, *(yz / element.size)])
    shares = np.linalg.lstsq(A, target, rcond=1e-9)[0]
    return shares, False
