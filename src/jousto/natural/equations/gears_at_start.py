"""Gear springs that begin where `Initial` values of the machine lead."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np

from jousto.base.arrays import Array
from jousto.mechanism.forces.base import Push
from jousto.model.compile import compile
from jousto.natural.equations.force_laws import LAWS
from jousto.natural.equations.initial_state import angles, state_of_engine
from jousto.natural.equations.system import Machine
from jousto.simulation.state import State

KIND = "gear spring"


def wind_gears(machine: Machine) -> None:
    """Set the laws of the gear springs to the declared wind-up at the start of the run.

    ``free`` of a `Push` belongs to the declared pose. `Initial` values move the joints, and the
    wind-up of a gear is that after this motion.

    Parameters
    ----------
    machine : Machine
        Machine after `Machine.close`; its laws are replaced.
    """
    mechanism = machine.mechanism
    geared = any(push.kind == KIND for force in mechanism.forces for push in force.pushes)
    if not mechanism.initials or not geared:
        return
    moved = _at_start(machine) - angles(machine)
    for force in mechanism.forces:
        for k, push in enumerate(force.pushes):
            if push.kind == KIND:
                law = LAWS[KIND](_wound(machine, push, moved), machine.frames, machine.scalars)
                machine.laws[machine.felt[id(force)] + k] = law


def _at_start(machine: Machine) -> Array:
    """Return the scalar functions (ns,) at the pose to which the `Initial` values lead."""
    with warnings.catch_warnings():  # of a mechanism that was compiled before
        warnings.simplefilter("ignore")
        model = compile(machine.mechanism)
    start = State(model.q0, model.v0, np.zeros(model.nrow))
    pose = machine.frames.evaluate(state_of_engine(machine, start)[0])
    return machine.scalars.values(pose.y, angles(machine))


def _wound(machine: Machine, push: Push, moved: Array) -> Push:
    """Return the law of a gear spring whose coordinates have moved."""
    assert push.coordinate is not None and push.other is not None
    scalars, ratio = machine.scalars, float(np.asarray(push.data["ratio"]))
    s, phi = (scalars.number(scalars.coordinate(x)) for x in (push.coordinate, push.other))
    free = float(np.asarray(push.data["free"])) + moved[s] - moved[phi] / ratio
    return replace(push, data={**push.data, "free": free})
