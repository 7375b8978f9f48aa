"""Nodes of the stress sites of a reduced part."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from jousto.reduction.fields.stress import StressModes
    from jousto.reduction.reduced import ReducedPart


_KNOWN: WeakKeyDictionary[ReducedPart, StressModes] = WeakKeyDictionary()


def located(reduced: ReducedPart) -> StressModes | None:
    """Return the stress modes of a part with the node and the node sets of every site."""
    stress = reduced.stress
    if stress is None or stress.nodes is not None:
        return stress
    if reduced not in _KNOWN:  # studies compile the same part many times
        _KNOWN[reduced] = _located(reduced, stress)
    return _KNOWN[reduced]


def _located(reduced: ReducedPart, stress: StressModes) -> StressModes:
    nodes = _nodes(reduced, stress)
    at: dict[int, list[int]] = {}
    for place, node in enumerate(nodes.tolist()):
        if node >= 0:
            at.setdefault(node, []).append(place)
    sets = {
        key: np.array([i for node in members for i in at.get(node, ())], dtype=np.int64)
        for key, members in reduced.node_sets.items()
    }
    sets = {key: members for key, members in sets.items() if len(members)}
    return replace(stress, nodes=nodes, sets=sets)


def _nodes(reduced: ReducedPart, stress: StressModes) -> NDArray[np.int64]:
    """Return the node of every site; -1 if the site has none."""
    if reduced.elements.ndim == 2 and reduced.elements.shape[1] == 2:
        # section points surround the nodes at the ends of beam elements
        found = np.full(len(stress.labels), -1, dtype=np.int64)
        for i, label in enumerate(stress.labels):
            match = re.fullmatch(r"e(\d+)\.([ab])\..*", label)
            if match and int(match[1]) <= len(reduced.elements):
                found[i] = reduced.elements[int(match[1]) - 1, "ab".index(match[2])]
        return found
    places = {tuple(x): k for k, x in enumerate(reduced.nodes.tolist())}
    return np.array([places.get(tuple(x), -1) for x in stress.positions.tolist()], dtype=np.int64)
