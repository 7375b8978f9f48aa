"""Robots and elastic joints in model files: construction, and the names that they add."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.errors import Problem, UnknownNameError
from jousto.mechanism.assembly import Assembly
from jousto.mechanism.bodies.body import FlexibleBody, RigidBody, ground
from jousto.mechanism.bodies.marker import Marker, marker_axes
from jousto.mechanism.forces.base import ForceElement
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.sensors.base import Sensor
from jousto.schema.make.builder import Section
from jousto.schema.make.declared import Place
from jousto.schema.make.quantities import build_amount

PREFIX_ENDS = {"robots": "_", "elastic_joints": " "}
"""Sections of assemblies, and the ends of the prefixes that their names make."""
JOINED = ("bodies", "joints", "forces", "sensors")
"""Sections to which assemblies add items."""


class Joined(Mapping[str, Any]):
    """Objects of a section and of assemblies by name; names of their items have a prefix.

    Parameters
    ----------
    own : Section
    groups : sequence of Section
        Robots and other assemblies.
    key : str
        The section, one of `JOINED`.
    """

    def __init__(self, own: Section, groups: Sequence[Section], key: str) -> None:
        self.own, self.groups, self.key = own, groups, key

    def brought(self, group: Assembly) -> Mapping[str, Any]:
        """Return the items of an assembly, by their names in the machine."""
        kinds: dict[str, Any] = {
            "sensors": Sensor,
            "forces": ForceElement,
            "bodies": RigidBody,
            "joints": Joint,
        }
        return {x.name: x for x in group.items if isinstance(x, kinds[self.key])}

    def likely(self, name: str) -> Iterator[Any]:
        """Yield the assemblies whose prefix this name begins with, longest prefix first."""
        for section, i, prefix in sorted(self._prefixes(), key=lambda x: -len(x[2])):
            if name.startswith(prefix) and i not in section.open:
                group = section.object(i)
                if group is not None:
                    yield group

    def lost(self, name: str) -> bool:
        """Return whether a name may belong to an item of an assembly that could not be built."""
        return any(self._lost(section, name) for section in self.groups)

    def _lost(self, section: Section, name: str) -> bool:
        given = section.builder.document.data.get(section.key)
        entries = given if isinstance(given, list) else []
        places = {loc: i for i, (_, loc, _) in enumerate(section.entries)}
        for k, entry in enumerate(entries):
            i = places.get((section.key, k), -1)
            if i < 0 or (i in section.made and section.made[i] is None):
                if name.startswith(prefix_of(section, entry if isinstance(entry, dict) else {})):
                    return True
        return False

    def opened(self, name: str) -> bool:
        """Return whether a name may belong to an item of an assembly under construction."""
        return any(i in section.open and name.startswith(p) for section, i, p in self._prefixes())

    def names(self) -> list[str]:
        """Return the names of the section, and of the frames of robots that are already built."""
        made = [group for section in self.groups for group in section.made.values()]
        robots = [group for group in made if group is not None and group.register == "robots"]
        return [*self.own, *(f"{robot.prefix}{name}" for robot in robots for name in robot.frames)]

    def _prefixes(self) -> list[tuple[Section, int, str]]:
        return [
            (section, i, prefix_of(section, vars(entry)))
            for section in self.groups
            for i, (_, _, entry) in enumerate(section.entries)
        ]

    def __getitem__(self, name: str) -> Any:
        """Return the object of a name; raise KeyError if there is none or it is invalid."""
        if name in self.own.places:
            return self.own[name]
        for group in self.likely(name):
            found = self.brought(group)
            if name in found:
                return found[name]
        raise KeyError(name)

    def frame(self, name: str) -> Any:
        """Return a named frame of a robot; None if there is no such frame."""
        for robot in self.likely(name):
            own = name.removeprefix(robot.prefix)
            if robot.register == "robots" and own in robot.frames:
                return Held(name, robot[own])
        return None

    def __iter__(self) -> Iterator[str]:
        names = [*self.own]
        for section in self.groups:
            for i in range(len(section.entries)):
                group = None if i in section.open else section.object(i)
                names += [] if group is None else self.brought(group)
        yield from dict.fromkeys(names)

    def __len__(self) -> int:
        return len(list(iter(self)))

    @property
    def places(self) -> Mapping[str, Any]:
        """The names."""
        return dict.fromkeys([*self.own.places, *self])

    def entry(self, name: str) -> Any:
        """Return the entry of a name; for an item of an assembly, the entry of the assembly."""
        if name in self.own.places:
            return self.own.entry(name)
        group = next(group for group in self.likely(name) if name in self.brought(group))
        return next(x.entry(group.name) for x in self.groups if x.key == group.register)


class Held:
    """Named frame on a link of a robot; it returns markers as a body does."""

    def __init__(self, name: str, marker: Marker) -> None:
        self.name, self.marker = name, marker

    def __getitem__(self, point: str) -> Marker:
        """Return the marker of the frame."""
        if point != "origin":
            message = f"no point {point!r}; a frame has its origin alone"
            raise UnknownNameError(Problem(f"frame {self.name!r}", message))
        return self.marker

    def at(self, position: ArrayLike, axes: Any = None) -> Marker:
        """Return a marker at a position in the frame, m, with axes relative to it."""
        A = np.asarray(self.marker.axes)
        body: Any = self.marker.body
        r = self.marker.position_local + A @ np.asarray(position)
        made: Marker = body.at(r, A @ marker_axes(self.name, axes))
        return made


def prefix_of(section: Section, entry: Mapping[str, Any]) -> str:
    """Return the prefix of the names of an assembly, from its entry."""
    prefix, name = entry.get("prefix"), entry.get("name")
    if isinstance(prefix, str):
        return prefix
    return f"{name}{PREFIX_ENDS[section.key]}" if isinstance(name, str) else ""


# -- fields ---------------------------------------------------------------------------------


def robot(place: Place, name: str) -> Any:
    """Return the robot of a file, relative to the model file."""
    from jousto.robots.readers.files import read_robot

    return place.builder.make(place.loc, read_robot, place.builder.file(name))


def base(place: Place, name: str) -> Any:
    """Return the marker of a body, a frame or a point; None if it does not exist."""
    builder, bodies = place.builder, place.known["bodies"]
    if "." in name:
        return builder.marker(place.loc, name, bodies)
    if name == "ground":
        return ground["origin"]
    body = bodies.get(name) or builder.frame(name)
    if body is None and bodies.opened(name):
        builder.note(place.loc, f"{name!r} depends on this robot itself")
    elif body is None:
        builder.unknown(place.loc, "bodies", "body", name, [*bodies.names(), "ground"])
    elif isinstance(body, FlexibleBody):
        builder.note(place.loc, f"body {name!r} is flexible; name a point of it, {name}.POINT")
        return None
    return None if body is None else builder.make(place.loc, body.__getitem__, "origin")


def starts(place: Place, given: Mapping[str, Any]) -> Any:
    """Return the initial values of joints, rad or m; None if one is invalid."""
    from jousto.robots.build import SINGLE, by_joint, ends_of, wrong_joint, wrong_start

    made, stops = place.values["robot"], place.values.get("stops", True)
    if made is None:
        return None
    kinds = {joint.name: joint.kind for joint in made.joints}
    ends = ends_of(made, stops)
    found: dict[str, float] = {}
    for key, value in given.items():
        here, (name,) = place.at(key), by_joint({key: value})
        message, x = wrong_joint(made, name), None
        if not message:
            unit = "rad" if kinds[name] == SINGLE[0] else "m"
            x = build_amount(here.builder, here.loc, value, unit)
            message = "" if x is None else wrong_start(made, name, x, ends)
        if message:
            here.builder.note(here.loc, message)
        elif x is not None:
            found[name] = x
    return found if len(found) == len(given) else None


FORMS: dict[str, Callable[[Place, Any], Any]] = {
    "robot": robot,
    "base": base,
    "robot starts": starts,
}
"""How the fields of a robot become objects."""
