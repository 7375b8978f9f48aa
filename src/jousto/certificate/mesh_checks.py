"""Checks of the mesh of a part, for the certificate."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.errors import count
from jousto.certificate.certificate import Check, Status, Table, number
from jousto.certificate.part_checks import hangs_together
from jousto.mesh.quality import POOR

if TYPE_CHECKING:
    from jousto.parts.part import Part


VOLUME_DOUBTFUL, VOLUME_WRONG = 0.01, 0.05
"""Relative difference of mesh and CAD volume for a warning, and for an error."""

STIFF_KINDS = {"tetra": "tetra10", "hexahedron": "hexahedron20", "wedge": "wedge15"}
"""Elements that are too stiff in bending, and replacements."""

BENDING = ("incompatible",)
"""Formulations of linear elements with correct bending stiffness."""

WORST = 5
"""Largest number of listed elements."""


def mesh_checks(part: Part) -> tuple[list[Check], list[Table]]:
    """Return the checks of the mesh of a part; empty for parts without a mesh."""
    mesh: Any = part.mesh
    if mesh is None or not hasattr(mesh, "quality"):
        return [], []
    checks, table = _quality(mesh)
    checks += [*_against_cad(mesh), _order(mesh)]
    checks.append(_surface(part))
    # findings of the mesh; element shapes are checked above
    found = [f for f in mesh.check() if f.kind not in ("jacobian", "sliver")]
    for finding in found:
        status: Status = "fail" if finding.severity == "error" else "warn"
        if finding.kind == "pieces" and hangs_together(part):
            sentence = "the mesh has several pieces, joined by rigid interfaces"
            checks.append(Check("mesh: pieces", "note", "found", "", sentence))
            continue
        value = count(len(finding.ids), "place") if finding.ids else "found"
        checks.append(Check(f"mesh: {finding.kind}", status, value, "", finding.message))
    if not found:
        sentence = "no free or doubled nodes, no overlapping elements, no gaps, one piece"
        checks.append(Check("mesh", "ok", "nothing found", "", sentence))
    return checks, [table]


def mesh_facts(part: Part) -> list[tuple[str, str]]:
    """Return volume and mean density of the mesh."""
    mesh: Any = part.mesh
    if mesh is None or not hasattr(mesh, "volume"):
        return []
    volume = float(mesh.volume)
    if not volume > 0.0:
        return []
    density = part.mass / volume
    return [
        ("volume", f"{number(1e9 * volume, 6)} mm3, {number(density, 5)} kg/m3 on average"),
    ]


def _quality(mesh: Any) -> tuple[list[Check], Table]:
    quality = mesh.quality()
    s = np.asarray(quality.scaled_jacobian)
    worst = quality.worst(WORST)
    aspect = {int(i): float(a) for i, a in zip(quality.ids, quality.aspect, strict=True)}
    table = Table(
        "worst elements",
        ("element", "scaled Jacobian", "longest edge / shortest"),
        tuple((str(i), number(value, 3), number(aspect[i], 3)) for i, value in worst),
        "Scaled Jacobian: 1 for the ideal shape, 0 for a flat element, negative for an inverted"
        " one.",
    )
    value = f"{number(s.min(), 3)} worst, {number(np.median(s), 3)} median of {len(s)}"
    limit = f"scaled Jacobian at least {POOR:g}"
    topic = "mesh quality"
    names = ", ".join(str(i) for i, _ in worst[:3])
    if len(quality.negative):
        check = Check(
            topic,
            "fail",
            value,
            limit,
            f"{count(len(quality.negative), 'element')} (such as {names}) are folded or inverted",
            "refine the mesh there or straighten its mid-side nodes",
        )
    elif s.min() < POOR:
        check = Check(
            topic,
            "warn",
            value,
            limit,
            f"{count(int(np.sum(s < POOR)), 'element')} (such as {names}) are nearly flat: stress "
            f"there is unreliable and high frequencies are inaccurate",
            "remove small faces from the geometry or refine the mesh there",
        )
    else:
        check = Check(topic, "ok", value, limit, "no element is flat or folded")
    return [check], table


def _against_cad(mesh: Any) -> list[Check]:
    """Return the check of the mesh volume against that of the CAD solids."""
    cad = mesh.cad_volume
    if not cad:
        return []
    share = float(mesh.volume) / cad - 1.0
    size = abs(share)
    topic, limit = "volume against CAD", f"{100.0 * VOLUME_DOUBTFUL:g} %"
    value = f"{100.0 * share:+.2g} % of {number(1e9 * cad, 6)} mm3"
    if size <= VOLUME_DOUBTFUL:
        return [Check(topic, "ok", value, limit, "the mesh has the volume of the CAD solid")]
    sentence = (
        f"the mesh is {number(100.0 * size, 2)} % {'heavier' if share > 0.0 else 'lighter'} than "
        "the CAD solid: its edges are chords of curved faces, so that mass, inertia and stiffness "
        "are wrong"
    )
    remedy = "mesh with more elements per_circle, a smaller size, or edges that follow curves"
    return [
        Check(topic, "warn" if size <= VOLUME_WRONG else "fail", value, limit, sentence, remedy)
    ]


def _order(mesh: Any) -> Check:
    number_of: dict[str, int] = {}
    for block in mesh.solids:
        plain = block.formulation == "full"
        name = block.kind if plain else f"{block.kind} ({block.formulation})"
        number_of[name] = number_of.get(name, 0) + len(block.nodes)
    value = ", ".join(f"{n} {name}" for name, n in number_of.items())
    linear = {block.kind for block in mesh.solids if block.kind in STIFF_KINDS}
    stiff = [b.kind for b in mesh.solids if b.kind in linear and b.formulation not in BENDING]
    if linear and not stiff:
        sentence = "bricks with incompatible modes are accurate in bending if they are cuboids"
        return Check("elements", "ok", value, "", sentence)
    soft = [b for b in mesh.solids if (b.kind, b.formulation) == ("hexahedron", "reduced")]
    if soft and len(soft) == len(stiff):
        return Check(
            "elements",
            "warn",
            value,
            "four over each thickness",
            "bricks of mean strain are too soft in bending: n over a thickness have 1 - 1/n^2 of"
            " its second moment",
            "use hexahedron20 or formulation 'incompatible', or at least four over each thickness",
        )
    if not stiff:
        return Check("elements", "ok", value, "", "quadratic elements are accurate in bending")
    better = " and ".join(dict.fromkeys(STIFF_KINDS[kind] for kind in stiff))
    return Check(
        "elements",
        "warn",
        value,
        "quadratic",
        "linear elements are too stiff in bending, and their stress is inaccurate",
        f"use {better} (order=2 when meshing), or refine until frequencies converge",
    )


def _surface(part: Part) -> Check:
    """Return the check that the outer surface is closed and has no shared edges."""
    triangles = np.asarray(part.elements)
    pairs = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, times = np.unique(pairs, axis=0, return_counts=True)
    corners = np.asarray(part.nodes)[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * float(np.linalg.norm(normal, axis=1).sum())
    value = f"{count(len(triangles), 'triangle')}, {number(1e6 * area, 5)} mm2"
    shared = np.flatnonzero(times > 2)
    if len(shared):
        a, b = edges[shared[0]] + 1
        return Check(
            "surface",
            "warn",
            value,
            "two triangles at each edge",
            f"at {count(len(shared), 'edge')} (such as node{a} to node{b}) bodies are connected "
            f"like by a hinge",
            "let them share faces, or separate them",
        )
    if np.any(times == 1):
        return Check(
            "surface",
            "warn",
            value,
            "two triangles at each edge",
            f"the surface is open at {count(int(np.sum(times == 1)), 'edge')}",
            "elements of different size or order meet there: mesh touching bodies together",
        )
    return Check("surface", "ok", value, "", "the surface is closed")
