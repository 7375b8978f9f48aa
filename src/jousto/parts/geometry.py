"""Geometry of a part: nodes, named sets and outer faces, for loads and interfaces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from jousto.base.arrays import Array, Ints


@dataclass(frozen=True, eq=False, kw_only=True)
class Geometry:
    """Geometry of a `Part`, without its matrices; see there."""

    name: str
    nodes: Array
    dofs_per_node: int
    node_sets: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    faces: Sequence[Ints] = ()
    surfaces: Mapping[str, Sequence[Ints]] = field(default_factory=dict)
