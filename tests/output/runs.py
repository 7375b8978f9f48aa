"""Short runs to draw."""

from __future__ import annotations

import functools
import warnings

import jousto as jo


@functools.cache
def swing(step: float = 1e-3) -> jo.Solution:
    """A stiff and a soft link swinging in the xz plane; sensors of every kind of unit."""
    part = jo.Part.beam(1.0, jo.Circle(0.02), 4, jo.Material(2.5e9, 0.4, 1140.0))
    rod = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4)).keep(range(4))
    arm = jo.FlexibleBody("arm", rod)
    hand = jo.RigidBody("hand", 0.1, (1e-5, 1e-3, 1e-3), center=(0.2, 0, 0), position=(1, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], arm["start"], axis=(0, 1, 0))
    model = jo.compile(
        jo.Mechanism(
            arm,
            hand,
            hinge,
            jo.Revolute("wrist", arm["end"], hand["origin"], axis=(0, 1, 0)),
            jo.Gravity((0, 0, -9.81)),
            jo.PositionSensor("tip", hand["center"]),
            jo.VelocitySensor("tip.speed", hand["center"]),
            jo.mechanism.ModalSensor("modes", arm),
            jo.ReactionSensor("pin", hinge),
            jo.StressSensor("stress", arm, ("e1.a.top", "e1.a.bottom")),
            name="swing",
        )
    )
    return jo.simulate(model, 0.4, solver=jo.RK4(step), output_step=0.01)


@functools.cache
def spatial() -> jo.Solution:
    """A spinning rigid body thrown upwards: motion in all directions."""
    body = jo.RigidBody(
        "stone",
        1.0,
        (0.1, 0.2, 0.3),
        markers={"nose": (0.3, 0.0, 0.0), "wing": (0.0, 0.3, 0.1)},
        velocity=(1.0, 2.0, 4.0),
        angular_velocity=(1.0, 5.0, 2.0),
    )
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*has no joint to another body", jo.JoustoWarning)
        model = jo.compile(jo.Mechanism(body, jo.Gravity((0, 0, -9.81)), name="stone"))
    return jo.simulate(model, 0.8, solver=jo.RK4(1e-3), output_step=0.01)
