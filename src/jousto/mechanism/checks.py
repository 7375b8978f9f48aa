"""Checks of a whole mechanism: all errors together, and warnings."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from jousto.base.errors import Problems, suggest, warn
from jousto.mechanism.beams.body import BeamBody
from jousto.mechanism.beams.discretisation import BeamNode
from jousto.mechanism.bodies.body import FlexibleBody, Ground, RigidBody
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.event import Event
from jousto.mechanism.forces.base import ForceElement
from jousto.mechanism.forces.friction import Friction
from jousto.mechanism.forces.loads import Gravity, PointLoad
from jousto.mechanism.foreign.fmu import Fmu, FmuSensor
from jousto.mechanism.initial import Initial
from jousto.mechanism.items_by_kind import Members
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coordinate import Coordinate, Distance
from jousto.mechanism.joints.coupling import Coupler, Drive
from jousto.mechanism.joints.switched import Lock
from jousto.mechanism.sensors.base import Sensor
from jousto.mechanism.signals.base import Input, Signal, leaves
from jousto.mechanism.signals.switched import Switched
from jousto.mechanism.states.block import Block

# largest gap at a joint that projection may close, relative to the size of the mechanism
GAP_TOLERANCE = 1e-6

# types of the arguments of Mechanism
ITEMS = (
    *(RigidBody, FlexibleBody, BeamBody, Joint, Coupler, Gravity, Friction, Event, Initial),
    *(ForceElement, Sensor, Fmu, Block),
)


def kind_of(item: Any) -> str:
    """Return the kind of an item for messages."""
    if isinstance(item, BeamBody):
        return "beam"
    if isinstance(item, RigidBody | FlexibleBody):
        return "body"
    if isinstance(item, Sensor):  # messages name the bridge instead of its gauges
        return "sensor"
    return getattr(item, "kind", "")


def where(item: Any) -> str:
    """Return the name of an item for messages, such as ``joint 'pivot'``."""
    return f"{kind_of(item)} {item.name!r}"


def check_items(problems: Problems, items: tuple[Any, ...]) -> None:
    """Report arguments that are not items of a mechanism, are repeated, or are too many."""
    seen: set[int] = set()
    for i, item in enumerate(items):
        place = f"item {i + 1}"
        if isinstance(item, ITEMS):
            if id(item) in seen:
                name = "gravity" if isinstance(item, Gravity) else where(item)
                problems.add(name, "given twice, leave one out")
            seen.add(id(item))
        elif isinstance(item, Ground):
            problems.add(place, "the ground always exists, leave it out")
        elif isinstance(item, list | tuple):
            problems.add(place, f"is a {type(item).__name__}; write Mechanism(*items)")
        elif isinstance(item, Marker):
            problems.add(
                place, f"is the marker {item.label}; give the body {item.body.name!r} instead"
            )
        elif hasattr(item, "invariants"):
            problems.add(place, "is a ReducedPart; make a body of it, FlexibleBody(name, reduced)")
        else:
            problems.add(
                place, f"is a {type(item).__name__}; must be a body, joint, force or sensor"
            )
    different = {id(x) for x in items if isinstance(x, Gravity)}
    if len(different) > 1:
        problems.add("gravity", f"{len(different)} Gravity items, only one is allowed")
    if not any(isinstance(x, RigidBody | FlexibleBody | BeamBody) for x in items):
        problems.add("mechanism", "has no bodies")


def check_assemblies(problems: Problems, mechanism: Members) -> None:
    """Report robots with the same prefix of names."""
    first: dict[str, Any] = {}
    for one in mechanism.assemblies:
        other = first.setdefault(one.prefix, one)
        if other is not one:
            problems.add(
                where(one),
                f"the names of its bodies and joints begin with {one.prefix!r}, as those of "
                f"{where(other)}; give it another prefix",
            )


def check_names(problems: Problems, mechanism: Members) -> None:
    """Report names that several items of a kind share."""
    groups: dict[str, tuple[Any, ...]] = {
        "bodies": whole_bodies(mechanism),
        "joints and couplings": (*mechanism.joints, *mechanism.couplings),
        "forces": (*mechanism.forces, *mechanism.frictions),
        "events": mechanism.events,
        "fmus": mechanism.fmus,
        "blocks": mechanism.blocks,
        "sensors": mechanism.sensors,
    }
    for group, items in groups.items():
        named: dict[str, list[Any]] = {}
        for item in items:
            named.setdefault(item.name, []).append(item)
        reported: set[str] = set()
        for item in items:
            if item is not named[item.name][0] and item.name not in reported:
                reported.add(item.name)
                count = len({id(x) for x in named[item.name]})
                kinds = {kind_of(x) for x in named[item.name]}
                plural = "joints" if kinds == {"joint"} else group
                problems.add(
                    where(item), f"{count} {plural} have this name, names must differ", "name"
                )


def whole_bodies(mechanism: Members) -> tuple[Any, ...]:
    """Return the bodies of a mechanism, each beam as one body in place of its nodes."""
    return tuple(x for x in mechanism.items if isinstance(x, RigidBody | FlexibleBody | BeamBody))


def coordinates_of(item: Any) -> tuple[Coordinate, ...]:
    """Return the coordinates that an item uses."""
    found = getattr(item, "coordinates", None) or (getattr(item, "coordinate", None),)
    return tuple(s for s in found if isinstance(s, Coordinate))


def markers_of(item: Any) -> Iterator[tuple[str, Marker]]:
    """Yield the markers that an item uses, each with the name of its argument."""
    for key, value in vars(item).items():
        if isinstance(value, Marker):
            yield key, value
    for one in getattr(item, "shapes", ()):
        yield one.name, one.marker
    for s in () if isinstance(item, Joint) else coordinates_of(item):
        yield s.name, s.a
        yield s.name, s.b


def check_members(problems: Problems, mechanism: Members) -> None:
    """Report items that refer to bodies or joints outside of the mechanism."""
    bodies = {body.name: body for body in whole_bodies(mechanism)}
    ids = {id(body) for body in (*mechanism.bodies, *mechanism.beams)}

    def missing(item: Any, argument: str, body: Any) -> None:
        if isinstance(body, Ground) or id(body) in ids:
            return
        kind, name = ("body", body.name)
        if isinstance(body, BeamBody | BeamNode):
            kind, name = "beam", getattr(body, "beam", body.name)
        if name in bodies:
            text = "is not the body of that name in the mechanism; use that one"
        else:
            text = f"is not in the mechanism{suggest(name, bodies)}"
        problems.add(where(item), f"{kind} {name!r} {text}", argument, named=False)

    items: tuple[Any, ...] = (
        *(*mechanism.joints, *mechanism.couplings, *mechanism.forces),
        *(*mechanism.blocks, *mechanism.sensors),
    )
    for event in mechanism.events:
        if isinstance(event.watch, Coordinate):
            missing(event, event.watch.name, event.watch.a.body)
            missing(event, event.watch.name, event.watch.b.body)
    members: tuple[tuple[Any, Known], ...] = (
        ((Joint, Coupler), Known(*mechanism.joints, *mechanism.couplings)),
        ((ForceElement, Friction), Known(*mechanism.forces, *mechanism.frictions)),
        (Sensor, Known(*mechanism.sensors)),
    )
    for item in (*items, *mechanism.frictions, *mechanism.initials):
        for argument, marker in markers_of(item):
            missing(item, argument, marker.body)
        for argument in ("body", "beam"):
            if (body := getattr(item, argument, None)) is not None:
                missing(item, argument, body)
        for used in vars(item).values() if isinstance(item, Sensor | Friction) else ():
            for kinds, known in members:
                if isinstance(used, kinds):
                    check_member(problems, item, used, known)


class Known:
    """Items of a mechanism, for search by identity and by name.

    Attributes
    ----------
    names : dict of str to None
        Names in the order of the items.
    """

    def __init__(self, *items: Any) -> None:
        self._ids = {id(item) for item in items}
        self.names = dict.fromkeys(item.name for item in items)

    def __contains__(self, item: Any) -> bool:
        return id(item) in self._ids


def check_member(problems: Problems, item: Any, used: Any, known: Known) -> None:
    """Report an item that refers to something outside of the mechanism."""
    if used in known:
        return
    if used.name in known.names:
        text = f"is another {kind_of(used)} of that name than the one in the mechanism"
    else:
        text = f"is not in the mechanism{suggest(used.name, known.names)}"
    problems.add(where(item), f"{kind_of(used)} {used.name!r} {text}")


def signals_of(item: Any) -> Iterator[Signal]:
    """Yield the signals that an item uses, and the terms of these signals."""
    values = (*vars(item).values(), getattr(item, "signal", None))  # a gauge's signal is a property
    values += getattr(item, "signals", ())
    for value in {id(value): value for value in values}.values():
        if isinstance(value, Signal):
            yield from leaves(value)


def check_releases(problems: Problems, mechanism: Members) -> None:
    """Report released items that are unknown, released twice, or have friction."""
    there = {id(x) for x in (*mechanism.joints, *mechanism.couplings, *mechanism.forces)}
    rubbing = {id(friction.joint): friction.name for friction in mechanism.frictions}
    first: dict[int, str] = {}
    for event in mechanism.events:
        for item in event.releases:
            what = f"releases {kind_of(item)} {item.name!r}, which"
            if id(item) not in there:
                problems.add(where(event), f"{what} is not in the mechanism; add it")
            if first.setdefault(id(item), event.name) != event.name:
                problems.add(where(event), f"{what} event {first[id(item)]!r} releases already")
            if getattr(item, "optional", False):
                problems.add(
                    where(event), f"{what} holds at times only; end a Lock by its own event, ends="
                )
            if id(item) in rubbing:
                problems.add(
                    where(event),
                    f"{what} has the friction {rubbing[id(item)]!r}; joints with friction cannot "
                    f"be released, leave the friction out",
                )


def check_events(problems: Problems, mechanism: Members) -> None:
    """Report watched sensors and switching events that are not in the mechanism."""
    sensors = Known(*mechanism.sensors)
    for event in mechanism.events:
        if isinstance(event.watch, Sensor) and event.watch not in sensors:
            if event.watch.name in sensors.names:
                text = "is not the sensor of that name in the mechanism; use that one"
            else:
                text = "is not in the mechanism; add it"
            problems.add(where(event), f"watches sensor {event.watch.name!r}, which {text}")
    check_releases(problems, mechanism)
    events = Known(*mechanism.events)
    items = (*mechanism.forces, *mechanism.couplings, *mechanism.sensors)
    uses = [
        (item, "its signal is switched by", signal.event)
        for item in items
        for signal in signals_of(item)
        if isinstance(signal, Switched)
    ]
    for lock in mechanism.couplings:
        if isinstance(lock, Lock):
            ends = (lock.begins,) if lock.ends is None else (lock.begins, lock.ends)
            uses += [(lock, "it follows", event) for event in ends]
    for item, how, event in uses:
        if event not in events:
            if event.name in events.names:
                text = "is not the event of that name in the mechanism; use that one"
            else:
                text = "is not in the mechanism; add it"
            problems.add(where(item), f"{how} event {event.name!r}, which {text}")


def check_fmus(problems: Problems, mechanism: Members) -> None:
    """Report sensors and inputs of FMUs that are not in the mechanism, and inputs set twice."""
    used = input_names(mechanism)
    setters: dict[str, str] = {}
    sensors = Known(*mechanism.sensors)
    for fmu in mechanism.fmus:
        for value in fmu.inputs.values():
            if isinstance(value, tuple):
                check_member(problems, fmu, value[0], sensors)
        for name in fmu.driven:
            if name not in used:
                problems.add(
                    where(fmu),
                    f"sets input {name!r}, which nothing in the mechanism uses"
                    f"{suggest(name, used)}",
                    "inputs",
                )
            if name in setters:
                problems.add(
                    where(fmu), f"sets input {name!r}, which {setters[name]} sets already", "inputs"
                )
            setters.setdefault(name, f"fmu {fmu.name!r}")


def input_names(mechanism: Members) -> set[str]:
    """Return the names of the external inputs."""
    return {
        signal.name
        for item in (*mechanism.forces, *mechanism.blocks, *mechanism.couplings, *mechanism.sensors)
        for signal in signals_of(item)
        if isinstance(signal, Input) and not isinstance(item, FmuSensor)
    }


def used_joints(mechanism: Members) -> set[int]:
    """Return the ids of the joints whose coordinates are used by other items.

    Such items are drives, couplings, springs, motors, controllers, sensors, events and friction;
    they need the coordinate.
    """
    items = (*mechanism.couplings, *mechanism.forces, *mechanism.sensors, *mechanism.frictions)
    users = (*items, *mechanism.blocks, *mechanism.initials)
    used = {id(s.joint) for item in users for s in coordinates_of(item)}
    used |= {id(e.watch.joint) for e in mechanism.events if isinstance(e.watch, Coordinate)}
    return used | {id(friction.joint) for friction in mechanism.frictions}


def check_joints(problems: Problems, mechanism: Members) -> None:
    """Report joints that connect a body with itself or are open at the initial pose."""
    tolerance = GAP_TOLERANCE * mechanism.size
    apart = mechanism.joint_ends[:, 1] - mechanism.joint_ends[:, 0]
    distances = np.linalg.norm(apart, axis=1).tolist()
    for joint, distance in zip(mechanism.joints, distances, strict=True):
        a, b = joint.a, joint.b
        if isinstance(a.body, Ground) and isinstance(b.body, Ground):
            problems.add(where(joint), f"both markers are on the ground, {a.label} and {b.label}")
        elif a.body is b.body:
            if np.array_equal(a.position_local, b.position_local) and a.site == b.site:
                problems.add(where(joint), f"connects {a.label} with itself")
            else:
                problems.add(
                    where(joint),
                    f"both markers are on body {a.body.name!r}, {a.label} and {b.label}; "
                    "a joint connects two bodies",
                )
        else:
            check_gap(problems, joint, distance, tolerance)


BEGINS = 1e-3
"""m or rad by which a drive of a robot may begin elsewhere."""


def check_starts(problems: Problems, mechanism: Members) -> None:
    """Report drives whose initial value differs from the joint of a robot at the initial pose.

    Closing this gap would move the whole machine, and the base of the robot with it.
    """
    carried = {id(item) for one in mechanism.assemblies for item in one.items}
    for drive in mechanism.couplings:
        if not isinstance(drive, Drive) or id(drive.coordinate.joint) not in carried:
            continue
        begins, stands, gap = drive.beginning
        if abs(gap) > BEGINS:
            problems.add(
                where(drive),
                f"begins at {begins:.6g} {drive.coordinate.unit}, but {drive.coordinate.name} "
                f"stands at {stands:.6g}; let the signal begin at that value, or move the joint "
                f"to the beginning of the signal",
            )


def drives_of(mechanism: Members) -> list[Drive]:
    """Return the drives among the couplings."""
    return [item for item in mechanism.couplings if isinstance(item, Drive)]


def check_drives(problems: Problems, mechanism: Members) -> None:
    """Report coordinates with more than one drive."""
    first: dict[Any, Drive] = {}
    for drive in drives_of(mechanism):
        other = first.setdefault(drive.coordinate.key, drive)
        if other is not drive:
            problems.add(
                where(drive),
                f"drives {drive.coordinate.name}, which drive {other.name!r} drives already; "
                "leave one out",
            )


def check_initials(problems: Problems, mechanism: Members) -> None:
    """Report initial values that are given twice, given by a drive, or belong to exact beams."""
    drives = {drive.coordinate.key: drive for drive in drives_of(mechanism)}
    first: dict[Any, Initial] = {}
    for initial in mechanism.initials:
        s = initial.coordinate
        if first.setdefault(s.key, initial) is not initial:
            problems.add(where(initial), "given twice, leave one out")
        if (drive := drives.get(s.key)) is not None:
            problems.add(
                where(initial),
                f"drive {drive.name!r} gives value and rate of {s.name}; leave this out, or "
                "the drive",
            )
        for block in mechanism.blocks:
            if block.starts_in_pose and initial.value is not None:
                problems.add(
                    where(initial),
                    f"{block.kind} {block.name!r} has the oil of the declared pose at the start; "
                    "place the bodies there instead, or take flow='volume'",
                )
        if mechanism.beams:
            problems.add(
                where(initial),
                "initial coordinates cannot move an exact beam as a whole; give pose, velocity "
                "and angular_velocity of the bodies instead",
            )


def check_distances(problems: Problems, mechanism: Members) -> None:
    """Report distances between coincident points, which have no direction."""
    users = (
        *(*mechanism.couplings, *mechanism.forces, *mechanism.blocks),
        *(*mechanism.sensors, *mechanism.initials),
    )
    size = mechanism.size
    for item in users:
        for s in coordinates_of(item):
            if isinstance(s, Distance) and s.initial <= 1e-12 * size:
                problems.add(
                    where(item),
                    f"{s.name}: {s.a.label} and {s.b.label} are at one point, so that their "
                    f"distance has no direction; move one of them, or use a Displacement",
                )


def check_frictions(problems: Problems, mechanism: Members) -> None:
    """Report joints with two friction elements, and driven joints whose friction cannot stick."""
    first: dict[int, Friction] = {}
    drives = {drive.coordinate.key: drive for drive in drives_of(mechanism)}
    for friction in mechanism.frictions:
        other = first.setdefault(id(friction.joint), friction)
        if other is not friction:
            problems.add(
                where(friction),
                f"joint {friction.joint.name!r} has the friction {other.name!r} already; "
                "leave one out",
                "joint",
            )
        moved = [drives.get(s.key) for s in friction.coordinates] if friction.law.sticks else []
        for drive in dict.fromkeys(filter(None, moved)):
            problems.add(
                where(friction),
                f"drive {drive.name!r} moves joint {friction.joint.name!r}, which therefore "
                "cannot stick; use law=Regularised()",
            )


def warn_jumps(mechanism: Members) -> None:
    """Warn about drives with discontinuous signals."""
    for item in mechanism.couplings:
        if isinstance(item, Drive) and item.signal.jumps:
            times = ", ".join(f"{t:g}" for t in item.signal.jumps[:4])
            warn(
                where(item),
                f"its signal jumps at t = {times} s, which no motion can follow; "
                "use SCurve or Ramp",
            )


def check_gap(problems: Problems, joint: Joint, distance: float, tolerance: float) -> None:
    """Report a joint that is open at the initial pose, unless `as_placed` is False.

    Parameters
    ----------
    distance : float
        Distance of its markers at the initial pose, m.
    tolerance : float
        Largest gap that counts as closed, m.
    """
    distances = [line for line in joint.lines if isinstance(line.coordinates[0], Distance)]
    if any(line.coordinates[0].initial <= tolerance for line in distances):
        problems.add(
            where(joint),
            f"has no length: {places(joint)}; a rod needs two points apart, Spherical joins them",
        )
    if not joint.as_placed:
        return
    if joint.coincident:
        gap = distance
        remedy = "move a body until the points meet"
    else:
        off = [line.initial - line.offset for line in joint.lines]
        gap = float(np.linalg.norm(off))
        remedy = {
            1: "move a body until the point is on the plane",
            2: "move a body until the point is on the axis",
        }.get(len(off), "move a body")
        if distances:
            remedy = "move a body, correct the length or leave it out"
    if gap > tolerance:
        if joint.coincident:
            hint = remedy
        else:
            hint = f"{remedy}, or let as_placed=False do it"
        problems.add(where(joint), f"initial gap of {1e3 * gap:.6g} mm: {places(joint)}; {hint}")


def places(joint: Joint) -> str:
    """Return the world positions of the markers of a joint, for messages."""
    a, b = joint.a, joint.b
    return f"{a.label} is at {world_point(a)}, {b.label} at {world_point(b)} m"


def world_point(marker: Marker) -> str:
    """Return the initial world position of a marker, for messages, ``(1, 0, 0)``."""
    return "(" + ", ".join(f"{x:.9g}" for x in marker.r + 0.0) + ")"


def turning(item: Any) -> Iterator[tuple[str, Marker]]:
    """Yield the markers whose orientation an item needs, each with the name of its argument."""
    if isinstance(item, Joint):
        yield from (
            (key, marker)
            for key, marker, turns in zip("ab", (item.a, item.b), item.turns, strict=True)
            if turns
        )
    elif isinstance(item, ForceElement | Sensor):
        yield from item.turning
    for s in () if isinstance(item, Joint) else coordinates_of(item):
        if s.turns_a:
            yield s.name, s.a
        if s.turns_b:
            yield s.name, s.b


def check_rotations(problems: Problems, mechanism: Members) -> None:
    """Report items that need the rotation of a node in a part that has translations only."""
    if not any(isinstance(body, FlexibleBody) for body in mechanism.bodies):
        return
    items = (*mechanism.joints, *mechanism.couplings, *mechanism.forces, *mechanism.sensors)
    for item in (*items, *mechanism.frictions, *mechanism.initials):
        for argument, marker in turning(item):
            body = marker.body
            if not isinstance(body, FlexibleBody) or marker.node is None:
                continue
            if body.reduced.rotation(marker.node) is None:
                reduced = body.reduced
                known = [] if reduced.rotation_nodes is None else list(reduced.rotation_nodes)
                turn = [k for k, v in reduced.node_sets.items() if len(v) == 1 and v[0] in known]
                remedy = (
                    f"; nodes with rotations are {', '.join(repr(name) for name in turn)}"
                    if turn
                    else "; connect a surface of the part to a node with rotations, "
                    "Interface(name, nodes)"
                )
                problems.add(
                    where(item),
                    f"{argument}: {marker.label} has no rotation mode shapes "
                    f"(three degrees of freedom per node), only translations can be used{remedy}",
                )


def warn_unconnected(mechanism: Members) -> None:
    """Warn about bodies that no joint connects."""
    elements = (x for x in mechanism.forces if x.ties)
    connections = (*mechanism.joints, *mechanism.couplings, *elements, *mechanism.blocks)
    joined = {id(marker.body) for item in connections for _, marker in markers_of(item)}
    joined |= {id(getattr(item, "body", None)) for item in connections}
    for body in whole_bodies(mechanism):
        parts = body.bodies if isinstance(body, BeamBody) else (body,)
        if not any(id(part) in joined for part in (body, *parts)):
            warn(where(body), "has no joint to another body, so it moves freely")


def warn_interfaces(mechanism: Members) -> None:
    """Warn about joints, drives and springs on nodes that are not interfaces of their part."""
    if not any(isinstance(body, FlexibleBody) for body in mechanism.bodies):
        return
    elements = (x for x in mechanism.forces if x.ties)
    for item in (*mechanism.joints, *mechanism.couplings, *elements):
        for marker in {id(m): m for _, m in markers_of(item)}.values():
            reduced = getattr(marker.body, "reduced", None)
            if reduced is None or marker.site is None or not reduced.interfaces:
                continue
            nodes = {n for name in reduced.interfaces for n in reduced.node_sets[name]}
            # a part with most of its modes represents loads at any node
            place = repr(marker.point) if marker.followed is None else "a node there"
            if marker.node not in nodes and reduced.n < 3 * len(reduced.nodes) - 6:
                warn(
                    where(item),
                    f"{marker.label} is not an interface of part {reduced.name!r} (the "
                    "interfaces are "
                    f"{', '.join(reduced.interfaces)}): its modes do not contain the deformation "
                    f"of the body under a force there; reduce it with {place} among the "
                    f"interfaces, or "
                    "with many more modes",
                )


def warn_ground_loads(mechanism: Members) -> None:
    """Warn about forces and torques on the ground."""
    for load in mechanism.forces:
        if isinstance(load, PointLoad) and isinstance(load.marker.body, Ground):
            warn(where(load), "acts on the ground, it has no effect")
