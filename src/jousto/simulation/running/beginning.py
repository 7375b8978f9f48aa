"""Where a run starts that is given no state."""

from __future__ import annotations

from jousto.model.model import Model
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
    """
    start = model.start if start is None else start
    if state is not None or start == "initial":
        return state
    if start == "rest":
        from jousto.simulation.statics.equilibrium import equilibrium

        return equilibrium(model)
    from jousto.simulation.statics.vibration_free import vibration_free_state

    return vibration_free_state(model)
