"""Duration of an impact on a stop, which the step must resolve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jousto.model.model import ForceModel, Model
from jousto.model.native.header import named, places
from jousto.simulation.solvers.stability import DENSE, braking


def shortest_blow(model: Model) -> float:
    """Return the shortest duration of an impact on a stop, s; infinite without stops.

    It is half a period on the spring of the stop, ``pi sqrt(M / k)``, where M is the effective mass
    along the coordinate at the initial position: a damper of coefficient k would decelerate it at
    the rate ``k / M``. Machines with more than 300 states are not examined.

    Parameters
    ----------
    model : Model
    """
    stops = [i for i, force in enumerate(model.forces) if force.kind == "stop"]
    if not stops or 2 * model.nv > DENSE:
        return np.inf
    bare, braked = list(model.forces), list(model.forces)
    for i in stops:
        bare[i], braked[i] = _damper(bare[i], 0.0), _damper(bare[i], _stiffness(bare[i]))
    plain = replace(model, frictions=(), tree=(), forces=tuple(bare))
    rates = braking(replace(plain, forces=tuple(braked)), plain)
    fastest = float(np.abs(rates).max(initial=0.0))
    return float(np.pi / np.sqrt(fastest)) if fastest > 0.0 else np.inf


def _stiffness(force: ForceModel) -> float:
    return float(np.real(named("jo_stop_data", force.data).stiffness))


def _damper(force: ForceModel, c: float) -> ForceModel:
    """Return a damper of coefficient c that replaces a force."""
    data = np.zeros(max(place.stop for place in places("jo_along_data").values()))
    named("jo_along_data", data).damping[...] = c
    return replace(force, kind="along", data=data)
