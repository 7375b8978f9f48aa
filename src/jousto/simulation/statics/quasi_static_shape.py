"""Bending: quasi-static shape of elastic bodies in a driven motion, without vibration."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array
from jousto.model.model import Model
from jousto.model.native.native import IMAGINARY, Engine, displaced
from jousto.model.scales import velocity_metres
from jousto.simulation.modes.linear import free_motions

ITERATIONS = 40  # maximum number of Newton iterations
CLOSE = 1e-11  # increment over the size of the mechanism at which the iteration has converged
FAR = 1e3  # increment over the size of the mechanism above which the iteration has diverged


class Bending:
    """Solver for elastic bodies in equilibrium with loads and inertia of a driven motion.

    At a time t the positions solve ``C(q, t) = 0`` and ``M a + Cq^T lam = Q``. The velocities and
    accelerations are those of the drives with the smallest modal part: the bodies bend, but their
    modes do not vibrate.

    Parameters
    ----------
    model : Model
        Model whose joints and drives prescribe all rigid motions.
    """

    def __init__(self, model: Model) -> None:
        self._model, self._metres = model, velocity_metres(model)
        self._twin = Engine(model, complex_scalars=True)
        self._modal = np.array(
            [body.iv + 6 + j for body in model.bodies for j in range(body.n)], dtype=int
        )

    def settle(self, engine: Engine) -> bool:
        """Set q, v and lam of the engine to the solution at its time; False if it diverged."""
        Cq, K = self._slopes(engine)
        rows = engine.row_metres
        N, inverse = free_motions(rows[:, None] * Cq / self._metres)
        N, inverse = N / self._metres[:, None], inverse / self._metres[:, None] * rows
        bend = np.linalg.pinv(N[self._modal])
        stiffness = N.T @ K @ N
        for _ in range(ITERATIONS):
            v, a = self._motion(engine, N, inverse, bend)
            engine.v[:], engine.a[:] = v, a
            r, c = engine.residual(), engine.constraints()[0]
            closing = -inverse @ c
            move = closing + N @ np.linalg.solve(stiffness, -N.T @ (r + K @ closing))
            far = np.abs(move * self._metres).max(initial=0.0) / self._model.size
            if not far < FAR:
                return False
            engine.q[:] = displaced(self._model, engine.q, move)
            engine.lam[:] -= inverse.T @ (r + K @ move)
            if far <= CLOSE:
                engine.v[:] = self._motion(engine, N, inverse, bend)[0]
                return True
        return False

    def _motion(self, engine: Engine, N: Array, inverse: Array, bend: Array) -> tuple[Array, Array]:
        """Return velocities and accelerations (nv,) of the drives with the smallest modal part."""
        twin, model = self._twin, self._model
        twin.q[:], twin.v[:], twin.time[0] = engine.q, 0.0, engine.time[0]
        v = -inverse @ twin.constraints()[1].real
        v -= N @ (bend @ v[self._modal])
        twin.q[:] = displaced(model, engine.q, 1j * IMAGINARY * v)
        twin.v[:], twin.time[0] = v, engine.time[0] + 1j * IMAGINARY
        a = -inverse @ (twin.constraints()[1].imag / IMAGINARY)
        a -= N @ (bend @ a[self._modal])
        return v, a

    def _slopes(self, engine: Engine) -> tuple[Array, Array]:
        """Return Cq (nrow, nv) and the derivative K (nv, nv) of the residual by q."""
        model, twin = self._model, self._twin
        for name in (
            "v",
            "a",
            "lam",
            "time",
            "input",
            "turn",
            "locked",
            "slip",
            "happened",
            "states",
        ):
            getattr(twin, name)[:] = getattr(engine, name)
        Cq, K = np.zeros((model.nrow, model.nv)), np.zeros((model.nv, model.nv))
        for j, move in enumerate(engine.increments().T):
            twin.q[:] = engine.q + 1j * IMAGINARY * move
            K[:, j] = twin.residual().imag / IMAGINARY
            Cq[:, j] = twin.constraints()[0].imag / IMAGINARY
        return Cq, K
