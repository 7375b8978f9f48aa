"""Modes of a reduced part in the degrees of freedom of its full model, and interface loads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from jousto.base.arrays import Array, Index
from jousto.certificate.part_checks import FullModel
from jousto.reduction.modes.rigid import rigid_modes

if TYPE_CHECKING:
    from jousto.reduction.reduced import ReducedPart


LEAST_HOLD = 1e-6
"""Smallest independent motion / size of the body of six loads that fix it."""

LOADS = ("fx", "fy", "fz", "mx", "my", "mz")


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes of a reduced part in the degrees of freedom of the full model.

    Parameters
    ----------
    reduced : ReducedPart
    X : (ndof, n) array
        Mass-normalised modes.
    loads : (ndof, nb) sparse array
        Nodal loads of unit forces and moments on the interfaces; ``loads^T u`` is the motion of the
        interfaces.
    names : tuple of str
        Name of each load, such as ``end fy``.
    weights : (nb,) array
        1 for forces, the size of the body for moments.
    interfaces : tuple of (str, (k,) int array)
        Names of the interfaces and indices of their loads.
    """

    reduced: ReducedPart
    X: Array
    loads: sp.csc_array
    names: tuple[str, ...]
    weights: Array
    interfaces: tuple[tuple[str, Index], ...]

    def moved(self, u: Array) -> Array:
        """Return the motions of the interfaces, (nb, m), rotations times the size of the body."""
        return np.asarray((self.loads.T @ u) * self.weights[:, None])


def modes_of(full: FullModel, reduced: ReducedPart) -> Modes:
    """Return the modes of a reduced part and the loads of its interfaces.

    The load on the reference node of a surface is distributed over the surface by the transpose of
    the average that defines its motion.
    """
    part, d = full.part, full.dofs
    nn = len(part.nodes)
    blocks = [reduced.modes[:nn]]
    if d == 6 and reduced.rotations is not None:
        blocks.append(reduced.rotations[:nn])
    X = np.concatenate(blocks, axis=1).reshape(-1, reduced.n)
    ties = {tie.name: tie for tie in part.ties}
    columns: list[Any] = []
    names: list[str] = []
    kinds: list[int] = []
    interfaces = []
    for name in reduced.interfaces:
        first = len(names)
        if name in ties:
            tie = ties[name]
            rows, unit = tie.dofs, tie.averaging.T
            names += [f"{name} {load}" for load in LOADS]
            kinds += range(6)
        else:
            members = part.node_sets[name]
            rows = (d * np.array(members)[:, None] + np.arange(d)).ravel()
            unit = np.eye(len(rows))
            for node in members:
                place = name if len(members) == 1 else f"{name} (node{node + 1})"
                names += [f"{place} {load}" for load in LOADS[:d]]
                kinds += range(d)
        i, j = np.nonzero(unit)
        shape = (X.shape[0], unit.shape[1])
        columns.append(sp.coo_array((unit[i, j], (rows[i], j)), shape=shape))
        interfaces.append((name, np.arange(first, len(names))))
    loads = sp.csc_array(sp.hstack(columns)) if columns else sp.csc_array((X.shape[0], 0))
    weights = np.where(np.array(kinds) < 3, 1.0, full.length)
    return Modes(reduced, X, loads, tuple(names), weights, tuple(interfaces))


def determinate(P: Array) -> Index | None:
    """Return six loads that fix the body; P (nb, 6) are their work in rigid motions."""
    if len(P) < 6:
        return None
    r, pivots = scipy.linalg.qr(P.T, mode="r", pivoting=True)
    if abs(r[5, 5]) < LEAST_HOLD * abs(r[0, 0]):
        return None
    return np.asarray(np.sort(pivots[:6]), dtype=np.intp)


def scaled_rigid(full: FullModel) -> Array:
    """Return rigid motions about the middle, rotations / size of the body."""
    R = rigid_modes(full.nodes, full.dofs, full.nodes.mean(axis=0))
    R[:, 3:] /= full.length
    return R
