"""What a part is made of: beams, a mesh with its materials, or matrices of another program."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import AnyField


class Dictionary(AnyField):
    """Values by name."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the mapping."""
        if not isinstance(value, Mapping):
            problems.add(where, f"{self.name} is {value!r}, must be a dictionary")
        return value


class PartForm(Declared, section="parts"):
    """What a part is made of."""

    kind = "part"

    def assembled(self) -> dict[str, Any]:
        """Return the fields of the part."""
        raise NotImplementedError

    def judge(self, part: Any) -> None:
        """Raise InputError where the part that was made of it cannot be used."""
