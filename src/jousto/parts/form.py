"""Input of a part: beams, a mesh with its materials, or matrices of another program."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import AnyField


class Dictionary(AnyField):
    """Field of values by name."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the mapping, or report a value of another type."""
        if not isinstance(value, Mapping):
            problems.add(where, f"{self.name} is {value!r}, must be a dictionary")
        return value


class PartForm(Declared, section="parts"):
    """Base of the inputs from which a part is built."""

    kind = "part"

    def assembled(self) -> dict[str, Any]:
        """Return the fields of the part that is built from the input."""
        raise NotImplementedError

    def judge(self, part: Any) -> None:
        """Raise InputError if a part built from this input cannot be used."""
