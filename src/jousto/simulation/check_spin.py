"""Does a flexible body spin too fast for its linear modes? Asked of the rows of a run."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from jousto.model.model import Model

# share of the body's lowest frequency: there the lowest flap frequency of a linear cantilever is
# 8 % low (Wright and others, J. Appl. Mech. 49 (1982) 197-202)
LIMIT = 0.2


class Spin:
    """How fast a flexible body without geometric stiffening spins.

    Only the spin that stretches it counts, ``w^T J w / max(J)``: a shaft that turns about its own
    axis does not.
    """

    def __init__(self, model: Model, index: int) -> None:
        body = model.bodies[index]
        self.index = index
        start = 1 + model.nq + body.iv + 3
        self._name = body.name
        self._columns = slice(start, start + 3)
        self._lowest = float(np.sqrt(body.K.min()))
        c = body.S0 / body.mass[0]
        xx, yy, zz, yz, xz, xy = body.J0
        J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        J = J - body.mass[0] * (c @ c * np.eye(3) - np.outer(c, c))
        self._shape = J / np.linalg.eigvalsh(J)[-1]

    def squared(self, rows: NDArray[np.float64]) -> float:
        """Return the square of the fastest spin in rows of the engine, (rad/s)2."""
        w = rows[:, self._columns]
        return float(np.einsum("ti,ti->t", w @ self._shape, w).max(initial=0.0))

    def share(self, squared: float) -> float:
        """Return the spin over the lowest natural frequency of the body."""
        return float(np.sqrt(squared)) / self._lowest

    def sentence(self, squared: float) -> str:
        """Return what is wrong with such a spin and what to do, empty if nothing is."""
        speed = float(np.sqrt(squared))
        share = self.share(squared)
        if share < LIMIT:
            return ""
        return (
            f"body '{self._name}' spins with up to {speed:.3g} rad/s, {100 * share:.0f} % of its "
            f"lowest natural frequency of {self._lowest / (2 * np.pi):.3g} Hz, and is linear: "
            f"above {100 * LIMIT:.0f} % it bends too far and in the end diverges; reduce its part "
            "with stiffening=True (parts of beams or solids), or cut it into several bodies fixed "
            "together"
        )


_KNOWN: WeakKeyDictionary[Model, tuple[Spin, ...]] = WeakKeyDictionary()


def spins(model: Model) -> tuple[Spin, ...]:
    """Return the spins of a model that are looked at, found once."""
    if model not in _KNOWN:
        some = [k for k, body in enumerate(model.bodies) if body.n and not body.stiffening]
        _KNOWN[model] = tuple(Spin(model, k) for k in some)
    return _KNOWN[model]
