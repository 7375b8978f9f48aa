"""Optimisation problems of model files: limits in text become `Limit` objects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem as Trouble, suggest
from jousto.base.expressions import Quantity
from jousto.design.optimisation.cost import read_price
from jousto.design.optimisation.limits import (
    DisplacementLimit,
    FrequencyLimit,
    LifeLimit,
    Limit,
    StressLimit,
)
from jousto.design.optimisation.machine import MachineProblem
from jousto.design.studies.outcomes.deflection import Deflection
from jousto.design.studies.outcomes.outcomes import Damage, Frequency, Stress
from jousto.design.studies.outcomes.requirement import Requirement, read_requirement
from jousto.design.studies.parameters.parameter import Parameter
from jousto.model.compile import compile
from jousto.simulation.modes.linear import modes

KINDS = "stress, deflection, frequency, life and damage"
WHERE = "optimise"


class FileProblem(MachineProblem):
    """Optimisation of a model file by its parameters with bounds; see `file_problem`."""

    def frequencies(self, x: Array) -> Array:
        """Return the natural frequencies at the start, Hz, as outcome ``frequency`` counts them."""
        machine = next(iter(self.machines(x).values()))
        return np.asarray(modes(compile(machine)).frequencies)


@explained
def file_problem(
    file: Any,
    limits: Sequence[str | Requirement] | str | None = None,
    *,
    cost: str = "mass",
    parameters: Sequence[Parameter] | None = None,
    t_end: float | None = None,
) -> FileProblem:
    """Return the optimisation problem of a model file: its parameters with bounds are the design.

    Parameters
    ----------
    file : ModelFile
        Model file from `read_model`.
    limits : sequence of str, optional
        ``"stress(boom) <= 160 MPa"``, ``"deflection(boom, end, start) <= 20 mm"``, ``"frequency(1)
        >= 5 Hz"``, ``"life(boom) >= 1000 h"`` or damage of a check; the limits of the file by
        default. Bounds are numbers that do not depend on the design.
    cost : str
        Cost to minimise: ``"mass"`` of everything that moves, ``"mass(boom)"``, another outcome
        that needs no run, or an expression of parameters, ``"2 * width + height"``.
    parameters : sequence of Parameter, optional
        Parameters instead of those of the file; only those with bounds are varied.
    t_end : float, optional
        End of the runs, s; it has precedence over that of the file.

    Returns
    -------
    FileProblem
        For `optimise`.

    Raises
    ------
    InputError
        If a limit is impossible with static loads, the cost needs runs, or no parameter has bounds.

    Examples
    --------
    >>> from jousto.schema.read import parse_model
    >>> file = parse_model('''
    ... parameters: {h: {value: 30 mm, bounds: [5 mm, 100 mm]}}
    ... parts:
    ...   rod:
    ...     type: beam
    ...     length: 1 m
    ...     section: {type: rectangle, width: 20 mm, height: "${h}"}
    ...     material: S355
    ...     elements: 2
    ...     reduce: {type: craig-bampton, interfaces: [start, end], modes: 0}
    ... bodies: [{name: arm, part: rod, damping: 0.05}]
    ... joints: [{type: fixed, name: clamp, a: ground.origin, b: arm.start}]
    ... simulation: {t_end: 0.1}
    ... ''')
    >>> file_problem(file, "frequency(1) >= 20 Hz")
    <FileProblem: 1 parameter, 1 limit>
    """
    variants = getattr(file, "variants", None)
    if variants is None:
        raise InputError(Trouble(WHERE, "file must be a model file from jo.read_model(path)"))
    every = tuple(file.parameters if parameters is None else parameters)
    chosen = [p for p in every if p.bounds is not None]
    if not chosen:
        message = "no parameter has bounds, such as {value: 4 mm, bounds: [2 mm, 8 mm]}"
        raise InputError(Trouble(WHERE, message))
    end = t_end if file.simulation is None or t_end is not None else file.simulation.t_end
    if end is None:
        message = "no end time: give t_end, or simulation: {t_end: ...} in the file"
        raise InputError(Trouble(WHERE, message))
    fixed = {p.name: p.value for p in every if p.bounds is None}
    given = [limits] if isinstance(limits, str) else limits
    texts = file.limits if given is None else given
    required = [read_requirement(one) if isinstance(one, str) else one for one in texts]
    troubles: list[Trouble] = []
    made: list[Limit] = []
    known = {p.name: Quantity(p.value, p.exponents) for p in every}
    for one in required:
        try:
            made.append(_limit(one, known, [p.name for p in chosen], file, end))
        except InputError as error:
            troubles += error.problems
    try:
        price = read_price(cost, file, every)
    except InputError as error:
        troubles += error.problems
    if troubles:
        raise InputError(troubles)
    kept: dict[Any, Any] = {}
    run = file.simulation
    found = FileProblem(
        chosen,
        lambda values: variants.parts({**fixed, **values}),
        lambda values, parts: variants.make({**fixed, **values}, kept)[0],
        made,
        end,
        solver=None if run is None else run.solver,
        output_step=None if run is None else run.output_step,
        state=None if run is None else run.begin,
        cost=lambda values, parts: price({**fixed, **values}, parts),
    )
    found.rigid = None if file.optimisation is None else file.optimisation.rigid
    return found


def _limit(
    one: Requirement, known: Mapping[str, Quantity], design: Sequence[str], file: Any, end: float
) -> Limit:
    """Return the limit of a requirement.

    Raises
    ------
    InputError
        If the limit is impossible with equivalent static loads.
    """
    where = f"limit {one.text!r}"
    outcome = one.outcome
    moving = one.names(dict.fromkeys(design, 0))
    if moving:
        message = f"its bound depends on {', '.join(moving)}, which the optimisation varies"
        raise InputError(Trouble(where, message))
    above = isinstance(outcome, Frequency) or (isinstance(outcome, Damage) and outcome.life)
    if one.below is above:
        raise InputError(Trouble(where, f"must be {'>=' if above else '<='}"))
    if isinstance(outcome, Stress):
        sites = (outcome.site,) if outcome.site else None
        return StressLimit(outcome.body, one.value(known, "Pa"), sites=sites)
    if isinstance(outcome, Deflection):
        bound = one.value(known, "m")
        return DisplacementLimit(outcome.body, bound, outcome.node, relative_to=outcome.seen_from)
    if isinstance(outcome, Frequency) and not outcome.rest:
        return FrequencyLimit(one.value(known, "Hz"), outcome.number)
    if isinstance(outcome, Damage):
        return _life(one, outcome, known, file, end)
    message = f"an optimisation limits {KINDS}; {one.left} is none of these"
    raise InputError(Trouble(where, message))


def _life(
    one: Requirement, outcome: Damage, known: Mapping[str, Quantity], file: Any, end: float
) -> Limit:
    """Return the limit on life or damage of a fatigue check in the file."""
    where = f"limit {one.text!r}"
    checks = () if file.fatigue is None else file.fatigue.checks
    check = next((c for c in checks if outcome.check_name in (c.name, c.body)), None)
    if check is None:
        tail = suggest(outcome.check_name, [c.name for c in checks])
        raise InputError(Trouble(where, f"no check {outcome.check_name!r} under fatigue{tail}"))
    others = set(check.options) - {"criterion", "mean", "required"}
    if check.residue != "repeat" or others:
        what = f"{', '.join(sorted(others))}" if others else f"residue {check.residue}"
        message = f"an optimisation supports residue repeat and a plain S-N curve only, not {what}"
        raise InputError(Trouble(where, message))
    repeats = one.value(known, "s") / end if outcome.life else 1.0 / one.value(known, "1")
    options = {k: v for k, v in check.options.items() if k != "required"}
    sites = None if check.sites is None else tuple(map(str, check.sites))
    return LifeLimit(check.body, repeats, check.sn, sites=sites, **options)
