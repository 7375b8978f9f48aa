"""Machines that both formulations run, and what they read at the same states."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

import jousto as jo
from jousto.natural.sensors_at_state import Instants, at_states
from jousto.reduction.methods import Reduction
from verification.mechanisms import SECTION, SOFT

G = jo.Gravity((1.0, -2.0, -9.0))


def rod(name: str = "rod") -> jo.ReducedPart:
    """A soft beam of 1 m whose nodes turn, with stresses."""
    part = jo.Part.beam(1.0, SECTION, 4, SOFT, theory=jo.parts.EulerBernoulli(), name=name)
    reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=1))
    return replace(reduced, source=None)  # nobody asks what the modes leave out of loads


def everything() -> jo.Mechanism:
    """A driven machine in space with forces and sensors of every kind that both know."""
    a = jo.FlexibleBody(
        "a",
        rod(),
        damping=0.01,
        modal_velocities=0.5 * np.cos(np.arange(1, 8)),
    )
    b = jo.FlexibleBody("b", a.reduced, position=(1, 0, 0), angular_velocity=(1.0, 2.0, 3.0))
    ball = jo.RigidBody(
        "ball",
        3.0,
        (0.02, 0.03, 0.04),
        center=(0.1, 0.05, 0),
        position=(2, 0, 0),
        markers={"m": (0.2, 0, 0.1)},
    )
    loose = jo.RigidBody(
        "loose",
        *(5.0, (0.2, 0.3, 0.4)),
        position=(0.5, 1.0, 0.3),
        velocity=(0.1, 0, 0.4),
        angular_velocity=(2.0, -1.0, 0.5),
    )
    hinge = jo.Revolute("hinge", jo.ground["origin"], a["start"], axis=(0.1, 0.2, 1))
    cross = jo.Universal("cross", a["end"], b["start"], axis_a=(0, 0, 1))
    wrist = jo.Spherical("wrist", b["end"], ball["origin"])
    span = jo.Distance(ball["m"], loose["origin"], name="span")
    drive = jo.Drive("motor", hinge.angle, jo.Harmonic(frequency=1.0, amplitude=0.3))
    wave = jo.Harmonic(frequency=3.0, offset=0.5)
    moving = b["end"].turned(jo.Rotate((1, 2, 3), degrees=50))

    def air(t: float, x: Any) -> list[float]:
        return [*(-0.3 * x[12:15]), *(-0.1 * x[15:18] + 0.2 * x[3:6])]

    forces = (
        jo.Spring("spring", span, 300.0, 5.0, preload=2.0),
        jo.Spring("table", cross.angle1, table=jo.Table([-1, 0, 1], [2.0, 0.0, -5.0])),
        jo.Servo("servo", cross.angle2, wave, kp=3.0, kd=0.1, limit=1.0),
        jo.JointForce("motor torque", cross.angle1, wave),
        jo.mechanism.GearSpring("gear", cross.angle2, cross.angle1, -3.0, 20.0, damping=0.2),
        jo.mechanism.Stop("stop", cross.angle2, upper=-0.02, stiffness=40.0, restitution=0.3),
        jo.Bushing("bush", a["node3"], loose["origin"], (200, 300, 100, 4, 5, 6), 2.0),
        jo.Force("push", b["node3"], (100, 200, 300), signal=wave),
        jo.Force("follow", ball["m"], (4, 0, 1), follow=True),
        jo.Torque("torque", a["end"], (50, 100, 200)),
        jo.Torque("twist", b["node2"], (1, 0.2, 0.3), follow=True),
        jo.mechanism.ModalLoad("pressure", a, np.outer(np.arange(5), (0.0, 1.0, 0.5)), signal=wave),
        jo.UserForce("air", ball["m"], air, reference=a["end"]),
        jo.mechanism.MovingLoad(
            "wheel", b, ("start", "end"), (0, 0, -8.0), jo.Ramp(0.0, 1.0, before=0.2)
        ),
    )
    motions = (
        *(jo.PositionSensor, jo.VelocitySensor, jo.AccelerationSensor, jo.OrientationSensor),
        *(jo.AngularVelocitySensor, jo.mechanism.AngularAccelerationSensor),
        jo.mechanism.AccelerationPartsSensor,
    )
    sensors = [
        *(kind(f"{kind.__name__} world", moving) for kind in motions),
        *(kind(f"{kind.__name__} seen", moving, relative_to=a["node3"]) for kind in motions),
        *(
            kind(
                f"{kind.__name__} turned", moving, relative_to=loose["origin"], resolved_in=a["end"]
            )
            for kind in motions
        ),
        *(jo.ReactionSensor(f"at {j.name}", j) for j in (hinge, cross, wrist, drive)),
        jo.ReactionSensor("in joint", hinge, resolved_in="joint"),
        *(jo.ForceSensor(f"of {f.name}", f) for f in forces),
        jo.CoordinateSensor("angle", cross.angle2),
        jo.RateSensor("rate", cross.angle2),
        jo.RateSensor("closing", span),
        jo.SignalSensor("wave", wave),
        jo.mechanism.ModalSensor("modes", b),
        jo.StressSensor("stress", a, ("e2.a.top", "e3.b.left")),
        jo.VonMisesSensor("mises", b, ("e2.a.top",)),
        jo.mechanism.PrincipalStressSensor("principal", b, ("e2.a.top",)),
        jo.gauges.Gauge("gauge", a, "e2.a.top"),
        *(
            jo.mechanism.EnergySensor(energy, energy)
            for energy in ("kinetic", "strain", "potential", "springs")
        ),
    ]
    bodies = (a, b, ball, loose)
    return jo.Mechanism(
        *bodies, hinge, cross, wrist, drive, *forces, *sensors, G, name="everything"
    )


def rssr(modes: Reduction, elements: int = 24) -> jo.Mechanism:
    """A crank, a slender coupler between two balls and a rocker that turns about another axis."""
    radius, arm, hinge = 0.05, 0.3, np.array([0.3, 0.5, 0.0])
    pin = radius * np.eye(3)[0]
    along = hinge + (0, 0, arm) - pin
    length = float(np.linalg.norm(along))
    x = along / length
    y = np.cross((0, 0, 1), x) / np.linalg.norm(np.cross((0, 0, 1), x))
    section = jo.Rectangle(0.005, 0.0065)
    part = jo.Part.beam(length, section, elements, jo.material("S355"), name="coupler")
    crank = jo.RigidBody("crank", 1.0, (0.001, 0.002, 0.002), center=(0.03, 0, 0))
    crank = replace(crank, angular_velocity=(0, 0, 1.0), markers={"pin": pin})
    coupler = jo.FlexibleBody(
        "coupler",
        jo.reduce(part, modes),
        position=pin,
        orientation=np.column_stack([x, y, np.cross(x, y)]),
    )
    rocker = jo.RigidBody("rocker", 1.0, (0.01, 0.01, 0.001), center=(0, 0, 0.1), position=hinge)
    rocker = replace(rocker, markers={"pin": (0, 0, arm)})
    shaft = jo.Revolute("shaft", jo.ground["origin"], crank["origin"], axis=(0, 0, 1))
    swing = jo.Revolute("swing", jo.ground.at(hinge), rocker["origin"], axis=(1, 0, 0))
    first = jo.Spherical("first ball", crank["pin"], coupler["start"])
    second = jo.Spherical("second ball", coupler["end"], rocker["pin"])
    motor = jo.Drive("motor", shaft.angle, jo.ConstantSpeed(1.0))
    bodies, joints = (crank, coupler, rocker), (shaft, swing, first, second, motor)
    return jo.Mechanism(*bodies, *joints, jo.Gravity((0, 0, -9.81)), name="RSSR")


def differences(
    mechanism: jo.Mechanism, run: jo.Solution, every: int = 1
) -> Iterator[tuple[str, float]]:
    """Yield the name of every sensor and by how much of its size both readings differ."""
    found = read(mechanism, run, every)
    for name, values in found.readings.items():
        engine = run[name][::every]
        yield name, float(np.abs(values - engine).max() / max(np.abs(engine).max(), 1e-6))


def read(mechanism: jo.Mechanism, run: jo.Solution, every: int = 1) -> Instants:
    """Return what the second formulation reads at the states of a run."""
    states = (run.state(float(t)) for t in run.time)
    return at_states(mechanism, states, mechanism.sensors, every)
