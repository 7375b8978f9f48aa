"""Sensors of the loads of one kind on a body: its generalised forces."""

from __future__ import annotations

from typing import ClassVar

from jousto.base.fields import Choice, field
from jousto.mechanism.bodies.body_field import FlexibleField, MovingBodyField
from jousto.mechanism.sensors.base import Reading, Sensor
from jousto.mechanism.sensors.loads import FORCE, MOMENT

LOADS = ("joint", "applied", "friction", "gravity", "inertia", "elastic", "damping")
"""Kinds of loads on a body, in the order of the engine; together they vanish."""


class BodyLoadSensor(Sensor, tag="body-load"):
    """Sum of all loads of one kind on a body: force and moment (6,), N and N m.

    Kinds: ``joint`` (reactions of joints, couplings and drives), ``applied`` (force elements),
    ``friction``, ``gravity``, ``inertia`` (d'Alembert, with centrifugal, gyroscopic and Coriolis
    forces), ``elastic`` (``-K p``) and ``damping`` (of modes, or of a rigid body in proportion to
    its momentum). The sum over all kinds vanishes (Altarriba 2010, eq. 96-98): ``Q_joint +
    Q_applied + Q_friction + Q_gravity + Q_inertia + Q_elastic + Q_damping = 0``.

    The moment is about the origin of the body frame; both are resolved in the body frame.
    `ModalLoadSensor` has the forces on the modes, `recovery.loads_of` every load by itself with its
    place.
    """

    unit: ClassVar[str] = "N, N m"
    frame: ClassVar[str] = "body"
    components: ClassVar[tuple[str, ...]] = (*FORCE, *MOMENT)
    body: MovingBodyField = field("Flexible or rigid body")
    load: Choice = field("Kind of the loads", words=LOADS)

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        return Reading("body load", self.body, LOADS.index(self.load))

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"{self.load} loads on {self.body.name}"


class ModalLoadSensor(Sensor, tag="modal-load"):
    """Sum of all loads of one kind on the modes of a flexible body, (n,) kg^0.5 m/s2.

    The generalised forces on its modal coordinates, of the kinds of a `BodyLoadSensor`; they vanish
    together as well.
    """

    unit: ClassVar[str] = "kg^0.5 m/s2"
    frame: ClassVar[str] = "body"
    flexible: ClassVar[bool] = True
    body: FlexibleField = field("The body")
    load: Choice = field("Kind of the loads", words=LOADS)

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the components, f1..fn."""
        return tuple(f"f{j + 1}" for j in range(self.body.n))

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        return Reading("modal load", self.body, LOADS.index(self.load))

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"{self.load} loads on the modes of {self.body.name}"
