"""The law of contact of a robot, as a field: none, that of its material, or that of its file."""

from __future__ import annotations

from typing import Any

from jousto.base.errors import Problems, suggest
from jousto.base.fields import Field

MATERIAL, FILE = "material", "file"
"""Laws of contact of a robot: one for all shapes, or those of its file."""


class RobotContact(Field["bool | str", "bool | str"]):
    """Field of the law of contact of a robot; True is that of the material."""

    form = "flag or choice"
    words = (MATERIAL, FILE)
    noun = 'bool or {"material", "file"}'

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return False or the law, or report another value."""
        if type(value).__name__ in ("bool", "bool_"):
            return MATERIAL if value else False
        if value not in self.words:
            near = suggest(value, self.words) if isinstance(value, str) else ""
            message = f"contact is {value!r}, must be True, False, 'material' or 'file'{near}"
            problems.add(where, message, self.key)
        return value
