"""Sensor of a state or output of a block, or of an expression."""

from __future__ import annotations

from typing import Any, ClassVar

from jousto.base.errors import Problems
from jousto.base.fields import Field, field
from jousto.base.units import check_unit
from jousto.mechanism.sensors.base import Reading, Sensor
from jousto.mechanism.states.expression import Expression, expression


class ExpressionField(Field["Any", "Any"]):
    """Field of an expression, or of the text ``block.name``."""

    form = "text"
    noun = "Expression or str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the expression, or report another value."""
        if isinstance(value, str):
            block, dot, name = value.rpartition(".")
            if dot and block and name:
                return Expression("named", of=(block, name))
        elif (found := expression(value)) is not None:
            return found
        problems.add(
            where, f"{self.name} is {value!r}, must be an expression, or 'block.name'", self.name
        )
        return None


class UnitField(Field["str", "str"]):
    """Field of an SI unit."""

    form = "text"
    noun = "str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the unit, or report an unknown one."""
        if not isinstance(value, str):
            problems.add(where, f"unit is {value!r}, must be a text such as 'Pa'", self.name)
            return "1"
        check_unit(problems, where, value)
        return value


class StateSensor(Sensor, tag="state"):
    """State or output of a block, or an expression of coordinates and states."""

    frame: ClassVar[str] = "world"
    components: ClassVar[tuple[str, ...]] = ("x",)
    of: ExpressionField = field("Expression such as ``motor['current']``, or 'motor.current'")
    unit: UnitField = field("SI unit of the values", default="1", kw_only=True)

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        return Reading("signal", self.of)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"value of {self.of}"
