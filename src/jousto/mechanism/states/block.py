"""Blocks: first-order states of a machine with their equations, outputs and forces."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field as keep
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from jousto.base.declare import Declared
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.fields import Name, field, kept
from jousto.base.object_repr import described
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.signals.base import Signal
from jousto.mechanism.states.expression import Expression, leaves_of, linear
from jousto.mechanism.states.inputs import FormulasField, as_expression, as_formula
from jousto.mechanism.states.state_space import matrices_of


@described
@dataclass(eq=False)
class Equations:
    """Equations of a block: rates of its states, outputs, and forces along coordinates.

    Attributes
    ----------
    rates, outputs : dict of str to Expression
        Rates of all states, 1/s times their units, and outputs by name.
    forces : list of (Coordinate, Expression)
        Forces along coordinates, N or N m.
    updates : dict of str to Expression
        Values of the memories from the end of a step or from a sample on.
    margin : Expression, optional
        Expression that is positive; where it would become negative, a step ends.
    delayed : Expression, optional
        Expression whose value the block delays by its `time`.
    """

    rates: dict[str, Any] = keep(default_factory=dict)
    outputs: dict[str, Any] = keep(default_factory=dict)
    forces: list[tuple[Coordinate, Any]] = keep(default_factory=list)
    updates: dict[str, Any] = keep(default_factory=dict)
    margin: Any = None
    delayed: Any = None

    @property
    def roots(self) -> tuple[Any, ...]:
        """All expressions."""
        some = *self.rates.values(), *self.outputs.values(), *(f for _, f in self.forces)
        others = (one for one in (self.margin, self.delayed) if one is not None)
        return (*some, *self.updates.values(), *others)


class Block(Declared, section="states"):
    """Base of the blocks: states x' = f(t, s, s', x), outputs, and forces along coordinates.

    A block is declared by its fields, its `starts`, and its `equations` in terms of expressions.
    ``block["name"]`` is a state or an output, for other blocks, sensors and forces.
    """

    kind = "block"
    symbol: ClassVar[str] = ""
    """Name of the symbol in pictures; empty for none."""
    name: Name = field("Unique among the blocks")

    @property
    def starts(self) -> Mapping[str, float]:
        """Initial values of the states by name."""
        return {}

    @property
    def nominals(self) -> Mapping[str, float]:
        """Sizes of states that count as 1 for error control, by name; others have 1."""
        return {}

    @property
    def memories(self) -> Mapping[str, float]:
        """Initial values of what is constant within a step, by name."""
        return {}

    jumps: ClassVar[bool] = False
    """Whether outputs jump with the memories."""

    if TYPE_CHECKING:

        @property
        def outputs(self) -> Any:
            """Names of the outputs; a class attribute, a property or a field."""

        @property
        def period(self) -> Any:
            """Sampling period of the memories, s; 0: they change at the end of each step."""

        @property
        def phase(self) -> Any:
            """Time of the first sample, s."""

        @property
        def jitter(self) -> Any:
            """Largest random delay of a sample, s."""

        @property
        def seed(self) -> Any:
            """Seed of the random delays."""

    else:
        outputs, period, phase, jitter, seed = (), 0.0, 0.0, 0.0, 0

    @property
    def changes(self) -> Sequence[tuple[Sequence[str], float]]:
        """Groups of memories that change together, and their delay after the sample, s."""
        return ((tuple(self.memories), 0.0),) if self.memories else ()

    @property
    def drawn_at(self) -> tuple[Any, ...]:
        """Markers, and points of bodies (body frame, m), at which pictures show the symbol."""
        return ()

    @property
    def cylinders(self) -> tuple[Any, ...]:
        """Hydraulic cylinders, which pictures show with the pressures of their chambers."""
        return ()

    @property
    def fastest(self) -> Mapping[str, float]:
        """Largest rates of quantities by name, 1/s, where the block has bounds of them."""
        return {}

    @property
    def openings(self) -> Mapping[str, Expression]:
        """Openings from 0 to 1 that steps have to follow, by name."""
        return {}

    @property
    def starts_in_pose(self) -> bool:
        """Whether initial values of states are those of the declared pose only."""
        return False

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the equations with the states x by name."""
        raise NotImplementedError

    def __getitem__(self, name: str) -> Expression:
        """Return a state or an output as an expression."""
        if name in self.starts or name in self.memories:
            return Expression("state", of=(self, name))
        if name in self.outputs:
            return Expression("output", of=(self, name))
        known = (*self.starts, *self.memories, *self.outputs)
        raise InputError(
            Problem(f"{self.kind} {self.name!r}", f"has no {name!r}{suggest(name, known)}")
        )

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates on which the block depends, and along which it pushes."""
        made = self.checked()
        found = {c.key: c for c, _ in made.forces}
        for one in leaves_of(made.roots):
            if one.operation in ("value", "rate"):
                found.setdefault(one.of.key, one.of)
        return tuple(found.values())

    @property
    def signals(self) -> tuple[Signal, ...]:
        """Signals of time on which the block depends."""
        roots = self.checked().roots
        return tuple(one.of for one in leaves_of(roots) if one.operation == "signal")

    def checked(self) -> Equations:
        """Return the equations as expressions, or report what does not fit the declaration.

        Raises
        ------
        InputError
            If a rate is missing, or a rate, output or force is no expression.
        """
        problems = Problems()
        where = f"{self.kind} {self.name!r}"
        made = self.equations({name: self[name] for name in (*self.starts, *self.memories)})
        done = Equations()
        for what, given, wanted, into in (
            ("rate", made.rates, tuple(self.starts), done.rates),
            ("output", made.outputs, self.outputs, done.outputs),
            ("next value", made.updates, tuple(self.memories), done.updates),
        ):
            for name in given:
                if name not in wanted:
                    problems.add(where, f"has a {what} of {name!r}{suggest(name, wanted)}")
            for name in wanted:
                if name not in given:
                    problems.add(where, f"has no {what} of {name!r}")
                else:
                    into[name] = as_expression(problems, where, f"{what} of {name!r}", given[name])
        for coordinate, force in made.forces:
            found = as_expression(problems, where, f"force along {coordinate.name!r}", force)
            done.forces.append((coordinate, found))
        if made.margin is not None:
            done.margin = as_expression(problems, where, "margin", made.margin)
        if made.delayed is not None:
            done.delayed = as_expression(problems, where, "input", made.delayed)
        problems.raise_if_any()
        return done


class States(Block, tag="states"):
    """States x' = f with equations of the user, their outputs, and forces along coordinates.

    Rates, outputs and forces are formulas of states and inputs by name, as text or as expressions
    (see `from_rule`). The engine evaluates them, with exact derivatives, in every method. Inputs
    are signals of time, coordinates, expressions, or ``"block.name"`` for a state or an output of
    another block.

    Examples
    --------
    >>> from jousto import Revolute, RigidBody, ground
    >>> from jousto.mechanism import States, rate
    >>> wheel = RigidBody("wheel", 1.0, (0.01, 0.01, 0.02))
    >>> axle = Revolute("axle", ground["origin"], wheel["origin"])
    >>> motor = States(
    ...     "motor",
    ...     {"current": 0.0},
    ...     {"current": "(voltage - 2*current - 0.1*speed)/0.01"},
    ...     inputs={"voltage": 12.0, "speed": rate(axle.angle)},
    ...     forces={axle.angle: "0.1*current"},
    ... )
    >>> print(motor["current"])
    motor.current
    """

    kind = "states"
    initial: FormulasField = field("Initial values of the states by name", numbers=True)
    rates: FormulasField = field("Rates of the states by name, their unit per second")
    outputs: FormulasField = field("Outputs by name", default=None, kw_only=True)
    inputs: FormulasField = field("Inputs by name", default=None, kw_only=True)
    forces: FormulasField = field(
        "Forces by coordinates, N or N m", default=None, kw_only=True, along=True
    )
    sizes: FormulasField = field(
        "Sizes of states for the error control of DormandPrince, by name; 1 for others",
        default=None,
        kw_only=True,
        numbers=True,
    )
    _made: Any = kept()

    def consistent(self, problems: Problems, where: str) -> None:
        """Report unknown names and formulas that are not valid."""
        empty = {key: getattr(self, key) or {} for key in ("outputs", "inputs", "forces", "sizes")}
        for key, value in empty.items():
            object.__setattr__(self, key, value)
        names = {name: Expression("state", of=(self, name)) for name in self.initial}
        for name, given in self.inputs.items():
            if name in names:
                problems.add(where, f"{name!r} is a state and an input", "inputs")
            names[name] = as_formula(problems, where, f"input {name!r}", given, {})
        for name in self.sizes:
            if name not in self.initial:
                problems.add(where, f"sizes has no state {name!r}{suggest(name, self.initial)}")
        made = Equations()
        for key, what, into in (
            ("rates", "rate of", made.rates),
            ("outputs", "output", made.outputs),
        ):
            for name, given in getattr(self, key).items():
                into[name] = as_formula(problems, where, f"{what} {name!r}", given, names)
        for coordinate, given in self.forces.items():
            label = f"force along {coordinate.name!r}"
            made.forces.append((coordinate, as_formula(problems, where, label, given, names)))
        for name in made.outputs:
            if name in self.initial:
                problems.add(where, f"{name!r} is a state and an output", "outputs")
        object.__setattr__(self, "_made", made)
        object.__setattr__(self, "outputs", dict(made.outputs))

    @classmethod
    def from_rule(
        cls,
        name: str,
        rule: Callable[..., Any],
        initial: Mapping[str, float],
        inputs: Mapping[str, Any] | None = None,
        sizes: Mapping[str, float] | None = None,
    ) -> States:
        """Return states whose equations a function writes.

        Parameters
        ----------
        name : str
            Name of the block.
        rule : callable
            Function of the states and the inputs, both dicts of expressions by name, called once.
            It returns the rates, or rates and outputs, or rates, outputs and forces, as dicts.
        initial, inputs, sizes : mapping
            As for the class.

        Raises
        ------
        InputError
            If the rule asks for an unknown name or returns something else.
        """
        where = f"states {name!r}"
        problems = Problems()
        given = {
            key: as_formula(problems, where, f"input {key!r}", one, {})
            for key, one in dict(inputs or {}).items()
        }
        problems.raise_if_any()
        x = {key: Expression("named", of=(name, key)) for key in initial}
        try:
            made = rule(x, given)
        except KeyError as error:
            asked = str(error.args[0])
            text = f"the rule asks for {asked!r}{suggest(asked, (*x, *given))}"
            raise InputError(Problem(where, text)) from None
        parts = made if isinstance(made, tuple) else (made,)
        if len(parts) > 3 or not all(isinstance(part, Mapping) for part in parts):
            text = f"the rule returns {made!r}, must return dicts of rates, outputs and forces"
            raise InputError(Problem(where, text))
        rates, outputs, forces = (*parts, {}, {})[:3]
        return cls(name, initial, rates, outputs=outputs, forces=forces, sizes=sizes)

    @classmethod
    def from_system(
        cls, name: str, system: Any, *inputs: Any, initial: Any = None, size: float = 1.0
    ) -> States:
        """Return a linear system of python-control or `scipy.signal` as states.

        Its states are ``x1``, ``x2`` and so on, in the order of the system; its outputs ``y``, or
        ``y1``, ``y2`` and so on.

        Parameters
        ----------
        name : str
            Name of the block.
        system : object
            Object with the attributes ``A, B, C, D`` or ``num, den``, and ``dt``.
        *inputs : Expression, Coordinate, Signal, float or str
            Inputs of the system.
        initial : (n,) array_like, optional
            Initial values of the states; zeros if not given.
        size : float
            Size of the states for the error control of DormandPrince.

        Raises
        ------
        InputError
            If the object is no linear system, differentiates its input, is sampled, or has
            another number of inputs.
        """
        where = f"states {name!r}"
        (A, B, C, D), period = matrices_of(system)
        problems = Problems()
        terms = [
            as_formula(problems, where, f"input {i + 1}", one, {}) for i, one in enumerate(inputs)
        ]
        if period:
            text = f"the system is sampled every {period:g} s; take Sampled.from_system"
            problems.add(where, text)
        if len(terms) != B.shape[1]:
            text = f"the system has {B.shape[1]} inputs, {len(terms)} are given"
            problems.add(where, text)
        start = np.zeros(len(A)) if initial is None else np.ravel(initial)
        if len(start) != len(A):
            problems.add(where, f"the system has {len(A)} states, {len(start)} initial values")
        problems.raise_if_any()
        names = [f"x{i + 1}" for i in range(len(A))]
        terms = [*(Expression("named", of=(name, one)) for one in names), *terms]
        rates = linear(np.hstack([A, B]), terms)
        y = linear(np.hstack([C, D]), terms)
        made = {"y": y[0]} if len(y) == 1 else {f"y{i + 1}": one for i, one in enumerate(y)}
        first = dict(zip(names, start, strict=True))
        sizes = dict.fromkeys(names, size)
        return cls(name, first, dict(zip(names, rates, strict=True)), outputs=made, sizes=sizes)

    @property
    def starts(self) -> Mapping[str, float]:
        """Initial values of the states by name."""
        return self.initial

    @property
    def nominals(self) -> Mapping[str, float]:
        """Sizes of states for error control."""
        return self.sizes

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the equations of the fields."""
        return self._made  # type: ignore[no-any-return]
