"""Static loads on a part as nodal forces: pressures, tractions, weights, rotation, forces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from jousto.base.arrays import Array, Ints, Sparse, times
from jousto.base.declare import Declared
from jousto.base.errors import Problems, suggest
from jousto.base.fields import AnyField, field
from jousto.base.numbers import Number, Vector
from jousto.base.renames import missing_attribute
from jousto.mesh.area import area_matrix, face_points
from jousto.mesh.picks import Pick
from jousto.mesh.sets import read_integers
from jousto.parts.geometry import Geometry

ZERO = (0.0, 0.0, 0.0)
SURFACE = "str, array_like of int or pick"


class Load(Declared):
    """Base of the loads; `Part.load` checks the values of all loads together."""

    def __post_init__(self) -> None:
        """Store the values without checks."""


class Pressure(Load):
    """Pressure on a surface of a solid, against its outward normal."""

    on: AnyField = field(
        "Surface or node set, node indices or a pick such as ``InCylinder``: it selects the "
        "outer faces with all their nodes in the set",
        noun=SURFACE,
    )
    pressure: Number = field("Negative pulls", unit="Pa", wanted="a finite number")


class Traction(Load):
    """Constant force per area on a surface of a solid."""

    on: AnyField = field("Surface; see :class:`Pressure`", noun=SURFACE)
    traction: Vector = field("Part frame", unit="Pa")


class SurfaceLoad(Load):
    """Force and moment distributed over a surface of a solid.

    The traction is ``a + b x (x - c)``, with a and b such that its resultants are the force and the
    moment about the surface's centroid c.
    """

    on: AnyField = field("Surface; see :class:`Pressure`", noun=SURFACE)
    force: Vector = field("Part frame", unit="N", default=ZERO)
    moment: Vector = field(
        "Moment about the centroid of the surface, part frame", unit="N m", default=ZERO
    )


class NodalForce(Load):
    """Force (and moment if nodes have rotations), shared equally by the nodes."""

    on: AnyField = field(
        "Node set, node indices or a pick", noun="str, int, array_like of int or pick"
    )
    force: Vector = field("Total force of all nodes, part frame", unit="N", default=ZERO)
    moment: Vector = field(
        "Total moment, part frame; for parts of six degrees of freedom per node",
        unit="N m",
        default=ZERO,
    )


class Weight(Load):
    """Weight of the mass of the part in a field such as gravity."""

    acceleration: Vector = field(
        "Acceleration of gravity, part frame: ``(0, 0, -9.81)`` acts downwards along z",
        unit="m/s^2",
    )


class Spin(Load):
    """Centrifugal force of a steady rotation, ``-rho w x (w x (x - c))``."""

    velocity: Vector = field("Angular velocity w, part frame", unit="rad/s")
    center: Vector = field("Point c on the axis, part frame", unit="m", default=ZERO)

    if not TYPE_CHECKING:  # types of attributes remain known

        def __getattr__(self, name: str) -> NoReturn:
            missing_attribute(self, name)


def load_vector(part: Geometry, M: Sparse, loads: Sequence[Load]) -> Array:
    """Return the nodal forces (ndof,) of loads, see `Part.load`."""
    problems = Problems()
    total = np.zeros((len(part.nodes), part.dofs_per_node))
    for number, load in enumerate(loads):
        given: object = load
        label = f"part '{part.name}', load {number + 1}"
        if not isinstance(given, Load):
            kinds = ", ".join(kind.__name__ for kind in Load.__subclasses__())
            problems.add(label, f"is {given!r}, must be one of {kinds}")
            continue
        label += f" ({type(load).__name__})"
        known = {
            name: kind.check(problems, label, getattr(load, name))
            for name, kind in load.fields.items()
        }
        if any(value is None for name, value in known.items() if name != "on"):
            continue
        if isinstance(load, Weight):
            total += _inertial(part, M, np.broadcast_to(known["acceleration"], part.nodes.shape))
        elif isinstance(load, Spin):
            w, r = known["velocity"], part.nodes - known["center"]
            total += _inertial(part, M, -np.cross(w, np.cross(w, r)))
        else:
            nodes = pick_nodes(problems, label, part, known["on"])
            if nodes is None:
                continue
            if isinstance(load, NodalForce):
                _on_nodes(problems, label, total, nodes, known)
                continue
            faces = _faces(problems, label, part, known["on"], nodes)
            if faces is None:
                continue
            if isinstance(load, Pressure):
                for group in faces:
                    N, area, _ = face_points(part.nodes, group)
                    force = np.einsum("qk,fqx->fkx", N, -known["pressure"] * area)
                    np.add.at(total[:, :3], group.ravel(), force.reshape(-1, 3))
            elif isinstance(load, Traction):
                t = np.broadcast_to(known["traction"], part.nodes.shape)
                total[:, :3] += times(area_matrix(part.nodes, faces), t)
            else:
                _spread(problems, label, part, faces, total, known)
    problems.raise_if_any()
    return total.reshape(-1)


def _inertial(part: Geometry, M: Sparse, field: Array) -> Array:
    """Return ``int rho field`` as nodal forces for an affine acceleration field (nn, 3)."""
    a = np.zeros((len(part.nodes), part.dofs_per_node))
    a[:, :3] = field
    return times(M, a.reshape(-1)).reshape(a.shape)


def _on_nodes(
    problems: Problems, label: str, total: Array, nodes: Ints, known: dict[str, Any]
) -> None:
    np.add.at(total[:, :3], nodes, known["force"] / len(nodes))
    if np.any(known["moment"] != 0.0):
        if total.shape[1] == 3:
            problems.add(
                label,
                "has a moment, but nodes of solids have no rotations: use SurfaceLoad on a surface",
            )
        else:
            np.add.at(total[:, 3:], nodes, known["moment"] / len(nodes))


def _spread(
    problems: Problems,
    label: str,
    part: Geometry,
    faces: list[Ints],
    total: Array,
    known: dict[str, Any],
) -> None:
    A = area_matrix(part.nodes, faces)
    share = times(A, np.ones(len(part.nodes)))
    area = float(share.sum())
    c = share @ part.nodes / area
    r = part.nodes - c
    second = r.T @ times(A, r)
    J = np.trace(second) * np.eye(3) - second
    t = np.broadcast_to(known["force"] / area, part.nodes.shape)
    if np.any(known["moment"] != 0.0):
        if np.linalg.eigvalsh(J)[0] < 1e-10 * np.trace(J):
            problems.add(
                label,
                "has a moment, but the faces lie on a line; pick a wider surface",
            )
            return
        t = t + np.cross(np.linalg.solve(J, known["moment"]), r)
    total[:, :3] += times(A, t)


def pick_nodes(problems: Problems, label: str, part: Geometry, on: Any) -> Ints | None:
    """Return the nodes of a set, of indices or of a pick; report wrong ones."""
    if isinstance(on, str):
        if on not in part.node_sets:
            problems.add(label, f"no surface or node set '{on}'{suggest(on, part.node_sets)}")
            return None
        return np.array(part.node_sets[on], dtype=np.int64)
    if isinstance(on, Pick):
        found = np.asarray(on.of(part.nodes), dtype=np.int64)
        if not len(found):
            problems.add(label, "the pick contains no node; check that it is in m")
            return None
        return found
    array = read_integers(on)
    if array is None or array.ndim > 1 or not array.size:
        problems.add(label, f"on is {on!r}, must name a node set, node indices or a pick", "on")
        return None
    array = np.atleast_1d(array)
    if array.min() < 0 or array.max() >= len(part.nodes):
        problems.add(label, f"names a node outside 0..{len(part.nodes) - 1}")
        return None
    return array


def _faces(
    problems: Problems, label: str, part: Geometry, on: Any, nodes: Ints
) -> list[Ints] | None:
    """Return the outer faces of a named surface, or those with all nodes among the given ones."""
    if not part.faces:
        problems.add(
            label,
            "needs a surface, but the part has no outer faces; only parts of solids have them",
        )
        return None
    named = part.surfaces.get(on) if isinstance(on, str) else None
    if named is not None:
        # rows of the outer faces, which have outward normals
        keys = {tuple(sorted(row)) for group in named for row in group.tolist()}
        masks = [[tuple(sorted(row)) in keys for row in group.tolist()] for group in part.faces]
        chosen = [g[np.array(m, dtype=bool)] for g, m in zip(part.faces, masks, strict=True)]
    else:
        inside = np.zeros(len(part.nodes), dtype=bool)
        inside[nodes] = True
        chosen = [group[np.all(inside[group], axis=1)] for group in part.faces]
    chosen = [group for group in chosen if len(group)]
    if not chosen:
        name = f"'{on}'" if isinstance(on, str) else "the nodes picked"
        problems.add(
            label,
            f"{name} ({len(nodes)} nodes) contain no complete face of the surface; pick all nodes "
            f"of a face including mid-side nodes, or use NodalForce",
            name,
        )
        return None
    return chosen
