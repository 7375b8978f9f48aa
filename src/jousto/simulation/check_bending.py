"""How far flexible bodies bend in a run: modes, which are linear, cannot follow far."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import warn
from jousto.model.model import Model, Shape

FAR = 0.3  # rad between two places of a body
"""A cantilever that its end load turns by as much is 1 to 2 % stiffer than linear (Bisshopp and
Drucker, Q. Appl. Math. 3 (1945) 272-275), and its end misses the shortening of 2 % of its length;
both grow with the square."""


def turn_within(shape: Shape, p: Array) -> float:
    """Return by how much the sides of elements turn against one another, rad.

    A side d that becomes d + u turns by ``d x u / d^2``; the largest difference of these vectors,
    component by component, does not depend on the frame of the body.
    """
    u = shape.modes @ p
    ends = np.asarray(shape.elements)
    pairs = np.stack([ends, np.roll(ends, -1, axis=1)], axis=2).reshape(-1, 2)
    a, b = pairs[pairs[:, 0] != pairs[:, 1]].T
    d = shape.nodes[b] - shape.nodes[a]
    size = np.einsum("ij,ij->i", d, d)
    kept = size > 0.0
    if not kept.any():
        return 0.0
    turns = np.cross(d[kept], (u[b] - u[a])[kept]) / size[kept, None]
    return float(np.ptp(turns, axis=0).max())


class Bend:
    """How far a flexible body bends in the rows of a run."""

    def __init__(self, model: Model, index: int) -> None:
        body = model.bodies[index]
        self._shape = model.shapes[index]
        self.name = body.name
        first = 1 + body.iq + 7
        self._columns = slice(first, first + body.n)
        # the turn is a norm of p: no more than the sum of those of the modes
        self._each = np.array([turn_within(self._shape, p) for p in np.eye(body.n)])

    def furthest(self, rows: NDArray[np.float64]) -> float:
        """Return the turn within the body in the row that may bend it most, rad; 0 below `FAR`."""
        p = rows[:, self._columns]
        most = np.abs(p) @ self._each
        k = int(np.argmax(most))
        return turn_within(self._shape, p[k]) if most[k] > FAR else 0.0

    def sentence(self, turn: float) -> str:
        """Return what is wrong with such a turn and what to do, empty if nothing is."""
        if not turn > FAR:
            return ""
        return (
            f"body '{self.name}' bends by {turn:.2g} rad within itself, but its modes are "
            f"linear: beyond {FAR} rad deflections are wrong by per cents, growing with the "
            "square, and its length grows; cut it into several bodies fixed together, or use "
            "a Beam, which is exact; or check the load and the units"
        )


_KNOWN: WeakKeyDictionary[Model, tuple[Bend, ...]] = WeakKeyDictionary()


def bends(model: Model) -> tuple[Bend, ...]:
    """Return the bodies of a model that may bend far, found once."""
    if model not in _KNOWN:
        pairs = enumerate(zip(model.bodies, model.shapes, strict=True))
        some = [k for k, (body, shape) in pairs if body.n and len(shape.elements)]
        _KNOWN[model] = tuple(Bend(model, k) for k in some)
    return _KNOWN[model]


def warn_far(model: Model, q: Array, where: str) -> set[str]:
    """Warn of bodies with modes that bend far at a position; return their names."""
    row = np.concatenate([[0.0], np.asarray(q, dtype=float)])[None]
    found = {bend.name: bend.sentence(bend.furthest(row)) for bend in bends(model)}
    far = {name for name, sentence in found.items() if sentence}
    for name in far:
        warn(where, found[name])
    return far
