"""Nodes and damping ratios in the files of reduced parts for other programs."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from jousto.base.arrays import Array, Index
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.files import written
from jousto.reduction.reduced import ReducedPart

ALL_UP_TO = 500
"""Number of nodes up to which all nodes are written by default."""


def exposed_nodes(
    reduced: ReducedPart, nodes: Sequence[str | int] | None, where: str
) -> tuple[Index, list[str]]:
    """Return the indices and names of the nodes to write.

    Parameters
    ----------
    reduced : ReducedPart
    nodes : sequence of str or int, optional
        Node sets or node numbers from 0. By default all nodes; for parts with many nodes, those of
        interfaces and of named sets of a single node.
    where : str
        Name in messages.

    Raises
    ------
    InputError
        If there is no such node, or none is left.
    """
    numbered = re.compile(r"(node|n)\d+")
    own = {
        members[0]: name
        for name, members in reversed(list(reduced.node_sets.items()))
        if len(members) == 1 and not numbered.fullmatch(name)
    }
    problems = Problems()
    chosen: dict[int, None] = {}
    if nodes is None:
        if len(reduced.nodes) <= ALL_UP_TO:
            chosen = dict.fromkeys(range(len(reduced.nodes)))
        else:
            held = [i for name in reduced.interfaces for i in reduced.node_sets[name]]
            chosen = dict.fromkeys(sorted({*held, *own}))
            if not chosen or len(chosen) > 10 * ALL_UP_TO:
                problems.add(
                    where,
                    f"the part has {len(reduced.nodes)} nodes and {len(chosen)} of them are"
                    " interfaces or named; name the nodes to write with nodes=",
                )
    for item in nodes if nodes is not None else ():
        if isinstance(item, str) and item not in reduced.node_sets:
            problems.add(where, f"no node set '{item}'{suggest(item, reduced.node_sets)}")
        elif isinstance(item, str):
            chosen |= dict.fromkeys(reduced.node_sets[item])
        elif not 0 <= int(item) < len(reduced.nodes):
            problems.add(where, f"no node {item}, must be 0..{len(reduced.nodes) - 1}")
        else:
            chosen[int(item)] = None
    if not chosen and not problems.found:
        problems.add(where, "no node is selected for writing; name at least one")
    problems.raise_if_any()
    index = np.array(list(chosen), dtype=np.intp)
    return index, [own.get(int(i), f"node{i + 1}") for i in index]


def node_modes(reduced: ReducedPart, nodes: Index) -> tuple[Array, Array]:
    """Return translations and rotations (nn, 3, n) of nodes; rotation 0 for solid nodes."""
    turns = np.zeros((len(nodes), 3, reduced.n))
    for k, i in enumerate(nodes):
        own = reduced.rotation(int(i))
        if own is not None:
            turns[k] = own
    return reduced.modes[nodes], turns


def damping_ratios(reduced: ReducedPart, damping: float | Sequence[float], where: str) -> Array:
    """Return the damping ratio of each mode.

    Raises
    ------
    InputError
        If a ratio is negative, or their number is wrong.
    """
    try:
        ratios = np.broadcast_to(np.asarray(damping, dtype=np.float64), (reduced.n,))
    except (TypeError, ValueError):
        ratios = np.array([np.nan])
    if not np.all(np.isfinite(ratios)) or np.any(ratios < 0.0):
        message = f"damping is {damping!r}, must be one ratio or {reduced.n}, zero or positive"
        raise InputError(Problem(where, message))
    return np.array(ratios)


def write_text(path: Path, text: str) -> None:
    """Write a text file.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    with written(path) as beside:
        beside.write_text(text, encoding="ascii", errors="replace")
