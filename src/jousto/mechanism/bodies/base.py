"""Fields that all bodies share: mass, inertia, named points and initial pose."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Field, Name, field
from jousto.base.frozen_dict import Frozen
from jousto.base.numbers import Number, OptionalNumber, OptionalValues, Vector
from jousto.base.rotations import parse_orientation
from jousto.mechanism.bodies.inertia import check_inertia

ZERO3 = (0.0, 0.0, 0.0)


class Mass(Number):
    """Field of a mass, a density or a mass per length."""

    def missed(self, x: float) -> str:
        """Return the problem of an invalid number; empty if it is valid."""
        return "" if x > 0 else "must be a positive number"


class OptionalMass(OptionalNumber):
    """Field of a mass or a density, or None."""

    def missed(self, x: float) -> str:
        """Return the problem of an invalid number; empty if it is valid."""
        return "" if x > 0 else "must be a positive number"


class Inertia(Field[ArrayLike, Array]):
    """Field of an inertia tensor, or of its diagonal."""

    form = "shapes"
    noun = "(3, 3) or (3,) array_like"
    shapes = ((3,), (3, 3))

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the inertia tensor (3, 3), or report a tensor that no real body can have."""
        return check_inertia(problems, where, value)


class Points(Field["Mapping[str, ArrayLike] | None", "Mapping[str, Array]"]):
    """Field of named points."""

    form = "points"
    noun = "mapping of str to (3,) array_like"
    checks_none = True

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the points as read-only arrays, or report wrong ones."""
        named: Any = {} if value is None else value
        if not isinstance(named, Mapping):
            problems.add(
                where, f"markers is {named!r}, must be a mapping of names to positions", "markers"
            )
            return None
        points = {
            str(point): problems.array(where, f"markers[{point!r}]", at, (3,))
            for point, at in named.items()
        }
        for point in points:
            if point in ("origin", "center"):
                problems.add(
                    where,
                    f"marker {point!r}: the name is reserved for the body's own {point}",
                    "markers",
                    point,
                )
        return Frozen(points)


class Outline(OptionalValues):
    """Field of a polyline or of triangles."""

    noun = "(k, 3) or (nt, 3, 3) array_like"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the points as a read-only array, or report what is wrong."""
        shape = self.shape if np.ndim(value) < 3 else (None, 3, 3)
        return problems.array(where, self.name, value, shape)


class Orientation(Field[Any, Array]):
    """Field of an orientation, stored as Euler parameters."""

    form = "orientation"
    noun = "orientation"
    checks_none = True

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the Euler parameters (4,), or report what is wrong."""
        return parse_orientation(problems, where, self.name, value)


class Posed(Declared, section="bodies"):
    """A body frame with its initial pose and velocity."""

    kind = "body"
    name: Name = field("Unique among the bodies")
    position: Vector = field(
        "Initial position of the body frame's origin in the world",
        unit="m",
        default=ZERO3,
        kw_only=True,
    )
    orientation: Orientation = field(
        "Initial orientation of the body frame in the world: None, Euler parameters (scalar "
        "first), a rotation matrix, a scipy Rotation or `Rotate`",
        default=None,
        kw_only=True,
    )
    velocity: Vector = field(
        "Initial velocity of the body frame's origin, resolved in the world frame",
        unit="m/s",
        default=ZERO3,
        kw_only=True,
    )
    angular_velocity: Vector = field(
        "Initial angular velocity, resolved in the world frame",
        unit="rad/s",
        default=ZERO3,
        kw_only=True,
    )
