"""Base of all signals, with value, rate and acceleration at a time; sums and products of signals.

A signal provides its first two derivatives in time, since drives and reference motions need them.
At a jump or kink, all three have their values just after it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.fields import Field, Name, field
from jousto.base.numbers import Number, number, set_fields

# value, rate 1/s and acceleration 1/s2 at the given times
Jet = tuple[Array, Array, Array]


@dataclass(frozen=True)
class Use:
    """Unit of a signal field, in model files.

    Parameters
    ----------
    rate : bool
        Whether the unit is that of the rate of the signal.
    """

    rate: bool = False

    def __str__(self) -> str:
        return ""


USE, RATE_OF_USE = Use(), Use(rate=True)


@dataclass(frozen=True, eq=False)
class Law:
    """Law of a signal in the engine, without the signals that are its terms.

    Parameters
    ----------
    kind : str
        Name of the law in the header of the engine, ``jousto.h``.
    data : mapping of str to float
        Numbers of the law by their names in the header.
    rest : tuple of array_like
        Further numbers, of any count.
    count, degree : int
        Number of points, and degree of the polynomials between the points.
    event : Event, optional
        Event that switches the signal.
    name : str
        Name of an input; signals with the same name are one input.
    """

    kind: str
    data: Mapping[str, float]
    rest: tuple[ArrayLike, ...] = ()
    count: int = 0
    degree: int = 0
    event: Any = None
    name: str = ""


class Signal(Declared, section="signals"):
    """Scalar function of time: a factor of a force, the value of a drive, an input.

    Signals add, subtract and multiply, also with numbers:

    >>> from jousto import Harmonic, Ramp
    >>> swell = 2.0 * Ramp(0.0, 1.0) * Harmonic(frequency=1.0) + 5.0
    >>> swell([0.25, 2.25])
    array([5.5, 7. ])
    """

    # lets numpy numbers multiply signals by the operators of this class
    __array_ufunc__ = None
    live: ClassVar[bool] = False
    """Whether the value depends on the motion, so that it is no function of time."""

    def jet(self, t: Array) -> Jet:
        """Return value, rate and acceleration at times t, s, each of the shape of t."""
        raise NotImplementedError

    def __call__(self, t: ArrayLike) -> Array:
        """Return the value at time t, s."""
        return self.jet(np.asarray(t, dtype=np.float64))[0][()]

    def rate(self, t: ArrayLike) -> Array:
        """Return the first derivative at time t, 1/s."""
        return self.jet(np.asarray(t, dtype=np.float64))[1][()]

    def acceleration(self, t: ArrayLike) -> Array:
        """Return the second derivative at time t, 1/s2."""
        return self.jet(np.asarray(t, dtype=np.float64))[2][()]

    @property
    def law(self) -> Law:
        """Law of the signal in the engine."""
        raise NotImplementedError(f"{type(self).__name__} has no law of the engine")

    @property
    def jumps(self) -> tuple[float, ...]:
        """Times at which the value jumps, s."""
        return ()

    @property
    def kinks(self) -> tuple[float, ...]:
        """Times at which the rate jumps while the value does not, s."""
        return ()

    @property
    def parts(self) -> tuple[Signal, ...]:
        """Terms of a sum, a product or a switched signal; empty for other signals."""
        return ()

    def __add__(self, other: Any) -> Signal:
        return combine(Sum, self, other)

    def __radd__(self, other: Any) -> Signal:
        return combine(Sum, other, self)

    def __sub__(self, other: Any) -> Signal:
        return combine(Sum, self, -other if isinstance(other, Signal) else negative(other))

    def __rsub__(self, other: Any) -> Signal:
        return combine(Sum, other, -self)

    def __mul__(self, other: Any) -> Signal:
        return combine(Product, self, other)

    def __rmul__(self, other: Any) -> Signal:
        return combine(Product, other, self)

    def __neg__(self) -> Signal:
        return Product(-1.0, self)


class SignalField(Field["Signal | float", Signal]):
    """Field of a signal, or of a number for a constant signal."""

    form = "signal"
    noun = "Signal or float"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the signal, or report a value of another type."""
        return check_signal(problems, where, self.name, value)


class OptionalSignal(Field["Signal | float | None", "Signal | None"]):
    """Field of a signal, of a number for a constant signal, or None."""

    form = "signal"
    noun = "Signal or float"
    check = SignalField.check


class SignalsField(Field["tuple[Signal | float, ...]", "tuple[Signal, ...]"]):
    """Field of several signals or numbers, which are positional arguments of the constructor.

    Parameters
    ----------
    text, unit, default, kw_only
        As for every field.
    rest : object, optional
        Unit of all signals after the first; None for the unit of the first.
    """

    form = "signals"
    noun = "Signal or float"
    spread = True

    def __init__(self, text: str = "", *, rest: Any = None, **common: Any) -> None:
        super().__init__(text, **common)
        self.rest = rest

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the signals as a tuple, or report wrong ones."""
        if not value:
            problems.add(where, f"{self.name} is empty, must have at least one signal")
        return tuple(
            check_signal(problems, where, f"{self.name}[{i}]", item) for i, item in enumerate(value)
        )


class Constant(Signal, tag="constant", by_value=True):
    """Signal with the same value at all times.

    Examples
    --------
    >>> Constant(2.5)([0.0, 1.0])
    array([2.5, 2.5])
    """

    value: Number = field("The value; a plain number means the same", unit=USE)

    def jet(self, t: Array) -> Jet:
        """Return value, rate and acceleration."""
        zero = np.zeros(t.shape)
        return zero + self.value, zero, zero

    @property
    def law(self) -> Law:
        """Law of the constant."""
        return Law("constant", {}, (self.value,))


class ConstantSpeed(Signal, tag="constant-speed", by_value=True):
    """Straight line ``offset + speed t`` for all times: a drive with constant speed.

    The initial velocities of the mechanism, also in closed loops, fit the signal at t = 0, so that
    no ramp is needed.

    Examples
    --------
    >>> ConstantSpeed(5.0, offset=1.0)([-1.0, 0.0, 2.0])
    array([-4.,  1., 11.])
    """

    speed: Number = field(
        "Rate of the driven coordinate: rad/s (in files also rpm) for an angle, m/s for a length",
        unit=RATE_OF_USE,
    )
    offset: Number = field("Value at t = 0", unit=USE, default=0.0)

    def jet(self, t: Array) -> Jet:
        """Return value, rate and acceleration."""
        zero = np.zeros(t.shape)
        return self.offset + self.speed * t, zero + self.speed, zero

    @property
    def law(self) -> Law:
        """Law of the straight line."""
        return Law("speed", {"offset": self.offset, "speed": self.speed})


class Combined(Signal):
    """Combination of several signals."""

    def consistent(self, problems: Problems, where: str) -> None:
        """Replace each nested sum or product of the same kind by its terms."""
        (key,) = self.fields
        found = [p.parts if type(p) is type(self) else (p,) for p in self.__dict__[key]]
        set_fields(self, **{key: tuple(p for some in found for p in some)})

    @property
    def parts(self) -> tuple[Signal, ...]:
        """The combined signals."""
        (key,) = self.fields
        found: tuple[Signal, ...] = self.__dict__[key]
        return found


class Sum(Combined, tag="sum", by_value=True):
    """Sum of signals and numbers: ``a + b``.

    Examples
    --------
    >>> Sum(Constant(1.0), 2.0, Constant(3.0))(0.0)
    np.float64(6.0)
    """

    terms: SignalsField = field("The signals, or numbers", unit=USE)

    def __init__(self, *terms: Signal | float) -> None:
        set_fields(self, terms=terms)
        self.__post_init__()

    def jet(self, t: Array) -> Jet:
        """Return value, rate and acceleration, each the sum over the terms."""
        f, df, ddf = (np.zeros(t.shape) for _ in range(3))
        for term in self.terms:
            g, dg, ddg = term.jet(t)
            f, df, ddf = f + g, df + dg, ddf + ddg
        return f, df, ddf

    @property
    def law(self) -> Law:
        """Law of the sum of two signals."""
        return Law("sum", {})

    @property
    def jumps(self) -> tuple[float, ...]:
        """Times at which a term jumps, s."""
        return merged(term.jumps for term in self.terms)

    @property
    def kinks(self) -> tuple[float, ...]:
        """Times at which the rate of a term jumps, s."""
        return merged(term.kinks for term in self.terms)


class Product(Combined, tag="product", by_value=True):
    """Product of signals and numbers: ``a * b``.

    Examples
    --------
    >>> Product(Constant(2.0), 3.0)(0.0)
    np.float64(6.0)
    """

    factors: SignalsField = field(
        "The signals, or numbers; in files the first may have a unit, the others have none",
        unit=USE,
        rest="1",
    )

    def __init__(self, *factors: Signal | float) -> None:
        set_fields(self, factors=factors)
        self.__post_init__()

    def jet(self, t: Array) -> Jet:
        """Return value, rate and acceleration by the product rule."""
        f, df, ddf = np.ones(t.shape), np.zeros(t.shape), np.zeros(t.shape)
        for factor in self.factors:
            g, dg, ddg = factor.jet(t)
            f, df, ddf = f * g, df * g + f * dg, ddf * g + 2 * df * dg + f * ddg
        return f, df, ddf

    @property
    def law(self) -> Law:
        """Law of the product of two signals."""
        return Law("product", {})

    @property
    def jumps(self) -> tuple[float, ...]:
        """Times at which a factor jumps while the other factors are not zero, s."""
        times = merged(factor.jumps for factor in self.factors)
        return tuple(t for t in times if self._steps(0, t))

    @property
    def kinks(self) -> tuple[float, ...]:
        """Times at which the rate jumps while the value does not, s."""
        bent = merged(factor.kinks for factor in self.factors)
        kept = merged(factor.jumps for factor in self.factors)
        smooth = tuple(t for t in kept if not self._steps(0, t) and self._steps(1, t))
        return merged((bent, smooth))

    def _steps(self, order: int, t: float) -> bool:
        """Return whether a derivative of the product, of a given order, jumps at a time."""
        try:
            before, after = self.jet(np.array([np.nextafter(t, -np.inf), t]))[order]
        except InputError:  # an input has no value as a function of time
            return True
        return bool(abs(after - before) > 1e-12 * max(1.0, abs(before), abs(after)))


class Input(Signal, tag="input", by_value=True):
    """Value that is set from outside while the engine runs, such as an actuator command.

    The value is constant within a step, so rate and acceleration are zero. An input is not a
    function of time and cannot be called.
    """

    kind = "input"
    name: Name = field("Name; inputs with the same name are one input")
    initial: Number = field("Value until a new one is set", unit=USE, default=0.0)

    @property
    def law(self) -> Law:
        """Law of the value set from outside."""
        return Law("input", {}, (self.initial,), name=self.name)

    def jet(self, t: Array) -> Jet:
        """Raise InputError: an input is not a function of time."""
        raise InputError(
            Problem(
                f"input {self.name!r}",
                "is set from outside while the model runs and has no value as a function of time",
            )
        )


def combine(kind: type[Sum] | type[Product], *items: Any) -> Signal:
    """Decorate an operator: it returns NotImplemented for terms that are no signals or numbers."""
    signal: Any = NotImplemented
    live = next((item for item in items if isinstance(item, Signal) and item.live), None)
    if live is not None:
        return live.combined("add" if kind is Sum else "multiply", *items)  # type: ignore[attr-defined,no-any-return]
    if all(isinstance(item, Signal | int | float | np.number) for item in items):
        signal = kind(*items)
    return signal  # type: ignore[no-any-return]


def negative(value: Any) -> Any:
    """Return a number with opposite sign; any other value unchanged (for NotImplemented)."""
    return -value if isinstance(value, int | float | np.number) else value


def merged(times: Iterator[tuple[float, ...]] | Any) -> tuple[float, ...]:
    """Return the sorted times without duplicates."""
    return tuple(sorted({t for some in times for t in some}))


def check_signal(problems: Problems, where: str, name: str, value: Any) -> Signal | None:
    """Return a signal, with a number as a constant signal, or report that the value is neither."""
    if isinstance(value, Signal):
        return value
    if isinstance(value, int | float | np.number) and not isinstance(value, bool):
        found = number(problems, where, name, value)
        return None if found is None else Constant(found)
    problems.add(
        where, f"{name} is {value!r}, must be a number or a signal such as Step(1.0)", name
    )
    return None


def leaves(signal: Signal) -> Iterator[Signal]:
    """Yield a signal and all signals of which it is composed, depth first."""
    yield signal
    for part in signal.parts:
        yield from leaves(part)
