"""Random chains of elastic beams with drives, springs, loads and weight, by seed."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

import jousto as jo
from design.flexibility.flexible_machines import STEEL
from jousto.design import advise_flexibility
from jousto.design.flexibility.body_advice import ReadingAdvice

AXES = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0))
ROUNDING = 1e-9
"""Loss / range of a reading, below which it is rounding."""


@dataclass(frozen=True, eq=False)
class RandomMachine:
    """A machine, the end of its run in s, and whether its first joint has no drive."""

    mechanism: jo.Mechanism
    t_end: float
    free: bool


def random_body(rng: np.random.Generator, name: str, at: float) -> tuple[float, jo.FlexibleBody]:
    """Return a slender steel beam from x = at along x, and its length."""
    length = float(rng.uniform(0.5, 2.0))
    height = length * float(rng.uniform(0.015, 0.05))
    section = jo.Rectangle(width=height * float(rng.uniform(0.5, 1.5)), height=height)
    part = jo.Part.beam(length, section, 4, STEEL)
    reduced = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=int(rng.integers(1, 4))))
    damping = float(rng.choice([0.0, 0.01, 0.03]))
    return length, jo.FlexibleBody(name, reduced, position=(at, 0.0, 0.0), damping=damping)


def random_signal(rng: np.random.Generator, end: float) -> object:
    """Return an angle over time: a smooth stroke, a harmonic motion, or rarely a ramp."""
    kind, size = int(rng.integers(8)), float(rng.uniform(0.3, 1.5))
    if kind < 3:
        return jo.SCurve((0.0, end * float(rng.uniform(0.4, 0.9))), (0.0, size))
    if kind < 5:
        return jo.SCurve((0.2 * end, end * float(rng.uniform(0.5, 0.8))), (0.0, size))
    if kind < 7:
        frequency = float(rng.uniform(1.0, 3.0)) / end
        half = 0.5 * size  # at rest at the start, at which only the acceleration jumps
        return jo.Harmonic(amplitude=half, frequency=frequency, phase=0.5 * np.pi, offset=-half)
    return jo.Ramp(start=0.0, end=0.6 * end, before=0.0, after=size)


def random_machine(seed: int) -> RandomMachine:
    """Return a chain of one to three beams, each turned by a drive or free at its first joint."""
    rng = np.random.default_rng(seed)
    end, count = float(rng.uniform(0.6, 1.5)), int(rng.integers(1, 4))
    axis, free = AXES[int(rng.random() < 0.4)], bool(rng.random() < 0.4)
    items: list[object] = []
    at, last = 0.0, jo.ground["origin"]
    for k in range(count):
        length, body = random_body(rng, f"b{k}", at)
        joint = jo.Revolute(f"j{k}", last, body["start"], axis=axis)
        items += [body, joint]
        if not (free and k == 0):
            items.append(jo.Drive(f"d{k}", joint.angle, random_signal(rng, end)))
        elif rng.random() < 0.5:
            stiffness, damping = float(10.0 ** rng.uniform(1.0, 3.5)), float(rng.choice([0.0, 0.5]))
            items.append(jo.Spring("k0", joint.angle, stiffness=stiffness, damping=damping))
        items += [jo.PositionSensor(f"p{k}", body["end"]), jo.ReactionSensor(f"r{k}", joint)]
        at, last = at + length, body["end"]
    if rng.random() < 0.7:
        mass = float(rng.uniform(0.2, 5.0))
        load = jo.RigidBody("load", mass, (0.01 * mass,) * 3, position=(at, 0.0, 0.0))
        items += [load, jo.Fixed("weld", last, load["origin"])]
        items.append(jo.AccelerationSensor("acc", load["origin"]))
    if rng.random() < 0.7:
        across = np.array([0.0, 0.0, -9.81]) if axis == AXES[1] else np.array([0.0, -9.81, 0.0])
        items.append(jo.Gravity(tuple(across)))
    rest = not free and rng.random() < 0.3
    name = f"random machine {seed}"
    mechanism = jo.Mechanism(*items, name=name, start="rest" if rest else "initial")
    return RandomMachine(mechanism, end, free)


def random_readings(seed: int) -> dict[str, ReadingAdvice]:
    """Return readings with a loss above rounding, by ``machine: rigid body: reading``."""
    machine = random_machine(seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # ramps with corners
        advice = advise_flexibility(
            machine.mechanism, machine.t_end, modes=False, output_step=machine.t_end / 400
        )
    return {
        f"{seed}: {body.body}: {one.reading}": one
        for body in advice.bodies
        for one in body.readings
        if one.measured is not None
        and one.measured.difference > max(one.floor, ROUNDING * one.scale)
    }
