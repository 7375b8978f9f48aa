"""Strain on the surface of beams anywhere along an element, from the stress at section points."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from jousto.base.arrays import Array
from jousto.reduction.fields.stress import StressModes

SAME = 1e-6
"""Share of a section's size within which two points of it are the same."""
_KNOWN: WeakKeyDictionary[StressModes, list[Element]] = WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class Element:
    """A beam element as its stress sites know it.

    Attributes
    ----------
    name : str
        Such as ``e3``.
    points : tuple of str
        Names of the section points that both ends have.
    a, b : tuple of int
        Their stress sites at both ends.
    origin : (3,) array
        Site of the first point at end a, m.
    axes : (3, 3) array
        Columns are the axes of the element, part frame.
    length : float
        Between the ends, m.
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
        """Least and largest coordinates of its section points, in its axes, m."""
        low, high = self.yz.min(axis=0), self.yz.max(axis=0)
        return np.array([0.0, *low]), np.array([self.length, *high])

    def nearest(self, local: Array) -> Array:
        """Return the place of the box that is nearest to a point in its axes."""
        low, high = self.box
        return np.minimum(np.maximum(local, low), high)

    def gap(self, x: Array) -> float:
        """Return how far a point is off the box, m."""
        local = self.axes.T @ (x - self.origin)
        return math.dist(local, self.nearest(local))


@dataclass(frozen=True, eq=False)
class Fibre:
    """A place on the surface of a beam.

    Attributes
    ----------
    element : Element
    s : float
        Share of the length from end a, 0 to 1.
    shares : (m,) array
        Weights of the section points; they add up to one.
    exact : bool
        Whether it is a named section point, where shear stress is known, too.
    x : (3,) array
        Position, part frame, m.
    distance : float
        From the point that was asked for, m.
    """

    element: Element
    s: float
    shares: Array
    exact: bool
    x: Array
    distance: float

    def sites(self, s: float | None = None) -> dict[int, float]:
        """Return stress sites with their weights, at the share s of the length."""
        at = self.s if s is None else s
        e = self.element
        out: dict[int, float] = {}
        for i, j, w in zip(e.a, e.b, self.shares, strict=True):
            if w != 0.0:
                out[i] = out.get(i, 0.0) + (1.0 - at) * w
                out[j] = out.get(j, 0.0) + at * w
        return {i: w for i, w in out.items() if w != 0.0}


def elements(stress: StressModes) -> list[Element]:
    """Return the beam elements whose stress sites are labelled ``e3.a.top``, ``e3.b.top``."""
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
    """Return the place within the outline of the section points that is nearest to x (3,), m.

    Axial stress is linear over a section, ``s11 = N/A + My z/Iy - Mz y/Iz``, so that three points
    that are not on a line give it everywhere.
    """
    gaps = np.array([element.gap(x) for element in beams])
    best = _on(beams[int(np.argmin(gaps))], x)
    # an element whose box is farther away than that has no nearer place; of equals the first counts
    near = np.flatnonzero(gaps <= best.distance * (1.0 + 1e-9) + 1e-12)
    best = _on(beams[near[0]], x)
    for i in near[1:]:
        other = _on(beams[i], x)
        if other.distance < best.distance * (1.0 - 1e-9) - 1e-15:
            best = other
    return best


def _on(element: Element, x: Array) -> Fibre:
    """Return the place of an element that is nearest to x."""
    along, *yz = element.nearest(element.axes.T @ (x - element.origin))
    shares, exact = _shares(element, np.array(yz))
    foot = element.origin + element.axes @ np.array([along, *(shares @ element.yz)])
    distance = float(np.linalg.norm(foot - x))
    return Fibre(element, float(along / element.length), shares, exact, foot, distance)


def _shares(element: Element, yz: Array) -> tuple[Array, bool]:
    """Return the weights of the section points at (y, z), and whether one of them is there."""
    away = np.linalg.norm(element.yz - yz, axis=1)
    i = int(np.argmin(away))
    if away[i] <= SAME * max(element.size, 1e-300) or len(element.yz) == 1:
        return np.eye(len(element.yz))[i], True
    # least norm: the weights that move least, exact for values linear over the section
    A = np.vstack([np.ones(len(element.yz)), element.yz.T / element.size])
    target = np.array([1.0, *(yz / element.size)])
    shares = np.linalg.lstsq(A, target, rcond=1e-9)[0]
    return shares, False
