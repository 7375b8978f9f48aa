"""Stress of free surfaces of solids from their surface strain, which strain gauges measure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from jousto.base.arrays import Ints, node_dofs, scatter
from jousto.base.errors import Problems
from jousto.materials.material import Material
from jousto.materials.orthotropic import elasticity
from jousto.parts.frames.stress import StressOperator
from jousto.parts.geometry import Geometry
from jousto.parts.loads import pick_nodes
from jousto.parts.solids.faces import face_operators
from jousto.parts.solids.model import SolidModel
from jousto.parts.solids.stress import compliances, labels


def surface_stress(
    part: Geometry, model: SolidModel | None, ties: Sequence[Ints], on: Any
) -> StressOperator:
    """Return the stress of free surfaces, see `Part.surface_stress`."""
    where, problems = f"part '{part.name}'", Problems()
    if model is None:
        problems.add(
            where, "has no surface stress; it is defined for parts of solids (Part.solid) only"
        )
        problems.raise_if_any()
    assert model is not None
    if on is None:
        # leave out faces of interfaces, on which loads act
        chosen = [np.ones(len(face), dtype=bool) for face in model.faces]
        for nodes in ties:
            tied = np.zeros(len(part.nodes), dtype=bool)
            tied[nodes] = True
            for mask, face in zip(chosen, model.faces, strict=True):
                mask &= ~np.all(tied[face], axis=1)
    else:
        picked = pick_nodes(problems, where, part, on)
        problems.raise_if_any()
        inside = np.zeros(len(part.nodes), dtype=bool)
        inside[picked] = True
        chosen = [np.all(inside[face], axis=1) for face in model.faces]
    if not any(np.any(mask) for mask in chosen):
        problems.add(where, "no outer face has all its nodes in the pick; pick mid-side nodes, too")
    problems.raise_if_any()
    faces = [face[mask] for face, mask in zip(model.faces, chosen, strict=True)]
    behind = [m[mask] for m, mask in zip(model.face_materials, chosen, strict=True)]
    return skin_stress(model, faces, behind)


def skin_stress(
    model: SolidModel, faces: Sequence[Ints], materials: Sequence[Ints]
) -> StressOperator:
    """Return the stress at the nodes of outer faces on which no load acts.

    The in-plane strain at the nodes is that of the face, ``grad_t u``; the rest of the strain
    follows from ``s n = 0``: with ``A = n . C . n`` and the traction ``t = s n`` for the in-plane
    strain alone, ``s <- s - C : (A^-1 t) n``. The stress of a node is the mean over the faces of
    one material around it. No value is extrapolated from inside the body.

    Parameters
    ----------
    model : SolidModel
    faces : sequence of (nf, k) ndarray
        Outer faces by kind, normals outwards.
    materials : sequence of (nf,) ndarray
        Index of the material behind each face.
    """
    n_mat = len(model.materials)
    pairs = [np.unique(face * n_mat + m[:, None]) for face, m in zip(faces, materials, strict=True)]
    both = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *pairs]))
    node, material = both // n_mat, both % n_mat
    ns, ndof = len(both), 3 * len(model.nodes)
    count = np.zeros(ns)
    blocks, rows, columns = [], [], []
    for face, m in zip(faces, materials, strict=True):
        k = face.shape[1]
        for index in np.unique(m):
            mine = m == index
            operator, _ = face_operators(
                elasticity(model.materials[index]), model.nodes, face[mine]
            )
            site = np.searchsorted(both, face[mine] * n_mat + index)
            np.add.at(count, site.ravel(), 1.0)
            blocks.append(operator.reshape(-1, 6, 3 * k))
            rows.append(node_dofs(site.reshape(-1, 1), 6))
            columns.append(np.repeat(node_dofs(face[mine], 3), k, axis=0))
    total = None
    for block, row, column in zip(blocks, rows, columns, strict=True):
        mean = block / count[row[:, 0] // 6][:, None, None]
        part = scatter(mean, row, column, (6 * ns, ndof))
        total = part if total is None else total + part
    constants = [(x.E, x.nu) if isinstance(x, Material) else (np.nan,) * 2 for x in model.materials]
    known = np.array(constants)[material]
    assert total is not None
    return StressOperator(
        labels(model, node, material),
        model.nodes[node],
        np.broadcast_to(np.eye(3), (ns, 3, 3)),
        total,
        None if np.any(np.isnan(known)) else known,
        compliances(model, material),
    )
