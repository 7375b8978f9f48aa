"""The machine with rigid bodies instead of its flexible ones."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np

from jousto.base.errors import InputError, Problem
from jousto.mechanism.beams.body import BeamBody
from jousto.mechanism.bodies.base import Posed
from jousto.mechanism.bodies.body import FlexibleBody, ground
from jousto.mechanism.mechanism import Mechanism
from jousto.reduction.reduced import ReducedPart


def rigid_machine(machine: Mechanism) -> Mechanism:
    """Return a copy of a mechanism whose flexible bodies are rigid.

    Each flexible body keeps its mass, inertia, nodes and loads; its only mode is zero everywhere.

    Raises
    ------
    InputError
        The mechanism has exact beams.
    """
    beams = [item.name for item in machine.items if isinstance(item, BeamBody)]
    if beams:
        message = f"exact beams cannot be made rigid: {', '.join(beams)}; use machine='flexible'"
        raise InputError(Problem("rigid machine", message))
    memo: dict[int, object] = {id(ground): ground}
    for body in machine.bodies:
        memo[id(body)] = rigid_copy(body) if isinstance(body, FlexibleBody) else body
    return copy.deepcopy(machine, memo)


def rigid_copy(body: FlexibleBody) -> FlexibleBody:
    """Return a body of the same mass and nodes with one mode that is zero everywhere."""
    given = {key: getattr(body, key) for key in Posed.fields}
    return FlexibleBody(**given, reduced=without_modes(body.reduced))


def without_modes(part: ReducedPart) -> ReducedPart:
    """Return a reduced part whose only mode has no displacement, stress or inertia coupling."""
    first = part.keep([0])
    integrals = replace(
        first.invariants,
        I3=np.zeros_like(first.invariants.I3),
        N0=np.zeros_like(first.invariants.N0),
        E=np.zeros_like(first.invariants.E),
    )
    stress = first.stress
    return replace(
        first,
        modes=np.zeros_like(first.modes),
        rotations=None if first.rotations is None else np.zeros_like(first.rotations),
        invariants=integrals,
        stress=None if stress is None else replace(stress, modes=np.zeros_like(stress.modes)),
        stiffening=None,
        source=None,
    )
