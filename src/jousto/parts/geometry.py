"""Geometry of a part for loads and interfaces: nodes, named sets and outer faces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from jousto.base.arrays import Array, Ints


@dataclass(frozen=True, eq=False, kw_only=True)
class Geometry:
    """Geometry of a `Part`, without its matrices; see `Part` for the attributes."""

    name: str
    nodes: Array
    dofs_per_node: int
    node_sets: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    faces: Sequence[Ints] = ()
    surfaces: Mapping[str, Sequence[Ints]] = field(default_factory=dict)
