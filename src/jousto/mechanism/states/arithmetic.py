"""Blocks without states: sum, product, switch, saturation, dead band, and force of a block."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, OptionalNumber, OptionalValues
from jousto.mechanism.joints.coordinate import FORCE, CoordinateField
from jousto.mechanism.states.block import Block, Equations
from jousto.mechanism.states.expression import Expression, clip, linear, where
from jousto.mechanism.states.inputs import InputField, InputsField
from jousto.mechanism.states.linear import check_limits, within


class _Function(Block):
    """Base of blocks with one output y that is a function of their inputs."""

    outputs = ("y",)

    @property
    def value(self) -> Expression:
        """Output y."""
        raise NotImplementedError

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the output."""
        return Equations(outputs={"y": self.value})


class Adder(_Function, tag="sum"):
    """Sum of inputs, each with a gain: ``y = sum gain_i u_i``."""

    kind = "sum"
    inputs: InputsField = field("Inputs u_i")
    gains: OptionalValues = field(
        "Gain of each input, such as (1, -1) for a difference; None for 1",
        default=None,
        shape=(None,),
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report gains of another number than that of the inputs."""
        if self.gains is None:
            object.__setattr__(self, "gains", np.ones(len(self.inputs)))
        if len(self.gains) != len(self.inputs):
            text = f"has {len(self.inputs)} inputs and {len(self.gains)} gains, must have as many"
            problems.add(where, text, "gains")

    @property
    def value(self) -> Expression:
        """Sum."""
        return linear(self.gains[None, :], self.inputs)[0]


class Multiplier(_Function, tag="product"):
    """Product of inputs, ``y = u_1 u_2 ..``."""

    kind = "product"
    inputs: InputsField = field("Inputs u_i")

    @property
    def value(self) -> Expression:
        """Product."""
        made = self.inputs[0]
        for one in self.inputs[1:]:
            made = made * one
        return made  # type: ignore[no-any-return]


class Switch(_Function, tag="switch"):
    """Switch: y is one input while a condition is above 0, and another one otherwise."""

    kind = "switch"
    condition: InputField = field("Condition, such as ``oil.p - 2e5``")
    positive: InputField = field("Value of y while the condition is above 0")
    otherwise: InputField = field("Value of y otherwise")

    @property
    def value(self) -> Expression:
        """Chosen input."""
        return where(self.condition, self.positive, self.otherwise)


class Saturation(_Function, tag="saturation"):
    """Input within limits."""

    kind = "saturation"
    input: InputField = field("Input u")
    lower: OptionalNumber = field("Smallest value; None for any", default=None)
    upper: OptionalNumber = field("Largest value; None for any", default=None)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report limits that are missing or in the wrong order."""
        check_limits(problems, where, self.lower, self.upper)
        if self.lower is None and self.upper is None:
            problems.add(where, "has no limit; give lower, upper or both", "upper")

    @property
    def value(self) -> Expression:
        """Input within the limits."""
        return within(self.input, self.lower, self.upper)


class DeadBand(_Function, tag="dead-band"):
    """Input beyond a band, ``y = u - clip(u, lower, upper)``: 0 inside the band."""

    kind = "dead band"
    input: InputField = field("Input u")
    lower: Number = field("Lower end of the band")
    upper: Number = field("Upper end of the band")

    def consistent(self, problems: Problems, where: str) -> None:
        """Report ends in the wrong order."""
        check_limits(problems, where, self.lower, self.upper)

    @property
    def value(self) -> Expression:
        """Input beyond the band."""
        made: Expression = self.input - clip(self.input, self.lower, self.upper)
        return made


class BlockForce(Block, tag="force"):
    """Force along a coordinate, or torque about it, that a block supplies.

    Examples
    --------
    >>> from jousto import Prismatic, RigidBody, ground
    >>> from jousto.mechanism import BlockForce, Lag
    >>> cart = RigidBody("cart", 2.0, (0.1, 0.1, 0.1))
    >>> rail = Prismatic("rail", ground["origin"], cart["origin"], axis=(1, 0, 0))
    >>> motor = Lag("motor", 20.0, 0.01)
    >>> push = BlockForce("push", rail.displacement, motor["y"])
    """

    kind = "block force"
    coordinate: CoordinateField = field("Coordinate along which the force acts")
    force: InputField = field("Force", unit=FORCE)

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the force."""
        forces: list[tuple[Any, Any]] = [(self.coordinate, self.force)]
        return Equations(forces=forces)
