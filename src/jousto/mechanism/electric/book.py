"""Blocks that transmit power: their power balance, and its integrals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from jousto.base.fields import Flag, field
from jousto.mechanism.states.block import Block

POWERS = ("supplied", "mechanical", "heat", "stored")
"""Parts of the balance ``supplied = mechanical + heat + stored``."""


class Booked(Block):
    """Base of blocks with the outputs ``supplied_power`` and so on, and works as states."""

    book: Flag = field(
        "Whether works are integrated: supplied_work, mechanical_work, heat_work, stored_work",
        default=False,
        kw_only=True,
    )

    if TYPE_CHECKING:

        @property
        def size(self) -> float:
            """Size of the states for error control."""

    @property
    def own(self) -> dict[str, float]:
        """Initial values of the states beside the works, by name."""
        return {}

    @property
    def others(self) -> tuple[str, ...]:
        """Names of the outputs beside the powers."""
        raise NotImplementedError

    @property
    def starts(self) -> Mapping[str, float]:
        """Initial values of the states by name."""
        works = dict.fromkeys((f"{name}_work" for name in POWERS), 0.0) if self.book else {}
        return self.own | works

    @property
    def outputs(self) -> Any:
        """Names of the outputs."""
        return (*self.others, *(f"{name}_power" for name in POWERS))

    def add_powers(self, made: Any, supplied: Any, mechanical: Any, heat: Any, stored: Any) -> None:
        """Add the powers, W, to the equations as outputs, and the rates of the works."""
        for name, power in zip(POWERS, (supplied, mechanical, heat, stored), strict=True):
            made.outputs[f"{name}_power"] = power
            if self.book:
                made.rates[f"{name}_work"] = power
