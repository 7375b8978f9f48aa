"""No circle of imports: those for types and those inside functions count, too."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import jousto

SOURCE = Path(jousto.__file__).parents[1]


@cache
def imports() -> dict[str, set[str]]:
    """Return for each file of jousto the others that it imports, wherever the import stands."""
    names = {}
    for path in SOURCE.rglob("*.py"):
        parts = path.relative_to(SOURCE).with_suffix("").parts
        names[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    found: dict[str, set[str]] = {}
    for name, path in names.items():
        own = found.setdefault(name, set())
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                own |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                full = {f"{node.module}.{alias.name}" for alias in node.names}
                own |= {name if name in names else str(node.module) for name in full}
        own &= names.keys() - {name}
    return found


def circles(graph: dict[str, set[str]]) -> list[set[str]]:
    """Return the sets of files that reach each other, by what leads nowhere and comes of nowhere.

    >>> [sorted(group) for group in circles({"a": {"b"}, "b": {"c"}, "c": {"b"}})]
    [['b', 'c']]
    """
    left = dict(graph)
    while ends := [x for x in left if not (left[x] & left.keys())]:
        for x in ends:
            del left[x]
    found = []
    while left:
        first = next(iter(left))
        forward, backward = reached(left, first), reached(turned(left), first)
        found.append(forward & backward)
        left = {x: left[x] for x in left if x not in found[-1]}
    return [group for group in found if len(group) > 1]


def reached(graph: dict[str, set[str]], first: str) -> set[str]:
    """Return what can be reached in a graph."""
    seen, ahead = {first}, [first]
    while ahead:
        new = (graph.get(ahead.pop(), set()) & graph.keys()) - seen
        seen |= new
        ahead += new
    return seen


def turned(graph: dict[str, set[str]]) -> dict[str, set[str]]:
    """Return the graph with its arrows turned round."""
    out: dict[str, set[str]] = {x: set() for x in graph}
    for x, others in graph.items():
        for y in others & out.keys():
            out[y].add(x)
    return out


def between(graph: dict[str, set[str]], room: str) -> dict[str, set[str]]:
    """Return the imports between the files and rooms of a room."""
    start, inside = f"{room}.", {x for x in graph if x.startswith(f"{room}.")}
    first = {x: x.removeprefix(start).partition(".")[0] for x in inside}
    found: dict[str, set[str]] = {x: set() for x in first.values()}
    for x in inside:
        found[first[x]] |= {first[y] for y in graph[x] & inside} - {first[x]}
    return found


def test_a_circle_is_found():
    graph = {"a": {"b"}, "b": {"c"}, "c": {"d"}, "d": {"b"}, "e": {"a", "f"}, "f": {"e"}}
    assert sorted(map(sorted, circles(graph))) == [["b", "c", "d"], ["e", "f"]]


def test_there_are_no_circles():
    graph = imports()
    assert len(graph) > 400
    assert "jousto.base.errors" in graph["jousto.mesh.grid"]
    assert [sorted(group) for group in circles(graph)] == []


# the reducer, its methods, its modes and its files call one another
OPEN = {"jousto.reduction"}


def test_rooms_inside_a_room_make_no_circles():
    graph = imports()
    assert between(graph, "jousto")["model"] >= {"mechanism", "base"}
    rooms = {x.rpartition(".")[0] for x in graph if x.count(".") > 1}
    found = {room for room in rooms if circles(between(graph, room))}
    assert found == OPEN
