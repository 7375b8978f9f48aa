"""Does a flexible body bend further than its modes, which are linear, can follow."""

from __future__ import annotations

import numpy as np

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


def warn_far(model: Model, q: Array, where: str) -> None:
    """Warn of bodies with modes that bend far at a position."""
    for body, shape in zip(model.bodies, model.shapes, strict=True):
        if not body.n or not len(shape.elements):
            continue
        turn = turn_within(shape, np.asarray(q[body.iq + 7 : body.iq + 7 + body.n], dtype=float))
        if turn > FAR:
            warn(
                where,
                f"body '{body.name}' bends by {turn:.2g} rad within itself, but its modes are "
                f"linear: beyond {FAR} rad deflections are wrong by per cents, growing with the "
                "square, and its length grows; cut it into several bodies fixed together, or use "
                "a Beam, which is exact; or check the load and the units",
            )
