"""Coverage of loads by the modes of a reduced part: static work, reduced against full."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg

from jousto.base.arrays import Array, Ints
from jousto.certificate.basis_families import held_response
from jousto.certificate.certify import full_model
from jousto.certificate.interface_loads import elastic_response
from jousto.certificate.interface_modes import Modes, modes_of
from jousto.certificate.part_checks import FullModel
from jousto.reduction.frames.clamp import by_mean_axes

if TYPE_CHECKING:
    from jousto.reduction.reduced import ReducedPart


ON_INTERFACE = 1e-4
"""Work with fixed interfaces / work of the free body below which the interfaces carry the load."""

AT_REST = 1e-14
"""Motion of the interfaces in a mode that counts as none / largest one of all modes."""


class Reach:
    """Full model of a reduced part, factorised once for any number of loads.

    Parameters
    ----------
    reduced : ReducedPart
        Reduced part that contains its `source`, the full part.
    """

    def __init__(self, reduced: ReducedPart) -> None:
        assert reduced.source is not None
        self._reduced = by_mean_axes(reduced)
        self.part = reduced.source
        full, faults = full_model(self.part, modes=0)
        self._full: FullModel | None = None if faults else full

    def nodal(self, pattern: Array) -> Array:
        """Return nodal forces (nodes, 3) of the reduced part as loads (ndof,) on the full one."""
        nn, d = len(self.part.nodes), self.part.dofs_per_node
        F = np.zeros((nn, d))
        F[:, :3] = pattern[:nn]
        loads = F.ravel()
        for tie, force in zip(self.part.ties, pattern[nn:], strict=False):
            loads[tie.dofs] += tie.averaging[:3].T @ force
        return loads

    def unit(self, node: int, first: int) -> Array:
        """Return unit forces (first = 0) or moments (3) on a node, (ndof, 3)."""
        nn, d = len(self.part.nodes), self.part.dofs_per_node
        F = np.zeros((nn * d, 3))
        if node >= nn:
            tie = self.part.ties[node - nn]
            F[tie.dofs] = tie.averaging[first : first + 3].T
        elif first < d:
            F[node * d + first + np.arange(3), np.arange(3)] = 1.0
        return F

    def spread(self, nodes: Ints, loads: Array) -> Array:
        """Return forces and moments (k, 6, m) on nodes as loads (ndof, m)."""
        out = np.zeros((self.part.K.shape[0], loads.shape[2]))
        for node, load in zip(nodes.tolist(), loads, strict=True):
            out += self.unit(node, 0) @ load[:3] + self.unit(node, 3) @ load[3:]
        return out

    def weight(self, g: Array) -> Array:
        """Return the loads (ndof,) of an acceleration of the frame, part axes, m/s2."""
        return np.asarray(self.part.M @ (self.part.rigid_modes()[:, :3] @ g))

    def work(self, F: Array) -> tuple[Array, Array] | None:
        """Return the static work ``f^T u`` of loads (ndof, m) in the full part and in the modes.

        The interfaces are fixed; ``u`` of the modes is the best approximation by them, so that its
        work is at most that of the full part. Without interfaces, or if necessary modes were left
        out, the body is free and accelerates. Loads carried by interfaces do no work. None if the
        full part cannot be solved.
        """
        full = self._full
        if full is None or full.rigid is None:
            return None
        relieved = F - full.rigid.MR @ (full.rigid.R.T @ F)
        free = np.einsum("ij,ij->j", relieved, elastic_response(full, relieved))
        modes = modes_of(full, self._reduced)
        # with selected modes that cannot fix the interfaces, the body is free, too
        if len(modes.names) > 6 + self._reduced.n or not modes.names:
            return free, ((modes.X.T @ F) ** 2 / self._reduced.stiffness[:, None]).sum(axis=0)
        whole = np.einsum("ij,ij->j", F, held_response(full, modes, F))
        whole = np.where(whole > ON_INTERFACE * free, whole, 0.0)
        return whole, np.where(whole > 0.0, self._held(full, modes, F), 0.0)

    def _held(self, full: FullModel, modes: Modes, F: Array) -> Array:
        """Return the work of the loads in the modes with fixed interfaces."""
        assert full.rigid is not None
        Y = np.concatenate([full.rigid.R, modes.X], axis=1)
        C = modes.moved(Y)
        size = np.sqrt(np.einsum("ij,ij->j", C, C))
        # modes with fixed interfaces (up to round-off) are used unchanged
        size = np.where(size > AT_REST * size.max(initial=0.0), size, 1.0)
        Z = scipy.linalg.null_space(C / size, rcond=1e-10) / size[:, None]
        if not Z.shape[1]:
            return np.zeros(F.shape[1])
        omega2 = np.concatenate([np.zeros(6), self._reduced.stiffness])
        K = Z.T @ (omega2[:, None] * Z)
        scale = 1.0 / np.sqrt(np.maximum(np.diag(K), np.finfo(float).tiny))
        g = scale[:, None] * (Z.T @ (Y.T @ F))
        y = np.linalg.lstsq(scale[:, None] * K * scale, g, rcond=1e-12)[0]
        return np.asarray(np.einsum("ij,ij->j", g, y))
