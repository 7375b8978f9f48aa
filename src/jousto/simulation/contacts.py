"""Contacts of a model and the states of their bristles."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.errors import InputError, Problem
from jousto.mechanism.forces.contact import RESOLVE
from jousto.model.model import ForceModel, Model
from jousto.model.native.header import named, places

STRETCH = "stretch "
"""Begin of the names of the states of a bristle: its stretch along three axes."""
SINCE = "since"
"""Name of the state of a contact that is the time of its last touch."""


def contacts(model: Model) -> list[ForceModel]:
    """Return the forces of a model by which bodies touch."""
    return [force for force in model.forces if force.kind.startswith("contact")]


def resolved_by(model: Model, how: str) -> list[ForceModel]:
    """Return the contacts of a model whose touches are resolved by "cut", "impulse" or "report"."""
    found = []
    for force in contacts(model):
        field = places(f"jo_{force.kind.replace(' ', '_')}_data").get("resolve")
        if field is not None and RESOLVE[int(np.real(force.data[field][0]))] == how:
            found.append(force)
    return found


def slides_freely(force: ForceModel) -> bool:
    """Return whether a force is a contact of two bodies that rests without friction.

    Its force at rest follows from the position alone, not from the way to it.
    """
    if force.kind not in ("contact", "contact pair", "contact track"):
        return False
    x = named(f"jo_{force.kind.replace(' ', '_')}_data", np.real(force.data))
    turns = float(getattr(x, "rolling", 0.0)) + float(getattr(x, "drilling", 0.0)) > 0.0
    return not turns and not (float(x.mu_static) and float(x.shear))


def without_sticking(model: Model, where: str) -> None:
    """Raise an error if rows hold the points of a contact that stick.

    Raises
    ------
    InputError
        With each such contact.
    """
    names = [model.forces[one.contact].name for one in model.frictions if one.contact >= 0]
    problems = [
        Problem(
            f"contact '{name}'",
            f"has friction=StickSlip(), whose rows {where} does not have; leave out friction for "
            "the bristle, whose stiffness it has",
        )
        for name in dict.fromkeys(names)
    ]
    if problems:
        raise InputError(problems)


def contact_states(model: Model, begin: str) -> NDArray[np.intp]:
    """Return the indices of the states of contacts whose names have this begin."""
    found = [
        force.state + i
        for force in contacts(model)
        for i, name in enumerate(force.state_names)
        if name.startswith(begin)
    ]
    return np.array(found, dtype=np.intp)


def bristle_rates(twin: Any, places: NDArray[np.intp], columns: Any, tiny: float) -> Any:
    """Return the derivatives (n, nv) of the rates of bristles with respect to velocities.

    A bristle follows the displacement of the contact point as its rate follows the velocity.

    Parameters
    ----------
    twin : Engine
        With complex numbers, at a state at rest; its velocities are 0 afterwards.
    places : (n,) array
        Indices of the states of the bristles.
    columns : (nv, nv) array
        Velocities of the engine for each unknown.
    tiny : float
        Complex step.
    """
    out = np.zeros((len(places), columns.shape[1]))
    for k in range(columns.shape[1] if len(places) else 0):
        twin.v[:] = 1j * tiny * columns[:, k]
        twin.accelerations()
        out[:, k] = np.imag(twin.state_rates[places]) / tiny
    twin.v[:] = 0.0
    return out
