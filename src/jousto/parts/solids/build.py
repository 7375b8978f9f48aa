"""Parts of solids from a mesh and materials: checks, assembly, masses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array, Ints, Sparse, as_csr, read_only, some
from jousto.base.errors import InputError, Problem, Problems, count, suggest, warn
from jousto.materials.library import by_name
from jousto.materials.material import Material
from jousto.materials.orthotropic import Orthotropic
from jousto.mesh.area import by_kind
from jousto.mesh.cells import Cells, instead
from jousto.mesh.inspection import require
from jousto.mesh.mesh import Mesh
from jousto.mesh.reference import KINDS, jacobians, table
from jousto.mesh.sets import read_sets
from jousto.parts.added_masses import attached_points
from jousto.parts.mass import MassPoints, PointMass, joined
from jousto.parts.solids.model import SolidGroup, SolidModel, expanded
from jousto.parts.solids.second_order import SolidSecondOrder
from jousto.parts.solids.stress import SolidStress

AnyMaterial = Material | Orthotropic
SAID_ELSEWHERE = (
    *("empty", "unsupported", "collapsed", "jacobian"),
    *("sliver", "free nodes", "unused nodes", "empty set"),
)
"""Findings of a mesh that are reported when a part is built from it, or by its certificate."""
LIKELY_FACTOR = (0.8, 1.25)
"""Limits of mass scaling: outside, a mistake is more probable than a casting tolerance."""


def solid_fields(
    mesh: Mesh,
    materials: Any,
    where: str,
    *,
    lumped: bool,
    point_masses: PointMass | Sequence[PointMass],
    weighed_mass: float | None,
) -> dict[str, Any]:
    """Return the fields of a part of solids, except its name and interfaces."""
    given: object = mesh
    if not isinstance(given, Mesh):
        message = f"mesh is {given!r}, must be a Mesh, such as that of read_mesh or mesh_cad"
        raise InputError(Problem(where, message))
    judge(mesh)
    model, used = solid_model(mesh, materials, where)
    new = np.full(len(mesh.nodes), -1, dtype=np.int64)
    new[used] = np.arange(len(used))
    if len(used) < len(mesh.nodes):
        lost = [str(i) for i in np.asarray(mesh.node_ids)[new < 0]]
        warn(
            where,
            f"{count(len(lost), 'node')} of the mesh in no solid element, left out (node"
            f" {some(lost)})",
        )
    sets = {key: new[np.asarray(value)] for key, value in mesh.node_sets.items()}
    node_sets = {
        key: tuple(int(i) for i in value[value >= 0])
        for key, value in sets.items()
        if np.any(value >= 0)
    }
    problems = Problems()
    known = read_sets(problems, where, node_sets, len(used))
    problems.raise_if_any()
    model, M, points, attached = solid_masses(
        model, point_masses, known, lumped=lumped, weighed_mass=weighed_mass, where=where
    )
    K = model.stiffness()
    model = replace(model)  # a copy without the cached positions of matrix entries
    return {
        "nodes": model.nodes,
        "elements": new[np.asarray(mesh.triangles)],
        "dofs_per_node": 3,
        "M": M,
        "K": K,
        "node_sets": node_sets,
        "mass_points": points,
        "stress": SolidStress.everywhere(model),
        "second_order": SolidSecondOrder(model, M, attached),
        "faces": model.faces,
        "surfaces": {key: by_kind(new[rows], rows >= 0) for key, rows in mesh.surfaces.items()},
        "solids": model,
        "mesh": mesh,
        "attached": attached,
    }


def solid_model(mesh: Mesh, materials: Any, where: str) -> tuple[SolidModel, Ints]:
    """Return the elements of a mesh with their materials, and the nodes that they use.

    Raises
    ------
    InputError
        With all problems: no solid elements, sets that do not exist, elements without
        or with two materials, elements with negative volume.
    """
    problems = Problems()
    cells = [c for c in mesh.cells if c.kind in KINDS]
    others = sorted({c.kind for c in mesh.cells} - set(KINDS))
    if not cells:
        found = (
            f"it has {', '.join(others)} only{instead(others)}" if others else "it has no elements"
        )
        known = ", ".join(KINDS)
        problems.add(where, f"mesh '{mesh.name}' has no solid elements ({known}); {found}", "mesh")
        problems.raise_if_any()
    for kind in ("pyramid", "pyramid13"):
        if kind in others:
            problems.add(
                where,
                f"mesh '{mesh.name}' has {kind} elements, which have no stiffness here; mesh the"
                " transition with tetrahedra",
                "mesh",
            )
    names, found_materials, owner = _materials(problems, where, mesh, cells, materials)
    problems.raise_if_any()

    used = np.unique(np.concatenate([c.nodes.ravel() for c in cells]))
    new = np.full(len(mesh.nodes), -1, dtype=np.int64)
    new[used] = np.arange(len(used))
    groups, start = [], 0
    for c in cells:
        mine = owner[start : start + len(c.nodes)]
        start += len(c.nodes)
        for m in np.unique(mine):
            rows = np.flatnonzero(mine == m)
            ids = np.asarray(c.ids)[rows]
            nodes = new[np.asarray(c.nodes)[rows]]
            groups.append(SolidGroup(c.kind, nodes, ids, int(m), c.formulation))
    xyz = read_only(np.asarray(mesh.nodes)[used])
    ids = np.asarray(mesh.node_ids)[used]
    model = SolidModel(xyz, ids, tuple(groups), found_materials, names)
    _check_volumes(problems, where, model)
    problems.raise_if_any()
    faces = tuple(new[face.nodes] for face in mesh.faces)
    behind = tuple(owner[face.owners] for face in mesh.faces)
    return replace(model, faces=faces, face_materials=behind), used


def judge(mesh: Mesh) -> None:
    """Raise InputError with errors of a mesh, and warn about doubtful findings.

    The findings are those of :meth:`Mesh.check`: a wrong unit, disconnected pieces, elements of
    negative volume or exported twice. Disconnected pieces cause a warning only, since a rigid
    interface may join them.

    Raises
    ------
    InputError
        With all errors of the mesh.

    Warns
    -----
    JoustoWarning
        With each doubtful finding.
    """
    require(mesh, tolerate=("pieces",), silent=SAID_ELSEWHERE)


def _materials(
    problems: Problems, where: str, mesh: Mesh, cells: Sequence[Cells], given: Any
) -> tuple[tuple[str, ...], tuple[AnyMaterial, ...], Ints]:
    """Return names, materials and the index of the material of each element."""
    ne = sum(len(c.nodes) for c in cells)
    if isinstance(given, (Material, Orthotropic)):
        _check_material(problems, where, given)
        return (given.name or "solid",), (given,), np.zeros(ne, dtype=np.int64)
    owner = np.full(ne, -1, dtype=np.int64)
    if not isinstance(given, Mapping) or not given:
        problems.add(
            where,
            f"materials is {given!r}, must be a Material, an Orthotropic or"
            f" {{element set: material}} with at least one entry{by_name(given)}",
            "materials",
        )
        return (), (), owner
    by_file: dict[str, list[Ints]] = {}
    start = 0
    for c in cells:
        if c.material:
            by_file.setdefault(c.material, []).append(np.arange(start, start + len(c.nodes)))
        start += len(c.nodes)
    known = {**{k: np.concatenate(v) for k, v in by_file.items()}, **mesh.element_sets}
    names = tuple(str(name) for name in given)
    for m, (name, material) in enumerate(given.items()):
        if not isinstance(material, (Material, Orthotropic)):
            problems.add(
                where,
                f"material of '{name}' is {material!r}, must be a Material{by_name(material)}",
                "material",
            )
            continue
        _check_material(problems, where, material)
        if name not in known:
            problems.add(where, f"no element set '{name}' for a material{suggest(name, known)}")
            continue
        members = np.asarray(known[name], dtype=np.int64)
        twice = members[owner[members] >= 0]
        if len(twice):
            other = names[int(owner[twice[0]])]
            problems.add(
                where,
                f"{len(twice)} elements have two materials: they are in the sets '{other}' and"
                f" '{name}'",
            )
        owner[members] = m
    if not problems.found and np.any(owner < 0):
        left = np.flatnonzero(owner < 0)
        ids = np.concatenate([np.asarray(c.ids) for c in cells])[left]
        problems.add(
            where,
            f"{len(left)} elements have no material (element {some([str(i) for i in ids])}); give"
            f" one for each element set{suggest('', known)}",
        )
    return names, tuple(given.values()), owner


def _check_material(problems: Problems, where: str, material: AnyMaterial) -> None:
    if isinstance(material, Material) and material.nu > 0.495:
        problems.add(
            where,
            f"Poisson's ratio of material '{material.name}' is {material.nu:g}: solids lock above "
            f"0.495; use 0.49",
        )
    if material.rho == 0.0:
        problems.add(
            where, f"density of material '{material.name}' is zero; solids need a mass", "density"
        )


def _check_volumes(problems: Problems, where: str, model: SolidModel) -> None:
    """Report elements of negative or zero volume."""
    bad: list[str] = []
    for group in model.groups:
        x = model.nodes[group.nodes]
        # relative measure: smallest volume ratio / mean size of the element
        least = np.full(len(group), np.inf)
        for purpose in ("stiffness", "mass"):
            t = table(group.kind, purpose)
            step = max(1, (1 << 22) // (9 * len(t.weights)))
            for i in range(0, len(group), step):
                detJ = jacobians(t.dN, x[i : i + step])
                least[i : i + step] = np.minimum(least[i : i + step], detJ.min(axis=1))
        size = np.ptp(x, axis=1).max(axis=1)
        bad += [str(i) for i in group.ids[least <= 1e-12 * size**3]]
    if bad:
        problems.add(
            where,
            f"{count(len(bad), 'element')} of negative or zero volume: element {some(bad)}; "
            f"repair the mesh there (mesh.check() has details)",
        )


def solid_masses(
    model: SolidModel,
    point_masses: PointMass | Sequence[PointMass],
    node_sets: Mapping[str, tuple[int, ...]],
    *,
    lumped: bool,
    weighed_mass: float | None,
    where: str,
) -> tuple[SolidModel, Sparse, MassPoints | None, MassPoints | None]:
    """Return the model with scaled density, M, all mass as points, and attached points.

    The mass as points is None unless the mass is lumped; attached points are the masses added to a
    consistent mass.
    """
    problems = Problems()
    masses = problems.several(where, "point_masses", point_masses, PointMass)
    points = attached_points(problems, where, masses, model.nodes, node_sets)
    if weighed_mass is not None:
        problems.positive(where, "weighed_mass", weighed_mass, "kg")
    problems.raise_if_any()
    added = 0.0 if points is None else float(points.mass.sum())
    scalar = None if lumped else model.scalar_mass()
    nodal = model.lumped_mass() if lumped else None
    own = float(nodal.sum() if nodal is not None else scalar.sum())  # type: ignore[union-attr]
    if weighed_mass is not None:
        factor = (weighed_mass - added) / own
        if factor <= 0.0:
            problems.add(
                where,
                f"weighed_mass is {weighed_mass:g} kg, but the point masses alone are {added:g} kg",
                "weighed_mass",
            )
            problems.raise_if_any()
        low, high = LIKELY_FACTOR
        if not low < factor < high:
            warn(
                where,
                f"the weighed mass of {weighed_mass:g} kg is {factor:.3g} times that of the model"
                f" ({own + added:.6g} kg): check units, material and whether parts are missing",
            )
        model = replace(model, density_factor=factor)
        scalar = None if scalar is None else scalar * factor
        nodal = None if nodal is None else nodal * factor
    if nodal is not None:
        own_points = _nodal_points(nodal, model.nodes)
        everything = joined([own_points] if points is None else [own_points, points])
        return model, everything.matrix(), everything, points
    assert scalar is not None
    M = expanded(scalar)
    if points is not None:
        M = as_csr(M + points.matrix())
    return model, M, None, points


def _nodal_points(mass: Array, nodes: Array) -> MassPoints:
    nn = len(nodes)
    E = sp.identity(3 * nn, format="csr")
    nothing = sp.csr_array((3 * nn, 3 * nn))
    return MassPoints(mass, nodes, np.zeros((nn, 3, 3)), as_csr(E), as_csr(nothing))
