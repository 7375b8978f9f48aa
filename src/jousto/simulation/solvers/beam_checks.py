"""Checks of geometrically exact beams before and after a run."""

from __future__ import annotations

import numpy as np

from jousto.base.errors import warn
from jousto.mechanism.beams.limits import highest_frequencies
from jousto.model.model import Model
from jousto.model.native.header import named
from jousto.model.native.native import Engine
from jousto.simulation.solvers.stability import MANY_STEPS

FAR = 1.0  # largest bending or twist of an element without a warning, rad


def fastest_beam(model: Model) -> tuple[str, float]:
    """Return the beam with the fastest element, and the frequency of that element, rad/s."""
    if not model.beams:
        return "", 0.0
    data = np.stack([beam.data for beam in model.beams])
    fastest = highest_frequencies(vars(named("jo_beam_data", data)))
    worst = int(np.argmax(fastest))
    return model.beams[worst].body, float(fastest[worst])


def beam_steps_warning(model: Model, duration: float) -> str:
    """Return a warning if beams force an explicit method to very many steps."""
    beam, fastest = fastest_beam(model)
    steps = duration * fastest / 2.0
    if steps < MANY_STEPS:
        return ""
    return (
        f"elements of beam '{beam}' of up to {fastest / (2 * np.pi):.3g} Hz force an explicit "
        f"method to about {steps:.2g} steps; GeneralizedAlpha and ROS2 do not mind them"
    )


def warn_bent(engine: Engine) -> None:
    """Warn once for every beam with an element that bent too far or had an unstable tension."""
    model = engine.model
    bent = np.array(engine.bent)
    names = np.array([beam.body for beam in model.beams])
    for name in dict.fromkeys(names.tolist()):
        mine = np.flatnonzero(names == name)
        turn, pull = (int(mine[np.argmax(bent[mine, k])]) for k in (0, 1))
        if bent[turn, 0] > FAR:
            warn(
                f"beam '{name}'",
                f"its element {turn - mine[0]} bent or twisted by {bent[turn, 0]:.3g} rad, which "
                "is coarse: strains are taken as constant along it; take "
                f"{_times(bent[turn, 0] / 0.5)} as many elements for half a radian each",
            )
        if bent[pull, 1] > 1.0:
            warn(
                f"beam '{name}'",
                tension_sentence(model.beams[pull].data, pull - int(mine[0]), float(bent[pull, 1])),
            )


def tension_sentence(data: np.ndarray, element: int, ratio: float) -> str:
    """Return the warning, with the remedy, for a tension above the limit of stable shear."""
    x = named("jo_beam_data", data)
    limit = 1.0 / float(x.limit)
    return (
        f"the tension in its element {element} reached {ratio:.3g} times {limit:.3g} N, beyond "
        "which the linear law of shear and extension is unstable (N > GA/(1 - GA/EA): the section "
        "turns aside instead of stretching), so that motion beyond is not physical; the axial "
        f"strain would be {ratio * limit / x.C[0]:.2g}: check units and loads, give the section a "
        "shear stiffness GA = EA where shear does not matter, and with bending=True take more "
        "elements or leave it out"
    )


def _times(factor: float) -> str:
    return f"{int(np.ceil(factor))} times"
