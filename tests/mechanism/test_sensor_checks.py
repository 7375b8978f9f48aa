"""What is wrong with sensors, and joints on nodes that are no interfaces, in sentences."""

from __future__ import annotations

import dataclasses
import warnings

import numpy as np
import pytest

from jousto.base.errors import InputError, JoustoWarning
from jousto.materials.material import Material
from jousto.mechanism.bodies.body import FlexibleBody, RigidBody, ground
from jousto.mechanism.forces.friction import Friction
from jousto.mechanism.forces.loads import Gravity
from jousto.mechanism.forces.springs import Bushing, Spring
from jousto.mechanism.joints.coordinate import Distance
from jousto.mechanism.joints.coupling import Drive
from jousto.mechanism.joints.hinges import Revolute
from jousto.mechanism.joints.points import Spherical
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.gauge import Gauge
from jousto.mechanism.sensors.loads import ForceSensor, ReactionSensor
from jousto.mechanism.sensors.motion import (
    AccelerationSensor,
    AngularAccelerationSensor,
    AngularVelocitySensor,
    PositionSensor,
    VelocitySensor,
)
from jousto.mechanism.sensors.scalar import CoordinateSensor
from jousto.mechanism.signals.piecewise import Ramp
from jousto.parts.part import Part
from jousto.reduction.methods import CraigBampton, FreeFree
from jousto.reduction.reducer import reduce
from jousto.sections.section import Rectangle

O = ground["origin"]
G = Gravity((0, 0, -9.81))


def ball(name="ball", **more):
    """Return a rigid body."""
    return RigidBody(name, 1.0, (1, 1, 1), markers={"tip": (1, 0, 0)}, **more)


def sentences(make, *args, **kwargs):
    """Return the problems of a constructor."""
    with pytest.raises(InputError) as error, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        make(*args, **kwargs)
    return [str(problem) for problem in error.value.problems]


def test_all_that_is_wrong_with_a_motion_sensor_is_said_at_once():
    b = ball()
    assert sentences(VelocitySensor, "a/b", b, relative_to="x", resolved_in=b) == [
        "sensor 'a/b': name must not contain '/'",
        "sensor 'a/b': marker is the body 'ball'; name a point of it, ball[...]",
        "sensor 'a/b': relative_to is 'x', must be a marker such as body[\"point\"] or "
        'ground["origin"]',
        "sensor 'a/b': resolved_in is the body 'ball'; name a point of it, ball[...]",
    ]
    tip = b["tip"]
    assert sentences(PositionSensor, "p", tip, relative_to=tip) == [
        "sensor 'p': relative_to is the marker itself, ball.tip: always zero"
    ]


def test_observers_and_axes_on_bodies_outside_are_named():
    b, bal = ball(), ball("bal")
    pivot = Spherical("pivot", O, b["origin"])
    text = "body 'bal' is not in the mechanism; did you mean 'ball'?"
    sensors = (
        AccelerationSensor("a", b["tip"], relative_to=bal["tip"]),
        AngularVelocitySensor("w", b["tip"], resolved_in=bal["tip"]),
        ReactionSensor("r", pivot, resolved_in=bal["tip"]),
        CoordinateSensor("s", Distance(O, bal["tip"], name="reach")),
    )
    assert sentences(Mechanism, b, pivot, G, *sensors) == [
        f"sensor 'a': relative_to: {text}",
        f"sensor 'w': resolved_in: {text}",
        f"sensor 'r': resolved_in: {text}",
        f"sensor 's': reach: {text}",
    ]


def test_forces_drives_and_frictions_outside_are_named():
    b = ball()
    hinge = Revolute("hinge", O, b["origin"])
    spring, twin = (Spring("spring", hinge.angle, 1.0) for _ in range(2))
    drive = Drive("drive", hinge.angle, Ramp(0, 1))
    rub = Friction("rub", hinge, 0.1, radius=0.01)
    sensors = (
        ForceSensor("f", twin),
        ReactionSensor("d", drive),
        ForceSensor("r", rub),
    )
    assert sentences(Mechanism, b, hinge, spring, G, *sensors) == [
        "sensor 'f': spring 'spring' is another spring of that name than the one in the mechanism",
        "sensor 'd': drive 'drive' is not in the mechanism; known: hinge",
        "sensor 'r': friction 'rub' is not in the mechanism; known: spring",
    ]


def test_axes_of_a_node_that_does_not_turn_are_refused(solid):
    beam = FlexibleBody("beam", solid)
    b = ball(position=(5, 0, 0))
    end = beam["end"]
    sensors = (
        AccelerationSensor("fine", end, relative_to=b["tip"]),
        PositionSensor("fine too", b["tip"], relative_to=end, resolved_in=O),
        VelocitySensor("v", b["tip"], relative_to=end, resolved_in=O),
        AccelerationSensor("a", end, resolved_in=end),
        AngularAccelerationSensor("w", end),
    )
    found = sentences(Mechanism, beam, b, G, *sensors)
    assert [text.split(": beam.end")[0] for text in found] == [
        "sensor 'v': relative_to",
        "sensor 'a': resolved_in",
        "sensor 'w': marker",
    ]
    assert all("has no rotation mode shapes" in text for text in found)


def test_forces_along_a_coordinate_have_no_axes():
    b = ball()
    hinge = Revolute("hinge", O, b["origin"])
    spring = Spring("spring", hinge.angle, 1.0)
    drive = Drive("drive", hinge.angle, Ramp(0, 1))
    assert sentences(ForceSensor, "f", spring, resolved_in=O) == [
        "sensor 'f': resolved_in: 'spring' acts along its coordinate, leave resolved_in out"
    ]
    assert sentences(ReactionSensor, "r", drive, resolved_in="joint") == [
        "sensor 'r': resolved_in: the reaction of 'drive' acts along its coordinates, "
        "leave resolved_in out"
    ]
    assert sentences(ReactionSensor, "r", hinge, resolved_in="body") == [
        "sensor 'r': resolved_in is 'body', must be 'world', 'joint' or a marker"
    ]
    assert sentences(ForceSensor, "f", hinge)[0].endswith("a force element such as a Spring")


def test_gauges_of_strain_say_what_is_wrong(rod, solid):
    beam = FlexibleBody("beam", rod)
    assert sentences(Gauge, "e", beam, "e1.a.tpo") == [
        "gauge 'e': at: part 'beam' has no stress site 'e1.a.tpo'; did you mean 'e1.a.top'?"
    ]
    (far,) = sentences(Gauge, "e", beam, (0.3, 0.0, 0.027))
    assert far.startswith(
        "gauge 'e': at: is 2 mm off the beams of part 'beam', more than reach 1 mm"
    )
    assert "the nearest point is (0.3, 0, 0.025) m on element e1" in far
    assert sentences(Gauge, "e", beam, "e1.a.top", (0, 0, 0), E=-1.0, nu=0.7, length=-1) == [
        "gauge 'e': direction is zero",
        "gauge 'e': length is -1 m, must not be negative",
        "gauge 'e': E is -1 Pa, must be positive",
        "gauge 'e': nu is 0.7, must be in (-1, 0.5]",
    ]
    (none,) = sentences(Gauge, "e", FlexibleBody("b", solid), "x")
    assert "has no stress modes and no surface; gauges need a part of beams" in none
    (sheared,) = sentences(Gauge, "e", beam, (0.3, 0.01, 0.025), (1, 1, 0))
    assert "measures shear, which is available at the section points of the beam only" in sheared
    # a position between two sites mixes them
    gauge = Gauge("e", beam, (0.125, 0.0, 0.025))
    ends = [Gauge("e", beam, f"e1.{end}.top").rows for end in "ab"]
    np.testing.assert_allclose(gauge.rows, 0.75 * ends[0] + 0.25 * ends[1], rtol=1e-12)


def test_reduced_files_keep_the_elastic_constants(rod, tmp_path):
    rod.save(tmp_path / "rod.h5")
    loaded = type(rod).load(tmp_path / "rod.h5")
    np.testing.assert_array_equal(loaded.stress.elasticity, rod.stress.elasticity)
    Gauge("e", FlexibleBody("beam", loaded), "e1.a.top")
    # files of parts that do not know them
    old = dataclasses.replace(rod, stress=dataclasses.replace(rod.stress, elasticity=None))
    old.save(tmp_path / "old.h5")
    beam = FlexibleBody("beam", type(rod).load(tmp_path / "old.h5"))
    assert sentences(Gauge, "e", beam, "e1.a.top") == [
        "gauge 'e': E is missing; give it, part 'beam' has no material data",
        "gauge 'e': nu is missing; give it, part 'beam' has no material data",
    ]


# -- interfaces -------------------------------------------------------------------------------


def part():
    """Return a steel beam with nodes start, node2 .. node8, end."""
    steel = Material(E=210e9, nu=0.3, rho=7850.0)
    return Part.beam(2.0, Rectangle(0.1, 0.05), 8, steel, name="boom")


def warned(reduced, connect):
    """Return the warnings of a mechanism of a beam and a ball."""
    beam = FlexibleBody("beam", reduced)
    b = ball(position=(0.25, 0, 0))
    pivot = Spherical("pivot", O, beam["start"])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", JoustoWarning)
        Mechanism(beam, b, pivot, G, connect(beam["node2"], b["origin"]))
    return [str(item.message) for item in caught if "interface" in str(item.message)]


@pytest.mark.parametrize(
    ("connect", "where"),
    [
        (lambda x, y: Spherical("weld", x, y), "joint 'weld'"),
        (lambda x, y: Bushing("rubber", x, y, (1,) * 6), "bushing 'rubber'"),
        (lambda x, y: Spring.between("rope", O, x, 1.0), "spring 'rope'"),
    ],
)
def test_a_joint_on_a_node_that_is_no_interface_warns(connect, where):
    few = CraigBampton(("start", "end"), modes=2)
    found = warned(reduce(part(), few), connect)
    assert len(found) == 1
    assert found[0].startswith(
        f"{where}: beam.node2 is not an interface of part 'boom' (the interfaces are start, end): "
    )
    assert "reduce it with 'node2' among the interfaces" in found[0]
    # what the sentence asks for helps, and so do many modes
    assert not warned(reduce(part(), CraigBampton(("start", "end", "node2"), modes=2)), connect)
    assert not warned(reduce(part(), CraigBampton(("start", "end"), modes=20)), connect)
    # free modes have no interfaces to choose from
    assert not warned(reduce(part(), FreeFree(modes=5)), connect)
