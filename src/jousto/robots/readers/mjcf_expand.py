"""Expansion of includes, replicas and names of attached models in MJCF files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError
from jousto.base.rotations import euler_parameters
from jousto.robots.readers.meshes import Folders
from jousto.robots.readers.xml import DEEPEST, MOST, Element, Reading, parse_file


def include_files(reading: Reading, root: Element, folders: Folders) -> Element:
    """Return a model with the contents of its included files.

    A file is searched in the folder of the model, then in that of the including file, and must be
    in the folder of the model. A file may be included once, as in MuJoCo.
    """
    return _Includes(reading, folders).within(root, folders.home, (), 0)


class _Includes:
    def __init__(self, reading: Reading, folders: Folders) -> None:
        self.reading, self.folders = reading, folders
        self.seen: dict[Path, Element] = {}
        self.count = 0

    def within(self, element: Element, here: Path, above: tuple[Path, ...], depth: int) -> Element:
        """Return an element with its includes replaced by the contents of the files."""
        children: list[Element] = []
        for child in element.children:
            self.count += 1
            if child.tag == "include":
                children += self.file(child, here, above, depth)
            else:
                children.append(self.within(child, here, above, depth + 1))
        return replace(element, children=children)

    def file(
        self, element: Element, here: Path, above: tuple[Path, ...], depth: int
    ) -> list[Element]:
        """Return the children of the root of an included file; add a problem if it is invalid."""
        name = element.given.get("file", "")
        path, why = self.folders.find(name)
        if path is None and here != self.folders.home:
            path, why = self.folders.allowed(here / name)
        if path is None:
            self.reading.add(element, f"the file {name!r} {why}")
            return []
        if path in above or path in self.seen:
            circle = "includes itself in a circle" if path in above else "is included already"
            self.reading.add(element, f"the file {name!r} {circle}; MuJoCo reads a file once")
            return []
        self.seen[path] = element
        if self.count > MOST or depth > DEEPEST:
            limits = f"more than {MOST} elements, or {DEEPEST} within each other"
            self.reading.add(element, f"the model has {limits}")
            return []
        try:
            root = parse_file(path)
        except InputError as error:
            self.reading.problems += error.problems
            return []
        return self.within(root, path.parent, (*above, path), depth).children


def replicate(
    reading: Reading, element: Element, euler: Callable[[Array], Array]
) -> tuple[Element, dict[str, list[str]]]:
    """Return an element with its replicas as frames, and the new names of each replicated name.

    Replica i of ``<replicate>`` is rotated by i times its angles, and displaced by the sum of the
    offsets, each in the axes of the previous replica.
    """
    maker = _Replicas(reading, euler)
    made = maker.within(element)
    return made, maker.names


class _Replicas:
    def __init__(self, reading: Reading, euler: Callable[[Array], Array]) -> None:
        self.reading, self.euler = reading, euler
        self.names: dict[str, list[str]] = {}
        self.count = 0

    def within(self, element: Element) -> Element:
        """Return an element with its replicas expanded."""
        children: list[Element] = []
        for child in element.children:
            if child.tag == "replicate":
                children += self.copies(child)
            else:
                children.append(self.within(child))
        return replace(element, children=children)

    def copies(self, element: Element) -> list[Element]:
        """Return the replicas as frames."""
        reading = self.reading
        inner = self.within(element)
        number = reading.number(element, "count")
        size = sum(1 for _ in everything(inner))
        if not (number >= 0 and number == int(number)):
            reading.add(
                element, f"count is {number:g}, must be a whole number that is not negative"
            )
            return []
        self.count += int(number) * size
        if self.count > MOST:
            reading.add(element, f"makes more than {MOST} elements")
            return []
        offset = reading.vector(element, "offset", (0.0, 0.0, 0.0))
        angles = reading.vector(element, "euler", (0.0, 0.0, 0.0))
        r, digits = np.zeros(3), len(str(int(number)))
        own = [x.given["name"] for x in everything(inner) if x is not inner and "name" in x.given]
        first = {final: name for name, finals in self.names.items() for final in finals}
        now: dict[str, list[str]] = {}
        made = []
        for i in range(int(number)):
            suffix = f"{element.given.get('sep', '')}{i:0{digits}d}"
            A = self.euler(i * angles)
            given = {"pos": numbers(r), "quat": numbers(euler_parameters(A))}
            if "childclass" in element.given:
                given["childclass"] = element.given["childclass"]
            children = [with_affixes(x, after=suffix) for x in inner.children]
            made.append(replace(element, tag="frame", given=given, children=children))
            for name in own:
                now.setdefault(first.get(name, name), []).append(f"{name}{suffix}")
            r = r + A @ offset
        self.names |= now
        return made


def numbers(values: Array) -> str:
    """Return numbers as a text with all digits."""
    return " ".join(repr(float(x)) for x in values)


def everything(element: Element) -> Iterator[Element]:
    """Yield an element and all its descendants."""
    waiting = [element]
    while waiting:
        element = waiting.pop()
        yield element
        waiting += reversed(element.children)


def with_affixes(element: Element, before: str = "", after: str = "") -> Element:
    """Return a copy of an element with a prefix and a suffix on all names."""
    given = dict(element.given)
    if "name" in given:
        given["name"] = f"{before}{given['name']}{after}"
    return replace(
        element,
        given=given,
        children=[with_affixes(child, before, after) for child in element.children],
    )


def find_named(
    element: Element, tag: str, name: str, inherited: str = "main"
) -> tuple[Element, str] | None:
    """Return the descendant of a tag and name, and its inherited class; None if there is none."""
    for child in element.children:
        if child.tag == tag and child.given.get("name") == name:
            return child, inherited
        inner: Any = child.given.get("childclass", inherited)
        if (found := find_named(child, tag, name, inner)) is not None:
            return found
    return None
