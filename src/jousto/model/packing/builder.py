"""Builder: joints, forces, signals and coordinates as objects of the engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.complexstep import floats
from jousto.base.errors import InputError, Problem
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.event import Event
from jousto.mechanism.forces.base import ForceElement, Packed, Push
from jousto.mechanism.forces.contact import Contact
from jousto.mechanism.forces.friction import Friction
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coordinate import Coordinate, Line
from jousto.mechanism.joints.coupling import Coupler
from jousto.mechanism.joints.switched import SwitchedRow
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.signals.base import Law, Signal
from jousto.mechanism.states.expression import Expression
from jousto.model.model import (
    CoordinateModel,
    EventModel,
    ForceModel,
    FrictionModel,
    JointModel,
    LineModel,
    MarkerModel,
    SignalModel,
    SwitchedModel,
)
from jousto.model.native.header import packed
from jousto.model.packing.systems import systems_of

RIGID = 6
"""Number of rows of a joint that lets nothing move."""


HELD_POINTS = 32
"""Most points of a body that rows may hold (``JO_POINTS``)."""


class Builder:
    """Collection of engine objects; equal objects are stored once.

    Parameters
    ----------
    bodies : dict of int to int
        Index of every moving body by id.
    events : sequence of Event
        All events.
    """

    def __init__(self, bodies: dict[int, int], events: Sequence[Event] = ()) -> None:
        self._bodies = bodies
        self._events = {id(event): i for i, event in enumerate(events)}
        self._releases = {id(x): i for i, event in enumerate(events) for x in event.releases}
        self.markers: list[MarkerModel] = []
        self.coordinates: list[CoordinateModel] = []
        self.joints: list[JointModel] = []
        self.signals: list[SignalModel] = []
        self.forces: list[ForceModel] = []
        self._states = 0
        self._row = 0  # first row of the next joint
        self.frictions: list[FrictionModel] = []
        self.switched: list[SwitchedModel] = []
        self.events: list[EventModel] = []
        self.force_places: dict[int, int] = {}
        self._places: dict[Any, int] = {}
        self._registers: dict[int, tuple[int, int]] = {}
        self._held: dict[int, int] = {}  # points of each body that rows may hold

    def marker(self, marker: Marker, turns: bool, *, shared: bool = True) -> int:
        """Return the index of a frame; `turns`: its rotation is needed at every evaluation.

        Frames that are `shared` are searched first: joints at one node use one frame.
        """
        body = self._bodies.get(id(marker.body), -1)
        Phi = Psi = chi = None
        if isinstance(marker.body, FlexibleBody):
            Phi = np.array(floats(marker.Phi))
            Psi = np.array(floats(marker.Psi))
            if not np.any(Psi):
                Psi = None
            chi = marker.chi
        u0, A0 = np.array(floats(marker.position_local)), np.array(floats(marker.axes))
        key = ("marker", body, marker.site, u0.tobytes(), A0.tobytes())
        if shared and key in self._places:
            place = self._places[key]
            if turns:
                self.markers[place] = replace(self.markers[place], turns=True, Psi=Psi)
            return place
        made = MarkerModel(body, turns, u0, A0, Phi, Psi if turns else None, chi, site=marker)
        self.markers.append(made)
        if shared:
            self._places[key] = len(self.markers) - 1
        return len(self.markers) - 1

    def declared(self, coordinate: Coordinate) -> int:
        """Return the index of a coordinate."""
        a = self.marker(coordinate.a, coordinate.turns_a)
        b = self.marker(coordinate.b, coordinate.turns_b)
        radius, cone, head = (
            float(np.real(getattr(coordinate, x, 0.0))) for x in ("radius", "cone", "head")
        )
        key = ("coordinate", coordinate.engine, a, b, coordinate.column, radius, cone, head)
        if key not in self._places:
            self._places[key] = len(self.coordinates)
            made = CoordinateModel(
                *(coordinate.name, coordinate.engine, a, b, coordinate.column),
                radius=radius,
                cone=cone,
                head=head,
            )
            self.coordinates.append(made)
        return self._places[key]

    def line(self, line: Line) -> LineModel:
        """Return a row that is linear in coordinates."""
        return LineModel(
            coordinates=tuple(self.declared(s) for s in line.coordinates),
            factors=tuple(line.factors),
            offset=line.offset,
            signal=self.signal(line.signal),
        )

    def joint(self, joint: Joint, *, used: bool = False) -> int:
        """Return the index of a joint; `used` if another object needs one of its coordinates."""
        sides = tuple(
            self.marker(marker, turns)
            for marker, turns in zip(joint.frames, joint.turns, strict=True)
        )
        lines = tuple(self.line(line) for line in joint.lines)
        rows = sides, joint.coincident, joint.perpendicular, lines
        release = self._releases.get(id(joint), -1)
        return self._rows(joint.name, *rows, used=used, release=release)

    def coupling(self, coupling: Coupler) -> int:
        """Return the index of a gear, rack, coupling or drive: one row, two or four markers."""
        lines = tuple(self.line(line) for line in coupling.lines)
        used = [self.coordinates[s] for line in lines for s in line.coordinates]
        sides = tuple(marker for s in used for marker in (s.a, s.b))
        release = self._releases.get(id(coupling), -1)
        if not isinstance(coupling, SwitchedRow):
            return self._rows(coupling.name, sides, False, (), lines, release=release)
        lock = len(self.switched)
        joint = self._rows(coupling.name, sides, False, (), lines, lock=lock)
        ends = (getattr(coupling, "begins", None), getattr(coupling, "ends", None))
        begin, end = (-1 if x is None else self._events[id(x)] for x in ends)
        numbers = packed("jo_limits_data", **coupling.numbers)
        self.switched.append(SwitchedModel(coupling.name, joint, begin, end, numbers))
        return joint

    def friction(self, friction: Friction, joint: int) -> int:
        """Return the index of the friction of joint `joint`; call it after all other rows."""
        places = [self.declared(s) for s in friction.coordinates]
        law = friction.law
        lock = -1
        if law.sticks:  # rows that are active while the coordinates stick
            first = self.coordinates[places[0]]
            lines = tuple(LineModel((place,), (1.0,)) for place in places)
            count = sum(other.lock >= 0 for other in self.joints)
            lock = self._rows(friction.name, (first.a, first.b), False, (), lines, lock=count)
        self.frictions.append(
            FrictionModel(
                name=friction.name,
                joint=joint,
                coordinate=places[0],
                other=places[1] if len(places) > 1 else -1,
                sticks=lock >= 0,
                lock=lock,
                data=friction_numbers(friction),
            )
        )
        return len(self.frictions) - 1

    def sticking(self, contact: Contact) -> None:
        """Add the rows and the friction of each tip of a contact; call it after all frictions."""
        place = self.force_places[id(contact)]
        _, _, b, _ = contact.sides
        body = b.body if id(b.body) in self._bodies else contact.sides[0].body
        self._held[id(body)] = self._held.get(id(body), 0) + len(contact.slips)
        if self._held[id(body)] > HELD_POINTS:
            raise InputError(
                Problem(
                    f"contact '{contact.name}'",
                    f"is one of more than {HELD_POINTS} points of {body.name!r} with StickSlip(); "
                    "leave out friction of some for the bristle",
                )
            )
        for i, slips in enumerate(contact.slips):
            places = [self.declared(s) for s in slips]
            first = self.coordinates[places[0]]
            lines = tuple(LineModel((s,), (1.0,)) for s in places)
            count = sum(other.lock >= 0 for other in self.joints)
            name = f"{contact.name}.slip" + (f" {i + 1}" if i else "")
            lock = self._rows(name, (first.a, first.b), False, (), lines, lock=count)
            numbers = packed(
                "jo_friction_data",
                mu_kinetic=contact.mu_kinetic,
                mu_static=contact.mu_static,
                velocity=1.0,
                plane=1.0,
                mass=contact.mass_in_play,
            )
            self.frictions.append(
                FrictionModel(
                    *(name, lock, places[0], True, lock, numbers),
                    other=places[1],
                    contact=place + i,
                )
            )

    def _rows(
        self,
        name: str,
        sides: tuple[int, ...],
        coincident: bool,
        perpendicular: tuple[tuple[int, int], ...],
        lines: tuple[LineModel, ...],
        **more: Any,
    ) -> int:
        made = JointModel(name, sides, coincident, perpendicular, self._row, lines, **more)
        self._row += made.rows
        self.joints.append(made)
        return len(self.joints) - 1

    def joined_bodies(self) -> list[tuple[int, int, bool]]:
        """Return the bodies of each joint so far, and whether it lets them move."""
        ends = [(joint, joint.sides[:2]) for joint in self.joints if len(joint.sides) == 2]
        return [
            (self.markers[a].body, self.markers[b].body, joint.rows == RIGID)
            for joint, (a, b) in ends
        ]

    def signal(self, signal: Signal | None) -> int:
        """Return the index of a signal, -1 for None."""
        if signal is None:
            return -1
        key = ("signal", id(signal))
        if key not in self._places:
            self._places[key] = self._signal(signal)
        return self._places[key]

    def states(self, mechanism: Mechanism) -> None:
        """Add the systems of states of a mechanism, and the expressions that sensors measure."""
        measured = [sensor.reading.of for sensor in mechanism.sensors]
        watched = [one for one in measured if isinstance(one, Expression)]
        for system in systems_of(mechanism.blocks, watched):
            self.force(system)
            self._registers |= {k: (system.number, r) for k, r in system.registers.items()}

    def _signal(self, signal: Signal) -> int:
        """Append a signal after its terms, since the engine combines two terms at a time."""
        if isinstance(signal, Expression):
            return self._append(self._live(signal))
        law = signal.law
        count = law.count if law.event is None else self._events[id(law.event)]
        if signal.parts:
            place = self.signal(signal.parts[0])
            for part in signal.parts[1:]:
                children = (place, self.signal(part))
                place = self._append(SignalModel(law.kind, np.zeros(1), count, children=children))
            return place
        key = (law.kind, law.name)
        if law.name:
            if key in self._places:
                return self._places[key]
            count = sum(other.kind == law.kind for other in self.signals)
        place = self._append(
            SignalModel(law.kind, numbers_of(law), count, law.degree, name=law.name)
        )
        return self._places.setdefault(key, place) if law.name else place

    def _live(self, signal: Expression) -> SignalModel:
        """Return an expression that is measured; it is in no other place."""
        if id(signal) not in self._registers:
            raise InputError(
                Problem(
                    str(signal),
                    "depends on the motion; forces, drives and references take signals of time. "
                    "Give it to a block of states, whose forces act along coordinates",
                )
            )
        system, register = self._registers[id(signal)]
        return SignalModel("network", np.zeros(1), system, children=(register, -1))

    def delayed(self, force: int) -> int:
        """Return the index of a new signal, the output of a delay, which is the force `force`."""
        return self._append(SignalModel("delay", np.zeros(1), force))

    def place_of(self, signal: Signal) -> int:
        """Return the index of a signal that was added before."""
        return self._places["signal", id(signal)]

    def _append(self, signal: SignalModel) -> int:
        self.signals.append(signal)
        return len(self.signals) - 1

    def force(self, force: ForceElement) -> int:
        """Return the index of a force, or of its first law if it has several."""
        self.force_places[id(force)] = place = len(self.forces)
        release = self._releases.get(id(force), -1)
        for push in force.pushes:
            self.forces.append(self._push(force, push, release))
        return place

    def _push(self, force: ForceElement, push: Push, release: int) -> ForceModel:
        self._states += len(push.states)
        packed = Packed(numbers_of(push)) if push.numbers is None else push.numbers(self)
        if push.numbers is not None and push.data:
            packed = replace(packed, data=np.append(numbers_of(push), packed.data))
        return ForceModel(
            name=force.name,
            kind=push.kind,
            data=packed.data,
            touches=packed.touches,
            coupled=packed.coupled,
            dense=packed.dense,
            slots=packed.slots,
            shapes=packed.shapes,
            sizes=packed.sizes,
            surfaces=packed.surfaces,
            restitutions=packed.restitution,
            slowest_each=packed.slowest,
            pressure=push.pressure,
            thickness=push.thickness,
            restitution=push.restitution,
            slowest=push.slowest,
            coordinate=-1 if push.coordinate is None else self.declared(push.coordinate),
            other=-1 if push.other is None else self.declared(push.other),
            a=-1 if push.a is None else self.marker(push.a, True),
            b=-1 if push.b is None else self.marker(push.b, push.turns),
            body=-1 if push.body is None else self._bodies[id(push.body)],
            follow=push.follow,
            active=push.active,
            spring=self.signal(push.spring),
            damper=self.signal(push.damper),
            signal=self.signal(push.signal),
            reference=self.signal(push.reference),
            function=push.function,
            release=release,
            state=self._states - len(push.states) if push.states else -1,
            state_names=push.states,
            openings=push.openings,
            element=force.kind,
        )


def friction_numbers(friction: Friction) -> NDArray[np.float64]:
    """Return the numbers of a friction in the order of the engine header."""
    return packed(
        "jo_friction_data",
        mu_kinetic=friction.mu_kinetic,
        mu_static=friction.mu_static,
        velocity=getattr(friction.law, "velocity", 1.0),
        radius=friction.radius or 0.0,
        bearing=friction.bearing_length or 0.0,
        collar=friction.collar_radius or 0.0,
        preload=friction.preload,
        plane=float(isinstance(friction.joint, SwitchedRow)),
    )


def numbers_of(law: Law | Push) -> NDArray[np.float64]:
    """Return the numbers of a law in the order of the engine header."""
    if law.data:
        return packed(f"jo_{law.kind.replace(' ', '_')}_data", *law.rest, **law.data)
    return np.concatenate([np.ravel(x) for x in law.rest]) if law.rest else np.zeros(1)
