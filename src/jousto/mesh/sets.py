"""Checks of the topology of a part: elements, node sets, connectivity."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array, Ints, frozen, some
from jousto.base.errors import Problems, suggest

NODE_NAMES_UP_TO = 10_000


def read_integers(value: Any) -> Ints | None:
    """Return an integer array, or None if the values are not whole numbers."""
    try:
        array = np.array(value)
        if array.size and array.dtype.kind not in "iu":
            rounded = array.astype(np.float64)
            if not np.array_equal(rounded, np.round(rounded)):
                return None
        return array.astype(np.int64)
    except (TypeError, ValueError):
        return None


def read_elements(
    problems: Problems, where: str, value: Any, nn: int, columns: int | None
) -> Ints | None:
    """Return the elements as a read-only (ne, m) array, or report what is wrong."""
    array = read_integers(value)
    if array is None:
        problems.add(where, "elements must be an array of whole numbers, node indices from 0")
        return None
    if array.ndim != 2 or len(array) == 0 or (columns is not None and array.shape[1] != columns):
        wanted = "any" if columns is None else str(columns)
        problems.add(where, f"elements has shape {array.shape}, must be (1 or more, {wanted})")
        return None
    bad = np.argwhere((array < 0) | (array >= nn))
    if len(bad):
        i, j = (int(x) for x in bad[0])
        problems.add(
            where, f"elements[{i}, {j}] is node {array[i, j]}, must be an index in 0..{nn - 1}"
        )
        return None
    return frozen(array)


def read_sets(
    problems: Problems, where: str, given: Mapping[str, Any], nn: int
) -> dict[str, tuple[int, ...]]:
    """Return the node sets; parts of up to 10000 nodes get ``node1`` .. ``nodeN``."""
    sets: dict[str, tuple[int, ...]] = {}
    if nn <= NODE_NAMES_UP_TO:
        sets = {f"node{i + 1}": (i,) for i in range(nn)}
    for name, value in given.items():
        label = f"node set '{name}'"
        array = read_integers(value)
        if array is None or array.ndim > 1:
            problems.add(where, f"{label} is {value!r}, must be node indices")
            continue
        members = tuple(int(i) for i in np.atleast_1d(array))
        bad = [i for i in members if not 0 <= i < nn]
        if not name or not isinstance(name, str):
            problems.add(where, f"{label} has no usable name")
        elif not members:
            problems.add(where, f"{label} is empty")
        elif bad:
            problems.add(where, f"{label} contains node {bad[0]}, must be an index in 0..{nn - 1}")
        elif len(set(members)) < len(members):
            problems.add(where, f"{label} contains a node twice")
        elif name in sets and sets[name] != members:
            problems.add(where, f"{label}: this name is reserved for the node of that number")
        else:
            sets[name] = members
    return sets


def node_index(name: int | str, sets: Mapping[str, tuple[int, ...]]) -> int:
    """Return the node of a one-node set, or the index itself; raises KeyError with a sentence."""
    if not isinstance(name, str):
        return int(name)
    if name not in sets:
        raise KeyError(f"no node set '{name}'{suggest(name, sets)}")
    if len(sets[name]) != 1:
        raise KeyError(f"node set '{name}' has {len(sets[name])} nodes, one is needed")
    return sets[name][0]


def unattached(problems: Problems, where: str, elements: Ints, nn: int) -> None:
    """Report nodes that belong to no element."""
    loose = np.setdiff1d(np.arange(nn), elements)
    if len(loose):
        names = some([f"node{i + 1}" for i in loose])
        problems.add(where, f"{names}: not attached to any element; remove or connect them")


def node_graph(matrix: Any, dofs: int) -> Any:
    """Return the graph (nn, nn), sparse, of nodes that a matrix couples."""
    coo = matrix.tocoo()
    nn = matrix.shape[0] // dofs
    return sp.coo_array((np.ones(len(coo.row)), (coo.row // dofs, coo.col // dofs)), shape=(nn, nn))


def rigid_groups(ties: Iterable[Any]) -> list[Ints]:
    """Return the nodes of each rigid tie, which move as one body; nodes of averages do not."""
    return [tie.nodes for tie in ties if tie.kind == "rigid"]


def tied(graph: Any, groups: Iterable[Ints]) -> Any:
    """Return a graph of nodes (nn, nn), sparse, with the nodes of each group connected."""
    nodes = [np.asarray(group) for group in groups]
    if not nodes:
        return graph
    i = np.concatenate([np.full(len(group), group[0]) for group in nodes])
    j = np.concatenate(nodes)
    return sp.coo_array(graph) + sp.coo_array((np.ones(len(i)), (i, j)), shape=graph.shape)


def connectivity(problems: Problems, where: str, xyz: Array, elements: Ints) -> None:
    """Report a part of disconnected pieces, with the nearest nodes of two pieces."""
    nn = len(xyz)
    i = np.repeat(elements[:, 0], elements.shape[1] - 1)
    graph = sp.coo_array((np.ones(len(i)), (i, elements[:, 1:].ravel())), shape=(nn, nn))
    pieces(problems, where, xyz, graph)


def pieces(problems: Problems, where: str, xyz: Array, graph: Any) -> None:
    """Report a graph of nodes (nn, nn), sparse, that is disconnected."""
    from scipy.sparse.csgraph import connected_components  # slow to import and rarely needed

    count, label = connected_components(graph, directed=False)
    if count == 1:
        return
    one = label == label[0]
    inside, outside = np.flatnonzero(one), np.flatnonzero(~one)
    from scipy.spatial import cKDTree  # slow to import and rarely needed

    distance, nearest = cKDTree(xyz[inside]).query(xyz[outside])
    distance, nearest = np.atleast_1d(distance), np.atleast_1d(nearest)
    k = int(np.argmin(distance))
    problems.add(
        where,
        f"has {count} pieces that are not connected; the nearest nodes of two pieces are"
        f" node{inside[nearest[k]] + 1} and node{outside[k] + 1}, {distance[k]:.3g} m apart."
        " Join them, or make each piece a part",
    )
