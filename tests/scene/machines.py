"""Small machines for the tests of scenes: one with every kind of joint, force and sensor."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

import jousto as jo
from jousto.base.declare import kinds

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
SECTION = jo.Rectangle(0.02, 0.03)
Z = (0.0, 0.0, 1.0)


@cache
def reduced(elements: int = 4, section: Any = SECTION, modes: int = 3) -> jo.ReducedPart:
    part = jo.Part.beam(1.0, section, elements, STEEL, name="rod")
    return jo.reduce(part, jo.CraigBampton(("start", "end"), modes=modes))


@cache
def corner() -> jo.ReducedPart:
    """Return a frame with a corner, two sections and rigid arms."""
    arms = np.zeros((3, 2, 3))
    arms[2, 0] = 0.0, 0.02, 0.0
    tube = jo.Tube(0.04, 0.003)
    part = jo.Part.frame(
        [[0, 0, 0], [0.5, 0, 0], [1, 0, 0], [1, 0.8, 0.2]],
        [[0, 1], [1, 2], [2, 3]],
        sections=[SECTION, SECTION, tube],
        materials=STEEL,
        offsets=arms,
        node_sets={"foot": 0, "head": 3},
        name="corner",
    )
    return jo.reduce(part, jo.CraigBampton(("foot", "head"), modes=4))


def ball(name: str, position: Any = (0, 0, 0), **more: Any) -> jo.RigidBody:
    return jo.RigidBody(
        name, 2.0, (0.3, 0.4, 0.5), center=(0.1, 0.2, -0.1), position=position, **more
    )


WHEELS = ("rolling-disc", "rolling-wheel", "rail-wheel")


def joint_of(kind: Any, a: Any, b: Any) -> Any:
    """Return a joint of each kind between two origins that coincide, or stand apart (APART)."""
    more: dict[str, Any] = {"axle": (0, 1, 0)} if kind.tag in WHEELS else {}
    if kind.tag == "knife-edge":
        more = {"across": (0, 1, 0)}
    numbers = (0.3,) if kind.tag == "screw" or "axle" in more else ()
    return kind("joint", a, b, *numbers, **more)


APART = {"rod": (0.7, 0.2, 0.4), **dict.fromkeys(WHEELS, (0, 0, 0.3))}


JOINTS = kinds("joints", "jousto.mechanism.joints")
COUPLINGS = kinds("couplings", "jousto.mechanism.joints")
FORCES = kinds("forces", "jousto.mechanism.forces")
SENSORS = kinds("sensors", "jousto.mechanism.sensors")


def jointed(kind: Any) -> jo.Mechanism:
    one, two = ball("one"), ball("two", APART.get(kind.tag, (0, 0, 0)))
    return jo.Mechanism(one, two, joint_of(kind, one["origin"], two["origin"]))


@cache
def everything() -> jo.Mechanism:
    """Return a machine with every coupling, force and sensor."""
    arm = jo.FlexibleBody("arm", reduced(), position=(0, 0, 1))
    slider = ball("slider", (0, 2, 0), markers={"tip": (0.3, 0, 0)})
    wheel = jo.RigidBody.cylinder("wheel", radius=0.2, length=0.05, mass=3, position=(0, 3, 0))
    driven, cart = ball("driven", (0, 5, 0)), ball("cart", (0, 6, 0))
    rope = jo.BeamBody("rope", [(0, 4, 0), (1, 4, 0)], jo.Circle(0.01), STEEL, elements=3)
    hinge = jo.Revolute("hinge", jo.ground.at((0, 0, 1)), arm["start"], Z)
    slide = jo.Prismatic("slide", jo.ground.at((0, 2, 0)), slider["origin"], (1, 0, 0))
    axle = jo.Revolute("axle", jo.ground.at((0, 3, 0)), wheel["origin"], Z)
    motor = jo.Revolute("motor", jo.ground.at((0, 5, 0)), driven["origin"], Z)
    rail = jo.Prismatic("rail", jo.ground.at((0, 6, 0)), cart["origin"], (1, 0, 0))
    clamp = jo.Fixed("clamp", jo.ground.at((0, 4, 0)), rope["start"])
    end, distance = arm["end"], jo.Distance(arm["end"], slider["tip"])
    spring = jo.Spring("spring", distance, 100.0, damping=2.0)
    yields = jo.mechanism.PlasticSpring("yields", slide.displacement, 1e4, 50.0)
    stress = jo.StressSensor("stress", arm, ("e1.a.top",))
    top = jo.gauges.Gauge("gauge", arm, "e1.a.top")
    pattern = np.zeros((5, 3))
    pattern[2] = 0.0, 0.0, 1.0
    return jo.Mechanism(
        *(arm, slider, wheel, driven, cart, rope, hinge, slide, axle, motor, rail, clamp),
        jo.Gear("gear", hinge.angle, axle.angle, -2.0),
        jo.Drive("drive", motor.angle, jo.Constant(0.0)),
        jo.Drive("push", rail.displacement, jo.Constant(0.0)),
        jo.Gravity((0, 0, -9.81)),
        spring,
        jo.Spring("stop", hinge.angle, damping=1.0),
        jo.Bushing("bushing", jo.ground.at((0, 2, 0.1)), slider["origin"], np.ones(6)),
        jo.JointForce("torque", axle.angle, jo.Constant(1.0)),
        jo.mechanism.Stop("limit", slide.displacement, upper=0.4, stiffness=1e4),
        yields,
        jo.mechanism.GearSpring("shaft", slide.displacement, motor.angle, 30.0, 50.0, damping=1.0),
        meet := jo.mechanism.Contacts(
            "meet",
            [
                jo.mechanism.CollisionShape("floor", jo.ground["origin"], jo.mechanism.HalfSpace()),
                jo.mechanism.CollisionShape("tip", slider["tip"], jo.mechanism.Sphere(0.05)),
            ],
            law=jo.mechanism.PowerLaw(1e6),
            overlap="start",
        ),
        touch := jo.mechanism.Contact(
            *("touch", jo.ground["origin"], jo.mechanism.HalfSpace()),
            *(slider["tip"], jo.mechanism.Sphere(0.05), jo.mechanism.PowerLaw(1e6)),
            mu_kinetic=0.3,
        ),
        jo.mechanism.TrackContact(
            *("trolley", (arm["start"], arm["end"]), slider["tip"], jo.mechanism.PowerLaw(1e6)),
            up=(0, 0, -1),
        ),
        jo.mechanism.SkinContact(
            *("bed", jo.ground.at((0, 4, -5)), jo.mechanism.HalfSpace(), rope),
            jo.mechanism.PowerLaw(1e6),
        ),
        jo.mechanism.Slider("runner", (arm["start"], arm["end"]), slider["tip"], 1e5),
        jo.mechanism.Tyre(
            *("tyre", jo.ground.at((0, 0, -50.0)), wheel["origin"], 0.3),
            *(jo.mechanism.MagicFormula(), 2e5),
            axle=(0, 1, 0),
        ),
        railway := jo.mechanism.RailContact(
            *("railway", jo.ground.at((0, 0, -50.0)), wheel["origin"], 0.3), axle=(0, 1, 0)
        ),
        jo.Servo("servo", slide.displacement, jo.Constant(0.1), kp=10.0),
        jo.mechanism.PID("hold", slide.displacement, 0.1, kp=10.0, ki=1.0),
        jo.mechanism.SpeedPID("spin", axle.angle, 1.0, kp=1.0),
        jo.mechanism.ModalLoad("suction", arm, pattern),
        jo.UserForce("drag", slider["tip"], lambda t, x: [0.0] * 6),
        jo.mechanism.LineLoad("wind", rope, (0, 1.0, 0)),
        jo.Force("pull", end, (0, 3.0, 0)),
        jo.Force("thrust", slider["tip"], (1.0, 0, 0), follow=True),
        jo.Torque("twist", wheel["origin"], (0, 0, 1.0)),
        jo.mechanism.MovingLoad("walker", arm, ("start", "end"), (0, 0, -1.0), jo.Constant(0.3)),
        jo.Friction("rub", axle, 0.1, radius=0.02),
        jo.PositionSensor("position", end),
        jo.mechanism.ContactForceSensor("landing", meet, "floor", "tip"),
        jo.mechanism.ContactPressureSensor("pressure", touch, modulus=1e11),
        jo.mechanism.RailContactSensor("rolling", railway),
        jo.VelocitySensor("velocity", end),
        jo.AccelerationSensor("acceleration", end),
        jo.mechanism.AccelerationPartsSensor("parts", end, relative_to=slider["tip"]),
        jo.OrientationSensor("orientation", end),
        jo.AngularVelocitySensor("spin", end),
        jo.mechanism.AngularAccelerationSensor("wheeling", end),
        jo.mechanism.ModalSensor("modal", arm),
        jo.mechanism.DeformationMomentumSensor("momentum", arm),
        jo.mechanism.BodyLoadSensor("loads", arm, "applied"),
        jo.mechanism.ModalLoadSensor("modal loads", arm, "inertia"),
        jo.ReactionSensor("reaction", hinge),
        jo.ReactionSensor("drive torque", axle),
        jo.ForceSensor("felt", spring),
        jo.mechanism.ForceStateSensor("bent", yields),
        jo.mechanism.SectionSensor("section", rope),
        stress,
        jo.VonMisesSensor("mises", arm),
        jo.mechanism.PrincipalStressSensor("principal", arm, ("e1.a.top", "e2.b.left")),
        jo.CoordinateSensor("angle", hinge.angle),
        jo.RateSensor("rate", distance),
        jo.mechanism.EnergySensor("energy", "kinetic"),
        jo.SignalSensor("signal", jo.Constant(3.0)),
        jo.mechanism.StateSensor("stretch", jo.mechanism.value(distance) - 0.5, unit="m"),
        jo.mechanism.DamageSensor(
            "damage",
            stress,
            jo.SN(100e6, 1e6, 5.0, "haibach", T_S=1.25),
            residue="repeat",
            components="e1.a.top:s11",
        ),
        top,
        jo.gauges.Rosette("rosette", arm, "e1.a.top"),
        jo.gauges.Bridge("bridge", (top,)),
        name="everything",
    )
