"""Static scenes of parts and meshes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jousto.base.errors import InputError, Problem
from jousto.mesh.mesh import Mesh
from jousto.mesh.surface import outer_faces, triangulate
from jousto.model.frame_record import ELEMENTS, FrameShape
from jousto.parts.frames.second_order import SecondOrder
from jousto.parts.part import Part
from jousto.scene.bodies import is_surface, line_body, solid_body
from jousto.scene.bounding_box import bounding_box
from jousto.scene.frames import frame_body
from jousto.scene.scene import Body, Mark, Scene, Side
from jousto.simulation.results.records import BodyShape

MOST_MARKS = 50  # number of named nodes shown


def part_scene(part: Part) -> Scene:
    """Return the scene of a part."""
    nodes, n = np.asarray(part.nodes).real, len(part.nodes)
    frame, second = None, part.second_order
    if isinstance(second, SecondOrder) and part.outlines is not None:
        beams = second.beams
        own = {name: np.asarray(getattr(beams, name)).real for name in ELEMENTS}
        which = np.asarray(part.outlines.which, dtype=np.intp)
        none = np.zeros((n, 3, 0))
        frame = FrameShape(**own, rotations=none, edges=part.outlines.edges, which=which)
    none = np.zeros((n, 3, 0))
    elements = np.asarray(part.elements, dtype=np.int64)
    shape = BodyShape(part.name, "flexible", 0, 0, 0, nodes, elements, none, None, frame)
    if is_surface(elements):
        body, facts = solid_body(shape, None), f"{n} nodes"
    elif frame is not None:
        body, facts = frame_body(shape, frame, None), f"{len(elements)} beam elements"
    else:
        body, facts = line_body(shape), f"{n} nodes"
    body = replace(body, shapes=None, about=facts, mass=float(np.real(part.mass)))
    single = [(key, members[0]) for key, members in part.node_sets.items() if len(members) == 1]
    chosen = [(key, node) for key, node in single if key != f"node{node + 1}"]
    marks = tuple(Mark(name, Side(-1, 0, nodes[node])) for name, node in chosen[:MOST_MARKS])
    return _still(part.name, body, marks)


def mesh_scene(mesh: Mesh) -> Scene:
    """Return the scene of a mesh.

    Raises
    ------
    InputError
        If the mesh has no solid elements.
    """
    faces = outer_faces(mesh.cells)
    triangles = np.asarray(triangulate(faces)) if faces else np.zeros((0, 3), dtype=np.int64)
    if not len(triangles):
        raise InputError(Problem(f"mesh '{mesh.name}'", "has no solid elements to show"))
    nodes = np.asarray(mesh.nodes)
    none = np.zeros((len(nodes), 3, 0))
    shape = BodyShape(mesh.name, "flexible", 0, 0, 0, nodes, triangles, none)
    body = replace(solid_body(shape, None), kind="mesh", about=f"{len(nodes)} nodes")
    return _still(mesh.name, body, ())


def _still(name: str, body: Body, marks: tuple[Mark, ...]) -> Scene:
    fixed = replace(body, place=-1)
    empty = np.zeros((1, 0))
    return Scene(
        what="part",
        name=name,
        title=name,
        still=empty[0],
        bodies=(fixed,),
        box=bounding_box([fixed], (), empty),
        markers=marks,
    )
