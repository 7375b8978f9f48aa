"""Check of the spin of flexible bodies in a run against the range of linear modes."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from jousto.model.model import Model

# largest spin over the lowest frequency of a body; at it the lowest flap frequency of a linear
# cantilever is 8 % too low (Wright and others, J. Appl. Mech. 49 (1982) 197-202)
LIMIT = 0.2


class Spin:
    """Largest spin of a flexible body without geometric stiffness in a run.

    Its square is ``w^T J w / max(J)``: the spin that stretches the body. It is almost zero for a
    shaft that turns about its own axis.
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
        """Return the ratio of the spin to the lowest natural frequency of the body."""
        return float(np.sqrt(squared)) / self._lowest

    def sentence(self, squared: float) -> str:
        """Return the warning for a spin; empty if the spin is below `LIMIT`."""
        speed = float(np.sqrt(squared))
        share = self.share(squared)
        if share < LIMIT:
            return ""
        return (
            f"body '{self._name}' spins with up to {speed:.3g} rad/s, {100 * share:.0f} % of its "
            f"lowest natural frequency of {self._lowest / (2 * np.pi):.3g} Hz, and is linear: "
            f"above {100 * LIMIT:.0f} % it bends too far and finally diverges; reduce its part "
            "with stiffening=True (parts of beams or solids), or divide it into several bodies "
            "fixed together"
        )


_KNOWN: WeakKeyDictionary[Model, tuple[Spin, ...]] = WeakKeyDictionary()


def spins(model: Model) -> tuple[Spin, ...]:
    """Return the checks of the flexible bodies without geometric stiffness (cached)."""
    if model not in _KNOWN:
        some = [k for k, body in enumerate(model.bodies) if body.n and not body.stiffening]
        _KNOWN[model] = tuple(Spin(model, k) for k in some)
    return _KNOWN[model]
