"""Check of the geometric stiffness that an equilibrium of linear bodies neglects."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import SimulationError, warn
from jousto.model.model import BodyModel, Model
from jousto.simulation.modes.linear import linearise
from jousto.simulation.modes.spectrum import DENSE
from jousto.simulation.second_order import linear_bodies, where_noticed
from jousto.simulation.state import State
from jousto.simulation.statics.continuation import (
    NoConvergenceError,
    Point,
    least_step,
    spectrum,
)
from jousto.simulation.statics.residual import TIME, Balance
from jousto.simulation.statics.states_rest import rest_with_states, state_systems

MISSED = 0.05
"""Relative change of the mean deflection of a body above which a warning follows."""
LEAST = 1e-3
"""Deflection over the largest of all bodies, below which a body is not bent."""
STRAIGHT = 1e-5
"""Mean deflection over the size of the machine, below which a body is not bent."""
WATCHED = 6
"""Number of modes with omega^2 nearest to zero that are checked for instability."""
GROWS = 1e-8
"""Real part of an eigenvalue over the largest one, above which a motion grows."""
REMEDY = "reduce its part with stiffening=True"


def check_second_order(model: Model, at: State, where: str, told: set[str]) -> None:
    """Compare an equilibrium of linear bodies with that of bodies with geometric stiffness.

    The difference is one Newton step from the equilibrium. There is no warning for the bodies in
    `told`, which already have a warning for bending beyond the range of their modes.

    Raises
    ------
    SimulationError
        If the equilibrium is unstable with the geometric stiffness of its bodies.

    Warns
    -----
    JoustoWarning
        If the deflection of a body changes by more than `MISSED`.
    """
    parts = linear_bodies(model)
    if not parts:
        return
    loaded = where_noticed(model, at, where)
    if loaded is model:
        return
    try:
        change_of = _with_states if state_systems(model) else _by_one_step
        changes, falls = change_of(model, loaded, at)
    except (NoConvergenceError, SimulationError):
        return
    names = [model.bodies[k].name for k in parts]
    if falls:
        raise SimulationError(
            f"{where}: this equilibrium neglects that loads soften linear bodies; with it the "
            f"machine buckles below these loads, in {_listed(names)}; {REMEDY}, and find the "
            "critical load with buckling or load_path",
            time=at.time,
            body=names[0],
        )
    # of mass-normalised modes |p| / sqrt(m) is the mean displacement within a body, m
    moved = {b.name: _moved(b, at.q[b.iq + 7 : b.iq + 7 + b.n]) for b in model.bodies if b.n}
    least = max(LEAST * max(moved.values()), STRAIGHT * model.size)
    for k in parts:
        b = model.bodies[k]
        change = _moved(b, changes[k])
        share = change / max(moved[b.name], least)
        if share > MISSED and b.name not in told:
            warn(
                where,
                f"body '{b.name}' is linear: its neglected geometric stiffness would change its "
                f"deflection by about {100.0 * share:.2g} %; {REMEDY}",
            )


def _by_one_step(model: Model, loaded: Model, at: State) -> tuple[list[Array], bool]:
    """Return the changes of the modal coordinates of all bodies, and whether the machine falls."""
    point = Point(at.q, at.lam, at.time)
    linear, exact = (
        Balance(one, TIME, at, where="equilibrium", frictionless=True) for one in (model, loaded)
    )
    step = least_step(exact, point)[0]
    small = model.nv + model.nrow <= DENSE
    falls = small and _unstable(exact, point) > _unstable(linear, point)
    return [step[b.iv + 6 : b.iv + 6 + b.n] for b in model.bodies], falls


def _with_states(model: Model, loaded: Model, at: State) -> tuple[list[Array], bool]:
    """Return the same for a machine with states, by its equilibrium and its eigenvalues."""
    found = rest_with_states(loaded, at)
    grow = []
    for one, state in ((model, at), (loaded, found)):
        poles = np.linalg.eigvals(linearise(one, state).A)
        grow.append(int((poles.real > GROWS * np.abs(poles).max(initial=0.0)).sum()))
    places = [slice(b.iq + 7, b.iq + 7 + b.n) for b in model.bodies]
    return [found.q[place] - at.q[place] for place in places], grow[1] > grow[0]


def _moved(body: BodyModel, p: Array) -> float:
    return float(np.linalg.norm(p) / np.sqrt(body.mass[0]))


def _unstable(balance: Balance, at: Point) -> int:
    return spectrum(balance, at, WATCHED, held=True).unstable


def _listed(names: list[str]) -> str:
    return ", ".join(f"'{name}'" for name in names[:3]) + (" and others" if len(names) > 3 else "")
