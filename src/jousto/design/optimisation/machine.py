"""Optimisation problems of machines with flexible bodies of variable dimensions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from jousto.base.arrays import Array, some
from jousto.base.errors import InputError, Problem as Trouble, Problems
from jousto.design.optimisation.elastic import Elastic, Motion
from jousto.design.optimisation.limits import Limit
from jousto.design.optimisation.problem import Problem, forget
from jousto.design.studies.case import Settings
from jousto.design.studies.parameters.parameter import Parameter
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.mechanism import Mechanism
from jousto.model.compile import compile
from jousto.model.model import Model
from jousto.parts.part import Part
from jousto.simulation.modes.linear import modes
from jousto.simulation.results.solution import Solution
from jousto.simulation.running.simulate import simulate
from jousto.simulation.state import State

Machines = Mechanism | Mapping[str, Mechanism]


class MachineProblem(Problem):
    """Optimisation of the dimensions of flexible bodies for the stresses of their motion.

    Parameters
    ----------
    parameters : sequence of Parameter
        Parameters with bounds; their values are the start.
    parts : function
        Returns the `Part` of each body that changes or is limited, by the name of the body, for
        the parameters by name. Static problems need no other function.
    build : function
        Returns the `Mechanism` for the parameters by name and the parts, which the function
        reduces; or one mechanism for each load case by name.
    limits : sequence of Limit
        `StressLimit`, `DisplacementLimit`, `LifeLimit`, `FrequencyLimit`.
    t_end : float
        End of each run, s.
    solver, output_step
        As for `simulate`; with a solver of fixed step the runs change smoothly with the parameters.
    state : State or function, optional
        Initial state of the runs, or a function of the model that returns it:
        `jo.simulation.vibration_free_state`, `jo.equilibrium`.
    cost : function, optional
        Returns the cost to minimise, for the parameters by name and the parts; by default the mass
        of the parts, kg.

    Raises
    ------
    InputError
        If `parts` or `build` return something else.
    """

    def __init__(
        self,
        parameters: Sequence[Parameter],
        parts: Callable[[Mapping[str, float]], Mapping[str, Part]],
        build: Callable[[Mapping[str, float], Mapping[str, Part]], Machines],
        limits: Sequence[Limit],
        t_end: float,
        *,
        solver: Any = None,
        output_step: float | None = None,
        state: State | Callable[[Model], State] | None = None,
        cost: Callable[[Mapping[str, float], Mapping[str, Part]], float] | None = None,
    ) -> None:
        super().__init__(parameters, limits)
        problems = Problems()
        problems.positive("MachineProblem", "t_end", t_end, "s")
        functions: dict[str, Any] = {"parts": parts, "build": build, "cost": cost or mass}
        for key, function in functions.items():
            if not callable(function):
                problems.add("MachineProblem", f"{key} is {function!r}, must be a function")
        begin: Any = state
        if not (begin is None or isinstance(begin, State) or callable(begin)):
            message = f"state is {state!r}, must be a State or a function of the model"
            problems.add("MachineProblem", message)
        problems.raise_if_any()
        self._make, self._build = parts, build
        self._cost, self.t_end = mass if cost is None else cost, float(t_end)
        how = {"solver": solver, "output_step": output_step, "state": state}
        self.settings: dict[str, Any] = how
        self._settings = Settings(t_end, how)
        self._parts: dict[bytes, Mapping[str, Part]] = {}

    def parts(self, x: Array) -> Mapping[str, Part]:
        """Return the part of each body for a design.

        Raises
        ------
        InputError
            If the function returns something else.
        """
        key = x.tobytes()
        if key not in self._parts:
            made: Any = self._make(self.values(x))
            good = isinstance(made, Mapping)
            if not good or not all(isinstance(part, Part) for part in made.values()):
                message = f"parts returns {made!r}, must be a dict of Part by the names of bodies"
                raise InputError(Trouble("MachineProblem", message))
            self._parts[key] = made
            forget(self._parts, len(x))
        return self._parts[key]

    def machines(self, x: Array) -> dict[str, Mechanism]:
        """Return the mechanism of each load case for a design.

        Raises
        ------
        InputError
            If `build` returns something else.
        """
        made: Any = self._build(self.values(x), self.parts(x))
        cases = {"": made} if isinstance(made, Mechanism) else made
        good = isinstance(cases, Mapping) and len(cases) > 0
        if not good or not all(isinstance(one, Mechanism) for one in cases.values()):
            message = f"build returns {made!r}, must be a Mechanism or a dict of them by name"
            raise InputError(Trouble("MachineProblem", message))
        return dict(cases)

    def cost(self, x: Array) -> float:
        """Return the cost of a design."""
        return float(self._cost(self.values(x), self.parts(x)))

    def elastic(self, x: Array) -> tuple[Elastic, ...]:
        """Return the unsupported static models of the flexible bodies."""
        return tuple(Elastic.from_part(name, part) for name, part in self.parts(x).items())

    def frequencies(self, x: Array) -> Array:
        """Return the natural frequencies of the first load case at its start, Hz."""
        machine = next(iter(self.machines(x).values()))
        f = modes(compile(machine)).frequencies
        return np.asarray(f[f > 1e-6 * f.max(initial=0.0)])

    def solutions(self, values: Mapping[str, float]) -> dict[str, Solution]:
        """Return the run of each load case by name (empty name if there is only one).

        Parameters
        ----------
        values : dict of float
            The parameters, such as ``optimum.values``.

        Raises
        ------
        InputError
            If a parameter is missing.
        """
        missing = [name for name in self.names if name not in values]
        if missing:
            raise InputError(Trouble("MachineProblem", f"no value of {some(missing)}"))
        x = self.vector(values)
        return {case: self._simulated(one) for case, one in self.machines(x).items()}

    def settings_for(self, model: Model) -> dict[str, Any]:
        """Return solver, output step and initial state of the runs of a model."""
        return self._settings.given(model)

    def _simulated(self, machine: Mechanism) -> Solution:
        model = compile(machine)
        return simulate(model, self.t_end, **self.settings_for(model))

    def run(self, x: Array) -> tuple[Motion, ...]:
        """Run all load cases and return the deformations."""
        found = []
        for case, machine in self.machines(x).items():
            run = self._simulated(machine)
            bodies = {body.name: body for body in machine.bodies}
            for i, (name, part) in enumerate(self.parts(x).items()):
                y = run.coordinates(name)[:, 7:].T
                shapes = shapes_of(bodies[name], part)
                found.append(Motion(i, case, run.time, shapes, y))
        return tuple(found)


def mass(values: Mapping[str, float], parts: Mapping[str, Part]) -> float:
    """Return the mass of the parts, kg."""
    return float(sum(part.mass for part in parts.values()))


def shapes_of(body: Any, part: Part) -> Array:
    """Return the mode displacements (ndof, n) of a body at its degrees of freedom.

    Raises
    ------
    InputError
        If the body does not consist of that part.
    """
    nn = len(part.nodes)
    if not isinstance(body, FlexibleBody) or len(body.reduced.nodes) < nn:
        message = "build must make it of the part of that name, reduced"
        raise InputError(Trouble(f"body '{body.name}'", message))
    shapes = body.reduced.modes[:nn]
    if part.dofs_per_node == 6:
        assert body.reduced.rotations is not None
        shapes = np.concatenate([shapes, body.reduced.rotations[:nn]], axis=1)
    return np.asarray(shapes.reshape(nn * part.dofs_per_node, -1))
