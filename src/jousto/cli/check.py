"""The command check, and what it prints of a model."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

from jousto.base.errors import JoustoWarning
from jousto.cli.group import command
from jousto.cli.options import Model, Trust, compile_model
from jousto.cli.terminal import facts, say

if TYPE_CHECKING:
    from jousto.schema.file.read import ModelFile


@command()
def check(model: Model, trust: Trust = False) -> None:
    """Read a model file, check everything and say what is in it and how it can move."""
    from jousto.model.rank.doctor import doctor
    from jousto.schema.file.read import read_model

    file = read_model(model, trust=trust)
    describe_model(file)
    compiled = compile_model(file.mechanism)
    facts(doctor(compiled).lines())
    settings = file.simulation
    if settings is not None:
        from jousto.simulation.solvers.choice import choose
        from jousto.simulation.solvers.schedule import schedule
        from jousto.simulation.solvers.stability import stability_warning

        solver = settings.solver
        if solver is None:
            solver, reason = choose(compiled, settings.t_end, settings.output_step)
            facts([("solver", f"{solver}, since {reason}")])
        steps = schedule(compiled, settings.t_end, solver, settings.output_step)
        sentence = stability_warning(compiled, solver, steps.step)
        if sentence:
            warnings.warn(JoustoWarning(f"{model.name}: simulation: {sentence}"), stacklevel=1)
    say(f"{model.name}: ok", style="green")


def describe_model(file: ModelFile) -> None:
    """Print what is in a model."""
    from jousto.schema.summary import model_facts

    facts(model_facts(file), file.mechanism.name)
