"""Findings about a mesh, that is, errors and doubtful points, as messages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array, Ints, some
from jousto.base.errors import InputError, Problem, count, warn
from jousto.base.ranking import ranking
from jousto.mesh.cells import LINES, SURFACES, base, edges, instead, is_quadratic
from jousto.mesh.grid import Grid
from jousto.mesh.quality import POOR
from jousto.mesh.surface import all_faces, match

# m, range of plausible diagonals
SMALL, LARGE, HUGE = 2e-3, 8.0, 100.0


@dataclass(frozen=True)
class Finding(Problem):
    """Error or doubtful point of a mesh.

    Attributes
    ----------
    where, message : str
        Place and message with the remedy, as in :class:`Problem`.
    kind : str
        ``empty``, ``numbers``, ``unsupported``, ``collapsed``, ``jacobian``, ``sliver``,
        ``overlap``, ``mixed orders``, ``pieces``, ``duplicate nodes``, ``free nodes``,
        ``unused nodes``, ``empty set`` or ``size``.
    severity : {"error", "warning"}
        A mesh with an error cannot be used for a part.
    ids : tuple of int
        Numbers of the elements or nodes in the file, worst first.
    """

    kind: str = ""
    severity: Literal["error", "warning"] = "warning"
    ids: tuple[int, ...] = ()


def inspect(mesh: Grid) -> tuple[Finding, ...]:
    """Return the findings of a mesh, errors first."""
    found = list(_all(mesh))
    return tuple(sorted(found, key=lambda finding: finding.severity != "error"))


def require(mesh: Grid, *, tolerate: Iterable[str] = (), silent: Iterable[str] = ()) -> None:
    """Raise InputError with all errors of a mesh, and warn about doubtful points.

    Parameters
    ----------
    mesh : Mesh or Grid
    tolerate : iterable of str
        Kinds of errors that become warnings.
    silent : iterable of str
        Kinds of findings that are not reported.
    """
    tolerated, unsaid = set(tolerate), set(silent)
    errors = []
    for finding in inspect(mesh):
        if finding.kind in unsaid:
            continue
        if finding.severity == "error" and finding.kind not in tolerated:
            errors.append(finding)
        else:
            warn(finding.where, finding.message)
    if errors:
        raise InputError(errors)


def _all(mesh: Grid) -> Iterator[Finding]:
    where = f"mesh '{mesh.name}'"
    yield from _unsupported(mesh, where)
    if not len(mesh.element_ids):
        kinds = sorted({block.kind for block in mesh.cells if len(block)})
        yield Finding(
            where,
            f"contains no solid elements, only {some(kinds) or 'nodes'}; export the volume mesh, "
            f"too"
            f"{instead(kinds)}",
            "empty",
            "error",
        )
        return
    yield from _numbers(mesh, where)
    yield from _shapes(mesh, where)
    yield from _connection(mesh, where)
    yield from _nodes(mesh, where)
    yield from _sets(mesh, where)
    yield from _size(mesh, where)


def _numbers(mesh: Grid, where: str) -> Iterator[Finding]:
    """Report numbers that are used by several solid elements or by several nodes."""
    for ids, what in ((mesh.element_ids, "element"), (mesh.node_ids, "node")):
        values, number = np.unique(ids, return_counts=True)
        wrong = values[number > 1]
        if len(wrong):
            yield Finding(
                where,
                f"number {_list(wrong)} belongs to more than one {what}; number each differently",
                "numbers",
                "error",
                tuple(int(i) for i in wrong),
            )


def _unsupported(mesh: Grid, where: str) -> Iterator[Finding]:
    for block in mesh.cells:
        if base(block.kind) == "pyramid" and len(block):
            yield Finding(
                where,
                f"{count(len(block), 'pyramid')} (element {_list(block.ids)}) cannot be used and"
                " would leave gaps; mesh with tetrahedra, hexahedra or wedges",
                "unsupported",
                "error",
                tuple(int(i) for i in block.ids),
            )


def _shapes(mesh: Grid, where: str) -> Iterator[Finding]:
    """Report collapsed, inverted and flat elements."""
    collapsed = []
    for block in mesh.solids:
        row = np.sort(block.nodes, axis=1)
        collapsed.append(np.any(row[:, 1:] == row[:, :-1], axis=1))
    bad = np.flatnonzero(np.concatenate(collapsed))
    if len(bad):
        ids = mesh.element_ids[bad]
        yield Finding(
            where,
            f"{count(len(bad), 'element')} (element {_list(ids)}) with the same node twice;"
            " export collapsed elements as wedges or tetrahedra",
            "collapsed",
            "error",
            tuple(int(i) for i in ids),
        )

    quality = mesh.quality()
    negative = np.setdiff1d(quality.negative, bad)
    if len(negative):
        order = negative[ranking(-quality.scaled_jacobian[negative])]
        ids = quality.ids[order]
        if len(negative) == len(quality):
            remedy = (
                "all elements have negative volume, because of the node order of another "
                "program or of a mirrored part; export again, or mirror the node order"
            )
        elif any(is_quadratic(block.kind) for block in mesh.solids):
            remedy = "refine the mesh there, or straighten the mid-side nodes of these elements"
        else:
            remedy = "correct their node order or mesh that region again"
        share = f" of {len(quality)}"
        yield Finding(
            where,
            f"the Jacobian of {count(len(negative), 'element')}{share} is not positive (element"
            f" {_list(ids)}): {remedy}",
            "jacobian",
            "error",
            tuple(int(i) for i in ids),
        )

    poor = np.setdiff1d(np.flatnonzero(quality.scaled_jacobian < POOR), quality.negative)
    poor = np.setdiff1d(poor, bad)
    if len(poor):
        order = poor[ranking(-quality.scaled_jacobian[poor])]
        ids = quality.ids[order]
        lowest = quality.scaled_jacobian[order[0]]
        yield Finding(
            where,
            f"{count(len(poor), 'element')} nearly flat (element {_list(ids)}), scaled Jacobian"
            f" down to {lowest:.2g}: stress there is unreliable and high frequencies are "
            f"inaccurate; remove small faces from the geometry or refine the mesh there",
            "sliver",
            "warning",
            tuple(int(i) for i in ids),
        )


def _connection(mesh: Grid, where: str) -> Iterator[Finding]:
    """Report overlapping elements, linear beside quadratic elements, and disconnected pieces."""
    blocks = all_faces(mesh.cells)
    group, number = match(blocks)
    owners = np.concatenate([block.owners for block in blocks])
    crowded = np.unique(owners[number[group] > 2])
    if len(crowded):
        ids = mesh.element_ids[crowded]
        yield Finding(
            where,
            f"{count(len(crowded), 'element')} (element {_list(ids)}) overlap: three or more share"
            " one face; remove elements that were exported twice",
            "overlap",
            "error",
            tuple(int(i) for i in ids),
        )
    columns = np.concatenate([np.full(len(block), block.nodes.shape[1]) for block in blocks])
    low, high = np.full(len(number), 99), np.zeros(len(number), dtype=np.int64)
    np.minimum.at(low, group, columns)
    np.maximum.at(high, group, columns)
    mixed = np.unique(owners[(low != high)[group]])
    if len(mixed):
        ids = mesh.element_ids[mixed]
        yield Finding(
            where,
            f"linear and quadratic elements share faces (element {_list(ids)}): the mid-side "
            f"nodes there are not connected; use one order",
            "mixed orders",
            "error",
            tuple(int(i) for i in ids),
        )

    from scipy.sparse.csgraph import connected_components  # slow to import and rarely needed

    nn = len(mesh.nodes)
    starts = [np.repeat(c.nodes[:, 0], c.nodes.shape[1] - 1) for c in mesh.solids]
    ends = [c.nodes[:, 1:].ravel() for c in mesh.solids]
    i, j = np.concatenate(starts), np.concatenate(ends)
    graph = sp.coo_array((np.ones(len(i), dtype=np.int8), (i, j)), shape=(nn, nn))
    _, label = connected_components(graph, directed=False)
    labels, sizes = np.unique(label[mesh.used], return_counts=True)
    if len(labels) > 1:
        from scipy.spatial import cKDTree

        smallest = labels[np.argmin(sizes)]
        inside = mesh.used[label[mesh.used] == smallest]
        outside = mesh.used[label[mesh.used] != smallest]
        distance, near = cKDTree(mesh.nodes[outside]).query(mesh.nodes[inside])
        distance, near = np.atleast_1d(distance), np.atleast_1d(near)
        k = int(np.argmin(distance))
        a, b = int(mesh.node_ids[inside[k]]), int(mesh.node_ids[outside[near[k]]])
        apart = float(distance[k])
        remedy = (
            "join them with mesh.merged()"
            if apart <= merge_tolerance(mesh)
            else "join them in the geometry, or make each piece a part"
        )
        yield Finding(
            where,
            f"has {len(labels)} pieces that are not connected; the smallest has"
            f" {count(len(inside), 'node')}, nearest to the others are node {a} and node {b},"
            f" {1e3 * apart:.3g} mm apart: {remedy}",
            "pieces",
            "error",
            (a, b),
        )


def _nodes(mesh: Grid, where: str) -> Iterator[Finding]:
    """Report coincident nodes, nodes that only shells or lines use, and nodes without elements."""
    tolerance = merge_tolerance(mesh)
    pairs = duplicates(mesh, tolerance)
    if len(pairs):
        a, b = mesh.node_ids[pairs[0]]
        yield Finding(
            where,
            f"{count(len(pairs), 'pair')} of coincident nodes (node {a} and node {b}, and so on;"
            f" within {1e3 * tolerance:.2g} mm): the elements are not connected there; join them "
            f"with mesh.merged(), except at a crack",
            "duplicate nodes",
            "warning",
            tuple(int(i) for i in mesh.node_ids[np.unique(pairs)]),
        )
    others = [block for block in mesh.cells if block.kind in SURFACES + LINES]
    touched = np.unique(np.concatenate([np.zeros(0, np.int64), *(c.nodes.ravel() for c in others)]))
    free = np.setdiff1d(touched, mesh.used)
    if len(free):
        ids = mesh.node_ids[free]
        yield Finding(
            where,
            f"{count(len(free), 'node')} (node {_list(ids)}) belong to shells, lines or points "
            f"only, which have no stiffness here: drop them with mesh.solid()",
            "free nodes",
            "warning",
            tuple(int(i) for i in ids),
        )
    loose = np.setdiff1d(np.arange(len(mesh.nodes)), np.union1d(mesh.used, touched))
    if len(loose):
        ids = mesh.node_ids[loose]
        yield Finding(
            where,
            f"{count(len(loose), 'node')} (node {_list(ids)}) belong to no element: drop them with"
            " mesh.solid(), or tie them as reference points of interfaces",
            "unused nodes",
            "warning",
            tuple(int(i) for i in ids),
        )


def _sets(mesh: Grid, where: str) -> Iterator[Finding]:
    named = {
        name
        for group in (mesh.node_sets, mesh.element_sets, mesh.surfaces)
        for name, members in group.items()
        if not len(members)
    }
    if named:
        yield Finding(
            where,
            f"empty {'sets' if len(named) > 1 else 'set'} {some(sorted(map(repr, named)))}: its "
            f"content was not exported or is not supported",
            "empty set",
        )


def _size(mesh: Grid, where: str) -> Iterator[Finding]:
    low, high = mesh.bounds
    long = float(np.linalg.norm(high - low))
    if not mesh.source or SMALL <= long <= LARGE:
        return
    found = f"is {long:.4g} m across"
    if long < SMALL:
        guess = f"if the file is in m, read it with unit='m': it is then {1e3 * long:.4g} m"
    elif long <= HUGE:
        guess = (
            f"if the file is in inches, read it with unit='in': it is then {0.0254 * long:.3g} m"
        )
    else:
        guess = (
            f"if the file is in mm or inches: with unit='mm' it is {1e-3 * long:.3g} m, with "
            f"unit='in'"
            f" {0.0254 * long:.3g} m"
        )
    yield Finding(where, f"{found}: {guess}", "size")


def merge_tolerance(mesh: Grid) -> float:
    """Return the distance, m, below which two nodes coincide."""
    low, high = mesh.bounds
    limit = 1e-5 * float(np.linalg.norm(high - low))
    for block in mesh.solids:
        ends = edges(block.kind)
        span = mesh.nodes[block.nodes[:, ends[:, 0]]] - mesh.nodes[block.nodes[:, ends[:, 1]]]
        long = np.linalg.norm(span, axis=2)
        long = long[long > 0.0]
        if len(long):
            limit = min(limit, 0.1 * float(long.min()))
    return limit


def duplicates(mesh: Grid, tolerance: float) -> Ints:
    """Return pairs (m, 2) of coincident nodes of solids, sorted, lower index first."""
    from scipy.spatial import cKDTree  # slow to import and rarely needed

    nodes: Array = mesh.nodes[mesh.used]
    if not len(nodes):
        return np.zeros((0, 2), dtype=np.int64)
    pairs = cKDTree(nodes).query_pairs(tolerance, output_type="ndarray")
    found = np.sort(mesh.used[pairs.reshape(-1, 2)], axis=1)
    return found[np.lexsort((found[:, 1], found[:, 0]))]


def _list(ids: Ints) -> str:
    return some([str(int(i)) for i in ids], 5)
