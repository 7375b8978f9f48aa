"""Joints, coordinates, couplings and signals of a model file."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.base.declare import SECTIONS
from jousto.base.errors import InputError
from jousto.base.fields import field
from jousto.base.numbers import OptionalNumber
from jousto.mechanism.bodies.body import RigidBody, ground
from jousto.mechanism.forces.friction import Friction, Regularised, StickSlip
from jousto.mechanism.forces.springs import Bushing, JointForce, Servo, Spring
from jousto.mechanism.joints.base import PARALLEL, AxisJoint, held
from jousto.mechanism.joints.coordinate import Distance
from jousto.mechanism.joints.coupling import Coupling, Drive, Gear, Rack
from jousto.mechanism.joints.directions import ParallelAxes, Perpendicular
from jousto.mechanism.joints.hinges import Cylindrical, Revolute, Screw, Universal
from jousto.mechanism.joints.points import PointOnLine, PointOnPlane, Rod, Spherical
from jousto.mechanism.joints.slides import ConstantOrientation, Fixed, Planar, Prismatic
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.signals.piecewise import Ramp, SCurve, Table
from jousto.schema.read import model_schema, parse_model
from schema.models import same

BODIES = "bodies:\n" + "".join(
    f"  - {{name: b{i}, mass: 1, inertia: [1, 1, 1], position: [{i}, 0, 0]}}\n" for i in range(12)
)
JOINTS = """\
joints:
  - {type: revolute, name: hinge, a: ground.origin, b: b0.origin, as_placed: no}
  - {type: prismatic, name: slide, a: ground.origin, b: b1.origin, axis: [1, 0, 0]}
  - {type: cylindrical, name: tube, a: ground.origin, b: b2.origin, axis: [1, 0, 0]}
  - {type: screw, name: screw, a: ground.origin, b: b3.origin, pitch: 5 mm, axis: [1, 0, 0]}
  - {type: universal, name: cross, a: {body: ground, at: [4, 0, 0]}, b: b4.origin,
     axis_a: [0, 0, 1], axis_b: [1, 0, 0]}
  - {type: planar, name: table, a: ground.origin, b: b5.origin, normal: [0, 1, 0]}
  - {type: point-on-line, name: line, a: ground.origin, b: b6.origin, axis: [1, 0, 0]}
  - {type: point-on-plane, name: plane, a: ground.origin, b: b7.origin, normal: [0, 0, 1]}
  - {type: constant-orientation, name: parallel, a: ground.origin, b: b8.origin}
  - {type: rod, name: rod, a: ground.origin, b: b9.origin, length: 900 cm}
  - {type: spherical, name: ball, a: {body: ground, at: [10, 0, 0]}, b: b10.origin}
  - {type: fixed, name: weld, a: {body: ground, at: [11, 0, 0]}, b: b11.origin}
  - {type: parallel-axes, name: axes, a: b0.origin, b: b1.origin, axis: [0, 1, 0]}
  - {type: perpendicular, name: right, a: b2.origin, b: b3.origin, axis_a: [0, 0, 1],
     axis_b: [0, 1, 0]}
"""
COUPLINGS = """\
couplings:
  - {type: gear, name: gear, a: hinge.angle, b: tube.angle, ratio: -2}
  - {type: rack, name: rack, pinion: table.angle, rack: slide.displacement, radius: 50 mm}
  - {type: coupling, name: pulley, coordinates: [line.displacement, plane.x], factors: [1, -2],
     offset: 30 mm}
  - {type: drive, name: turn, coordinate: cross.angle2, signal:
      {type: sum, terms: [90 deg, {type: s-curve, times: [0, 1 min], values: [0, 180 deg]}, {type:
        product, factors: [{type: ramp, start: 0, end: 1, after: 1 turn}, {type: constant, value: 2}]}]}}
  - {type: drive, name: push, coordinate: {type: distance, a: ground.origin, b: b8.origin}, signal:
      {type: table, times: [0, 1, 2, 3], values: [8 m, 9, 9, 900 cm], interpolation: cubic}}
"""  # noqa: E501


def machine() -> Mechanism:
    """Return the mechanism of the text, written in Python."""
    b = [RigidBody(f"b{i}", 1, (1, 1, 1), position=(i, 0, 0)) for i in range(12)]
    o, x = ground["origin"], (1, 0, 0)
    hinge = Revolute("hinge", o, b[0]["origin"], as_placed=False)
    slide = Prismatic("slide", o, b[1]["origin"], axis=x)
    tube = Cylindrical("tube", o, b[2]["origin"], axis=x)
    cross = Universal("cross", ground.at((4, 0, 0)), b[4]["origin"], axis_a=(0, 0, 1), axis_b=x)
    table = Planar("table", o, b[5]["origin"], normal=(0, 1, 0))
    line = PointOnLine("line", o, b[6]["origin"], axis=x)
    plane = PointOnPlane("plane", o, b[7]["origin"], normal=(0, 0, 1))
    turn = np.pi / 2 + SCurve((0, 60), (0, np.pi)) + Ramp(0, 1, 0, 2 * np.pi) * 2
    way = Table((0, 1, 2, 3), (8, 9, 9, 9), "cubic")
    return Mechanism(
        *b, hinge, slide, tube,
        Screw("screw", o, b[3]["origin"], 0.005, axis=x),
        cross, table, line, plane,
        ConstantOrientation("parallel", o, b[8]["origin"]),
        Rod("rod", o, b[9]["origin"], length=9.0),
        Spherical("ball", ground.at((10, 0, 0)), b[10]["origin"]),
        Fixed("weld", ground.at((11, 0, 0)), b[11]["origin"]),
        ParallelAxes("axes", b[0]["origin"], b[1]["origin"], axis=(0, 1, 0)),
        Perpendicular("right", b[2]["origin"], b[3]["origin"], (0, 0, 1), (0, 1, 0)),
        Gear("gear", hinge.angle, tube.angle, -2),
        Rack("rack", table.angle, slide.displacement, 0.05),
        Coupling("pulley", (line.displacement, plane.x), (1, -2), 0.03),
        Drive("turn", cross.angle2, turn),
        Drive("push", Distance(o, b[8]["origin"]), way),
    )  # fmt: skip


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
def test_joints_and_couplings_equal_the_python_constructors():
    same(parse_model(BODIES + JOINTS + COUPLINGS).mechanism, machine())


MODEL = """\
bodies: [{name: c, mass: 1, inertia: [1, 1, 1]}, {name: s, mass: 1, inertia: [1, 1, 1]}]
joints:
  - {type: revolute, name: hinge, a: ground.origin, b: c.origin}
  - {type: prismatic, name: slide, a: ground.origin, b: s.origin, axis: [1, 0, 0]}
  - {type: spherical, name: ball, a: c.origin, b: ground.origin}
couplings:
  - {type: rack, name: r, pinion: hinge.angle, rack: slide.displacement, radius: 10 cm}
  - {type: drive, name: d, coordinate: hinge.angle,
     signal: {type: s-curve, times: [0, 1], values: [0, 90 deg]}}
"""
MISTAKES = [
    ("pinion: hinge.angle", "pinion: hnge.angle", 7,
     "couplings.0.pinion: no joint 'hnge'; did you mean 'hinge'?"),
    ("pinion: hinge.angle", "pinion: hinge.angel", 7,
     "couplings.0.pinion: joint 'hinge' has no angel; did you mean 'angle'?"),
    ("pinion: hinge.angle", "pinion: ball.angle", 7,
     "couplings.0.pinion: joint 'ball' has no angle; a Spherical joint has no coordinates"),
    ("pinion: hinge.angle", "pinion: hinge", 7,
     "couplings.0.pinion: expects a coordinate such as hinge.angle, "),
    ("pinion: hinge.angle", "pinion: slide.displacement", 7,
     "couplings.0.pinion: slide.displacement is a length, must be an angle; "),
    ("rack: slide.displacement", "rack: [slide, displacement]", 7,
     "couplings.0.rack: expects "),
    ("radius", "radus", 7, "couplings.0: 'radius' is missing"),
    ("type: rack", "type: rak", 7,
     "couplings.0.type: no coupling type 'rak'; did you mean 'rack'?"),
    ("coordinate: hinge.angle", "coordinate: {type: distnce, a: c.origin, b: s.origin}", 8,
     "couplings.1.coordinate.type: no coordinate type 'distnce'; did you mean 'distance'?"),
    ("90 deg", "90 mm", 9, "couplings.1.signal.values.1: expects an angle (rad), got 90 mm"),
    ("s-curve", "scurve", 9,
     "couplings.1.signal.type: no signal type 'scurve'; did you mean 's-curve'?"),
    ("{type: s-curve, times: [0, 1], values: [0, 90 deg]}",
     "{type: product, factors: [2 rad, 3 rad]}", 9,
     "couplings.1.signal.factors.1: expects a number, got 3 rad (an angle)"),
    ("type: prismatic", "type: prismtic", 4,
     "joints.1.type: no joint type 'prismtic'; did you mean 'prismatic'?"),
    ("axis: [1, 0, 0]", "axs: [1, 0, 0]", 4,
     "joints.1.axs: unknown key 'axs'; did you mean 'axis'?"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "line", "sentence"), MISTAKES, ids=[m[1] for m in MISTAKES])
def test_a_mistake_has_its_line_field_and_remedy(old, new, line, sentence):
    assert old in MODEL
    with pytest.raises(InputError) as error:
        parse_model(MODEL.replace(old, new, 1), name="m.yaml")
    found = [str(problem) for problem in error.value.problems]
    assert found[0].startswith(f"m.yaml:{line}: {sentence}"), found
    assert len(found) <= 1 + new.startswith("radus"), found


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
def test_a_pinion_driven_by_the_file_moves_the_rack():
    text = MODEL.replace("  - {type: spherical, name: ball, a: c.origin, b: ground.origin}\n", "")
    text += "sensors: [{type: position, name: s, marker: s.origin}]\n"
    run = jo.simulate(jo.compile(parse_model(text).mechanism), 1.0)
    # radius times a quarter turn
    assert abs(run["s"][-1, 0] - 0.1 * np.pi / 2) < 1e-9


FORCES = """\
forces:
  - {type: spring, name: k, coordinate: hinge.angle, stiffness: 2 N m/rad, damping: 0.1 N m s/rad,
     free: 90 deg, preload: 1 kNm}
  - {type: bushing, name: bush, a: ground.origin, b: s.origin, stiffness: [1 N/mm, 1, 1, 1, 1, 1]}
  - {type: joint-force, name: push, coordinate: slide.displacement, signal: 2 kN}
  - {type: servo, name: servo, coordinate: hinge.angle, reference: 90 deg, kp: 3, kd: 1,
     limit: 5 Nm}
"""


def test_force_elements_equal_the_python_constructors():
    model = parse_model(MODEL[: MODEL.index("  - {type: spherical")] + FORCES).mechanism
    hinge, slide = model.joints
    expected = (
        Spring("k", hinge.angle, 2.0, 0.1, free=np.pi / 2, preload=1000.0),
        Bushing("bush", ground["origin"], slide.b, (1000, 1, 1, 1, 1, 1)),
        JointForce("push", slide.displacement, 2000.0),
        Servo("servo", hinge.angle, np.pi / 2, 3.0, 1.0, limit=5.0),
    )
    same(model.forces, expected)
    assert jo.simulate(jo.compile(model), 0.01).complete


def test_the_stiffness_along_an_angle_is_no_stiffness_along_a_length():
    text = MODEL[: MODEL.index("  - {type: spherical")] + FORCES
    with pytest.raises(InputError, match=r"forces.0.stiffness: expects an angular stiffness"):
        parse_model(text.replace("2 N m/rad", "2 N/m"))


FRICTIONS = """\
frictions:
  - {name: pin, joint: hinge, mu_kinetic: 0.1, mu_static: 12 %, radius: 25 mm, bearing_length: 8 cm,
     collar_radius: 40 mm, preload: 2 kN, law: {type: stick-slip}}
  - {name: rail, joint: slide, mu_kinetic: 0.2, law: {type: regularised, velocity: 5 mm/s}}
"""


def test_frictions_equal_the_python_constructors():
    text = MODEL[: MODEL.index("  - {type: spherical")] + FRICTIONS + "gravity: [0, -9.81, 0]\n"
    model = parse_model(text).mechanism
    hinge, slide = model.joints
    expected = (
        Friction(
            *("pin", hinge, 0.1, 0.12),
            radius=0.025,
            bearing_length=0.08,
            collar_radius=0.04,
            preload=2000.0,
            law=StickSlip(),
        ),
        Friction("rail", slide, 0.2, law=Regularised(0.005)),
    )
    same(model.frictions, expected)


@pytest.mark.parametrize(
    ("old", "new", "line", "sentence"),
    [
        ("joint: hinge, mu", "joint: hnge, mu", 6,
         "frictions.0.joint: no joint 'hnge'; did you mean 'hinge'?"),
        ("stick-slip", "stickslip", 7,
         "frictions.0.law.type: no law type 'stickslip'; did you mean 'stick-slip'?"),
        ("5 mm/s", "0", 8, "frictions.1.law.velocity: velocity is 0 m/s, must be"),
        ("radius: 25 mm, ", "", 6, "frictions.0: radius is missing: the pin radius"),
        ("mu_kinetic: 0.2", "mu: 0.2", 8, "frictions.1: 'mu_kinetic' is missing"),
    ],
)  # fmt: skip
def test_a_mistake_of_a_friction_has_its_line_field_and_remedy(old, new, line, sentence):
    text = MODEL[: MODEL.index("  - {type: spherical")] + FRICTIONS
    assert old in text
    with pytest.raises(InputError) as error:
        parse_model(text.replace(old, new, 1), name="m.yaml")
    assert str(error.value).startswith(f"m.yaml:{line}: {sentence}")


STARTING = """
name: wheels
bodies:
  - {name: c, mass: 1, inertia: [1, 1, 1]}
  - {name: s, mass: 1, inertia: [1, 1, 1]}
joints:
  - {type: revolute, name: hinge, a: ground.origin, b: c.origin}
  - {type: prismatic, name: slide, a: ground.origin, b: s.origin, axis: [1, 0, 0]}
initial:
  - {coordinate: hinge.angle, value: 30 deg, rate: 50 rpm}
  - {coordinate: slide.displacement, rate: 200 mm/s}
"""


def test_the_start_of_coordinates_and_a_constant_speed() -> None:
    found = parse_model(STARTING).mechanism.initials
    assert [(s.coordinate.name, s.value, s.rate) for s in found] == [
        ("hinge.angle", pytest.approx(np.pi / 6), pytest.approx(50 * 2 * np.pi / 60)),
        ("slide.displacement", None, pytest.approx(0.2)),
    ]
    drive = """
couplings:
  - {type: drive, name: d, coordinate: hinge.angle, signal: {type: constant-speed, speed: 60 rpm,
     offset: 90 deg}}
"""
    (driven,) = parse_model(STARTING[: STARTING.index("initial")] + drive).mechanism.couplings
    assert driven.signal.speed == pytest.approx(2 * np.pi)
    assert driven.signal.offset == pytest.approx(np.pi / 2)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("50 rpm", "50 mm/s", "10: initial.0.rate: expects an angular velocity (rad/s)"),
        ("30 deg", "270 deg", "10: initial.0.value: value is 270 deg, must be within half a turn"),
        ("hinge.angle, v", "hnge.angle, v", "10: initial.0.coordinate: no joint 'hnge'; did you"),
        ("slide.displacement", "hinge.angle", "given twice, leave one out"),
        (", rate: 200 mm/s", "", "11: initial.1: contains neither a value nor a rate"),
    ],
)
def test_mistakes_of_the_start(old: str, new: str, sentence: str) -> None:
    assert old in STARTING
    text = STARTING.replace(old, new).replace("hinge.angle, rate: 200 mm/s", "hinge.angle, rate: 1")
    with pytest.raises(InputError) as error:
        parse_model(text)
    assert sentence in str(error.value)


def test_a_class_that_a_user_declares_is_an_entry_too():
    class Bead(AxisJoint, tag="bead"):
        """A bead on a wire."""

        perpendicular = PARALLEL
        wire: OptionalNumber = field("Length of the wire", unit="m", above=0, default=None)

        @property
        def lines(self):
            return held(self, "x", "y")

    body = "bodies: [{name: b0, mass: 1, inertia: [1, 1, 1]}]\n"
    text = body + "joints: [{type: bead, name: bead, a: ground.origin, b: b0.origin, wire: 5 cm}]"
    try:
        bead = parse_model(text).mechanism.joints[-1]
        assert isinstance(bead, Bead)
        assert bead.wire == 0.05
        assert "BeadEntry" in model_schema()["$defs"]
        with pytest.raises(InputError, match="wire is -0.05 m, must be positive"):
            parse_model(text.replace("5 cm", "-5 cm"))
    finally:
        del SECTIONS["joints"]["bead"]
