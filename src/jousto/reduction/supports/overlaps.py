"""Directions of nodes that several supports hold."""

from __future__ import annotations

from collections.abc import Sequence

from jousto.base.arrays import Index
from jousto.base.errors import Problems
from jousto.reduction.supports.support import DIRECTIONS, Clamp, Support
from jousto.reduction.supports.system import SupportedNode, System

SHOWN = 3  # nodes that a message names


def held_directions(support: Support, node: SupportedNode) -> list[int]:
    """Return the directions 0..5 in which a clamp holds a node."""
    words = getattr(support, "directions", ())
    if not words:
        return [k for k in range(6) if node.places[k] >= 0]
    return [DIRECTIONS.index(word) for word in words]


def check_overlaps(problems: Problems, system: System, supports: Sequence[Support]) -> None:
    """Report supports that are listed twice, and directions of nodes that two clamps hold.

    Each of two clamps would list the full reaction. Springs on a node act in parallel.
    """
    # the position of each object, the first clamp of each coordinate, and the directions that pairs
    # of clamps share
    listed: dict[int, int] = {}
    first: dict[int, int] = {}
    shared: dict[tuple[int, int], dict[str, list[int]]] = {}
    for j, (support, nodes) in enumerate(zip(supports, system.nodes, strict=True)):
        i = listed.setdefault(id(support), j)
        if i < j:
            problems.add(
                system.where,
                f"supports {i + 1} and {j + 1} are the same {_name(support)}; leave one out",
            )
        elif isinstance(support, Clamp):
            for node in nodes:
                _add_shared(shared, first, j, node, held_directions(support, node))
    for (i, j), held in shared.items():
        names = [_name(supports[k]) for k in (i, j)]
        both = f"support {i + 1} ({names[0]}) and support {j + 1} ({names[1]})"
        if names[0] == names[1]:
            both = f"supports {i + 1} and {j + 1}, each {names[0]},"
        # nodes whose directions are held in the same way, in one sentence
        alike: dict[tuple[int, ...], list[str]] = {}
        for name, directions in held.items():
            alike.setdefault(tuple(directions), []).append(name)
        where = " and ".join(
            f"{_listed(some)} in {' '.join(DIRECTIONS[k] for k in directions)}"
            for directions, some in alike.items()
        )
        problems.add(
            system.where,
            f"{both} both hold {where}; give each direction of a node to one support",
        )


def _add_shared(
    shared: dict[tuple[int, int], dict[str, list[int]]],
    first: dict[int, int],
    j: int,
    node: SupportedNode,
    directions: list[int],
) -> None:
    """Add directions of a node of clamp j that an earlier clamp holds."""
    places: Index = node.places
    for k in directions:
        if places[k] >= 0:
            i = first.setdefault(int(places[k]), j)
            if i != j:
                shared.setdefault((i, j), {}).setdefault(node.name, []).append(k)


def _name(support: Support) -> str:
    return f"{type(support).__name__} on {support.label}"


def _listed(names: list[str]) -> str:
    """Return the first names and the number of the others as text."""
    more = len(names) - SHOWN
    if more > 0:
        return f"{', '.join(names[:SHOWN])} and {more} more node{'s' * (more > 1)}"
    return ", ".join(names)
