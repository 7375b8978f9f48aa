"""Sensor of the loads of one kind on a body: its generalised forces."""

from __future__ import annotations

from jousto.base.errors import Problems
from jousto.base.fields import Choice, Flag, field
from jousto.mechanism.bodies.body_field import MovingBodyField
from jousto.mechanism.sensors.base import Reading, Sensor
from jousto.mechanism.sensors.loads import FORCE, MOMENT

LOADS = ("joint", "applied", "friction", "gravity", "inertia", "elastic", "damping")
"""Kinds of loads on a body, in the order of the engine; together they vanish."""


class BodyLoadSensor(Sensor, tag="body-load"):
    """Sum of all loads of one kind on a body, its generalised forces (6,) or (n,).

    Kinds: ``joint`` (reactions of joints, couplings and drives), ``applied`` (force elements),
    ``friction``, ``gravity``, ``inertia`` (d'Alembert, with centrifugal, gyroscopic and Coriolis
    forces), ``elastic`` (``-K p``) and ``damping`` (of modes, or of a rigid body in proportion to
    its momentum). The sum over all kinds vanishes (Altarriba 2010, eq. 96-98): ``Q_joint +
    Q_applied + Q_friction + Q_gravity + Q_inertia + Q_elastic + Q_damping = 0``.

    The values are the force, N, and the moment about the origin of the body frame, N m, both
    resolved in the body frame; with ``modal`` the n generalised forces on the modes of a flexible
    body. `recovery.loads_of` has every load by itself, with its place.
    """

    body: MovingBodyField = field("Flexible or rigid body")
    load: Choice = field("Kind of the loads", words=LOADS)
    modal: Flag = field("Whether the values are the forces on the modes", default=False)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report forces on the modes of a body that has none."""
        if self.modal and not self._n:
            problems.add(
                where,
                f"{self.body.name!r} is rigid and has no modes; leave modal out for its force and "
                "moment",
                "modal",
                named=False,
            )

    @property
    def _n(self) -> int:
        return int(getattr(self.body, "n", 0))

    @property
    def unit(self) -> str:
        """Units of force and moment, or of the forces on the modes."""
        return "kg^0.5 m/s2" if self.modal else "N, N m"

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the components of force and moment, or f1..fn."""
        if not self.modal:
            return (*FORCE, *MOMENT)
        return tuple(f"f{j + 1}" for j in range(self._n))

    @property
    def frame(self) -> str:
        """Name of the axes in which the components are resolved."""
        return "body"

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        kind = "modal load" if self.modal else "body load"
        return Reading(kind, self.body, LOADS.index(self.load))

    @property
    def description(self) -> str:
        """One line for results and plots."""
        what = "modal forces" if self.modal else "loads"
        return f"{self.load} {what} on {self.body.name}"
