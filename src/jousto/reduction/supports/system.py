"""Coordinates of a part in which the motions of supported nodes are coordinates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array, Index, Ints, skew
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.mesh.picks import Pick
from jousto.mesh.sets import read_integers
from jousto.parts.loads import Load, NodalForce, Weight
from jousto.parts.part import Part
from jousto.reduction.modes.rigid import length_scale
from jousto.reduction.modes.ties import coordinates
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.supports.support import Support

LINE = 60  # characters of a value in messages
# singular value of scaled motions of nodes, relative to the largest one, below which they are
# dependent
DEPENDENT = 1e-9


@dataclass(frozen=True, eq=False)
class SupportedNode:
    """A node with the indices of its coordinates, -1 for a missing rotation."""

    name: str
    at: Array
    places: Index


@dataclass(frozen=True, eq=False)
class System:
    """Stiffness and mass of a part in coordinates c, and the nodes of each of its supports.

    Parameters
    ----------
    where : str
        Name of the part for messages.
    K : (n, n) sparse array
        Stiffness.
    M : (m, m) sparse array
        Mass of the motions `lift` returns.
    lift : callable
        Returns the motions (m, k) of coordinates (n, k); `lower` is its transpose.
    displacements : callable
        Returns the displacements (nodes, 3, k) of motions (m, k).
    load : callable
        Returns the loads (n,) on the coordinates.
    motions : (n, 6) array
        Rigid motions: translations, and rotations about the centre.
    nodes : tuple of tuple of SupportedNode
        Nodes of each support.
    center : (3,) array
        Centroid of the nodes, m.
    length : float
        Size of the part, m.
    label : callable
        Name of a coordinate for messages.
    points : (n, 3) array or None
        Positions of the coordinates, for the factorisation.
    """

    where: str
    K: sp.csr_array
    M: sp.csr_array
    lift: Callable[[Array], Array]
    lower: Callable[[Array], Array]
    displacements: Callable[[Array], Array]
    load: Callable[[Sequence[Any]], Array]
    motions: Array
    nodes: tuple[tuple[SupportedNode, ...], ...]
    center: Array
    length: float
    label: Callable[[int], str]
    points: Array | None


def full_system(part: Part, supports: Sequence[Support]) -> System:
    """Return the system of a finite element model; rigid ties are satisfied."""
    where, problems = f"part '{part.name}'", Problems()
    z = coordinates(part)
    d = part.dofs_per_node
    ties = {tie.name: tie for tie in part.ties}
    tied = {int(i): tie.name for tie in part.ties if tie.kind == "rigid" for i in tie.nodes}
    found: list[tuple[SupportedNode, ...]] = []
    for support in supports:
        label, on = f"{where}, {support.heading(problems)}", support.on
        if isinstance(on, str) and on in ties:
            tie = ties[on]
            if tie.kind != "rigid":
                problems.add(
                    label, f"interface {on!r} is an average; hold its nodes or a rigid interface"
                )
                continue
            found.append((SupportedNode(on, tie.at, z.references[on]),))
            continue
        nodes = _nodes(problems, label, part.node_sets, part.nodes, on)
        if owner := next((tied[i] for i in map(int, nodes) if i in tied), None):
            problems.add(label, f"has nodes of interface {owner!r}; hold that interface")
            continue
        places = [_six(z.of_dof[d * int(i) + np.arange(d)]) for i in nodes]
        found.append(
            tuple(
                SupportedNode(_node_name(part.node_sets, int(i)), part.nodes[i], place)
                for i, place in zip(nodes, places, strict=True)
            )
        )
    problems.raise_if_any()

    def load(loads: Sequence[Any]) -> Array:
        if len(loads) == 1 and not isinstance(loads[0], Load):
            problems = Problems()
            if not _is_array(loads[0]):
                kinds = ", ".join(kind.__name__ for kind in Load.__subclasses__())
                problems.add(
                    f"{where}, load 1",
                    f"is {brief(loads[0])}, must be one of {kinds}, each an argument of its own, "
                    f"or the array ({part.K.shape[0]},) of forces that part.load(...) returns",
                )
                problems.raise_if_any()
            given = problems.array(where, "loads", loads[0], (part.K.shape[0],))
            problems.raise_if_any()
            assert given is not None
            return z.gather(given)
        return z.gather(part.load(*loads))

    def displacements(u: Array) -> Array:
        return u.reshape(len(part.nodes), d, -1)[:, :3]

    return System(
        where=where,
        K=sp.csr_array(z.restrict(sp.csr_array(part.K))),
        M=sp.csr_array(part.M),
        lift=z.spread,
        lower=z.gather,
        displacements=displacements,
        load=load,
        motions=z.motions * np.repeat([1.0, z.length], 3),
        nodes=tuple(found),
        center=part.nodes.mean(axis=0),
        length=z.length,
        label=z.label,
        points=z.points,
    )


def reduced_system(part: ReducedPart, supports: Sequence[Support]) -> System:
    """Return the system of a reduced part, ``c = [u of the supported nodes, rest]``.

    Its motions are x = [translation of the origin, rotation, p]. Supports are on interfaces, whose
    static shapes the modes contain.
    """
    where, problems = f"reduced part '{part.name}'", Problems()
    boundary = {name: part.node_sets[name] for name in part.interfaces}
    chosen: list[tuple[int, ...]] = []
    for support in supports:
        label = f"{where}, {support.heading(problems)}"
        nodes = _nodes(problems, label, part.node_sets, part.nodes, support.on)
        inside = [int(i) for i in nodes if not any(i in some for some in boundary.values())]
        if inside:
            known = ", ".join(part.interfaces) or "none"
            problems.add(
                label,
                f"node{inside[0] + 1} is no interface (there are: {known}): the modes lack the "
                "shape of forces there; make it an interface of the reduction, or hold the full "
                "part",
            )
        chosen.append(tuple(int(i) for i in nodes))
    problems.raise_if_any()
    length, n = length_scale(part.nodes), part.n
    # rows of all motions of the supported nodes, each node once
    rows: list[Array] = []
    places: dict[int, Index] = {}
    for i in dict.fromkeys(i for some in chosen for i in some):
        turn = part.rotation(i)
        own = [np.hstack([np.eye(3), -skew(part.nodes[i]), part.modes[i]])]
        if turn is not None:
            own.append(np.hstack([np.zeros((3, 3)), np.eye(3), turn]))
        first = sum(len(row) for row in rows)
        count = 3 * len(own)
        places[i] = _six(first + np.arange(count))
        rows += own
    B = np.vstack(rows) if rows else np.zeros((0, 6 + n))
    X = _coordinates(where, B, part, places, length)
    I = part.invariants
    M = np.zeros((6 + n, 6 + n))
    M[:3, :3], M[3:6, 3:6], M[6:, 6:] = I.mass * np.eye(3), I.I7, I.I6
    M[:3, 3:6], M[:3, 6:], M[3:6, 6:] = -skew(I.I2), I.I3, I.I4
    M = np.triu(M) + np.triu(M, 1).T
    K = np.zeros_like(M)
    K[6:, 6:] = np.diag(part.stiffness)
    center = part.nodes.mean(axis=0)
    rigid = np.vstack([np.eye(6), np.zeros((n, 6))])
    # rotations about the centre
    rigid[:3, 3:6] = skew(center)

    def displacements(x: Array) -> Array:
        turned = -np.einsum("nij,jk->nik", skew(part.nodes), x[3:6])
        return np.asarray(x[None, :3] + turned + np.einsum("nij,jk->nik", part.modes, x[6:]))

    return System(
        where=where,
        K=sp.csr_array(X.T @ K @ X),
        M=sp.csr_array(M),
        lift=lambda c: X @ c,
        lower=lambda f: X.T @ f,
        displacements=displacements,
        load=lambda loads: X.T @ _reduced_load(where, part, loads),
        motions=np.asarray(np.linalg.solve(X, rigid)),
        nodes=tuple(
            tuple(
                SupportedNode(_node_name(part.node_sets, i), part.nodes[i], places[i]) for i in some
            )
            for some in chosen
        ),
        center=center,
        length=length,
        label=lambda k: f"coordinate {k + 1}",
        points=None,
    )


def _coordinates(
    where: str, B: Array, part: ReducedPart, places: dict[int, Index], length: float
) -> Array:
    """Return X (N, N) of ``x = X c`` whose first coordinates are ``B x``."""
    # x = D xi with all xi in m: rotations over the length, modes times the root of the mass
    D = np.repeat([1.0, 1.0 / length, part.invariants.mass**0.5], [3, 3, part.n])
    weight = np.ones(len(B))
    for place in places.values():
        weight[place[3:][place[3:] >= 0]] = length
    U, s, Vt = np.linalg.svd(weight[:, None] * B * D)
    if len(s) < len(B) or (len(s) and s[-1] <= DEPENDENT * s[0]):
        raise InputError(
            Problem(
                where,
                f"its {part.n} modes do not move the {len(places)} supported nodes independently; "
                "reduce it with CraigBampton and these nodes as interfaces, or hold the full part",
            )
        )
    m = len(B)
    inverse = (Vt[:m].T / s) @ U.T * weight
    return np.asarray(D[:, None] * np.hstack([inverse, Vt[m:].T]))


def _reduced_load(where: str, part: ReducedPart, loads: Sequence[Any]) -> Array:
    """Return loads on x = [translation, rotation, p]; forces act at interfaces."""
    problems = Problems()
    f = np.zeros(6 + part.n)
    boundary = {int(i) for name in part.interfaces for i in part.node_sets[name]}
    for number, load in enumerate(loads):
        label = f"{where}, load {number + 1} ({type(load).__name__})"
        if isinstance(load, Weight):
            g = problems.array(label, "acceleration", load.acceleration, (3,))
            if g is not None:
                I = part.invariants
                f += np.concatenate([I.mass * g, np.cross(I.I2, g), I.I3.T @ g])
        elif isinstance(load, NodalForce):
            nodes = _nodes(problems, label, part.node_sets, part.nodes, load.on)
            F = problems.array(label, "force", load.force, (3,))
            T = problems.array(label, "moment", load.moment, (3,))
            if F is None or T is None:
                continue
            for i in map(int, nodes):
                turn = part.rotation(i)
                if i not in boundary:
                    problems.add(label, f"node{i + 1} is no interface; use the full part")
                    break
                if T.any() and turn is None:
                    problems.add(label, f"has a moment, but node{i + 1} has no rotations")
                    break
                arm = np.cross(part.nodes[i], F)
                modal = part.modes[i].T @ F + (0.0 if turn is None else turn.T @ T)
                f += np.concatenate([F, arm + T, modal]) / len(nodes)
        elif isinstance(load, Load):
            problems.add(label, "a reduced part takes Weight and NodalForce; use the full part")
        else:
            problems.add(
                f"{where}, load {number + 1}",
                f"is {brief(load)}, must be Weight or NodalForce, each an argument of its own",
            )
    problems.raise_if_any()
    return f


def _is_array(value: Any) -> bool:
    """Return whether a value is an array of numbers, of whatever length."""
    try:
        return np.ndim(value) > 0 and np.asarray(value).dtype.kind in "iufc"
    except ValueError:
        return False


def brief(value: Any) -> str:
    """Return a value for messages, in one line of at most 60 characters."""
    text = " ".join(repr(value).split())
    return text if len(text) <= LINE else f"{text[: LINE - 4]} ..."


def _nodes(problems: Problems, label: str, sets: Any, points: Array, on: Any) -> Ints:
    """Return the nodes of a set, of indices or of a pick; none after reporting what is wrong."""
    none = np.zeros(0, dtype=np.int64)
    if isinstance(on, str):
        if on not in sets:
            problems.add(label, f"no node set {on!r}{suggest(on, sets)}", "on")
            return none
        if not len(sets[on]):
            problems.add(label, f"node set {on!r} is empty", "on")
        return np.array(sorted(sets[on]), dtype=np.int64)
    array = on.of(points) if isinstance(on, Pick) else read_integers(on)
    if array is None or np.ndim(array) > 1 or not np.size(array):
        what = f"on is {brief(on)}, must be the name of a node set, indices from 0 or a pick"
        if isinstance(on, Pick):
            what = "the pick contains no node; check that it is in m"
        problems.add(label, what, "on")
        return none
    found = np.unique(np.atleast_1d(array)).astype(np.int64)
    if found[0] < 0 or found[-1] >= len(points):
        problems.add(label, f"names a node outside 0..{len(points) - 1}", "on")
        return none
    return found


def _six(places: Index) -> Index:
    """Return the coordinates of a node (6,), -1 for missing rotations."""
    return np.concatenate([places, np.full(6 - len(places), -1)]).astype(np.intp)


def _node_name(sets: Any, node: int) -> str:
    """Return the name of a node: a set of this node alone, else its number from 1."""
    plain = f"node{node + 1}"
    return next((k for k, v in sets.items() if tuple(v) == (node,) and k != plain), plain)
