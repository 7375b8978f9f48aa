"""Steps of bounded work (``events="step"``): models that they fit, and the changes they defer."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from jousto.base.errors import InputError, Problem
from jousto.model.model import ForceModel, Model
from jousto.model.native.header import named
from jousto.simulation.contacts import contacts, resolved_by
from jousto.simulation.solvers.base import Solver
from jousto.simulation.solvers.rosenbrock import ROS2

ON_STEP = 1e-6
"""Part of a step within which a sample is at its end."""


def check_bounded(model: Model, solver: Solver) -> None:
    """Raise an error if a model cannot be stepped with bounded work.

    A contact takes shorter steps while it touches, as many as it needs, unless it strikes by
    impulses and the method has closed contacts in its matrix; a rigid stop or lock ends a step at
    its impact; a sampled block is sampled at ends of steps.

    Raises
    ------
    InputError
        With all contacts, rigid stops, locks and samples between steps of the model, for a solver
        with ``events="step"``.
    """
    if not solver.bounded:
        return
    name = type(solver).__name__
    impulses = {force.name for force in resolved_by(model, "impulse")}
    implicit = isinstance(solver, ROS2)
    problems = [
        Problem(
            f"force {touch!r}",
            f"is a contact, which takes shorter steps while it touches, but {name} has "
            'events="step", whose work is bounded; take resolve="impulse" of the contact and ROS2, '
            'or events="located", or a Stop',
        )
        for touch in dict.fromkeys(force.name for force in contacts(model))
        if not (implicit and touch in impulses)
    ]
    problems += [
        Problem(
            f"joint {row.name!r}",
            f'ends a step at each impact, but {name} has events="step", whose work is bounded; '
            'take events="located", or a Stop with a stiffness',
        )
        for row in model.switched
    ]
    problems += [
        Problem(
            f"states {force.name!r}",
            f"are sampled, and the {what} of {x:g} s is no multiple of the step of {solver.step:g} "
            f's; take a step of {near:.6g} s, or events="located"',
        )
        for force in model.forces
        if force.kind == "memory"
        for what, x, near in _between_steps(force, solver.step)
    ]
    problems += [
        Problem(
            f"delay {force.state_names[0].partition('.')[0]!r}",
            f"is {delay:g} s, less than the step of {solver.step:g} s; take a shorter step, or "
            'events="located"',
        )
        for force in model.forces
        if force.kind == "delay"
        and (delay := float(np.real(named("jo_delay_data", force.data).time))) < solver.step
    ]
    if problems:
        raise InputError(problems)


def _between_steps(force: ForceModel, step: float) -> Iterator[tuple[str, float, float]]:
    """Yield the period and phase of samples between the ends of steps, s, and a step that fits."""
    numbers = named("jo_memory_data", force.data)
    period, phase = float(np.real(numbers.period)), float(np.real(numbers.phase))
    near = period / max(1, round(period / step))
    if numbers.jitter != 0.0:
        yield "jitter", float(np.real(numbers.jitter)), near
    for what, x in (("period", period), ("phase", phase)):
        count = x / step
        if period > 0.0 and (abs(count - round(count)) > ON_STEP or (x == period and count < 0.5)):
            yield what, x, near


def deferred_warning(deferred: int, steps: int) -> str:
    """Return a sentence if steps left changes to the next one, else an empty text."""
    if not deferred:
        return ""
    return (
        f"{deferred} of {steps} steps left a change of friction or an event to the next step, "
        "since a step of bounded work makes two passes for them; take a smaller step, or "
        'events="located"'
    )
