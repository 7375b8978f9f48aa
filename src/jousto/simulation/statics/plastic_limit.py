"""Plastic limit: springs without hardening at their full strength where a search fails."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jousto.base.arrays import Array
from jousto.model.model import ForceModel
from jousto.model.native.header import named, places
from jousto.model.native.native import Engine

FULL = 0.01
"""Share of the strength that may be missing where a spring counts as fully loaded."""
FLAT = 1e-3
"""Plastic modulus over the elastic stiffness, up to which a spring has no hardening left."""


def name_plastic_limit(engine: Engine, *positions: Array) -> str:
    """Return the end of a message, with the springs at their plastic limit; "" without any.

    A spring counts as fully loaded if it would yield at a strength smaller by 1 %.

    Parameters
    ----------
    engine : Engine
        With the deformations from which the search started.
    positions : (nq,) arrays
        Where the search failed: the last equilibrium, then the last trial. The first at which
        springs are at their limit counts.
    """
    model = engine.model
    springs = [force for force in model.forces if force.kind == "plastic"]
    if not springs:
        return ""
    weaker = tuple(_weakened(f) if f.kind == "plastic" else f for f in model.forces)
    probe = Engine(replace(model, forces=weaker).keeping_tree(model))
    for name in ("time", "input", "turn", "locked", "held", "states"):
        getattr(probe, name)[:] = np.real(getattr(engine, name))
    before = np.array(probe.states)
    for q in positions:
        probe.q[:], probe.v[:], probe.states[:] = np.real(q), 0.0, before
        probe.yield_forces()
        found = [force for force in springs if _is_flat(force, before, np.array(probe.states))]
        if found:
            return _sentence(engine, found)
    return ""


def _sentence(engine: Engine, found: list[ForceModel]) -> str:
    listed = ", ".join(f"'{f.name}' ({_strength(f):g} {_unit(engine, f)})" for f in found)
    several = len(found) > 1
    return (
        f"; the plastic spring{'s' if several else ''} {listed} "
        f"{'carry' if several else 'carries'} the full strength without hardening: likely the "
        "plastic limit, beyond which there is no equilibrium; take a smaller load, or give "
        "hardening (kinematic=, isotropic=)"
    )


def _weakened(force: ForceModel) -> ForceModel:
    data = np.array(force.data)
    data[places("jo_plastic_data")["strength"]] *= 1.0 - FULL
    return replace(force, data=data)


def _is_flat(force: ForceModel, before: Array, after: Array) -> bool:
    """Return whether a spring has yielded with a plastic modulus of about zero."""
    place = {name: force.state + k for k, name in enumerate(force.state_names)}
    flow = after[place["plastic"]] - before[place["plastic"]]
    if flow == 0.0:
        return False
    x, back, path = named("jo_plastic_data", force.data), after[place["back"]], after[place["path"]]
    modulus = (
        x.kinematic
        - x.recovery * back * np.sign(flow)
        + x.isotropic
        + x.saturation * x.rate * np.exp(-x.rate * path)
    )
    return bool(np.real(modulus) <= FLAT * np.real(x.stiffness))


def _strength(force: ForceModel) -> float:
    return float(np.real(named("jo_plastic_data", force.data).strength))


def _unit(engine: Engine, force: ForceModel) -> str:
    return "N m" if engine.model.coordinates[force.coordinate].kind == "angle" else "N"
