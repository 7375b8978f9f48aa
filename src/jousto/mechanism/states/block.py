"""Blocks: first-order states of a machine with their equations, outputs and forces."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field as keep
from typing import Any

from jousto.base.declare import Declared
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.fields import Field, Name, field, kept
from jousto.base.numbers import number
from jousto.base.object_repr import described
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.signals.base import Signal
from jousto.mechanism.states.expression import Expression, expression, leaves_of
from jousto.mechanism.states.formula import FormulaError, formula


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
    """

    rates: dict[str, Any] = keep(default_factory=dict)
    outputs: dict[str, Any] = keep(default_factory=dict)
    forces: list[tuple[Coordinate, Any]] = keep(default_factory=list)


class Block(Declared, section="states"):
    """Base of the blocks: states x' = f(t, s, s', x), outputs, and forces along coordinates.

    A block is declared by its fields, its `starts`, and its `equations` in terms of expressions.
    ``block["name"]`` is a state or an output, for other blocks, sensors and forces.
    """

    kind = "block"
    name: Name = field("Unique among the blocks")

    @property
    def starts(self) -> Mapping[str, float]:
        """Initial values of the states by name."""
        return {}

    @property
    def nominals(self) -> Mapping[str, float]:
        """Sizes of states that count as 1 for error control, by name; others have 1."""
        return {}

    outputs: Any = ()
    """Names of the outputs."""

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the equations with the states x by name."""
        raise NotImplementedError

    def __getitem__(self, name: str) -> Expression:
        """Return a state or an output as an expression."""
        if name in self.starts:
            return Expression("state", of=(self, name))
        if name in self.outputs:
            return Expression("output", of=(self, name))
        known = (*self.starts, *self.outputs)
        raise InputError(
            Problem(f"{self.kind} {self.name!r}", f"has no {name!r}{suggest(name, known)}")
        )

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates on which the block depends, and along which it pushes."""
        made = self.checked()
        found = {c.key: c for c, _ in made.forces}
        roots = (*made.rates.values(), *made.outputs.values(), *(f for _, f in made.forces))
        for one in leaves_of(roots):
            if one.operation in ("value", "rate"):
                found.setdefault(one.of.key, one.of)
        return tuple(found.values())

    @property
    def signals(self) -> tuple[Signal, ...]:
        """Signals of time on which the block depends."""
        made = self.checked()
        roots = (*made.rates.values(), *made.outputs.values(), *(f for _, f in made.forces))
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
        made = self.equations({name: self[name] for name in self.starts})
        done = Equations()
        for what, given, wanted, into in (
            ("rate", made.rates, tuple(self.starts), done.rates),
            ("output", made.outputs, self.outputs, done.outputs),
        ):
            for name in given:
                if name not in wanted:
                    problems.add(where, f"has a {what} of {name!r}{suggest(name, wanted)}")
            for name in wanted:
                if name not in given:
                    problems.add(where, f"has no {what} of {name!r}")
                else:
                    into[name] = _as_expression(problems, where, f"{what} of {name!r}", given[name])
        for coordinate, force in made.forces:
            found = _as_expression(problems, where, f"force along {coordinate.name!r}", force)
            done.forces.append((coordinate, found))
        problems.raise_if_any()
        return done


class FormulasField(Field["Mapping[Any, Any] | None", "dict[Any, Any]"]):
    """Field of formulas or numbers by name, or by coordinate.

    Parameters
    ----------
    text, default, kw_only
        As for every field.
    numbers : bool
        Whether the values are numbers.
    along : bool
        Whether the keys are coordinates.
    """

    form = "formulas"
    noun = "dict"

    def __init__(
        self, text: str = "", *, numbers: bool = False, along: bool = False, **common: Any
    ) -> None:
        super().__init__(text, **common)
        self.numbers, self.along = numbers, along

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a dict, or report another type and keys or numbers that are invalid."""
        if not isinstance(value, Mapping):
            problems.add(where, f"{self.name} is {value!r}, must be a dict", self.name)
            return {}
        made: dict[Any, Any] = {}
        for key, given in value.items():
            if not isinstance(key, Coordinate if self.along else str):
                what = "coordinates" if self.along else "names"
                problems.add(where, f"{self.name} has the key {key!r}, must have {what}", self.name)
            elif isinstance(key, str) and not key.isidentifier():
                problems.add(where, f"{self.name}: {key!r} is no name of a state", self.name)
            elif self.numbers:
                made[key] = number(problems, where, f"{self.name} of {key!r}", given)
            else:
                made[key] = given
        return made


def _as_expression(problems: Problems, where: str, what: str, given: Any) -> Any:
    found = expression(given)
    if found is None:
        problems.add(
            where, f"{what} is {given!r}, must be an expression of states, inputs, numbers, signals"
        )
    return found


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
            names[name] = _formula(problems, where, f"input {name!r}", given, {})
        for name in self.sizes:
            if name not in self.initial:
                problems.add(where, f"sizes has no state {name!r}{suggest(name, self.initial)}")
        made = Equations()
        for key, what, into in (
            ("rates", "rate of", made.rates),
            ("outputs", "output", made.outputs),
        ):
            for name, given in getattr(self, key).items():
                into[name] = _formula(problems, where, f"{what} {name!r}", given, names)
        for coordinate, given in self.forces.items():
            label = f"force along {coordinate.name!r}"
            made.forces.append((coordinate, _formula(problems, where, label, given, names)))
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
            key: _formula(problems, where, f"input {key!r}", one, {})
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


def _formula(
    problems: Problems, where: str, what: str, given: Any, names: Mapping[str, Any]
) -> Any:
    """Return an expression, signal, number or formula as an expression, or report it."""
    if not isinstance(given, str):
        return _as_expression(problems, where, what, given)

    def refer(block: str, part: str) -> Expression:
        return Expression("named", of=(block, part))

    try:
        return formula(given, names, refer)
    except FormulaError as error:
        problems.add(where, f"{what}: {error}")
        return Expression("number", of=0.0)
