"""Scene bodies from the shapes in results and parts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array, Index
from jousto.reduction.fields.stress import StressModes
from jousto.scene.default_shapes import default_shape
from jousto.scene.scene import Body
from jousto.scene.surfaces import compact, feature_edges
from jousto.simulation.results.records import BodyShape


def is_surface(elements: Index) -> bool:
    """Return whether elements are triangles."""
    return bool(np.ndim(elements) == 2 and len(elements) and elements.shape[1] == 3)


def solid_body(shape: BodyShape, modes: StressModes | None) -> Body:
    """Return a body with a surface; flexible bodies with mode shapes and stress.

    Parameters
    ----------
    shape : BodyShape
    modes : StressModes or None
        Stress modes of the body.
    """
    used, triangles = compact(shape.elements)
    positions = np.asarray(shape.nodes, dtype=np.float64)[used]
    flexible = shape.kind == "flexible"
    stress, known = (None, None) if modes is None else _at_nodes(modes, used, len(shape.nodes))
    facts = [f"{shape.n} modes"] if flexible else []
    facts.append(f"{len(shape.nodes)} nodes" if flexible else f"{len(triangles)} triangles")
    return Body(
        name=shape.name,
        kind="solid" if flexible else "rigid",
        place=shape.q_offset,
        modes=shape.n,
        positions=positions,
        triangles=triangles,
        edges=feature_edges(positions, triangles),
        shapes=np.moveaxis(shape.modes[used], 2, 0) if shape.n else None,
        stress=stress,
        known=known,
        nodes=used + 1 if flexible else None,
        about=", ".join(facts),
    )


def _at_nodes(
    modes: StressModes, used: Index, count: int
) -> tuple[Array | None, NDArray[np.bool_] | None]:
    """Return the stress (n, nv, 6) at nodes in the axes of the part, and a mask of known nodes.

    Nodes with several places, such as on the border of two materials, use the first place.
    """
    if modes.nodes is None:
        return None, None
    places = np.flatnonzero(modes.nodes >= 0)
    at = np.full(count, -1, dtype=np.intp)
    at[modes.nodes[places][::-1]] = places[::-1]
    found = at[used]
    if (found < 0).all():
        return None, None
    stress = modes.modes[np.maximum(found, 0)]
    if (found < 0).any():
        stress[found < 0] = 0.0
        return np.moveaxis(stress, 2, 0), found >= 0
    return np.moveaxis(stress, 2, 0), None


def line_body(shape: BodyShape) -> Body:
    """Return a flexible body as lines between its nodes."""
    elements = np.asarray(shape.elements)
    pairs = np.zeros((0, 2), dtype=np.intp)
    if elements.ndim == 2 and elements.shape[1] >= 2 and len(elements):
        ring = np.stack([elements, np.roll(elements, -1, axis=1)], axis=2).reshape(-1, 2)
        ring = np.unique(np.sort(ring, axis=1), axis=0)
        pairs = ring[ring[:, 0] != ring[:, 1]].astype(np.intp)
    return Body(
        name=shape.name,
        kind="frame",
        place=shape.q_offset,
        modes=shape.n,
        positions=np.asarray(shape.nodes, dtype=np.float64),
        lines=pairs,
        shapes=np.moveaxis(shape.modes, 2, 0) if shape.n else None,
        nodes=np.arange(len(shape.nodes)) + 1,
        about=f"{shape.n} modes, {len(shape.nodes)} nodes",
    )


def rigid_body(shape: BodyShape, joints: Array, size: float) -> Body:
    """Return a rigid body without a surface as rods and a ball.

    Parameters
    ----------
    shape : BodyShape
        Shape with lines as elements.
    joints : (k, 3) array
        Points at which joints and forces act, m.
    size : float
        Size of the machine, m.
    """
    nodes = np.asarray(shape.nodes, dtype=np.float64)
    pairs = np.asarray(shape.elements, dtype=np.intp).reshape(-1, 2)
    # star: every line starts at the centre of mass
    star = bool(len(nodes)) and not np.any(pairs[:, 0])
    if star and len(joints):
        more = np.unique(np.round(joints, 12), axis=0)
        pairs = np.concatenate([pairs, [[0, len(nodes) + i] for i in range(len(more))]]).astype(
            np.intp
        )
        nodes = np.concatenate([nodes, more])
    if star and len(nodes) > 2:  # the origin is part of the shape if a line ends there
        used = np.unique(nodes[2:], axis=0)
        if not (np.abs(used - nodes[1]) <= 1e-9 * size).all(axis=1).any():
            pairs = pairs[pairs[:, 1] != 1]
    centre = nodes[0] if star else None
    positions, triangles = default_shape(nodes, pairs, centre, shape.mass, size)
    return Body(
        name=shape.name,
        kind="rigid",
        place=shape.q_offset,
        modes=0,
        positions=positions,
        triangles=triangles,
        edges=np.zeros((0, 2), dtype=np.intp),
        mass=shape.mass,
        about="no surface was declared" if star else "",
    )
