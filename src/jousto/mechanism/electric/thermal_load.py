"""Thermal load of motors and converters from their current."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jousto.base.errors import Problems
from jousto.base.fields import Flag, field
from jousto.base.numbers import Number, OptionalNumber
from jousto.mechanism.states.block import Block, Equations
from jousto.mechanism.states.expression import Expression, clip, expression, sqrt, where
from jousto.mechanism.states.inputs import InputField


class ThermalLoad(Block, tag="thermal-load"):
    """Thermal load of a motor by its current, ``time load' = (i/rated)^2 - load``.

    The load is 1 where the motor has the temperature of its rated current. With `largest`, the
    output ``limit`` is the allowed current: ``limit^2 = rated^2 + (largest^2 - rated^2) (1 - load)
    / (1 - reduced_from)``, at most `largest`. The output ``tripped`` becomes 1 when the load
    reaches 1, and stays.

    Examples
    --------
    >>> from jousto.electric import ThermalLoad
    >>> load = ThermalLoad("load", "motor.current", rated=4.0, time=60.0, largest=12.0)
    >>> print(load["limit"])
    load.limit
    """

    kind = "thermal load"
    jumps = True
    current: InputField = field("Current i", unit="A")
    rated: Number = field("Current that the motor carries at all times", unit="A", above=0)
    time: Number = field("Thermal time constant", unit="s", above=0)
    largest: OptionalNumber = field(
        "Largest allowed current of a cold motor; None for no output `limit`", unit="A", above=0,
        default=None, kw_only=True,
    )  # fmt: skip
    reduced_from: Number = field(
        "Load from which on the allowed current is reduced", least=0, below=1, default=0.8,
        kw_only=True,
    )  # fmt: skip
    trips: Flag = field("Whether there is the output `tripped`", default=False, kw_only=True)
    initial: Number = field("Load at the start", least=0, default=0.0, kw_only=True)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report an allowed current below the rated one."""
        if self.largest is not None and self.largest < self.rated:
            text = f"largest is {self.largest:g} A, must not be below rated, {self.rated:g} A"
            problems.add(where, text, "largest")

    @property
    def starts(self) -> Mapping[str, float]:
        """Initial load."""
        return {"load": self.initial}

    @property
    def memories(self) -> Mapping[str, float]:
        """Whether the load has reached 1."""
        return {"tripped": float(self.initial >= 1.0)} if self.trips else {}

    @property
    def outputs(self) -> Any:
        """Names of the outputs."""
        return () if self.largest is None else ("limit",)

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the rate of the load, the allowed current, and the trip."""
        load, i = x["load"], 1.0 / self.rated * self.current
        made = Equations({"load": (i * i - load) / self.time})
        if self.largest is not None:
            left = clip((1.0 - load) / (1.0 - self.reduced_from), 0.0, 1.0)
            more = self.largest**2 - self.rated**2
            made.outputs["limit"] = sqrt(self.rated**2 + more * left)
        if self.trips:
            tripped = x["tripped"]
            made.updates["tripped"] = where(load - 1.0, 1.0, tripped)
            made.margin = where(tripped, expression(1.0), 1.0 - load)
        return made
