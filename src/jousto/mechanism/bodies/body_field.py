"""Fields whose value is a body."""

from __future__ import annotations

from typing import Any

from jousto.base.errors import Problems
from jousto.base.fields import Reference
from jousto.mechanism.bodies.body import FlexibleBody, MovingBody, RigidBody


class FlexibleField(Reference[FlexibleBody, FlexibleBody]):
    """Field of a flexible body; a model file contains its name."""

    section = "bodies"
    word = "body"
    noun = "FlexibleBody"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the flexible body, or report a value of another type."""
        if not isinstance(value, FlexibleBody):
            problems.add(where, f"{self.label} is {value!r}, must be a flexible body")
        return value


class MovingBodyField(Reference[MovingBody, MovingBody]):
    """Field of a flexible or rigid body; a model file contains its name."""

    section = "bodies"
    word = "body"
    noun = "FlexibleBody or RigidBody"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the body, or report a value of another type."""
        if not isinstance(value, FlexibleBody | RigidBody):
            problems.add(where, f"{self.label} is {value!r}, must be a flexible or a rigid body")
        return value
