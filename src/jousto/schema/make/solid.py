"""Mesh, picked nodes and Part of the entry of a solid part."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.errors import count, suggest
from jousto.schema.entries import solids as ss
from jousto.schema.entries.parts import PressurePatternEntry
from jousto.schema.file.document import Loc
from jousto.schema.file.mesh_cache import mesh_of_cad
from jousto.schema.make.declared import Place, build_declared, build_material

if TYPE_CHECKING:
    from jousto.mesh.mesh import Mesh
    from jousto.schema.make.builder import Builder

DIAMETER = 0.02  # largest relative difference of a hole from the requested diameter
SHOWN = 6  # maximum number of holes or sets in a message


def build_solid(builder: Builder, loc: Loc, name: str, entry: Any) -> Any:
    """Return the Part of an entry; None, with problems, if it is invalid."""
    from jousto.parts.part import Part

    before = len(builder.found)
    materials = solid_materials(builder, loc, entry)
    masses = [
        build_declared(builder, (*loc, "point_masses", i), mass)
        for i, mass in enumerate(entry.point_masses or ())
    ]
    mesh = read_solid_mesh(builder, loc, entry)
    if mesh is None:
        return None
    for key, value in (entry.sets or {}).items():
        here = (*loc, "sets", key)
        if key in mesh.node_sets:
            builder.note(here, f"the mesh has a set {key!r} already; take another name")
            continue
        nodes = picked(builder, here, value, mesh)
        if nodes is not None:
            mesh = mesh.with_set(key, nodes)
    mesh = with_stress_set(builder, loc, entry, mesh)
    interfaces = [
        build_declared(builder, (*loc, "interfaces", i), item, {"mesh": mesh})
        for i, item in enumerate(entry.interfaces or ())
    ]
    if len(builder.found) > before:
        return None
    values = entry.given(
        "reduce", "in_plane", "keep", "stiffening", "residual_stress", "mesh", "material",
        "materials", "sets", "interfaces", "point_masses", "stress", "welds", "solver", "cache",
    )  # fmt: skip
    part = builder.make(
        loc,
        Part.solid,
        mesh,
        materials,
        **values,
        point_masses=masses,
        interfaces=interfaces,
        name=name,
    )
    if part is not None:
        part = builder.make((*loc, "stress"), with_stress_at, part, entry)
    return part if part is None or not entry.welds else with_welds(builder, loc, part, entry)


def with_welds(builder: Builder, loc: Loc, part: Any, entry: ss.SolidChoices) -> Any:
    """Return the part with its weld toes as further stress sites; None if one is invalid."""
    from jousto.fatigue.welds.toes import weld_stress

    toes = [
        build_declared(builder, (*loc, "welds", i), toe) for i, toe in enumerate(entry.welds or ())
    ]
    if any(toe is None for toe in toes):
        return None
    stress = builder.make((*loc, "welds"), weld_stress, part, toes, add=part.stress)
    return None if stress is None else part.with_stress(stress)


def with_stress_at(part: Any, entry: ss.SolidChoices) -> Any:
    """Return the part with stress data at the nodes that the entry selects."""
    chosen = entry.stress or "surface"
    if chosen == "none":
        return replace(part, stress=None)
    if chosen == "all" or part.stress is None:
        return part
    if chosen == "skin":
        return part.with_stress(part.surface_stress())
    if chosen == "surface":
        nodes = np.unique(part.elements)
    else:
        nodes = np.asarray(part.node_sets[STRESS_SET])
    return replace(part, stress=part.stress.at(nodes))


def solid_materials(builder: Builder, loc: Loc, entry: ss.SolidChoices) -> Any:
    """Return the material of a solid, or a mapping of materials by element set."""
    if entry.materials is None:
        return build_material(builder, (*loc, "material"), entry.material)
    return {
        key: build_material(builder, (*loc, "materials", key), value)
        for key, value in entry.materials.items()
    }


def read_solid_mesh(builder: Builder, loc: Loc, entry: ss.SolidChoices) -> Mesh | None:
    """Return the mesh of an entry; None, with problems, if it cannot be read."""
    from jousto.mesh.readers.files import read_mesh

    form, here = entry.mesh, (*loc, "mesh")
    if isinstance(form, str):
        return builder.make(here, read_mesh, builder.file(form))
    values = form.given("file", "cad")
    if isinstance(form, ss.MeshFileEntry):
        return builder.make(here, read_mesh, builder.file(form.file), **values)
    keep = builder.options.get("cache", entry.cache)
    return builder.make(here, mesh_of_cad, builder.file(form.cad), keep, **values)


def pick(place: Place, value: Any) -> Any:
    """Return the name of a set, or the picked nodes of a mesh; None if there are none."""
    mesh = place.known.get("mesh")
    if mesh is None or (isinstance(value, str) and value in mesh.node_sets):
        return value
    return picked(place.builder, place.loc, value, mesh)


def with_stress_set(builder: Builder, loc: Loc, entry: ss.SolidChoices, mesh: Mesh) -> Mesh:
    """Return the mesh with the picked stress nodes as a set; add a problem if there are none."""
    if entry.stress is None or entry.stress in STRESS_WORDS:
        return mesh
    nodes = picked(builder, (*loc, "stress"), entry.stress, mesh)
    return mesh if nodes is None else mesh.with_set(STRESS_SET, nodes)


STRESS_WORDS = ("surface", "skin", "all", "none")
STRESS_SET = "stress sites"


def unknown_set(name: str, mesh: Mesh, words: tuple[str, ...] = ()) -> str:
    """Return the message for a set that the mesh does not have."""
    return f"the mesh has no set {name!r}{suggest(name, [*words, *mesh.node_sets])}"


# -- picks ----------------------------------------------------------------------------------


def picked(builder: Builder, loc: Loc, pick: Any, mesh: Mesh) -> Any:
    """Return the node indices of a pick; None, with a problem, if it selects no node."""
    if isinstance(pick, str):
        pick = (pick,)
    if isinstance(pick, tuple):
        missing = [name for name in pick if name not in mesh.node_sets]
        if any(name.startswith("hole") for name in missing):
            mesh = with_holes(mesh)
            missing = [name for name in pick if name not in mesh.node_sets]
        for name in missing:
            words = STRESS_WORDS if loc[-1] == "stress" else ()
            builder.note(loc, unknown_set(name, mesh, words))
        if missing:
            return None
        return np.unique(np.concatenate([mesh.node_sets[name] for name in pick]))
    form = next(key for key in ss.PickEntry.model_fields if getattr(pick, key) is not None)
    if form == "hole":
        return hole_nodes(builder, (*loc, "hole"), pick.hole, mesh)
    found = build_declared(builder, (*loc, form), getattr(pick, form))
    if found is None:
        return None
    nodes = mesh.picked(found, surface=form != "plane" and not pick.inside)
    if form == "nearest" and len(nodes):
        away = np.linalg.norm(mesh.nodes[nodes] - found.point, axis=1)
        sentence = far_off(found.point, mesh.nodes[nodes[np.argmin(away)]], mesh)
        if sentence:
            builder.note((*loc, form, "point"), sentence)
            return None
    if not len(nodes):
        low, high = mesh.bounds
        size = " to ".join(
            "(" + ", ".join(f"{round(1e3 * x, 3) + 0.0:g}" for x in corner) + ")"
            for corner in (low, high)
        )
        builder.note((*loc, form), f"holds no node of the mesh, which spans {size} mm")
        return None
    return nodes


def with_holes(mesh: Mesh) -> Mesh:
    """Return the mesh with the walls of its holes as sets hole1, hole2 ..."""
    for hole in mesh.holes():
        if hole.name not in mesh.node_sets:
            mesh = mesh.with_set(hole.name, hole.nodes)
    return mesh


def hole_nodes(builder: Builder, loc: Loc, entry: ss.HolePick, mesh: Mesh) -> Any:
    """Return the nodes on the wall of a hole; None, with a problem, if there is no such hole."""
    from jousto.mesh.holes import hole_text

    holes = mesh.holes()
    fitting = [
        hole
        for hole in holes
        if entry.diameter is None
        or abs(2.0 * hole.radius - entry.diameter) <= DIAMETER * entry.diameter
    ]
    near = np.asarray(entry.near)
    nearest = min(fitting, key=lambda h: float(np.linalg.norm(h.point - near)), default=None)
    if nearest is not None and not far_off(near, nearest.point, mesh):
        return nearest.nodes
    found = "; ".join(f"{hole.name}, {hole_text(hole)}" for hole in holes[:SHOWN]) or "none"
    there = f"the mesh has {count(len(holes), 'hole')}: {found}"
    if nearest is not None:
        builder.note((*loc, "near"), f"{far_off(near, nearest.point, mesh)}; {there}")
    elif entry.diameter is None:
        builder.note(loc, "the mesh has no cylindrical hole; pick its nodes by a cylinder or box")
    else:
        builder.note(loc, f"no hole of {1e3 * entry.diameter:g} mm; {there}")
    return None


def far_off(point: Any, found: Any, mesh: Mesh) -> str:
    """Return the message for a point that is far from the mesh; empty if it is near enough.

    A point is far if its distance from the nearest candidate exceeds the longest side of the mesh;
    often the unit is missing, since numbers without a unit are m.
    """
    low, high = mesh.bounds
    longest = float((high - low).max())
    point = np.asarray(point, dtype=float)
    away = float(np.linalg.norm(point - found))
    if away <= longest:
        return ""
    sentence = f"lies {away:.4g} m from the nearest, the mesh is {1e3 * longest:.4g} mm long"
    if float(np.linalg.norm(1e-3 * point - found)) > longest:
        return sentence
    meant = ", ".join(f"{x:g} mm" if x else "0" for x in point)
    return f"{sentence}; numbers without a unit are m, was [{meant}] meant?"


# -- reduction ------------------------------------------------------------------------------


def residuals(place: Place, value: Any) -> Any:
    """Return load patterns (ndof,) and names of stress sites; None if one is invalid."""
    part = place.known["part"]
    found = [
        item if isinstance(item, str) else pattern(place.at(i), item, part)
        for i, item in enumerate(value)
        if isinstance(item, str) or part is not None
    ]
    return None if any(item is None for item in found) else tuple(found)


def pattern(place: Place, entry: Any, part: Any) -> Any:
    """Return the nodal forces (ndof,) of a load; None, with a problem, if it is invalid."""
    from jousto.parts.loads import Pressure

    if isinstance(entry, PressurePatternEntry):
        load = Pressure(entry.pressure, 1.0)
        return place.builder.make((*place.loc, "pressure"), part.load, load)
    if entry.nodes not in part.node_sets:
        known = suggest(entry.nodes, part.node_sets)
        place.builder.note((*place.loc, "nodes"), f"no set {entry.nodes!r}{known}")
        return None
    forces = np.zeros((len(part.nodes), part.dofs_per_node))
    nodes = np.asarray(part.node_sets[entry.nodes])
    forces[nodes, :3] = np.asarray(entry.force) / len(nodes)
    return forces.ravel()


FORMS: dict[str, Callable[[Place, Any], Any]] = {"pick": pick, "residuals": residuals}
"""How a value of each form becomes an object."""
