"""Reliability-based optimisation of a model file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

from jousto.base.arguments import explained
from jousto.base.errors import InputError, Problem as Trouble, Problems
from jousto.design.optimisation.cost import read_price
from jousto.design.reliability.from_study import limit_state
from jousto.design.reliability.targets.rbdo import RbdoResult, rbdo
from jousto.design.studies.outcomes.requirement import Requirement, read_requirement
from jousto.design.studies.parameters.parameter import Parameter
from jousto.design.studies.study import study

WHERE = "reliable design"


@explained
def file_rbdo(
    file: Any,
    limits: Sequence[str | Requirement] | str | None = None,
    *,
    cost: str = "mass",
    parameters: Sequence[Parameter] | None = None,
    target: float | None = None,
    t_end: float | None = None,
    method: Literal["sora", "pma", "ria"] = "sora",
    tolerance: float = 1e-5,
    cycles: int = 50,
) -> RbdoResult:
    """Return the design of least cost of a model file with a reliability index for each limit.

    Parameters with bounds are design variables, those with a distribution are random. A parameter
    with both is random about its design value, with the deviation of its distribution.

    Parameters
    ----------
    file : ModelFile
        Model file from `read_model`.
    limits : sequence of str, optional
        Outcomes with their bounds, ``"max(tip.y) <= 12 mm"``; those of the file by default.
    cost : str
        Cost to minimise, as in `file_problem`, at the means.
    parameters : sequence of Parameter, optional
        Parameters instead of those of the file.
    target : float, optional
        Index of all limits; else ``reliability: {target: ...}`` of the file.
    t_end : float, optional
        End of the runs, s; it has precedence over that of the file.
    method, tolerance, cycles
        As for `rbdo`.

    Returns
    -------
    RbdoResult

    Raises
    ------
    InputError
        If there are no limits, no target, no design variables or no random variables.
    DesignPointError
        If no design within the bounds reaches the target.
    LimitStateError
        If a limit has no value at a point.

    Examples
    --------
    >>> from jousto.schema.read import parse_model
    >>> file = parse_model('''
    ... parameters:
    ...   k: {value: 40 N/m, bounds: [10 N/m, 100 N/m]}
    ...   m: {value: 1 kg, distribution: normal(sd=0.05 kg)}
    ... bodies: [{name: block, mass: "${m}", inertia: [1, 1, 1]}]
    ... joints: [{type: prismatic, name: rail, a: ground.origin, b: block.origin, axis: [1, 0, 0]}]
    ... forces: [{type: spring, name: spring, coordinate: rail.displacement, stiffness: "${k}"}]
    ... ''')
    >>> found = file_rbdo(file, "frequency(1) >= 1 Hz", cost="k", target=2.0)
    >>> round(found.design["k"], 3)  # (2 pi)^2 of a mass two deviations above its mean
    43.426
    """
    if getattr(file, "variants", None) is None:
        raise InputError(Trouble(WHERE, "file must be a model file from jo.read_model(path)"))
    every = tuple(file.parameters if parameters is None else parameters)
    given = [limits] if isinstance(limits, str) else limits
    texts = file.limits if given is None else given
    beta = file.reliability.target if target is None else target
    problems = Problems()
    if not texts:
        problems.add(WHERE, "there are no limits; give some, or limits: [...] in the model file")
    if file.optimisation is not None and file.optimisation.rigid is not None:
        message = "runs the flexible machine only; leave out optimisation: {machine: rigid}"
        problems.add(WHERE, message)
    if beta is None:
        message = "no target index: give target=, or reliability: {target: 3}"
        problems.add(WHERE, message)
    if not any(p.bounds is not None for p in every):
        message = "no parameter has bounds, such as {value: 4 mm, bounds: [2 mm, 8 mm]}"
        problems.add(WHERE, message)
    if not any(p.distribution is not None for p in every):
        message = "no parameter has a distribution, such as {value: 1 kN, distribution: "
        problems.add(WHERE, message + "normal(sd=50 N)}: no parameter is random")
    problems.raise_if_any()
    required = [read_requirement(one) if isinstance(one, str) else one for one in texts]
    price = read_price(cost, file, every)
    outcomes = list({one.outcome.name: one.outcome for one in required}.values())
    made = study(file, list(every), outcomes, t_end=t_end)
    pairs = file.reliability.correlation or None
    states = {one.name: limit_state(made, one, correlation=pairs) for one in required}
    nominal = {p.name: p.value for p in every}

    def least(d: Any) -> float:
        values = {**nominal, **{name: float(d[name]) for name in d.names}}
        return price(values, file.variants.parts(values))

    return rbdo(
        least,
        states,
        bounds={p.name: p.bounds for p in every if p.bounds is not None},
        beta=beta,
        start={p.name: p.value for p in every if p.bounds is not None and p.distribution is None},
        method=method,
        tolerance=tolerance,
        cycles=cycles,
    )
