"""Initial state of a run: a given one, equilibrium, or the vibration-free state."""

from __future__ import annotations

from jousto.base.errors import InputError, NotAnalytic, Problem
from jousto.model.model import Model
from jousto.model.start_complex_step import has_steps
from jousto.simulation.state import State


def initial_state(
    model: Model, state: State | None = None, start: str | None = None
) -> State | None:
    """Return the initial state of a run; None for the initial state of the model.

    Parameters
    ----------
    model : Model
        The model.
    state : State, optional
        Initial state given by the user; it is returned unchanged.
    start : str, optional
        "initial", "rest" or "vibration-free"; `start` of the mechanism if not given.

    Raises
    ------
    InputError
        If there is no such state, or it cannot be found because the machine contains an FMU.
    NotAnalytic
        If the model has derivatives and the state is found by iterations.
    """
    start = model.start if start is None else start
    if state is not None or start == "initial":
        return state
    if model.fmus:
        unit = model.fmus[0].fmu.name
        message = (
            f"start is '{start}', but the outputs of fmu '{unit}' in that state are not known; "
        )
        message += "take start 'initial', or give the state to start from"
        raise InputError(Problem(f"mechanism {model.name!r}", message))
    if has_steps(model):
        if start != "rest":
            raise NotAnalytic("the vibration-free initial state is found by iterations")
        from jousto.simulation.statics.complex_step import rest

        return rest(model)
    if start == "rest":
        from jousto.simulation.statics.equilibrium import equilibrium

        return equilibrium(model)
    from jousto.simulation.statics.vibration_free import vibration_free_state

    return vibration_free_state(model)
