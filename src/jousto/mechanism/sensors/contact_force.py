"""Sensors of contacts: the force between two shapes of a set, and the pressure of a contact."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from jousto.base.errors import Problems, suggest
from jousto.base.fields import Reference, Text, field
from jousto.base.numbers import OptionalNumber, OptionalValues
from jousto.mechanism.bodies.marker import Marker, OptionalMarker
from jousto.mechanism.contacts.hertz import HertzScale, line_scale, point_scale
from jousto.mechanism.contacts.laws import Hertz
from jousto.mechanism.contacts.meetings import labels_of
from jousto.mechanism.contacts.shapes import Cylinder, HalfSpace, Shape, Torus
from jousto.mechanism.forces.contact import Contact
from jousto.mechanism.forces.contact_set import Contacts
from jousto.mechanism.sensors.base import Reading, Sensor
from jousto.mechanism.sensors.loads import FORCE, MOMENT, SUM_PAIR, SUM_PRESSURE, SUM_ROW
from jousto.mechanism.sensors.motion import frame_name


class ContactsField(Reference[Contacts, Contacts]):
    """Field of a set of contacts; a model file contains its name."""

    section = ("forces",)
    word = "force"
    noun = "Contacts"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the set, or report a value of another type."""
        if not isinstance(value, Contacts):
            hint = "; take a ForceSensor" if isinstance(value, Contact) else ""
            problems.add(where, f"{self.name} is {value!r}, must be Contacts{hint}", self.name)
        return value


class ContactField(Reference[Contact, Contact]):
    """Field of a contact of two shapes; a model file contains its name."""

    section = ("forces",)
    word = "force"
    noun = "Contact"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the contact, or report a value of another type."""
        if not isinstance(value, Contact):
            problems.add(where, f"{self.name} is {value!r}, must be a Contact", self.name)
        return value


class ContactForceSensor(Sensor, tag="contact-force"):
    """Force and moment (6,) that shapes of a set exert on other ones, N and N m.

    a and b are names of shapes or of groups of `Contacts`. The sensor measures the sum over all
    pairs of a shape of a and a shape of b: the force on b, and its moment about the origin of the
    marker of the first shape of b. Contacts with other shapes do not count.
    """

    unit: ClassVar[str] = "N, N m"
    components: ClassVar[tuple[str, ...]] = (*FORCE, *MOMENT)
    contacts: ContactsField = field("The set of contacts")
    a: Text = field("Name of a shape, or of a group of shapes")
    b: Text = field("Name of the shape or group on which the force acts")
    resolved_in: OptionalMarker = field(
        "Axes of the components; None for the world frame", default=None, kw_only=True
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report unknown names, and shapes on both sides."""
        known = dict.fromkeys(x for one in self.contacts.shapes for x in labels_of(one))
        for key in ("a", "b"):
            name = getattr(self, key)
            if name not in known:
                text = f"no shape or group {name!r} in {self.contacts.name!r}{suggest(name, known)}"
                problems.add(where, text, key)
                return
        both = [one.name for one in self.contacts.shapes if {self.a, self.b} <= set(labels_of(one))]
        if both or self.a == self.b:
            what = repr(both[0]) if both else "every shape"
            problems.add(where, f"{what} is on both sides; name two groups without it", "b")

    @property
    def axes(self) -> Marker | None:
        """Marker in whose axes the components are resolved; None for the world."""
        return self.resolved_in

    @property
    def frame(self) -> str:
        """Name of the axes in which the components are resolved."""
        return frame_name(self.resolved_in)

    @property
    def turning(self) -> tuple[tuple[str, Marker], ...]:
        """Markers whose orientation matters, each with the name of the argument."""
        return () if self.resolved_in is None else (("resolved_in", self.resolved_in),)

    @property
    def reading(self) -> Reading:
        """Input of the engine: the set, and the side of each shape."""
        shapes = self.contacts.shapes
        rows = np.zeros((2, max(SUM_ROW, len(shapes))))
        rows[0, :2] = SUM_PAIR, self.contacts.slots + self.contacts.convex
        for i, one in enumerate(shapes):
            rows[1, i] = 2 * (self.b in labels_of(one)) or self.a in labels_of(one)
        return Reading("contact", self.contacts, 0, self.axes, rows)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"force of {self.a} on {self.b}"


class ContactPressureSensor(Sensor, tag="contact-pressure"):
    """Largest pressure, Pa, and half axes a, b, m, of a contact by Hertz, from its normal force.

    A point contact has ``p0 = 3 F/(2 pi a b)`` with the ellipse of its relative radii, a line
    contact ``p0 = sqrt(F E*/(pi L R))`` with b half its length (K. L. Johnson, Contact Mechanics,
    1985). E* is that of the `Hertz` law or ``modulus``; the radii are those of the shapes (spheres,
    half-spaces, and a torus that rolls on a half-space), or ``radii``: 1/R = 1/R_1 + 1/R_2 along
    the rolling direction x and across it, y. `fatigue.rolling_life` takes the forces of the same
    contact.
    """

    frame: ClassVar[str] = "coordinate"
    contact: ContactField = field("The contact, of one tip")
    modulus: OptionalNumber = field(
        "E* of both bodies; None: that of the law", unit="Pa", above=0, default=None, kw_only=True
    )
    radii: OptionalValues = field(
        "Relative radii along x (rolling) and y; None: those of the shapes",
        unit="m",
        shape=(2,),
        default=None,
        kw_only=True,
    )
    length: OptionalNumber = field(
        "Length of a line contact, whose radius is the first one; None: a point contact",
        unit="m",
        above=0,
        default=None,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a contact whose modulus or radii are not known."""
        if len(self.contact.pushes) != 1:
            problems.add(
                where,
                f"{self.contact.name!r} has several tips with a pressure each; take a contact of "
                "one tip",
                "contact",
            )
        if self._modulus is None:
            name = type(self.contact.law).__name__
            problems.add(where, f"{name} has no E*; give modulus=", "modulus")
        if self.radii is not None and not np.all(np.asarray(self.radii) > 0.0):
            problems.add(where, f"radii are {np.asarray(self.radii)}, must be positive", "radii")
        elif self._radii is None:
            a, b = self.contact.shape_a.tag, self.contact.shape_b.tag
            problems.add(where, f"{a} and {b} have no radii of a point; give radii=", "radii")

    @property
    def unit(self) -> str:
        """Units of the components."""
        return ", ".join(("Pa", "m", "m")[: len(self.components)])

    @property
    def components(self) -> tuple[str, ...]:
        """Largest pressure, and the half axes that grow with the force."""
        return ("p0", "a", "b") if self.length is None else ("p0", "a")

    @property
    def _modulus(self) -> float | None:
        law = self.contact.law
        own: Any = self.modulus
        return own if own is not None else law.modulus if isinstance(law, Hertz) else None

    @property
    def _radii(self) -> tuple[float, float] | None:
        """Relative radii along x and y, m; None if they are not those of a point contact."""
        if self.radii is not None:
            x, y = np.asarray(self.radii, dtype=float).tolist()
            return x, y
        both = [curvatures_of(shape) for shape in (self.contact.shape_a, self.contact.shape_b)]
        sums = [None if None in pair else sum(pair) for pair in zip(*both, strict=True)]
        if any(x is None or x <= 0.0 for x in sums):
            return None
        return 1.0 / sums[0], 1.0 / sums[1]  # type: ignore[operator]

    @property
    def scale(self) -> HertzScale:
        """Pressure and half axes under 1 N."""
        modulus, radii, length = self._modulus, self._radii, self.length
        assert modulus is not None and radii is not None
        if length is not None:
            return line_scale(modulus, radii[0], float(length))
        return point_scale(modulus, radii)

    @property
    def reading(self) -> Reading:
        """Input of the engine: coefficients of pressure and half axes, and the power."""
        one = self.scale
        rows = np.zeros((1, SUM_ROW))
        rows[0] = SUM_PRESSURE, 1, one.p0, one.a, one.b, one.power
        return Reading("contact", self.contact, rows=rows)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"largest pressure and half axes of {self.contact.name}"


def curvatures_of(shape: Shape) -> tuple[float | None, float | None]:
    """Return the curvatures of a shape where it touches, along x (rolling) and y, 1/m."""
    if isinstance(shape, HalfSpace):
        return 0.0, 0.0
    if isinstance(shape, Torus) and shape.tube:
        return 1.0 / (shape.radius + shape.tube), 1.0 / shape.tube
    if isinstance(shape, Cylinder):
        return 1.0 / shape.radius, 0.0
    return shape.curvature, shape.curvature
