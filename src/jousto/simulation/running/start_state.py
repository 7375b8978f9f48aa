"""Where a run starts that is given no state."""

from __future__ import annotations

from jousto.base.errors import InputError, NotAnalytic, Problem
from jousto.model.model import Model
from jousto.model.start_complex_step import has_steps
from jousto.simulation.state import State


def beginning(model: Model, state: State | None = None, start: str | None = None) -> State | None:
    """Return the state that a run starts from; None for the initial one of the model.

    Parameters
    ----------
    model : Model
        The model.
    state : State, optional
        What the user gave; it counts.
    start : str, optional
        "initial", "rest" or "vibration-free"; that of the mechanism if not given.

    Raises
    ------
    InputError
        If that is unknown because a model of another program runs beside the machine, or if there
        is none.
    NotAnalytic
        If derivatives of it are asked for that there are none of.
    """
    start = model.start if start is None else start
    if state is not None or start == "initial":
        return state
    if model.fmus:
        unit = model.fmus[0].fmu.name
        told = f"is to start at '{start}', but what fmu '{unit}' gives there is not known; "
        told += "take start 'initial', or give the state to start from"
        raise InputError(Problem(f"mechanism {model.name!r}", told))
    if has_steps(model):
        if start != "rest":
            raise NotAnalytic("a start without vibration is sought by iterations")
        from jousto.simulation.statics.complex_step import rest

        return rest(model)
    if start == "rest":
        from jousto.simulation.statics.equilibrium import equilibrium

        return equilibrium(model)
    from jousto.simulation.statics.vibration_free import vibration_free_state

    return vibration_free_state(model)
