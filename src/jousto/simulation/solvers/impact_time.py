"""How long a blow on a stop lasts: a step has to see it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jousto.model.model import ForceModel, Model
from jousto.model.native.header import named, places
from jousto.simulation.solvers.stability import DENSE, braking


def shortest_blow(model: Model) -> float:
    """Return how long the quickest blow on a stop lasts, s; infinite without stops.

    Half a period on its spring, ``pi sqrt(M / k)``, M being what moves along the coordinate at the
    initial position: k as a damper brakes at the rate ``k / M``. Machines of more than 300 states
    are not examined.

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
    """Return a damper in the place of a force."""
    data = np.zeros(max(place.stop for place in places("jo_along_data").values()))
    named("jo_along_data", data).damping[...] = c
    return replace(force, kind="along", data=data)
