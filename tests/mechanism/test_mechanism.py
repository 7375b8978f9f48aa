"""Mechanisms: joint frames, and every check with its sentence."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jousto as jo
import session
from jousto.base.declare import kinds
from jousto.base.errors import InputError, JoustoWarning
from jousto.base.rotations import Rotate
from jousto.mechanism.beams.body import BeamBody, BeamDamping
from jousto.mechanism.beams.discretisation import BeamNode
from jousto.mechanism.beams.stiffness import BeamSection
from jousto.mechanism.bodies.body import FlexibleBody, Ground, RigidBody, ground
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.event import Event
from jousto.mechanism.forces.friction import Friction, Regularised, StickSlip
from jousto.mechanism.forces.loads import Force, Gravity, Torque
from jousto.mechanism.initial import Initial
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coordinate import Angle, Coordinate, Displacement, Distance, Line
from jousto.mechanism.joints.coupling import Coupler
from jousto.mechanism.joints.hinges import Revolute
from jousto.mechanism.joints.points import Spherical
from jousto.mechanism.joints.slides import Fixed
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.body import ModalSensor, StressSensor
from jousto.mechanism.sensors.loads import ReactionSensor
from jousto.mechanism.sensors.motion import (
    AngularVelocitySensor,
    OrientationSensor,
    PositionSensor,
    VelocitySensor,
)
from jousto.mechanism.sensors.temperature import Temperature
from jousto.mechanism.signals.base import Signal
from jousto.mechanism.signals.harmonic import Harmonic
from jousto.mechanism.signals.piecewise import Step, Table

G = Gravity((0, -9.81, 0))


def ball(name: str = "ball", **kwargs) -> RigidBody:
    return RigidBody(name, 1.0, (1, 1, 1), markers={"tip": (1, 0, 0)}, **kwargs)


def pivot(body, name: str = "pivot") -> Spherical:
    return Spherical(name, ground["origin"], body["origin"])


def problems(*items, **kwargs) -> list[str]:
    with pytest.raises(InputError) as error, warnings.catch_warnings():
        warnings.simplefilter("error")
        Mechanism(*items, **kwargs)
    return [str(problem) for problem in error.value.problems]


# -- frames of joints -----------------------------------------------------------------------


def random_bodies(rod):
    """A flexible and a rigid body in general position whose points meet, deformed."""
    rng = np.random.default_rng(5)
    arm = FlexibleBody(
        "arm", rod, orientation=Rotation.from_rotvec([0.4, 0.5, -0.6]), position=(1, 2, 3),
        modal_coordinates=1e-2 * rng.normal(size=rod.n),
    )  # fmt: skip
    turn = Rotation.from_rotvec([-0.7, 0.1, 0.2])
    position = arm["end"].r - turn.as_matrix() @ [1, 0, 0]
    return arm, ball(position=position, orientation=turn)


AXIS = np.array([1.0, 2.0, -2.0])


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (lambda a, b: Revolute("j", a, b, axis=AXIS), AXIS / 3),
        (lambda a, b: Revolute("j", a, b), None),
        (lambda a, b: Fixed("j", a, b), None),
    ],
)
def test_both_frames_of_a_joint_agree_at_the_initial_pose(rod, make, expected):
    arm, other = random_bodies(rod)
    joint = make(arm["end"].turned(Rotate((0, 1, 0), degrees=30)), other["tip"])
    a, b = joint.frames
    np.testing.assert_allclose(a.A, b.A, atol=1e-14)
    z = joint.a.A[:, 2] if expected is None else expected
    np.testing.assert_allclose(a.A[:, 2], z, atol=1e-14)
    np.testing.assert_allclose(a.r, joint.a.r)
    if isinstance(joint, Revolute):
        np.testing.assert_allclose(joint.axis_world, z, atol=1e-14)


def test_every_joint_load_sensor_and_signal_is_exported_and_in_its_tuple():
    public = {place.rpartition(".")[2]: thing for place, thing in session.public().items()}
    rooms = ("jousto.mechanism", "jousto.base.rotations")
    classes = {k: v for k, v in public.items() if getattr(v, "__module__", "").startswith(rooms)}
    room = "jousto.mechanism.joints"
    declared = [*kinds("joints", room).values(), *kinds("couplings", room).values()]
    signals = kinds("signals", "jousto.mechanism.signals").values()
    forces = kinds("forces", "jousto.mechanism.forces").values()
    sensors = kinds("sensors", "jousto.mechanism.sensors").values()
    tuples = (*declared, *sensors, *signals, *forces)
    for cls in tuples:
        assert classes[cls.__name__] is cls
    found = {c for c in classes.values() if isinstance(c, type)}
    others = {Ground, RigidBody, FlexibleBody, Marker, Mechanism, Rotate, Gravity}
    # what they have in common, and what they refer to
    others |= {Joint, Coupler, Signal, Line, Event, Friction}
    others |= {Regularised, StickSlip, Temperature, Initial}
    others |= {BeamBody, BeamDamping, BeamNode, BeamSection}
    others |= {Coordinate, Angle, Displacement, Distance}
    others |= {jo.Fmu}  # a model of another program beside it
    others |= {jo.mechanism.ElasticJoint, jo.mechanism.HarmonicDrive}
    others |= set(kinds("tyre_laws", "jousto.mechanism.forces").values())
    for section in ("contact shapes", "contact laws"):
        others |= set(kinds(section, "jousto.mechanism.contacts").values())
    names = ("Apart", "CollisionShape", "Surface", "SurfacePair")  # parts of a set of contacts
    names += ("Block", "States", "Equations", "Expression")  # equations beside the machine
    names += ("RopeSpan",)  # a coordinate
    others |= set(kinds("states", "jousto.mechanism.states").values())
    others |= {getattr(jo.mechanism, name) for name in names}
    others |= {getattr(jo.hydraulics, name) for name in jo.hydraulics.__all__}  # of such a block
    others |= {one for one in found if issubclass(one, jo.mechanism.Block)}
    assert set(tuples) <= found <= set(tuples) | others


# -- what a mechanism holds -----------------------------------------------------------------


def test_items_keep_their_order_by_kind(rod):
    arm = FlexibleBody("arm", rod)
    two = ball("two", position=(2, 0, 0))
    j1 = Spherical("j1", ground["origin"], arm["start"])
    j2 = Revolute("j2", arm["end"], two["origin"])
    push = Force("push", two["tip"], (1, 0, 0), signal=Harmonic(frequency=2.0))
    turn = Torque("turn", two["tip"], (0, 0, 1), follow=True)
    s1, s2 = PositionSensor("s1", arm["end"]), ReactionSensor("s2", j1)
    m = Mechanism(s1, j2, turn, arm, G, j1, two, push, s2, name="chain")
    assert m.bodies == (arm, two)
    assert m.joints == (j2, j1)
    assert m.forces == (turn, push)
    assert m.sensors == (s1, s2)
    np.testing.assert_array_equal(m.gravity, [0, -9.81, 0])
    assert m.size == pytest.approx(3.0)
    R, A, e = m.pose(two)
    assert (R.tolist(), A.tolist(), e.tolist()) == ([2, 0, 0], np.eye(3).tolist(), [1, 0, 0, 0])
    assert repr(m) == "<Mechanism 'chain': 2 bodies, 2 joints, 2 forces, 2 sensors>"


def test_a_sound_mechanism_does_not_warn():
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        b = ball()
        Mechanism(b, pivot(b), G)
    assert not said


# -- errors ---------------------------------------------------------------------------------


def test_unknown_bodies_are_named_with_a_suggestion():
    boom, bom = ball("boom"), ball("bom")
    joint = pivot(boom)
    found = problems(
        boom, joint, G,
        Spherical("j", ground["origin"], bom["origin"]),
        Force("f", bom["tip"], (1, 0, 0)),
        PositionSensor("s", bom["tip"]),
    )  # fmt: skip
    text = "body 'bom' is not in the mechanism; did you mean 'boom'?"
    assert found == [f"joint 'j': b: {text}", f"force 'f': marker: {text}",
                     f"sensor 's': marker: {text}"]  # fmt: skip


def test_another_body_of_the_same_name_is_not_the_same_body():
    one, two = ball("arm"), ball("arm")
    assert problems(one, pivot(two), G) == [
        "joint 'pivot': b: body 'arm' is not the body of that name in the mechanism; use that one"
    ]


def test_unknown_joint_of_a_reaction_sensor():
    b = ball()
    joint, other, twin = pivot(b), pivot(b, "pivo"), pivot(b)
    assert problems(b, joint, G, ReactionSensor("r", other), ReactionSensor("t", twin)) == [
        "sensor 'r': joint 'pivo' is not in the mechanism; did you mean 'pivot'?",
        "sensor 't': joint 'pivot' is another joint of that name than the one in the mechanism",
    ]


def test_modal_sensor_of_a_body_outside(rod):
    b, arm = ball(), FlexibleBody("arm", rod)
    assert problems(b, pivot(b), G, ModalSensor("m", arm)) == [
        "sensor 'm': body: body 'arm' is not in the mechanism; known: ball"
    ]


def test_items_given_twice_and_names_used_twice():
    one, two = ball("arm"), ball("arm")
    joint = pivot(one)
    assert problems(one, two, joint, joint, pivot(two), G, one) == [
        "joint 'pivot': given twice, leave one out",
        "body 'arm': given twice, leave one out",
        "body 'arm': 2 bodies have this name, names must differ",
        "joint 'pivot': 2 joints have this name, names must differ",
    ]


def test_forces_and_torques_share_their_names():
    b = ball()
    found = problems(b, pivot(b), Force("f", b["tip"], (1, 0, 0)), Torque("f", b["tip"], (1, 0, 0)))
    assert found == ["torque 'f': 2 forces have this name, names must differ"]


def test_several_gravities():
    b = ball()
    assert problems(b, pivot(b), G, Gravity((0, 0, -9.81))) == [
        "gravity: 2 Gravity items, only one is allowed"
    ]


def test_joints_that_connect_nothing():
    b = ball()
    found = problems(
        b, pivot(b), G,
        Spherical("self", b["tip"], b["tip"]),
        Spherical("same", b["tip"], b["origin"]),
        Fixed("ground", ground["origin"], ground.at((1, 0, 0))),
    )  # fmt: skip
    assert found == [
        "joint 'self': connects ball.tip with itself",
        "joint 'same': both markers are on body 'ball', ball.tip and ball.origin; "
        "a joint connects two bodies",
        "joint 'ground': both markers are on the ground, ground.origin and ground.at(1, 0, 0)",
    ]


def test_initial_gap_is_reported_in_mm_with_both_points():
    b = ball(position=(0.0, 0.0025, 0.0))
    assert problems(b, pivot(b), G) == [
        "joint 'pivot': initial gap of 2.5 mm: ground.origin is at (0, 0, 0), ball.origin at "
        "(0, 0.0025, 0) m; move a body until the points meet"
    ]


def test_a_gap_below_a_millionth_of_the_size_is_closed_later():
    # the ball reaches from its origin to its tip: 1 m
    b = ball(position=(0.0, 0.9e-6, 0.0))
    Mechanism(b, pivot(b), G)
    b = ball(position=(0.0, 1.1e-6, 0.0))
    assert "initial gap of 0.0011 mm" in problems(b, pivot(b), G)[0]


def test_gap_of_a_deformed_body_counts(rod):
    p = np.zeros(rod.n)
    p[0] = 1.0
    arm = FlexibleBody("arm", rod, modal_coordinates=p)
    gap = np.linalg.norm(rod.modes[rod.node("end")] @ p)
    (found,) = problems(arm, Spherical("j", ground.at((2, 0, 0)), arm["end"]), G)
    assert f"initial gap of {1e3 * gap:.6g} mm" in found


def test_items_that_are_no_items(rod):
    b = ball()
    joint = pivot(b)
    found = problems(b, joint, G, ground, [b], b["tip"], rod, 3)
    assert found == [
        "item 4: the ground always exists, leave it out",
        "item 5: is a list; write Mechanism(*items)",
        "item 6: is the marker ball.tip; give the body 'ball' instead",
        "item 7: is a ReducedPart; make a body of it, FlexibleBody(name, reduced)",
        "item 8: is a int; must be a body, joint, force or sensor",
    ]


def test_no_bodies():
    assert problems(G) == ["mechanism: has no bodies"]


def test_everything_at_once():
    one, two = ball("arm"), ball("arm", position=(0, 1, 0))
    found = problems(one, two, pivot(two), G, Gravity((1, 0, 0)), 5)
    assert len(found) == 4


def test_nodes_without_rotations_can_only_be_translated(solid):
    arm = FlexibleBody("arm", solid)
    start, end = arm["start"], arm["end"]
    found = problems(
        arm, G,
        Revolute("hinge", ground["origin"], start),
        Torque("t", end, (1, 0, 0)),
        Force("f", end, (1, 0, 0), follow=True),
        OrientationSensor("o", end),
        AngularVelocitySensor("w", end),
        VelocitySensor("v", end),
        Force("g", end, (1, 0, 0)),
    )  # fmt: skip
    assert [f.partition(":")[0] for f in found] == [
        "joint 'hinge'", "torque 't'", "force 'f'", "sensor 'o'", "sensor 'w'"
    ]  # fmt: skip
    assert "arm.start has no rotation mode shapes" in found[0]


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda b: Revolute("j", ground["origin"], b["tip"], axis=(0, 0, 0)),
         "joint 'j': axis is (0, 0, 0), must have a direction"),
        (lambda b: Revolute("j", ground["origin"], b["tip"], axis=(0, 1)),
         "joint 'j': axis has shape (2,), must be (3)"),
        (lambda b: Spherical("j", ground["origin"], b),
         "joint 'j': b is the body 'ball'; name a point of it, ball[...]"),
        (lambda b: Spherical("j", (0, 0, 0), b["tip"]),
         "joint 'j': a is (0, 0, 0), must be a marker such as body[\"point\"] or "
         'ground["origin"]'),
        (lambda b: Force("f", b["tip"], (0, np.nan, 0)),
         "force 'f': vector[1] is nan, must be finite"),
        (lambda b: Torque("t", b["tip"], (0, 0)), "torque 't': vector has shape (2,), must be (3)"),
        (lambda b: Force("f", b["tip"], (0, 1, 0), signal="3"),
         "force 'f': signal is '3', must be a number or a signal such as Step(1.0)"),
        (lambda b: Gravity((0, -9.81)), "gravity: acceleration has shape (2,), must be (3)"),
        (lambda b: PositionSensor("s/t", b["tip"]),
         "sensor 's/t': name must not contain '/'"),
        (lambda b: ModalSensor("m", b),
         "sensor 'm': body is <RigidBody 'ball': 1 kg>, must be a flexible body"),
        (lambda b: ReactionSensor("r", b["tip"]),
         "sensor 'r': joint is <Marker 'ball.tip'>, must be a joint"),
        (lambda b: b["tip"].turned((1, 0)), "marker ball.tip: axes has shape (2,); must be four"),
        (lambda b: Harmonic(frequency=-1), "Harmonic: frequency is -1 Hz, must not be negative"),
        (lambda b: Step(np.inf), "Step: time is inf, must be finite"),
        (lambda b: Table((0, 1, 1), (0, 1, 2)),
         "Table: times must increase: times[1] = 1 s, times[2] = 1 s"),
        (lambda b: Table((0, 1), (0, 1, 2)),
         "Table: 2 times but 3 values, both must have the same number"),
        (lambda b: Table((), ()), "Table: times is empty, must have at least one point"),
    ],
)  # fmt: skip
def test_bad_constructor_arguments_say_why(make, sentence):
    with pytest.raises(InputError) as error:
        make(ball())
    assert sentence in str(error.value)


def test_stress_sites(rod, solid):
    arm = FlexibleBody("arm", rod)
    labels = rod.stress.labels
    sensor = StressSensor("s", arm, sites=(labels[3], labels[1]))
    assert sensor.indices == (3, 1)
    assert sensor.components[:2] == (f"{labels[3]}:s11", f"{labels[3]}:s22")
    assert len(StressSensor("s", arm).components) == 6 * len(labels)
    with pytest.raises(InputError) as error:
        StressSensor("s", arm, sites=("e1.a.topp",))
    assert "sensor 's': sites: body 'arm' has no stress site 'e1.a.topp'; did you mean" in str(
        error.value
    )
    with pytest.raises(InputError, match="sites is empty"):
        StressSensor("s", arm, sites=())
    with pytest.raises(InputError, match="has no stress modes"):
        StressSensor("s", FlexibleBody("b", solid))


def test_modal_sensor_names_its_components(rod):
    sensor = ModalSensor("m", FlexibleBody("arm", rod))
    n = rod.n
    assert sensor.components[0] == "p1"
    assert sensor.components[n] == "p1'"
    assert len(sensor.components) == 2 * n


# -- signals --------------------------------------------------------------------------------


def test_signals_are_the_functions_they_say():
    t = np.linspace(-1, 3, 41)
    wave = Harmonic(frequency=0.5, amplitude=2.0, phase=0.3, offset=1.0)
    np.testing.assert_allclose(wave(t), 1 + 2 * np.sin(np.pi * t + 0.3), atol=1e-15)
    np.testing.assert_array_equal(Step(1.0, before=2.0, after=5.0)([0.99, 1.0, 2.0]), [2, 5, 5])
    np.testing.assert_allclose(
        Table((0, 1, 2), (1, 3, -1))([-5, 0.5, 1, 1.75, 9]), [1, 2, 3, 0, -1]
    )


# -- warnings -------------------------------------------------------------------------------


def test_an_unconnected_body_is_a_warning():
    b, lost = ball(), ball("lost")
    with pytest.warns(JoustoWarning) as caught:
        Mechanism(b, pivot(b), lost, G)
    assert [str(w.message) for w in caught] == [
        "body 'lost': has no joint to another body, so it moves freely"
    ]


def test_a_mechanism_at_rest_is_fine():
    """It may be made for its modes; `simulate` alone says that nothing will move."""
    b = ball()
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        still = Mechanism(b, pivot(b), name="still")
    assert not said
    assert still.bodies == (b,)


@pytest.mark.parametrize(
    "start",
    [
        {"velocity": (1, 0, 0)},
        {"angular_velocity": (0, 0, 1)},
        {"modal_coordinates": [1e-3] * 8},
        {"modal_velocities": [1e-3] * 8},
    ],
)
def test_an_initial_state_moves_without_forces(rod, start):
    arm = FlexibleBody("arm", rod, **start)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        # a large gap tolerance is not needed: the joint is at the deformed point
        Mechanism(arm, Spherical("j", ground.at(arm["start"].r), arm["start"]))
    # neither of the joint nor of a mechanism that nothing moves
    assert [str(w.message) for w in caught] == []


def test_a_force_on_the_ground_is_a_warning():
    body = ball()
    with pytest.warns(JoustoWarning) as caught:
        Mechanism(body, pivot(body), Torque("wind", ground["origin"], (0, 0, 1)))
    assert [str(item.message) for item in caught] == [
        "torque 'wind': acts on the ground, it has no effect",
    ]


@pytest.mark.parametrize("name", [".", ".."])
def test_names_that_mean_a_folder(name):
    with pytest.raises(InputError, match="name must not be '.' or '..'"):
        pivot(ball(), name)


def test_the_length_of_the_axis_of_a_joint(recwarn):
    body = ball()
    joint = Revolute("j", ground["origin"], body["origin"], axis=(0, 3e-149, 4e-149))
    np.testing.assert_allclose(joint.axis_world, [0, 0.6, 0.8], atol=1e-15)
    np.testing.assert_allclose(joint.frames[0].A[:, 2], [0, 0.6, 0.8], atol=1e-15)
    with pytest.raises(InputError, match="must have a direction"):
        Revolute("j", ground["origin"], body["origin"], axis=(1e-300, 0, 0))
    assert not recwarn.list
