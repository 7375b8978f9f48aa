"""Sensor of the contact of a wheel on its rail."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from jousto.base.errors import Problems
from jousto.base.fields import Choice, Reference, field
from jousto.mechanism.forces.rail_contact import RailContact
from jousto.mechanism.sensors.base import Reading, Sensor
from jousto.mechanism.sensors.loads import SUM_RAIL, SUM_ROW


class RailContactField(Reference[RailContact, RailContact]):
    """Field of a wheel on a rail; a model file contains its name."""

    section = ("forces",)
    word = "force"
    noun = "RailContact"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the contact, or report a value of another type."""
        if not isinstance(value, RailContact):
            problems.add(where, f"{self.name} is {value!r}, must be a RailContact", self.name)
        return value


class RailContactSensor(Sensor, tag="rail-contact"):
    """Load, creep forces, creepages and pressure of a wheel on its rail, at tread or flange.

    Components: normal load N; creep forces Fx along the rail and Fy across it in the plane of
    contact, and the moment M about its upward normal, on the wheel; creepages nu_x, nu_y (1) and
    phi (1/m); largest pressure p0 and half axes a along and b across by Hertz; the rolling radius r
    at the point of contact, and its distance y across the rail from marker a. Without contact all
    but r and y are 0.

    `fatigue.rolling_passes` takes p0 of the passes of a point of the tread; the ratio of the
    forces of a flange tells how near it is to climbing (Nadal).
    """

    frame: ClassVar[str] = "contact"
    unit: ClassVar[str] = "N, N, N, N m, 1, 1, 1/m, Pa, m, m, m, m"
    components: ClassVar[tuple[str, ...]] = (
        *("N", "Fx", "Fy", "M", "nu_x", "nu_y", "phi"),
        *("p0", "a", "b", "r", "y"),
    )
    contact: RailContactField = field("The wheel on its rail")
    patch: Choice = field("Place of contact", words=("tread", "flange"), default="tread")

    def consistent(self, problems: Problems, where: str) -> None:
        """Report the flange of a wheel without one."""
        if self.patch == "flange" and self.contact.play is None:
            text = f"{self.contact.name!r} has no flange; give play= to it, or take the tread"
            problems.add(where, text, "patch")

    @property
    def reading(self) -> Reading:
        """Input of the engine: the number of the patch."""
        rows = np.zeros((1, SUM_ROW))
        rows[0, :2] = SUM_RAIL, float(self.patch == "flange")
        return Reading("contact", self.contact, rows=rows)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"contact of {self.contact.name}, {self.patch}"
