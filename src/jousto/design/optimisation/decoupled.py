"""Decoupled problems: each flexible part alone under frozen loads of a rigid machine."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem as Trouble
from jousto.design.optimisation.elastic import Elastic, Motion
from jousto.design.optimisation.problem import Problem
from jousto.design.optimisation.rigid_options import RigidMachine
from jousto.design.optimisation.structure import StructureProblem


class Decoupled(Problem):
    """Base class: the problem of a machine with the vibration of each part alone.

    Parameters
    ----------
    true : Problem
        Problem of the flexible machine.
    options : RigidMachine

    Attributes
    ----------
    runs : int
        Runs of the parts alone.
    rigid_runs : int
        Runs of the rigid machine.
    """

    def __init__(self, true: Any, options: RigidMachine) -> None:
        super().__init__(true.parameters, true.limits)
        self.true, self.options, self.rigid_runs = true, options, 0

    def cost(self, x: Array) -> float:
        """Return the cost of a design."""
        return float(self.true.cost(x))

    def elastic(self, x: Array) -> tuple[Elastic, ...]:
        """Return the static models of the flexible bodies."""
        return tuple(self.true.bodies(x))

    def frequencies(self, x: Array) -> Array:
        """Return the natural frequencies of the flexible machine, Hz."""
        return np.asarray(self.true.frequencies(x))

    @abstractmethod
    def freeze(self, x: Array) -> float:
        """Run the rigid machine of a design and keep its loads for all designs.

        Returns
        -------
        float
            Relative change of the interface loads since the last call; NaN at the first one.
        """

    def follow(self, size: float) -> None:
        """Let the frozen loads follow the design to first order.

        Parameters
        ----------
        size : float
            Step of the differences as a share of the span of each parameter.
        """
        return None

    def carriers(self, x: Array) -> dict[str, float]:
        """Return ``m / (M + m0)`` of each part: its moving mass over the mass that carries it."""
        return {}

    def springs(self, x: Array) -> dict[str, float]:
        """Return the stiffness of forces on each part over its own, which has no effect alone."""
        return {}

    def other(self) -> Decoupled | None:
        """Return this problem with the parts held the other way, under the same loads."""
        return None


class DecoupledStructure(Decoupled):
    """A supported structure whose parts vibrate alone.

    The rigid structure is at rest, so that its interface loads are the forces beyond each interface
    and depend on no parameter. With ``u = sum T_i s_i`` the columns of T_i move the nodes of part i
    and, as a rigid body, those of the parts beyond it: ``T^T K T`` has one block for each part.
    """

    def __init__(self, true: StructureProblem, options: RigidMachine) -> None:
        super().__init__(true, options)
        if options.held != "motion":
            message = "held is 'force', but the structure is supported: use 'motion'"
            raise InputError(Trouble("optimise", message))

    def freeze(self, x: Array) -> float:
        """Return 0: a rigid structure does not move, and its loads do not change."""
        self.rigid_runs += 1
        return 0.0 if self.rigid_runs > 1 else float("nan")

    def run(self, x: Array) -> tuple[Motion, ...]:
        """Return the sum of the motions of all parts, each alone."""
        M, K = self.true.matrices(x)
        if M is None:
            return tuple(self.true.run(x))
        parts = [
            self.true.vibration(self._mass(M, T, own), T.T @ K @ T, T)
            for own, T in zip(self.true.components.values(), carried(K, self.true), strict=True)
        ]
        shapes = np.hstack([shape for shape, _ in parts])
        q = np.vstack([motion for _, motion in parts])
        return (Motion(0, "", self.true.time, shapes, q),)

    def _mass(self, M: Array, T: Array, own: Any) -> Array:
        """Return the mass of a part, with that of the parts beyond it if it carries them."""
        return np.asarray(T.T @ M @ T if self.options.beyond else M[np.ix_(own, own)])


def carried(K: Array, problem: StructureProblem) -> list[Array]:
    """Return the motion T_i (n, n_i) of all nodes with those of each part, the others rigid.

    Parts that are nearer to the support do not move; those beyond follow without strain energy:
    ``u_beyond = -K_bb^-1 K_bi``.
    """
    rows = list(problem.components.values())
    found = []
    for i, own in enumerate(rows):
        T = np.zeros((len(K), len(own)))
        T[own] = np.eye(len(own))
        if i + 1 < len(rows):
            beyond = np.concatenate(rows[i + 1 :])
            T[beyond] = -np.linalg.solve(K[np.ix_(beyond, beyond)], K[np.ix_(beyond, own)])
        found.append(T)
    return found
