"""Sampled blocks: values that change at sampling times only, with zero-order hold between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.errors import Problems, suggest
from jousto.base.fields import field, kept
from jousto.base.numbers import Number, Positive, Whole
from jousto.mechanism.states.block import Block, Equations
from jousto.mechanism.states.expression import Expression, linear
from jousto.mechanism.states.inputs import FormulasField, as_formula
from jousto.mechanism.states.state_space import matrices_of


class Ticking(Block):
    """Base of the blocks whose values change at samples only.

    A sample reads its inputs at ``phase + k period``, later by a random part of `jitter`. The
    values change `latency` after this, as a computer that needs this time would.
    """

    jumps = True
    phase: Number = field("Time of the first sample", unit="s", least=0, default=0.0, kw_only=True)
    latency: Number = field(
        "Time from a sample to the change of the values",
        unit="s",
        least=0,
        default=0.0,
        kw_only=True,
    )
    jitter: Number = field(
        "Largest delay of a sample, random with equal probability of all delays up to it",
        unit="s",
        least=0,
        default=0.0,
        kw_only=True,
    )
    seed: Whole = field(
        "Seed: with the same one, delays are the same", least=0, default=0, kw_only=True
    )

    if TYPE_CHECKING:

        @property
        def period(self) -> Any:
            """Sampling period, s."""

    @property
    def values(self) -> Mapping[str, float]:
        """Values before the first sample, by name."""
        raise NotImplementedError

    def next_values(self, x: Mapping[str, Expression]) -> Mapping[str, Any]:
        """Return the values from a sample on, from those of the sample before."""
        raise NotImplementedError

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a latency and a jitter that do not end before the next sample."""
        late = self.latency + self.jitter
        if self.period is not None and late >= self.period:
            text = f"latency and jitter are {late:g} s, must be less than the period of "
            problems.add(where, f"{text}{self.period:g} s", "latency" if self.latency else "jitter")

    def _ahead(self, name: str) -> str:
        """Name of a value that is computed and not yet seen by others."""
        return f"next {name}" if self.latency else name

    @property
    def memories(self) -> Mapping[str, float]:
        """Values that others see, and with a latency those that are computed."""
        computed = {self._ahead(name): x for name, x in self.values.items()}
        return {**self.values, **computed}

    @property
    def changes(self) -> Sequence[tuple[Sequence[str], float]]:
        """The computed values change at a sample, and what others see after the latency."""
        names = tuple(self.values)
        seen = ((names, self.latency),) if self.latency else ()
        return (*seen, (tuple(map(self._ahead, names)), 0.0))

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the next values."""
        made = self.next_values({name: x[self._ahead(name)] for name in self.values})
        updates = {self._ahead(name): one for name, one in made.items()}
        if self.latency:
            updates |= {name: x[self._ahead(name)] for name in self.values}
        return Equations(updates=updates)


class Sampled(Ticking, tag="sampled"):
    """Values that change at the times ``phase + k period`` only, and are constant between them.

    At a sample all values follow at once from the values before it and from the inputs, by their
    formulas. Steps end at the samples. Outputs of other blocks and coordinates are read before
    events of the same time act.

    Examples
    --------
    >>> from jousto import Prismatic, RigidBody, ground
    >>> from jousto.mechanism import Sampled, rate
    >>> cart = RigidBody("cart", 2.0, (0.1, 0.1, 0.1))
    >>> rail = Prismatic("rail", ground["origin"], cart["origin"], axis=(1, 0, 0))
    >>> control = Sampled(
    ...     "control",
    ...     0.02,
    ...     {"u": 0.0},
    ...     {"u": "-800*x - 60*v"},
    ...     inputs={"x": rail.displacement, "v": rate(rail.displacement)},
    ... )
    >>> print(control["u"])
    control.u
    """

    kind = "sampled block"
    period: Positive = field("Time between samples", unit="s")
    initial: FormulasField = field("Values before the first sample, by name", numbers=True)
    updates: FormulasField = field("Values from a sample on, by name")
    inputs: FormulasField = field("Inputs by name", default=None, kw_only=True)
    _made: Any = kept()

    def consistent(self, problems: Problems, where: str) -> None:
        """Report unknown names and formulas that are not valid."""
        super().consistent(problems, where)
        object.__setattr__(self, "inputs", self.inputs or {})
        if not self.initial:
            problems.add(where, "has no values", "initial")
        names = {name: Expression("state", of=(self, self._ahead(name))) for name in self.initial}
        for name, given in self.inputs.items():
            if name in names:
                problems.add(where, f"{name!r} is a value and an input", "inputs")
            names[name] = as_formula(problems, where, f"input {name!r}", given, {})
        made = {}
        for name, given in self.updates.items():
            if name not in self.initial:
                text = f"updates has no value {name!r}{suggest(name, self.initial)}"
                problems.add(where, text, "updates")
            made[name] = as_formula(problems, where, f"update of {name!r}", given, names)
        object.__setattr__(self, "_made", made)

    @classmethod
    def from_system(
        cls, name: str, system: Any, *inputs: Any, initial: Any = None, **times: Any
    ) -> Sampled:
        """Return a sampled linear system of python-control or `scipy.signal`.

        Its values are ``y``, or ``y1``, ``y2`` and so on, and the states ``x1``, ``x2`` and so on
        of the next sample.

        Parameters
        ----------
        name : str
            Name of the block.
        system : object
            Object with the attributes ``A, B, C, D`` or ``num, den``, and the period ``dt``, s.
        *inputs : Expression, Coordinate, Signal, float or str
            Inputs of the system.
        initial : (n,) array_like, optional
            States at the first sample; zeros if not given.
        **times
            `phase`, `latency`, `jitter` and `seed`, as for the class.

        Raises
        ------
        InputError
            If the object is no sampled linear system, or has another number of inputs.
        """
        where = f"sampled block {name!r}"
        (A, B, C, D), period = matrices_of(system)
        problems = Problems()
        given = {f"u{i + 1}": one for i, one in enumerate(inputs)}
        if not period:
            problems.add(where, "the system is continuous; take States.from_system")
        if len(given) != B.shape[1]:
            problems.add(where, f"the system has {B.shape[1]} inputs, {len(given)} are given")
        first = np.zeros(len(A)) if initial is None else np.ravel(initial)
        if len(first) != len(A):
            problems.add(where, f"the system has {len(A)} states, {len(first)} initial values")
        problems.raise_if_any()
        states = [f"x{i + 1}" for i in range(len(A))]
        outputs = ["y"] if len(C) == 1 else [f"y{i + 1}" for i in range(len(C))]
        terms = [Expression("named", of=(name, one)) for one in states]
        terms += [as_formula(problems, where, key, one, {}) for key, one in given.items()]
        problems.raise_if_any()
        rows = linear(np.vstack([np.hstack([A, B]), np.hstack([C, D])]), terms)
        start = dict(zip(states, first.tolist(), strict=True)) | dict.fromkeys(outputs, 0.0)
        updates = dict(zip([*states, *outputs], rows, strict=True))
        return cls(name, period, start, updates, **times)

    @property
    def values(self) -> Mapping[str, float]:
        """Values before the first sample."""
        return self.initial

    def next_values(self, x: Mapping[str, Expression]) -> Mapping[str, Any]:
        """Return the values of the formulas."""
        return self._made  # type: ignore[no-any-return]
