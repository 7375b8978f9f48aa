"""Hydraulic network: a block whose equations its elements write."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jousto.base.errors import InputError, Problem, Problems, suggest, warn
from jousto.base.fields import Choice, Flag, Item, field, kept
from jousto.base.numbers import Number
from jousto.mechanism.hydraulics.accumulator import Accumulator
from jousto.mechanism.hydraulics.circuit import Circuit, constant
from jousto.mechanism.hydraulics.element import ElementsField, HydraulicElement
from jousto.mechanism.hydraulics.hose import Hose
from jousto.mechanism.hydraulics.nodes import FlowSource, Node, Supply, Tank
from jousto.mechanism.hydraulics.oil import Oil
from jousto.mechanism.hydraulics.pressure_valves import ReliefValve
from jousto.mechanism.states.block import Block, Equations
from jousto.mechanism.states.expression import Expression

FLOWS = ("volume", "mass")
IN_BAR = ("setting", "cutoff", "precharge", "burst", "most", "start")
"""Fields of pressures that are hardly ever below a few bar."""
LEAST_IN_PASCAL = 1000.0
"""Pressure, Pa, below which, from 1 on, a value is taken for one in bar."""


class HydraulicNetwork(Block, tag="hydraulics"):
    """Nodes and elements with ports, the oil between them, and forces on bodies.

    All pressures are gauge pressures, Pa. Outputs are the pressure of each node by its name, the
    volume of vapour ``node_vapour``, the flows, forces and heats of the elements, such as
    ``lift_force`` and ``valve_heat``, and ``supplied_power = mechanical_power + heat_power +
    stored_power``.

    Examples
    --------
    >>> from jousto.hydraulics import HydraulicNetwork, Node, Orifice, Supply, Tank
    >>> oil = HydraulicNetwork(
    ...     "oil",
    ...     [
    ...         Supply("pump", 10e6),
    ...         Node("line", 1e-3),
    ...         Tank("tank"),
    ...         Orifice("inlet", "pump", "line", flow=40e-3 / 60),
    ...         Orifice("outlet", "line", "tank", flow=40e-3 / 60),
    ...     ],
    ... )
    >>> print(oil["line"])
    oil.line
    """

    kind = "hydraulics"
    elements: ElementsField = field("Nodes, tanks, cylinders, valves, pumps and other elements")
    oil: Item[Oil] = field("The oil", default=Oil(), kw_only=True)
    flow: Choice = field(
        "Whether the oil of a node is counted by volume, or by mass, which is then conserved",
        words=FLOWS,
        default="volume",
        kw_only=True,
    )
    transition: Number = field(
        "Pressure drop below which flow through edges is laminar", unit="Pa", above=0, default=1e4,
        kw_only=True,
    )  # fmt: skip
    book: Flag = field(
        "Whether works are integrated: supplied_work, mechanical_work, heat_work, stored_work",
        default=False,
        kw_only=True,
    )
    _circuit: Any = kept()

    def consistent(self, problems: Problems, where: str) -> None:
        """Connect the elements; report ports without node, nodes without volume and the like."""
        places = {one.name: one for one in self.elements if one.own}
        seen = set[str]()
        for one in self.elements:
            if one.name in seen:
                problems.add(where, f"has two elements {one.name!r}; give each its own name")
            seen.add(one.name)
            for port, to in one.ports.items():
                if to not in places:
                    text = f"{port} of {one.kind} {one.name!r} is {to!r}, which is no node, tank or"
                    hint = f"{suggest(to, places)}; or add Node({to!r}, volume)"
                    problems.add(where, f"{text} supply{hint}")
        used = {to for one in self.elements for to in one.ports.values()}
        for name, place in places.items():
            if name not in used:
                problems.add(where, f"nothing is connected to {place.kind} {name!r}; remove it")
        if not problems.found or not any(p.where == where for p in problems.found):
            self._connect(problems, where)

    def _connect(self, problems: Problems, where: str) -> None:
        nodes = {one.name: one.start for one in self.elements if isinstance(one, Node)}
        given = {one.name: one.pressure for one in self.elements if isinstance(one, Tank | Supply)}
        self._check_sources(problems, where)

        def refer(kind: str, name: str) -> Expression:
            return Expression(kind, of=(self, name))

        made = Circuit(refer, self.oil, self.transition, self.flow == "mass", given, nodes)
        for one in self.elements:
            one.check_with(problems, f"{where}: {one.kind} {one.name!r}", made)
            one.connect(made)
        self._check_limits(problems, where, made)
        for name, at in made.nodes.items():
            if not at.least > 0.0:
                text = f"node {name!r} has the volume {at.least:g} m3 at an end of the strokes"
                problems.add(where, f"{text}, must be positive; give it the volume of its lines")
        if not problems.found:
            self._warn_of_bar(where)
            made.finish(self.book)
            for name in made.starts:
                if name in made.outputs:
                    problems.add(where, f"{name!r} is both a node and a quantity of another "
                                 "element; rename one")  # fmt: skip
        object.__setattr__(self, "_circuit", made)
        object.__setattr__(self, "outputs", tuple(made.outputs))

    def _check_limits(self, problems: Problems, where: str, made: Circuit) -> None:
        """Report pressures at the start and relief valves above what an element bears."""
        reliefs = [one for one in self.elements if isinstance(one, ReliefValve)]
        for element, most, ports in made.limits:
            end = f"the burst pressure {most:g} Pa of {element.kind} {element.name!r}"
            for port in ports:
                start = made.start_of(port)
                if start > most:
                    problems.add(where, f"{port!r} starts at {start:g} Pa, above {end}; lower it")
            for one in reliefs:
                opens = constant(one.setting)
                if one.a in ports and opens is not None and opens > most:
                    text = f"{one.kind} {one.name!r} opens at {opens:g} Pa, above {end}"
                    problems.add(where, f"{text}; lower its setting")

    def _warn_of_bar(self, where: str) -> None:
        """Warn of pressures that seem to be in bar."""
        for one in self.elements:
            for key, kind in one.fields.items():
                given = getattr(one, key) if key in IN_BAR or isinstance(one, Supply) else None
                p = None if kind.unit != "Pa" or given is None else constant(given)
                if p is not None and 1 <= p < LEAST_IN_PASCAL:
                    text = f"{key} of {one.kind} {one.name!r} is {p:g} Pa"
                    warn(where, f"{text}, which is very low; write {p * 1e5:g} for {p:g} bar")

    def _check_sources(self, problems: Problems, where: str) -> None:
        kinds = [type(one) for one in self.elements]
        if (Supply in kinds or FlowSource in kinds) and Tank not in kinds:
            problems.add(where, "has a supply but no tank; add Tank('tank') and lead oil to it")
        oil = self.oil
        if self.flow == "mass" and (oil.air or {Accumulator, Hose} & set(kinds)):
            text = "flow 'mass' is not available with free air, accumulators or hoses"
            problems.add(where, f"{text}; take flow='volume'")

    @property
    def cylinders(self) -> tuple[HydraulicElement, ...]:
        """Its cylinders."""
        return tuple(one for one in self.elements if one.kind == "cylinder")

    @property
    def starts(self) -> Mapping[str, float]:
        """Initial values of the states."""
        found: Mapping[str, float] = self._circuit.starts
        return found

    @property
    def starts_in_pose(self) -> bool:
        """Whether the masses of oil at the start are those of chambers in the declared pose."""
        return self.flow == "mass" and bool(self._circuit.forces)

    @property
    def nominals(self) -> Mapping[str, float]:
        """Sizes of the states."""
        found: Mapping[str, float] = self._circuit.sizes
        return found

    @property
    def fastest(self) -> Mapping[str, float]:
        """Largest rates of the states by name, 1/s: edges fully open at no pressure drop."""
        return {f"{self.name}.{name}": rate for name, rate in self._circuit.fastest.items()}

    @property
    def openings(self) -> Mapping[str, Expression]:
        """Ways of the valves that pressures open, 0 to 1, by what they are called in messages."""
        found: Mapping[str, Expression] = self._circuit.openings
        return found

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the equations of the circuit."""
        made = self._circuit
        return Equations(made.rates, made.outputs, made.forces)

    def element(self, name: str) -> HydraulicElement:
        """Return the element of a name.

        Raises
        ------
        InputError
            If there is none.
        """
        known = {one.name: one for one in self.elements}
        if name not in known:
            text = f"has no element {name!r}{suggest(name, known)}"
            raise InputError(Problem(f"hydraulics {self.name!r}", text))
        found: HydraulicElement = known[name]
        return found
