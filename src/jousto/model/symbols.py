"""Symbols of a mechanism: positions and directions of its joints, forces and sensors."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.complexstep import floats
from jousto.mechanism.beams.body import BeamBody
from jousto.mechanism.beams.discretisation import BeamNode
from jousto.mechanism.bodies.body import FlexibleBody, RigidBody
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.forces.base import ForceElement
from jousto.mechanism.forces.friction import Friction
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coordinate import Angle, Coordinate
from jousto.mechanism.joints.coupling import Coupler, Drive
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.base import Sensor
from jousto.mechanism.sensors.body import SiteSensor
from jousto.mechanism.sensors.bridge import Bridge
from jousto.mechanism.sensors.gauge import Attached
from jousto.mechanism.sensors.state import StateSensor
from jousto.mechanism.states.block import Block
from jousto.model.symbol_record import NO_TURN, CylinderShape, SymbolPoint, SymbolShape

MOST_SITES = 32  # maximum number of stress sites with a symbol


def symbols(mechanism: Mechanism, index: Mapping[int, int]) -> tuple[SymbolShape, ...]:
    """Return the symbols of a mechanism; `index` gives the index of every body by its id."""
    make = SymbolMaker(index)
    return (
        *map(make.joint, mechanism.joints),
        *map(make.coupling, mechanism.couplings),
        *map(make.force, mechanism.forces),
        *(make.block(block) for block in mechanism.blocks if block.symbol),
        *(
            make.cylinder(block, one, mechanism.sensors)
            for block in mechanism.blocks
            for one in block.cylinders
        ),
        *map(make.friction, mechanism.frictions),
        *(symbol for sensor in mechanism.sensors for symbol in make.sensor(sensor)),
        *(symbol for body in mechanism.bodies for symbol in make.named(body)),
        *make.shapes(mechanism.forces),
    )


class SymbolMaker:
    """Builder of symbols from declared items.

    Parameters
    ----------
    index : mapping of int to int
        Index of every moving body by its id.
    """

    def __init__(self, index: Mapping[int, int]) -> None:
        self._index = index

    # -- one symbol each --------------------------------------------------------------------

    def joint(self, joint: Joint) -> SymbolShape:
        """Return the symbol of a joint, with its kind and the z axis of its frame a."""
        a, b = joint.frames
        axis = np.array(floats(a.axes))[:, 2]
        points = (self.point(a), self.point(b))
        return SymbolShape(joint.name, joint.tag, "joint", points, axis, text=_text(joint))

    def coupling(self, coupling: Coupler) -> SymbolShape:
        """Return the symbol of a gear, rack, coupling or drive."""
        kind = "coupling" if coupling.optional else coupling.tag
        if isinstance(coupling, Drive):
            kind = "motor" if isinstance(coupling.coordinate, Angle) else "actuator"
        points, axis = self._along(coupling.coordinates)
        return SymbolShape(coupling.name, kind, "joint", points, axis, text=_text(coupling))

    def force(self, force: ForceElement) -> SymbolShape:
        """Return the symbol of a force element."""
        points, axis, fixed = self._pushed(force)
        return SymbolShape(force.name, force.symbol, "force", points, axis, fixed, _text(force))

    def block(self, block: Block) -> SymbolShape:
        """Return the symbol of a block that is seen, such as a rope."""
        points = tuple(
            self.point(at) if isinstance(at, Marker) else self.place(*at) for at in block.drawn_at
        )
        return SymbolShape(block.name, block.symbol, "force", points, text=_text(block))

    def cylinder(self, network: Block, one: Any, sensors: Sequence[Sensor]) -> SymbolShape:
        """Return the symbol of a hydraulic cylinder; sensors of its nodes colour its chambers."""
        read = {
            str(sensor.of): sensor.name for sensor in sensors if isinstance(sensor, StateSensor)
        }
        nodes = [f"{network.name}.{node}" for node in (one.piston, one.rod_side)]
        known = [read.get(node, "") for node in nodes]
        bore, rod, closed, stroke = (
            float(np.real(x)) for x in (one.bore, one.rod, one.closed, one.stroke)
        )
        outputs = {f"{network.name}.{output}" for output in network.outputs}  # not those of tanks
        missing = [node for node in nodes if node in outputs and node not in read]
        hint = f"; a StateSensor of {' and '.join(missing)} colours it" if missing else ""
        return SymbolShape(
            f"{network.name}.{one.name}",
            "hydraulic-cylinder",
            "force",
            (self.point(one.a), self.point(one.b)),
            text=f"cylinder '{one.name}' of {network.kind} '{network.name}'{hint}",
            cylinder=CylinderShape(bore, rod, closed, stroke, (known[0], known[1])),
        )

    def friction(self, friction: Friction) -> SymbolShape:
        """Return the symbol of friction, at its joint."""
        made = self.joint(friction.joint)
        text = f"friction '{friction.name}' of {friction.joint.name}"
        return SymbolShape(friction.name, "friction", "force", made.points, made.axis, text=text)

    def sensor(self, sensor: Sensor) -> Iterator[SymbolShape]:
        """Return the symbol of a sensor; None for energies and signals, which have no position."""
        points, axis = self._sensed(sensor)
        if points:
            text = f"{sensor.name}: {sensor.description}"
            # the tag of the sensor is also that of a force
            kind = "force-sensor" if sensor.tag == "force" else sensor.tag
            yield SymbolShape(
                sensor.name, kind, "sensor", points, axis, text=text, sensor=sensor.name
            )

    def named(self, body: RigidBody | FlexibleBody) -> Iterator[SymbolShape]:
        """Return the named points of a body; for a flexible body its interfaces."""
        if isinstance(body, BeamNode):
            return
        if isinstance(body, FlexibleBody):
            sets = body.reduced.node_sets
            names: Sequence[str] = [x for x in body.reduced.interfaces if len(sets[x]) == 1]
        else:
            names = list(body.markers)
        for name in names:
            label = f"{body.name}.{name}"
            yield SymbolShape(label, "marker", "marker", (self.point(body[name]),), text=label)

    def shapes(self, forces: Iterable[ForceElement]) -> Iterator[SymbolShape]:
        """Return the shapes that touch, each place of a shape once."""
        seen: set[Any] = set()
        for force in forces:
            for marker, shape in force.touching_shapes:
                place = marker.position_local.tobytes(), marker.axes.tobytes(), marker.site
                key = (id(marker.body), *place, repr(shape), shape.triangles.tobytes())
                if key in seen:
                    continue
                seen.add(key)
                text = f"{shape.tag} of {force.tag} '{force.name}' on {marker.label}"
                name = f"{marker.label} {shape.tag}"
                point = (self.point(marker),)
                yield SymbolShape(
                    name, shape.tag, "shape", point, text=text, triangles=shape.triangles
                )

    # -- where they are ---------------------------------------------------------------------

    def point(self, marker: Marker) -> SymbolPoint:
        """Return the symbol point of a marker."""
        modes = None
        if marker.followed is not None:
            modes = np.array(floats(marker.Phi))
        return SymbolPoint(
            self._index.get(id(marker.body), -1),
            floats(marker.position_local),
            floats(marker.axes),
            -1 if marker.node is None else marker.node,
            modes,
        )

    def place(self, body: Any, position: Array) -> SymbolPoint:
        """Return a symbol point of a body; in a flexible body it moves with the nearest section."""
        place = self._index.get(id(body), -1)
        if not isinstance(body, FlexibleBody):
            return SymbolPoint(place, np.array(floats(position)), NO_TURN)
        reduced = body.reduced
        nodes = np.array(floats(reduced.nodes))
        at = np.array(floats(position))
        node = int(np.argmin(np.linalg.norm(nodes - at, axis=1)))
        turn, arm = reduced.rotation(node), at - nodes[node]
        if turn is None or not arm.any():
            return SymbolPoint(place, at, NO_TURN, node)
        modes = np.array(floats(reduced.modes[node])) + np.cross(floats(turn), arm, axis=0)
        return SymbolPoint(place, at, NO_TURN, modes=modes)

    def origin(self, body: Any) -> SymbolPoint:
        """Return the symbol point in the middle of a body."""
        if isinstance(body, BeamBody):
            return self.point(body[f"node{len(body.bodies) // 2 + 1}"])
        if isinstance(body, FlexibleBody):
            return self.place(body, np.asarray(body.reduced.nodes).mean(axis=0))
        return self.place(body, body.center)

    def _along(
        self, coordinates: Sequence[Coordinate]
    ) -> tuple[tuple[SymbolPoint, ...], Array | None]:
        """Return the points and the direction for a force along coordinates."""
        markers = [marker for s in coordinates for marker in (s.a, s.b)]
        points = tuple(self.point(marker) for marker in markers)
        first = coordinates[0]
        if first.engine == "distance":
            return points, None
        return points, np.array(floats(first.a.axes))[:, first.column]

    def _pushed(self, force: ForceElement) -> tuple[tuple[SymbolPoint, ...], Array | None, bool]:
        """Return points and direction of a force, and whether it is fixed in the world."""
        points = tuple(
            self.point(at) if isinstance(at, Marker) else self.place(*at) for at in force.drawn_at
        )
        if force.direction is not None:
            axis, follows = force.direction
            return points, axis, not follows
        if points:
            return points, None, False
        if force.coordinates:
            return *self._along(force.coordinates), False
        push = force.pushes[0]
        if push.coordinate is not None:
            return *self._along([push.coordinate]), False
        return (self.origin(push.body),), None, False

    def _sensed(self, sensor: Sensor) -> tuple[tuple[SymbolPoint, ...], Array | None]:
        """Return points and direction of a sensor; no points without a position."""
        if isinstance(sensor, Bridge):
            points = [self.place(sensor.body, gauge.position) for gauge in sensor.gauges]
            return tuple(points), np.array(floats(sensor.gauges[0].axis))
        if isinstance(sensor, Attached):
            place: Any = sensor
            return (self.place(sensor.body, place.position),), np.array(floats(place.axis))
        if isinstance(sensor, SiteSensor):
            stress = sensor.body.reduced.stress
            assert stress is not None
            chosen = list(sensor.indices[:MOST_SITES])
            return tuple(self.place(sensor.body, x) for x in stress.positions[chosen]), None
        return self._read(sensor.reading.of, sensor)

    def _read(self, of: Any, sensor: Sensor) -> tuple[tuple[SymbolPoint, ...], Array | None]:
        if isinstance(of, Marker):
            return (self.point(of),), None
        if isinstance(of, Coordinate):
            return self._along([of])
        if isinstance(of, Joint):  # position on the body of marker b, on which the reaction acts
            return (self.point(of.frames[1]),), None
        if isinstance(of, Coupler):
            return self._along(of.coordinates)
        if isinstance(of, Friction):
            return (self.point(of.joint.frames[1]),), None
        if isinstance(of, ForceElement):
            points = self._pushed(of)[0]
            return points[-1:], None
        if isinstance(of, BeamBody):
            return (self.point(of[f"node{sensor.reading.at + 1}"]),), None
        if isinstance(of, RigidBody | FlexibleBody):
            return (self.origin(of),), None
        if isinstance(of, Sensor) and of is not sensor:
            return self._sensed(of)
        meters = sensor.meters
        return self._sensed(meters[0].sensor) if meters else ((), None)


def _text(thing: Any) -> str:
    """Return one line that describes an item: ``revolute 'hinge': ground.origin - rod.origin``."""
    given = vars(thing).values()
    facts = [x.label for x in given if isinstance(x, Marker)]
    facts = facts or [x.name for x in given if isinstance(x, Coordinate | BeamBody)]
    facts = facts or [x.name for x in given if isinstance(x, RigidBody | FlexibleBody)]
    return f"{thing.tag} '{thing.name}'" + (f": {' - '.join(facts)}" if facts else "")
