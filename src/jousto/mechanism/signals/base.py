"""What all signals share: value, rate and acceleration at a time, sums and products.

A signal knows its first two derivatives in time, since drives and reference motions need them.
At a jump or kink all three are those just after it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.declare import Field
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.names import check_name
from jousto.base.numbers import number, set_fields
from jousto.base.rotations import Array

# value, rate 1/s, acceleration 1/s2 at the times asked for
Jet = tuple[Array, Array, Array]


class Signal(ABC):
    """A scalar function of time: a factor on a force, the value of a drive, an input.

    Signals add, subtract and multiply, also with numbers:

    >>> from jousto import Harmonic, Ramp
    >>> swell = 2.0 * Ramp(0.0, 1.0) * Harmonic(frequency=1.0) + 5.0
    >>> swell([0.25, 2.25])
    array([5.5, 7. ])
    """

    # numpy leaves products of its numbers with signals to this class
    __array_ufunc__ = None

    @abstractmethod
    def jet(self, t: Array) -> Jet:
        """Return value, rate and acceleration at times t, s, each of the shape of t."""

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
    def jumps(self) -> tuple[float, ...]:
        """Times at which the value jumps, s."""
        return ()

    @property
    def kinks(self) -> tuple[float, ...]:
        """Times at which the rate jumps while the value does not, s."""
        return ()

    @property
    def parts(self) -> tuple[Signal, ...]:
        """The signals this one is made of; empty unless a sum, a product or switched."""
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


@dataclass(frozen=True, init=False)
class Constant(Signal):
    """The same value at all times.

    Examples
    --------
    >>> Constant(2.5)([0.0, 1.0])
    array([2.5, 2.5])
    """

    value: float

    def __init__(self, value: float) -> None:
        problems = Problems()
        found = number(problems, "Constant", "value", value)
        problems.raise_if_any()
        set_fields(self, value=found)

    def jet(self, t: Array) -> Jet:
        """Return value, rate and acceleration."""
        zero = np.zeros(t.shape)
        return zero + self.value, zero, zero


@dataclass(frozen=True, init=False)
class ConstantSpeed(Signal):
    """A straight line without end, ``offset + speed t``: a drive at constant speed from the start.

    The velocities of the mechanism fit it from t = 0 on, and closed loops follow: no ramp is
    needed.

    Parameters
    ----------
    speed : float
        Rate of what follows the signal: rad/s for an angle, m/s for a displacement.
    offset : float
        Value at t = 0.

    Examples
    --------
    >>> ConstantSpeed(5.0, offset=1.0)([-1.0, 0.0, 2.0])
    array([-4.,  1., 11.])
    """

    speed: float
    offset: float

    def __init__(self, speed: float, offset: float = 0.0) -> None:
        problems = Problems()
        values = {
            "speed": number(problems, "ConstantSpeed", "speed", speed),
            "offset": number(problems, "ConstantSpeed", "offset", offset),
        }
        problems.raise_if_any()
        set_fields(self, **values)

    def jet(self, t: Array) -> Jet:
        """Return value, rate and acceleration."""
        zero = np.zeros(t.shape)
        return self.offset + self.speed * t, zero + self.speed, zero


@dataclass(frozen=True, init=False)
class Sum(Signal):
    """The sum of signals and numbers: ``a + b``.

    Examples
    --------
    >>> Sum(Constant(1.0), 2.0, Constant(3.0))(0.0)
    np.float64(6.0)
    """

    terms: tuple[Signal, ...]

    def __init__(self, *terms: Signal | float) -> None:
        set_fields(self, terms=gather(Sum, "terms", terms))

    @property
    def parts(self) -> tuple[Signal, ...]:
        """The terms."""
        return self.terms

    def jet(self, t: Array) -> Jet:
        """Return value, rate and acceleration: each the sum of those of the terms."""
        f, df, ddf = (np.zeros(t.shape) for _ in range(3))
        for term in self.terms:
            g, dg, ddg = term.jet(t)
            f, df, ddf = f + g, df + dg, ddf + ddg
        return f, df, ddf

    @property
    def jumps(self) -> tuple[float, ...]:
        """Times at which a term jumps, s."""
        return merged(term.jumps for term in self.terms)

    @property
    def kinks(self) -> tuple[float, ...]:
        """Times at which the rate of a term jumps, s."""
        return merged(term.kinks for term in self.terms)


@dataclass(frozen=True, init=False)
class Product(Signal):
    """The product of signals and numbers: ``a * b``.

    Examples
    --------
    >>> Product(Constant(2.0), 3.0)(0.0)
    np.float64(6.0)
    """

    factors: tuple[Signal, ...]

    def __init__(self, *factors: Signal | float) -> None:
        set_fields(self, factors=gather(Product, "factors", factors))

    @property
    def parts(self) -> tuple[Signal, ...]:
        """The factors."""
        return self.factors

    def jet(self, t: Array) -> Jet:
        """Return value, rate and acceleration by the product rule."""
        f, df, ddf = np.ones(t.shape), np.zeros(t.shape), np.zeros(t.shape)
        for factor in self.factors:
            g, dg, ddg = factor.jet(t)
            f, df, ddf = f * g, df * g + f * dg, ddf * g + 2 * df * dg + f * ddg
        return f, df, ddf

    @property
    def jumps(self) -> tuple[float, ...]:
        """Times at which a factor jumps while the others are not zero, s."""
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
        """Return whether a derivative of the product differs before and after a time."""
        try:
            before, after = self.jet(np.array([np.nextafter(t, -np.inf), t]))[order]
        except InputError:  # an input has no value to tell from
            return True
        return bool(abs(after - before) > 1e-12 * max(1.0, abs(before), abs(after)))


@dataclass(frozen=True, init=False)
class Input(Signal):
    """A value that comes from outside while the engine runs: an actuator command, an FMU input.

    It is held between two steps, so its rate and acceleration are zero. It has no value as a
    function of time and cannot be called.

    Parameters
    ----------
    name : str
        Name; inputs of one name are one input.
    initial : float
        Value until another one is set.
    """

    name: str
    initial: float

    def __init__(self, name: str, initial: float = 0.0) -> None:
        problems = Problems()
        where = check_name(problems, "input", name)
        value = number(problems, where, "initial", initial)
        problems.raise_if_any()
        set_fields(self, name=name, initial=value)

    def jet(self, t: Array) -> Jet:
        """Raise InputError: the value is not known as a function of time."""
        raise InputError(
            Problem(
                f"input {self.name!r}",
                "comes from outside while the model runs and has no value as a function of time",
            )
        )


def combine(kind: type[Sum] | type[Product], *items: Any) -> Signal:
    """Return a sum or product, or NotImplemented for what is no signal and no number."""
    signal: Any = NotImplemented
    if all(isinstance(item, Signal | int | float | np.number) for item in items):
        signal = kind(*items)
    return signal  # type: ignore[no-any-return]


def negative(value: Any) -> Any:
    """Return the negative of a number, anything else as it is."""
    return -value if isinstance(value, int | float | np.number) else value


def gather(kind: type[Signal], name: str, items: tuple[Any, ...]) -> tuple[Signal, ...]:
    """Return the signals of a sum or product; those of the same kind are taken apart."""
    problems = Problems()
    found: list[Signal] = []
    if not items:
        problems.add(kind.__name__, f"{name} is empty, must have at least one signal")
    for i, item in enumerate(items):
        signal = check_signal(problems, kind.__name__, f"{name}[{i}]", item)
        if signal is not None:
            found.extend(signal.parts if isinstance(signal, kind) else (signal,))
    problems.raise_if_any()
    return tuple(found)


def merged(times: Iterator[tuple[float, ...]] | Any) -> tuple[float, ...]:
    """Return all times in order, each once."""
    return tuple(sorted({t for some in times for t in some}))


class SignalField(Field["Signal | float", Signal]):
    """A signal, or a number for a constant one."""

    form = "signal"
    noun = "Signal or float"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the signal."""
        return check_signal(problems, where, self.name, value)


def check_signal(problems: Problems, where: str, name: str, value: Any) -> Signal | None:
    """Return a signal, a number as a constant one, or note why the value is neither."""
    if isinstance(value, Signal):
        return value
    if isinstance(value, int | float | np.number) and not isinstance(value, bool):
        found = number(problems, where, name, value)
        return None if found is None else Constant(found)
    problems.add(where, f"{name} is {value!r}, must be a number or a signal such as Step(1.0)")
    return None


def leaves(signal: Signal) -> Iterator[Signal]:
    """Yield the signal itself and all signals it is made of, depth first."""
    yield signal
    for part in signal.parts:
        yield from leaves(part)
