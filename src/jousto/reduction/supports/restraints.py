"""Coordinates held by clamps, stiffness of springs, and the effect of both on rigid motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array, Index
from jousto.base.errors import Problems
from jousto.reduction.supports.overlaps import held_directions
from jousto.reduction.supports.support import DIRECTIONS, Clamp, SpringSupport, Support
from jousto.reduction.supports.system import System

# eigenvalue of a spring matrix of unit diagonal, below which a motion does not strain the spring
SOFT = 1e-9


@dataclass(frozen=True, eq=False)
class RigidSupport:
    """Rows that strain supports in rigid motions, with the stiffness of the supports.

    Attributes
    ----------
    rows : (m, 6) array
        Motions of the supports, with rotations multiplied by a length, in each rigid motion.
    stiffness : (m,) array
        N/m; infinite for clamps.
    owners : (m,) array
        Number of the spring support; -1 for clamps.
    """

    rows: Array
    stiffness: Array
    owners: Index


def held_coordinates(
    problems: Problems, system: System, supports: Sequence[Support]
) -> tuple[Index, Array]:
    """Return the coordinates that clamps hold, ascending, and their settlement."""
    settled: dict[int, float] = {}
    for support, nodes in zip(supports, system.nodes, strict=True):
        if not isinstance(support, Clamp):
            continue
        label = f"{system.where}, {support.heading(problems)}"
        t, w = support.motion[:3], support.motion[3:]
        middle = np.mean([node.at for node in nodes], axis=0)
        for node in nodes:
            moved = np.concatenate([t + np.cross(w, node.at - middle), w])
            own = held_directions(support, node)
            lacking = [DIRECTIONS[k] for k in own if node.places[k] < 0]
            if lacking:
                problems.add(label, f"{node.name} has no rotations, {lacking[0]} cannot be held")
                break
            loose = [k for k in range(6) if k not in own and moved[k] and node.places[k] >= 0]
            if loose:
                word = DIRECTIONS[loose[0]]
                problems.add(label, f"settlement moves {node.name} in {word}, which is free")
                break
            settled.update({int(node.places[k]): moved[k] for k in own})
    held = np.array(sorted(settled), dtype=np.intp)
    return held, np.array([settled[int(k)] for k in held])


def spring_stiffness(
    problems: Problems, system: System, supports: Sequence[Support]
) -> sp.csr_array:
    """Return the stiffness (n, n) of the springs."""
    n = system.K.shape[0]
    total = sp.csr_array((n, n))
    for support, nodes in zip(supports, system.nodes, strict=True):
        if not isinstance(support, SpringSupport):
            continue
        for node in nodes:
            known = node.places >= 0
            if support.stiffness[~known].any():
                label = f"{system.where}, {support.heading(problems)}"
                problems.add(label, f"{node.name} has no rotations, its stiffness must be 0 there")
                break
            at = node.places[known]
            i, j = np.meshgrid(at, at, indexing="ij")
            values = support.stiffness[np.ix_(known, known)]
            own = sp.coo_array((values.ravel(), (i.ravel(), j.ravel())), shape=(n, n))
            total = sp.csr_array(total + own.tocsr())
    return total


def rigid_support(
    system: System, supports: Sequence[Support], held: Index, unit: Array, R: Array
) -> RigidSupport:
    """Return the rows in which supports resist the rigid motions R (n, 6).

    Parameters
    ----------
    system, supports, held
        Held coordinates as from `held_coordinates`.
    unit : (n,) array
        Size of the part, m, for rotations of supported nodes; 1 for translations.
    R : (n, 6) array
        Rigid motions, with rotations divided by the size of the part.
    """
    rows = [(unit[:, None] * R)[held]]
    stiffness, owners = [np.full(len(held), np.inf)], [np.full(len(held), -1)]
    for number, (support, nodes) in enumerate(zip(supports, system.nodes, strict=True)):
        if not isinstance(support, SpringSupport):
            continue
        for node in nodes:
            known = node.places >= 0
            at = node.places[known]
            strained, k = _strained(support.stiffness[np.ix_(known, known)], unit[at])
            rows.append(strained @ (unit[at, None] * R[at]))
            stiffness.append(k)
            owners.append(np.full(len(k), number))
    return RigidSupport(*(np.concatenate(some) for some in (rows, stiffness, owners)))


def _strained(K: Array, unit: Array) -> tuple[Array, Array]:
    """Return unit rows of motions, times their units, that strain a spring, and stiffness."""
    scaled = K / np.outer(unit, unit)
    size = np.sqrt(np.where(np.diag(scaled) > 0.0, np.diag(scaled), 1.0))
    values, vectors = np.linalg.eigh(scaled / np.outer(size, size))
    strains = values > SOFT
    rows = vectors[:, strains].T * size
    length = np.linalg.norm(rows, axis=1)
    return rows / length[:, None], values[strains] * length**2
