"""Static loads on a part as nodal forces: pressures, tractions, weights, spin, forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arrays import Floats, Ints, Sparse, times
from jousto.base.described import described
from jousto.base.errors import Problems, suggest
from jousto.mesh.area import area_matrix, face_points
from jousto.mesh.picks import Pick
from jousto.mesh.sets import read_integers
from jousto.parts.geometry import Geometry


@described
@dataclass(frozen=True, eq=False)
class Pressure:
    """A pressure on a surface of a solid, against its outward normal.

    Parameters
    ----------
    on : str, array_like of int or pick
        Surface or node set, node indices or a pick such as ``InCylinder``: the outer faces whose
        nodes are all among these.
    pressure : float
        In Pa; negative pulls.
    """

    on: Any
    pressure: float


@described
@dataclass(frozen=True, eq=False)
class Traction:
    """An even force per area on a surface of a solid.

    Parameters
    ----------
    on : str, array_like of int or pick
        As for :class:`Pressure`.
    traction : (3,) array_like
        In Pa, part frame.
    """

    on: Any
    traction: Any


@described
@dataclass(frozen=True, eq=False)
class SurfaceLoad:
    """A force and a moment spread over a surface of a solid.

    The traction is ``a + b x (x - c)``, with a and b such that its resultants are the force and the
    moment about the surface's centroid c.

    Parameters
    ----------
    on : str, array_like of int or pick
        As for :class:`Pressure`.
    force : (3,) array_like
        In N, part frame.
    moment : (3,) array_like
        In N m about the centroid of the surface, part frame.
    """

    on: Any
    force: Any = (0.0, 0.0, 0.0)
    moment: Any = (0.0, 0.0, 0.0)


@described
@dataclass(frozen=True, eq=False)
class NodalForce:
    """A force, and a moment where nodes can turn, shared equally by nodes.

    Parameters
    ----------
    on : str, int, array_like of int or pick
        Node set, node indices or a pick.
    force : (3,) array_like
        In N, part frame; together.
    moment : (3,) array_like
        In N m, part frame; for parts of six degrees of freedom per node.
    """

    on: Any
    force: Any = (0.0, 0.0, 0.0)
    moment: Any = (0.0, 0.0, 0.0)


@described
@dataclass(frozen=True, eq=False)
class Weight:
    """The weight of the part's mass in a field such as gravity.

    Parameters
    ----------
    acceleration : (3,) array_like
        In m/s^2, part frame: ``(0, 0, -9.81)`` pulls downwards along z.
    """

    acceleration: Any


@described
@dataclass(frozen=True, eq=False)
class Spin:
    """The centrifugal force of a steady rotation, ``-rho w x (w x (x - c))``.

    Parameters
    ----------
    velocity : (3,) array_like
        Angular velocity w in rad/s, part frame.
    centre : (3,) array_like
        A point c of the axis in m, part frame.
    """

    velocity: Any
    centre: Any = (0.0, 0.0, 0.0)


Load = Pressure | Traction | SurfaceLoad | NodalForce | Weight | Spin
_FIELDS = {
    Pressure: (),
    Traction: ("traction",),
    SurfaceLoad: ("force", "moment"),
    NodalForce: ("force", "moment"),
    Weight: ("acceleration",),
    Spin: ("velocity", "centre"),
}


def load_vector(part: Geometry, M: Sparse, loads: Sequence[Load]) -> Floats:
    """Return the nodal forces (ndof,) of loads, see `Part.load`."""
    problems = Problems()
    total = np.zeros((len(part.nodes), part.dofs_per_node))
    for number, load in enumerate(loads):
        given: object = load
        label = f"part '{part.name}', load {number + 1}"
        if type(given) not in _FIELDS:
            kinds = ", ".join(kind.__name__ for kind in _FIELDS)
            problems.add(label, f"is {given!r}, must be one of {kinds}")
            continue
        label += f" ({type(load).__name__})"
        vectors = {
            name: problems.array(label, name, getattr(load, name), (3,))
            for name in _FIELDS[type(load)]
        }
        if any(v is None for v in vectors.values()):
            continue
        known = {name: v for name, v in vectors.items() if v is not None}
        if isinstance(load, Weight):
            total += _inertial(part, M, np.broadcast_to(known["acceleration"], part.nodes.shape))
        elif isinstance(load, Spin):
            w, r = known["velocity"], part.nodes - known["centre"]
            total += _inertial(part, M, -np.cross(w, np.cross(w, r)))
        else:
            nodes = pick_nodes(problems, label, part, load.on)
            if nodes is None:
                continue
            if isinstance(load, NodalForce):
                _on_nodes(problems, label, total, nodes, known)
                continue
            faces = _faces(problems, label, part, load.on, nodes)
            if faces is None:
                continue
            if isinstance(load, Pressure):
                if not problems.number(label, "pressure", load.pressure, "Pa"):
                    continue
                for group in faces:
                    N, area, _ = face_points(part.nodes, group)
                    force = np.einsum("qk,fqx->fkx", N, -load.pressure * area)
                    np.add.at(total[:, :3], group.ravel(), force.reshape(-1, 3))
            elif isinstance(load, Traction):
                t = np.broadcast_to(known["traction"], part.nodes.shape)
                total[:, :3] += times(area_matrix(part.nodes, faces), t)
            else:
                _spread(problems, label, part, faces, total, known)
    problems.raise_if_any()
    return total.reshape(-1)


def _inertial(part: Geometry, M: Sparse, field: Floats) -> Floats:
    """Return ``int rho field`` of an affine field of accelerations (nn, 3) as nodal forces."""
    a = np.zeros((len(part.nodes), part.dofs_per_node))
    a[:, :3] = field
    return times(M, a.reshape(-1)).reshape(a.shape)


def _on_nodes(
    problems: Problems, label: str, total: Floats, nodes: Ints, known: dict[str, Floats]
) -> None:
    np.add.at(total[:, :3], nodes, known["force"] / len(nodes))
    if np.any(known["moment"] != 0.0):
        if total.shape[1] == 3:
            problems.add(
                label,
                "has a moment, but nodes of solids do not turn: use SurfaceLoad on a surface",
            )
        else:
            np.add.at(total[:, 3:], nodes, known["moment"] / len(nodes))


def _spread(
    problems: Problems,
    label: str,
    part: Geometry,
    faces: list[Ints],
    total: Floats,
    known: dict[str, Floats],
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
            problems.add(label, "has a moment, but the faces lie on a line")
            return
        t = t + np.cross(np.linalg.solve(J, known["moment"]), r)
    total[:, :3] += times(A, t)


def pick_nodes(problems: Problems, label: str, part: Geometry, on: Any) -> Ints | None:
    """Return the nodes of a set, of indices or of a pick, or note what is wrong."""
    if isinstance(on, str):
        if on not in part.node_sets:
            problems.add(label, f"no surface or node set '{on}'{suggest(on, part.node_sets)}")
            return None
        return np.array(part.node_sets[on], dtype=np.int64)
    if isinstance(on, Pick):
        found = np.asarray(on.of(part.nodes), dtype=np.int64)
        if not len(found):
            problems.add(label, "no node lies where it picks; is the pick in metres?")
            return None
        return found
    array = read_integers(on)
    if array is None or array.ndim > 1 or not array.size:
        problems.add(label, f"on is {on!r}, must name a node set, node indices or a pick")
        return None
    array = np.atleast_1d(array)
    if array.min() < 0 or array.max() >= len(part.nodes):
        problems.add(label, f"names a node outside 0..{len(part.nodes) - 1}")
        return None
    return array


def _faces(
    problems: Problems, label: str, part: Geometry, on: Any, nodes: Ints
) -> list[Ints] | None:
    """Return the outer faces of a named surface, or those all of whose nodes are among these."""
    if not part.faces:
        problems.add(
            label, "needs a surface, but the part has no outer faces: only Part.solid has them"
        )
        return None
    named = part.surfaces.get(on) if isinstance(on, str) else None
    if named is not None:
        # rows of the outer faces, which are turned outwards
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
            f"{name} ({len(nodes)} nodes) hold no whole face of the surface; pick all nodes of a"
            " face, its mid nodes too, or use NodalForce",
        )
        return None
    return chosen
