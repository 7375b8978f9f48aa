"""Check of the bending of flexible bodies in a run against the range of linear modes."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import warn
from jousto.model.model import Model, Shape

FAR = 0.3  # largest relative rotation within a body in the range of linear modes, rad
"""A cantilever whose end rotates by this angle is 1 to 2 % stiffer than linear theory (Bisshopp and
Drucker, Q. Appl. Math. 3 (1945) 272-275), and linear theory neglects a shortening of 2 % of its
length; both errors grow with the square of the angle."""


def turn_within(shape: Shape, p: Array) -> float:
    """Return the largest relative rotation of element edges within a body, rad.

    An edge d that becomes d + u rotates by ``d x u / d^2``. The result is the largest difference of
    these vectors, component by component, which does not depend on the motion of the body frame.
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
    """Check of the largest bending of a flexible body in the rows of a run."""

    def __init__(self, model: Model, index: int) -> None:
        body = model.bodies[index]
        self._shape = model.shapes[index]
        self.name = body.name
        first = 1 + body.iq + 7
        self._columns = slice(first, first + body.n)
        # the rotation is a norm of p, so the sum of those of the modes is an upper bound
        self._each = np.array([turn_within(self._shape, p) for p in np.eye(body.n)])

    def furthest(self, rows: NDArray[np.float64]) -> float:
        """Return the largest rotation within the body in rows of the engine, rad; 0 below `FAR`."""
        p = rows[:, self._columns]
        most = np.abs(p) @ self._each
        k = int(np.argmax(most))
        return turn_within(self._shape, p[k]) if most[k] > FAR else 0.0

    def sentence(self, turn: float) -> str:
        """Return the warning for a rotation within the body; empty if it is below `FAR`."""
        if not turn > FAR:
            return ""
        return (
            f"body '{self.name}' bends by {turn:.2g} rad within itself, but its modes are "
            f"linear: beyond {FAR} rad its deflections have errors of per cents, which grow with "
            "the square, and its length grows; divide it into several bodies fixed together, or "
            "use a Beam, which is exact; or check the load and the units"
        )


_KNOWN: WeakKeyDictionary[Model, tuple[Bend, ...]] = WeakKeyDictionary()


def bends(model: Model) -> tuple[Bend, ...]:
    """Return the checks of the flexible bodies of a model (cached)."""
    if model not in _KNOWN:
        pairs = enumerate(zip(model.bodies, model.shapes, strict=True))
        some = [k for k, (body, shape) in pairs if body.n and len(shape.elements)]
        _KNOWN[model] = tuple(Bend(model, k) for k in some)
    return _KNOWN[model]


def warn_far(model: Model, q: Array, where: str) -> set[str]:
    """Warn of modal bodies bent by more than `FAR` at a position; return their names."""
    row = np.concatenate([[0.0], np.asarray(q, dtype=float)])[None]
    found = {bend.name: bend.sentence(bend.furthest(row)) for bend in bends(model)}
    far = {name for name, sentence in found.items() if sentence}
    for name in far:
        warn(where, found[name])
    return far
