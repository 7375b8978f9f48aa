"""Linear blocks: state space, transfer function, integrator, lag and lead."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.errors import InputError, Problems
from jousto.base.fields import field, kept
from jousto.base.numbers import Number, OptionalNumber, OptionalValues, Positive, Values
from jousto.mechanism.states.block import Block, Equations
from jousto.mechanism.states.expression import Expression, clip, linear, maximum, minimum, where
from jousto.mechanism.states.inputs import InputField, InputsField
from jousto.mechanism.states.state_space import Matrices, of_transfer_function

SIZE = "Size of the states for the error control of DormandPrince"


class Sized(Block):
    """Base of blocks whose states have one size for the error control."""

    if TYPE_CHECKING:

        @property
        def size(self) -> float:
            """Size of the states."""

    @property
    def nominals(self) -> Mapping[str, float]:
        """Sizes of the states for error control."""
        return dict.fromkeys(self.starts, self.size)


class _Linear(Sized):
    """Base of ``x' = A x + B u``, ``y = C x + D u`` with states x1, x2 and so on."""

    size: Positive = field(SIZE, default=1.0, kw_only=True)

    @property
    def matrices(self) -> Matrices:
        """A, B, C and D."""
        raise NotImplementedError

    @property
    def given(self) -> Sequence[Expression]:
        """Inputs u."""
        raise NotImplementedError

    @property
    def first(self) -> Any:
        """Initial values x of the states."""
        return np.zeros(len(self.matrices[0]))

    @property
    def starts(self) -> Mapping[str, float]:
        """Initial values of the states by name."""
        return {f"x{i + 1}": x for i, x in enumerate(self.first)}

    @property
    def outputs(self) -> Any:
        """Names of the outputs."""
        count = len(self.matrices[2])
        return ("y",) if count == 1 else tuple(f"y{i + 1}" for i in range(count))

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the products with the matrices."""
        A, B, C, D = self.matrices
        terms = [*x.values(), *self.given]
        return Equations(
            dict(zip(x, linear(np.hstack([A, B]), terms), strict=True)),
            dict(zip(self.outputs, linear(np.hstack([C, D]), terms), strict=True)),
        )


class LinearSystem(_Linear, tag="linear-system"):
    """Linear system ``x' = A x + B u``, ``y = C x + D u``.

    The states are ``x1``, ``x2`` and so on; the outputs ``y``, or ``y1``, ``y2`` and so on.

    Examples
    --------
    >>> from jousto.mechanism import LinearSystem
    >>> lag = LinearSystem("lag", 1.0, [[-10.0]], [[10.0]], [[1.0]])
    >>> print(lag["y"])
    lag.y
    """

    kind = "linear system"
    inputs: InputsField = field("Inputs u")
    A: Values = field("Matrix of the rates by the states", shape=(None, None))
    B: Values = field("Matrix of the rates by the inputs", shape=(None, None))
    C: Values = field("Matrix of the outputs by the states", shape=(None, None))
    D: OptionalValues = field(
        "Matrix of the outputs by the inputs; None for zeros", default=None, shape=(None, None)
    )
    initial: OptionalValues = field(
        "Initial values of the states; None for zeros", default=None, kw_only=True, shape=(None,)
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report matrices of shapes that do not fit; set defaults."""
        n, m, p = len(self.A), len(self.inputs), len(self.C)
        if self.D is None:
            object.__setattr__(self, "D", np.zeros((p, m)))
        if self.initial is None:
            object.__setattr__(self, "initial", np.zeros(n))
        shapes = {"A": (n, n), "B": (n, m), "C": (p, n), "D": (p, m), "initial": (n,)}
        for key, shape in shapes.items():
            found = getattr(self, key).shape
            if found != shape:
                text = f"{key} has shape {found}, must be {shape} for {n} states"
                problems.add(where, f"{text}, {m} inputs and {p} outputs", key)

    @property
    def matrices(self) -> Matrices:
        """A, B, C and D."""
        return self.A, self.B, self.C, self.D

    @property
    def given(self) -> Sequence[Expression]:
        """Inputs u."""
        return self.inputs

    @property
    def first(self) -> Any:
        """Initial values of the states."""
        return self.initial


class TransferFunction(_Linear, tag="transfer-function"):
    """Transfer function ``y = (b0 s^m + .. + bm) / (a0 s^n + .. + an) u``, m <= n.

    Its states, in controllable form and scaled by powers of 2, start at 0.

    Examples
    --------
    >>> from jousto.mechanism import TransferFunction
    >>> notch = TransferFunction("notch", 1.0, [1, 0, 400.0], [1, 40.0, 400.0])
    >>> print(notch["y"])
    notch.y
    """

    kind = "transfer function"
    input: InputField = field("Input u")
    numerator: Values = field("Coefficients b0 .. bm of falling powers of s", shape=(None,))
    denominator: Values = field("Coefficients a0 .. an of falling powers of s", shape=(None,))
    _matrices: Any = kept()

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a denominator of 0, and a numerator of higher degree."""
        try:
            made = of_transfer_function(self.numerator, self.denominator)
        except InputError as error:
            for one in error.problems:
                problems.add(where, one.message, "numerator")
        else:
            object.__setattr__(self, "_matrices", made)

    @property
    def matrices(self) -> Matrices:
        """A, B, C and D."""
        return self._matrices  # type: ignore[no-any-return]

    @property
    def given(self) -> Sequence[Expression]:
        """Input u."""
        return (self.input,)


class Integrator(Sized, tag="integrator"):
    """Integral ``y' = gain u``; at a limit it stops while the input pushes on.

    Beyond a limit the integral goes at most by one step, and y not at all.
    """

    kind = "integrator"
    outputs = ("y",)
    input: InputField = field("Input u")
    gain: Number = field("Gain, 1/s times the unit of y over that of u", default=1.0)
    initial: Number = field("Value at the start", default=0.0, kw_only=True)
    lower: OptionalNumber = field("Smallest value; None for any", default=None, kw_only=True)
    upper: OptionalNumber = field("Largest value; None for any", default=None, kw_only=True)
    size: Positive = field(SIZE, default=1.0, kw_only=True)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report limits in the wrong order, and a start beyond them."""
        check_limits(problems, where, self.lower, self.upper)
        for limit, side in ((self.lower, -1.0), (self.upper, 1.0)):
            if limit is not None and (self.initial - limit) * side > 0.0:
                text = f"initial is {self.initial:g}, beyond the limit of {limit:g}"
                problems.add(where, text, "initial")

    @property
    def starts(self) -> Mapping[str, float]:
        """Initial value."""
        return {"integral": self.initial}

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the rate, 0 at a limit towards which the input pushes."""
        y = x["integral"]
        rate = self.gain * self.input
        if self.upper is not None:
            rate = where(y - self.upper, minimum(rate, 0.0), rate)
        if self.lower is not None:
            rate = where(self.lower - y, maximum(rate, 0.0), rate)
        return Equations({"integral": rate}, {"y": within(y, self.lower, self.upper)})


class Lag(Sized, tag="lag"):
    """Lag of first order, ``time y' = gain u - y``."""

    kind = "lag"
    input: InputField = field("Input u")
    time: Positive = field("Time constant", unit="s")
    gain: Number = field("Gain", default=1.0)
    initial: Number = field("Value of y at the start", default=0.0, kw_only=True)
    size: Positive = field(SIZE, default=1.0, kw_only=True)

    @property
    def starts(self) -> Mapping[str, float]:
        """Initial value."""
        return {"y": self.initial}

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the rate."""
        return Equations({"y": (self.gain * self.input - x["y"]) / self.time})


class Lead(Sized, tag="lead"):
    """Lead or lag ``y = gain (1 + lead s) / (1 + lag s) u``.

    The state x with ``lag x' = u - x`` gives ``y = gain (x + lead/lag (u - x))``.
    """

    kind = "lead"
    outputs = ("y",)
    input: InputField = field("Input u")
    lead: Number = field("Time constant of the numerator", unit="s", least=0)
    lag: Positive = field("Time constant of the denominator", unit="s")
    gain: Number = field("Gain", default=1.0)
    initial: Number = field("Value of the state x at the start", default=0.0, kw_only=True)
    size: Positive = field(SIZE, default=1.0, kw_only=True)

    @property
    def starts(self) -> Mapping[str, float]:
        """Initial value."""
        return {"x": self.initial}

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return rate and output."""
        missing = self.input - x["x"]
        y = self.gain * (x["x"] + self.lead / self.lag * missing)
        return Equations({"x": missing / self.lag}, {"y": y})


def check_limits(problems: Problems, where: str, lower: Any, upper: Any) -> None:
    """Report a lower limit that is not below the upper one."""
    if lower is not None and upper is not None and not lower < upper:
        text = f"lower is {lower:g}, must be below upper, {upper:g}"
        problems.add(where, text, "lower")


def within(x: Expression, lower: Any, upper: Any) -> Expression:
    """Return an expression within limits, each of which may be None."""
    if lower is not None and upper is not None:
        return clip(x, lower, upper)
    if upper is not None:
        return minimum(x, upper)
    return x if lower is None else maximum(x, lower)
