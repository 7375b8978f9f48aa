"""Machines that excite terms of the equations of motion which the examples hardly do.

Each is in space, off every axis and fast, so that a term that is missing or turned shows.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import jousto as jo
from jousto.reduction import NodeFrame
from natural.machines import G
from verification.mechanisms import SECTION, SOFT

X, Y, Z = np.eye(3)
OBLIQUE = jo.Rotate((1, 2, 0.5), degrees=40)


def rotating_slides(core: str = "auto") -> jo.Mechanism:
    """Two sliders on a rail that turns about two axes; one of them spins about the rail."""
    frame = jo.RigidBody("frame", 4.0, (0.3, 0.2, 0.4), center=(0.05, 0, 0.1))
    rail = jo.RigidBody(
        "rail", 2.0, (0.02, 0.3, 0.31), center=(0.2, 0.01, 0), angular_velocity=(2.0, 3.0, 9.0)
    )
    block = jo.RigidBody(
        "block",
        1.5,
        (0.02, 0.03, 0.04),
        center=(0.03, 0.05, -0.02),
        position=(0.3, 0, 0),
        velocity=(2.0, 3.0, -1.0),
        angular_velocity=(2.0, 3.0, 9.0),
    )
    nut = jo.RigidBody(
        "nut",
        1.0,
        (0.01, 0.02, 0.015),
        center=(0, 0.04, 0.03),
        position=(-0.3, 0, 0),
        velocity=(1.5, -3.0, 1.0),
        angular_velocity=(25.0, 3.0, 9.0),
    )
    turn = jo.Revolute("turn", jo.ground["origin"], frame["origin"], axis=Z)
    tilt = jo.Revolute("tilt", frame["origin"], rail["origin"], axis=Y)
    slide = jo.Prismatic("slide", rail.at((0.3, 0, 0)), block["origin"], axis=X)
    sleeve = jo.Cylindrical("sleeve", rail.at((-0.3, 0, 0)), nut["origin"], axis=X)
    spring = jo.Spring("spring", slide.displacement, 60.0, 0.5)
    motor = jo.Drive("motor", turn.angle, jo.ConstantSpeed(9.0))
    sensors = (
        jo.CoordinateSensor("way", slide.displacement),
        jo.RateSensor("speed of the nut", sleeve.displacement),
    )
    return jo.Mechanism(
        *(frame, rail, block, nut, turn, tilt, slide, sleeve, spring, motor, G, *sensors),
        name="rotating slides",
        core=core,
    )


def gyroscope(core: str = "auto") -> jo.Mechanism:
    """A fast rotor with three unequal moments of inertia in two rings that turn."""
    spin = np.array([4.0, -3.0, 120.0])
    outer = jo.RigidBody("outer", 0.6, (0.004, 0.005, 0.006), center=(0.01, 0, 0.02))
    inner = jo.RigidBody("inner", 0.4, (0.002, 0.0031, 0.0027), angular_velocity=(4.0, -3.0, 0))
    rotor = jo.RigidBody(
        *("rotor", 2.0, (0.004, 0.006, 0.009)), center=(0.002, 0.001, 0.01), angular_velocity=spin
    )
    post = jo.Revolute("post", jo.ground["origin"], outer["origin"], axis=X)
    ring = jo.Revolute("ring", outer["origin"], inner["origin"], axis=Y)
    bearing = jo.Revolute("bearing", inner["origin"], rotor["origin"], axis=Z)
    turned = jo.OrientationSensor("axis", inner["origin"])
    top = jo.RigidBody("top", 1.0, (0.01, 0.02, 0.03), angular_velocity=(1.0, 60.0, 2.0))
    return jo.Mechanism(
        *(outer, inner, rotor, top, post, ring, bearing, G, turned), name="gyroscope", core=core
    )


def node_frames(core: str = "auto") -> jo.Mechanism:
    """Two bent beams in the frames of their first nodes; a hand at the end of each has an arm."""
    part = jo.Part.beam(1.0, SECTION, 4, SOFT, theory=jo.parts.EulerBernoulli(), name="beam")
    modes = jo.CraigBampton(("start", "end"), modes=1, frame=NodeFrame("start"))
    reduced = replace(jo.reduce(part, modes), source=None)
    bent = 0.4 * np.cos(np.arange(1, reduced.n + 1))
    arm = np.array([0.05, 0.08, -0.06])
    first = jo.FlexibleBody(
        "first", reduced, angular_velocity=(3.0, 1.0, 6.0), modal_velocities=bent
    )
    second = jo.FlexibleBody(
        "second", reduced, position=X + arm, angular_velocity=(8.0, 2.0, 5.0), modal_velocities=bent
    )
    hands = [
        jo.RigidBody(f"hand {k + 1}", 0.3, (0.001, 0.002, 0.0015), position=place)
        for k, place in enumerate((X, 2 * X + arm))
    ]
    load = jo.RigidBody("load", 0.5, (0.002, 0.003, 0.004), position=(2.0, 0.6, 0.4))
    pin = jo.Universal("pin", jo.ground["origin"], first["start"], axis_a=Z)
    holds = [
        jo.Fixed(f"hold {k + 1}", body["end"], hand["origin"])
        for k, (body, hand) in enumerate(zip((first, second), hands, strict=True))
    ]
    elbow = jo.Revolute("elbow", hands[0].at(arm), second["start"], axis=(1, 0, 1))
    cord = jo.Bushing("cord", hands[1].at(arm), load["origin"], (50.0,) * 6, 0.5)
    push = jo.Force("push", second["node3"], (5.0, -8.0, 6.0), follow=True)
    sensors = (
        jo.PositionSensor("elbow point", second["start"]),
        jo.StressSensor("stress", first, "e2.a.top"),
    )
    return jo.Mechanism(
        *(first, second, *hands, load, pin, *holds, elbow, cord, push, G, *sensors),
        name="node frames",
        core=core,
    )


def offset_bushings(core: str = "auto") -> jo.Mechanism:
    """Two bodies on bushings with arms, turned by up to a radian and a half and by each other."""
    low = jo.RigidBody(
        "low", 3.0, (0.05, 0.07, 0.04), center=(0.1, 0, 0.05), angular_velocity=(3.0, -6.0, 4.0)
    )
    high = jo.RigidBody(
        *("high", 2.0, (0.03, 0.02, 0.05)),
        position=(0.4, 0.3, 0.2),
        orientation=jo.Rotate((1, -1, 2), degrees=70),
        angular_velocity=(-4.0, 5.0, 7.0),
    )
    stiffness = (900.0, 500.0, 700.0, 6.0, 9.0, 4.0)
    damping = (8.0, 5.0, 3.0, 0.1, 0.06, 0.2)
    foot = jo.Bushing(
        "foot",
        jo.ground.at((0.2, -0.3, 0.1)).turned(OBLIQUE),
        low.at((-0.2, 0.25, 0.15)),
        stiffness,
        damping,
    )
    link = jo.Bushing(
        "link", low.at((0.3, 0.2, -0.1)), high.at((-0.1, 0.2, 0.15)), stiffness, damping
    )
    return jo.Mechanism(low, high, foot, link, G, name="offset bushings", core=core)


def reversing_friction(core: str = "auto") -> jo.Mechanism:
    """A block on springs that slides back and forth, and a pendulum on it; both rub."""
    block = jo.RigidBody("block", 2.0, (0.01,) * 3, center=(0, 0.1, 0.05), velocity=(1.5, 0, 0))
    pendulum = jo.RigidBody(
        "pendulum", 1.0, (0.02, 0.02, 0.003), center=(0, 0, -0.3), angular_velocity=(0, 8.0, 0)
    )
    guide = jo.Prismatic("guide", jo.ground["origin"], block["origin"], axis=X)
    pin = jo.Revolute("pin", block["origin"], pendulum["origin"], axis=Y)
    law = jo.mechanism.Regularised(velocity=0.05)
    slides = jo.Friction("slides", guide, 0.3, law=law)
    turns = jo.Friction("turns", pin, 0.4, radius=0.05, law=law)
    spring = jo.Spring("spring", guide.displacement, 900.0)
    way = jo.CoordinateSensor("way", guide.displacement)
    return jo.Mechanism(
        *(block, pendulum, guide, pin, slides, turns, spring, G, way),
        name="reversing friction",
        core=core,
    )


TERMS = {
    "rotating slides": rotating_slides,
    "gyroscope": gyroscope,
    "node frames": node_frames,
    "offset bushings": offset_bushings,
    "reversing friction": reversing_friction,
}
