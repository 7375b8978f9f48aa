"""Sensors, tables, bushings, modal loads and user forces of a model file."""

from __future__ import annotations

import numpy as np
import pytest
from typer.testing import CliRunner

import jousto as jo
from jousto.base.declare import SECTIONS
from jousto.base.errors import InputError
from jousto.base.fields import field
from jousto.base.numbers import Number
from jousto.base.rotations import Rotate
from jousto.mechanism.bodies.body import ground
from jousto.mechanism.forces.springs import ModalLoad
from jousto.mechanism.joints.coordinate import Distance
from jousto.mechanism.sensors.body import (
    DeformationMomentumSensor,
    ModalSensor,
    PrincipalStressSensor,
    StressSensor,
    VonMisesSensor,
)
from jousto.mechanism.sensors.body_load import BodyLoadSensor, ModalLoadSensor
from jousto.mechanism.sensors.bridge import Bridge
from jousto.mechanism.sensors.damage import DamageSensor
from jousto.mechanism.sensors.force_state import ForceStateSensor
from jousto.mechanism.sensors.gauge import Gauge
from jousto.mechanism.sensors.loads import ForceSensor, ReactionSensor
from jousto.mechanism.sensors.motion import (
    AccelerationPartsSensor,
    AccelerationSensor,
    AngularAccelerationSensor,
    AngularVelocitySensor,
    OrientationSensor,
    PositionSensor,
    VelocitySensor,
)
from jousto.mechanism.sensors.rosette import Rosette
from jousto.mechanism.sensors.scalar import (
    CoordinateSensor,
    EnergySensor,
    RateSensor,
    SignalSensor,
)
from jousto.mechanism.sensors.section import SectionSensor
from jousto.mechanism.sensors.temperature import Temperature
from jousto.mechanism.signals.base import USE, Constant, Signal
from jousto.mechanism.signals.piecewise import Step, Table
from jousto.schema.read import model_schema, parse_model, read_model
from schema.models import same

MODEL = """\
parts:
  rod:
    type: beam
    length: 2 m
    section: {type: rectangle, width: 50 mm, height: 0.1}
    material: {E: 210 GPa, nu: 0.3, rho: 7850}
    elements: 2
    reduce: {type: craig-bampton, interfaces: [start, end], modes: 2}
bodies:
  - {name: arm, part: rod}
  - {name: slider, mass: 1, inertia: [1, 1, 1], position: [0, 1, 0]}
joints:
  - {type: revolute, name: hinge, a: ground.origin, b: arm.start}
  - {type: prismatic, name: slide, a: {body: ground, at: [0, 1, 0]}, b: slider.origin,
     axis: [1, 0, 0]}
couplings:
  - {type: rack, name: rack, pinion: hinge.angle, rack: slide.displacement, radius: 10 cm}
forces:
  - {type: spring, name: k, coordinate: hinge.angle, stiffness: 5}
"""
EVERY = """\
sensors:
  - {type: position, name: s1, marker: arm.end, relative_to: slider.origin}
  - {type: velocity, name: s2, marker: arm.end, resolved_in: arm.start}
  - {type: acceleration, name: s3, marker: arm.end, relative_to: slider.origin,
     resolved_in: {body: ground, point: origin, axes: {axis: [0, 0, 1], angle_deg: 30}}}
  - {type: orientation, name: s4, marker: arm.end, relative_to: slider.origin}
  - {type: angular-velocity, name: s5, marker: arm.end}
  - {type: angular-acceleration, name: s6, marker: arm.end}
  - {type: modal, name: s7, body: arm}
  - {type: reaction, name: s8, joint: hinge, resolved_in: joint}
  - {type: reaction, name: s9, joint: slide, resolved_in: arm.end}
  - {type: reaction, name: s10, joint: rack}
  - {type: force, name: s11, force: k}
  - {type: stress, name: s12, body: arm, sites: [e1.a.top]}
  - {type: von-mises, name: s13, body: arm}
  - {type: principal-stress, name: s14, body: arm, sites: [e1.a.top, e2.b.left]}
  - {type: gauge, name: s15, body: arm, at: e1.a.top, direction: [1, 1, 0]}
  - {type: gauge, name: s16, body: arm, at: [40 cm, 0, 50 mm], length: 3 mm, E: 200 GPa, nu: 0.25}
  - {type: coordinate, name: s17, coordinate: hinge.angle}
  - {type: rate, name: s18, coordinate: {type: distance, a: arm.end, b: ground.origin}}
  - {type: energy, name: s19, energy: kinetic}
  - {type: signal, name: s20, signal: {type: step, time: 1}}
  - {type: signal, name: s21, signal: 3}
  - {type: damage, name: s22, sensor: s12, components: "e1.a.top:s11", residue: repeat,
     depth: 40, sn: {S_D: 100 MPa, N_D: 1e6, k: 5, rule: haibach, T_S: 1.25},
     mean: {type: goodman, S_u: 400 MPa}}
  - {type: damage, name: s23, sensor: s17, sn: fat71-en, residue: half, factor: 2e6,
     resolution: 10 kPa, mean: {type: swt}}
  - {type: rosette, name: s24, body: arm, at: e1.a.top, kind: '60',
     temperature: {signal: 30, part: S355}}
  - {type: bridge, name: s25, arms: [s15, null, s16], gauge_factor: 2.1}
  - {type: acceleration-parts, name: s26, marker: arm.end, relative_to: slider.origin}
  - {type: deformation-momentum, name: s27, body: arm}
  - {type: body-load, name: s28, body: slider, load: joint}
  - {type: modal-load, name: s29, body: arm, load: inertia}
"""


def test_sensors_equal_the_python_constructors():
    model = parse_model(MODEL + EVERY).mechanism
    arm, slider = model.bodies
    hinge, slide = model.joints
    end, seat = arm["end"], slider["origin"]
    turned = ground["origin"].turned(Rotate((0, 0, 1), degrees=30))
    distance = Distance(end, ground["origin"])
    stress, angle = (s for s in model.sensors if s.name in ("s12", "s17"))
    top = Gauge("s15", arm, "e1.a.top", (1, 1, 0))
    between = Gauge("s16", arm, (0.4, 0, 0.05), length=0.003, E=200e9, nu=0.25)
    expected = (
        PositionSensor("s1", end, relative_to=seat),
        VelocitySensor("s2", end, resolved_in=arm["start"]),
        AccelerationSensor("s3", end, relative_to=seat, resolved_in=turned),
        OrientationSensor("s4", end, relative_to=seat),
        AngularVelocitySensor("s5", end),
        AngularAccelerationSensor("s6", end),
        ModalSensor("s7", arm),
        ReactionSensor("s8", hinge, resolved_in="joint"),
        ReactionSensor("s9", slide, resolved_in=end),
        ReactionSensor("s10", model.couplings[0]),
        ForceSensor("s11", model.forces[0]),
        StressSensor("s12", arm, ("e1.a.top",)),
        VonMisesSensor("s13", arm),
        PrincipalStressSensor("s14", arm, ("e1.a.top", "e2.b.left")),
        top,
        between,
        CoordinateSensor("s17", hinge.angle),
        RateSensor("s18", distance),
        EnergySensor("s19", "kinetic"),
        SignalSensor("s20", Step(1.0)),
        SignalSensor("s21", Constant(3.0)),
        DamageSensor(
            *("s22", stress, jo.SN(100e6, 1e6, 5.0, "haibach", T_S=1.25)),
            residue="repeat",
            mean=jo.fatigue.Goodman(400e6),
            components="e1.a.top:s11",
            depth=40,
        ),
        DamageSensor(
            *("s23", angle, jo.sn_curve("fat71-en")),
            residue="half",
            factor=2e6,
            resolution=1e4,
            mean=jo.fatigue.SWT(),
        ),
        Rosette("s24", arm, "e1.a.top", kind="60", temperature=Temperature(30.0, part=12e-6)),
        Bridge("s25", (top, None, between), gauge_factor=2.1),
        AccelerationPartsSensor("s26", end, relative_to=seat),
        DeformationMomentumSensor("s27", arm),
        BodyLoadSensor("s28", slider, "joint"),
        ModalLoadSensor("s29", arm, "inertia"),
    )
    same(model.sensors, expected)
    # those of beams: test_beams.py, of states: test_plastic_spring.py, test_states.py
    others = {SectionSensor, ForceStateSensor, jo.mechanism.StateSensor}
    # those of contacts: test_contact_sensors.py
    others |= {jo.mechanism.ContactForceSensor, jo.mechanism.ContactPressureSensor}
    others |= {jo.mechanism.RailContactSensor}  # test_rail_contact.py
    assert {type(s) for s in model.sensors} == set(SECTIONS["sensors"].values()) - others
    run = jo.simulate(jo.compile(model), 0.002)
    assert all(np.isfinite(run[name]).all() for name in run.sensors)


FIRST = 21  # line of the first sensor

MISTAKES = [
    ("{type: aceleration, name: s, marker: arm.end}",
     "sensors.0.type: no sensor type 'aceleration'; did you mean 'acceleration'?"),
    ("{type: velocity, name: s, marker: arm.end, relative_to: slidr.origin}",
     "sensors.0.relative_to: no body 'slidr'; did you mean 'slider'?"),
    ("{type: reaction, name: s, joint: rak}",
     "sensors.0.joint: no joint 'rak'; did you mean 'rack'?"),
    ("{type: reaction, name: s, joint: hinge, resolved_in: wrld}",
     "sensors.0.resolved_in: no resolved_in 'wrld'; did you mean 'world'?"),
    ("{type: reaction, name: s, joint: rack, resolved_in: joint}",
     "sensors.0.resolved_in: the reaction of 'rack' acts along its coordinates, leave resolved_in"),
    ("{type: force, name: s, force: kk}", "sensors.0.force: no force 'kk'; did you mean 'k'"),
    ("{type: gauge, name: s, body: arm, at: e1.a.tip}",
     "sensors.0.at: part 'rod' has no stress site 'e1.a.tip'; did you mean 'e1.a.top'?"),
    ("{type: gauge, name: s, body: arm, at: [1, 0, 0.3]}",
     "sensors.0.at: is 250 mm off the beams of part"),
    ("{type: gauge, name: s, body: arm, at: e1.a.top, E: 3 N}",
     "sensors.0.E: expects a pressure (Pa), got 3 N (a force)"),
    ("{type: bridge, name: s, arms: [g1]}",
     "sensors.0.arms.0: no gauge 'g1'; there are none"),
    ("{type: rosette, name: s, body: arm, at: e1.a.top, kind: '30'}",
     "sensors.0.kind: kind is '30', must be '45', '60' (delta) or '90' (tee)"),
    ("{type: gauge, name: s, body: arm, at: e1.a.top, temperature: {signal: 20, part: 12}}",
     "sensors.0.temperature.part: part is 12 1/K; if it is in 1e-6/K, multiply by 1e-6 "
     "(12e-6 for steel)"),
    ("{type: energy, name: s, energy: kintic}",
     "sensors.0.energy: energy is 'kintic'; did you mean 'kinetic'?"),
    ("{type: von-mises, name: s, body: slider}",
     "sensors.0.body: body is <RigidBody"),
]  # fmt: skip


@pytest.mark.parametrize(("entry", "sentence"), MISTAKES, ids=[m[0][:45] for m in MISTAKES])
def test_mistakes_in_sensors_have_their_line_and_remedy(entry, sentence):
    with pytest.raises(InputError) as error:
        parse_model(MODEL + f"sensors:\n  - {entry}\n", name="m.yaml")
    found = [str(problem) for problem in error.value.problems]
    assert found[0].startswith(f"m.yaml:{FIRST}: {sentence}"), found
    assert len(found) == 1


# -- forces -----------------------------------------------------------------------------------


def forces(text, tmp_path=None, **more):
    """Return the forces of the model with further ones."""
    return parse_model(MODEL + text, name="m.yaml", folder=tmp_path, **more).mechanism.forces[1:]


def test_a_bushing_takes_a_whole_matrix_with_units():
    text = """\
  - type: bushing
    name: b
    a: ground.origin
    b: slider.origin
    stiffness:
      - [1 N/mm, 0, 0, 0, 2 N/rad, 0]
      - [0, 1000, 0, 0, 0, 0]
      - [0, 0, 1000, 0, 0, 0]
      - [0, 0, 0, 5 Nm/rad, 0, 0]
      - [2 N, 0, 0, 0, 5, 0]
      - [0, 0, 0, 0, 0, 5]
    damping: [1 N s/mm, 1000, 1000, 2 N m s/rad, 2, 2]
"""
    (found,) = forces(text)
    K = np.diag([1000.0] * 3 + [5.0] * 3)
    K[0, 4] = K[4, 0] = 2.0
    D = np.diag([1000.0] * 3 + [2.0] * 3)
    np.testing.assert_array_equal(found.stiffness, K)
    np.testing.assert_array_equal(found.damping, D)
    with pytest.raises(InputError, match=r"forces.1.stiffness.0.4: expects a force for a turn"):
        forces(text.replace("2 N/rad", "2 N/m"))
    with pytest.raises(InputError, match=r"forces.1.stiffness: stiffness is not symmetric"):
        forces(text.replace("2 N,", "3 N,"))
    with pytest.raises(InputError, match=r"forces.1.stiffness.1: expects a list of 6 numbers"):
        forces(text.replace("[0, 1000, 0, 0, 0, 0]", "[0, 1000]"))


def test_tables_of_springs_and_dampers(tmp_path):
    (tmp_path / "damper.csv").write_text(
        "rate;left;torque\n# deg/s;;Nm\n-90;0;-2\n0;7;0\n180;0;3\n"
    )
    text = """\
  - type: spring
    name: s
    coordinate: hinge.angle
    table: {at: [-90 deg, 0, 90 deg], values: [-1 kN m, 0, 500]}
    damper_table: {file: damper.csv, columns: [rate, torque], units: [deg/s, kN m],
                   interpolation: cubic}
"""
    (found,) = forces(text, tmp_path)
    same(found.table, Table((-np.pi / 2, 0, np.pi / 2), (-1000, 0, 500)))
    np.testing.assert_allclose(found.damper_table.times, (-np.pi / 2, 0, np.pi), rtol=1e-15)
    np.testing.assert_array_equal(found.damper_table.values, (-2000, 0, 3000))
    assert found.damper_table.interpolation == "cubic"
    for old, new, sentence in (
        ("columns: [rate,", "columns: [rat,", "table.file: .*no column 'rat'; did you mean 'rate'"),
        ("deg/s, kN m", "deg/s, kN", "expects a torque \\(N m\\), got 1 kN \\(a force\\)"),
        ("damper.csv", "dmper.csv", "cannot be read: .*No such file"),
        ("{file: damper.csv", "{at: [1], file: damper.csv", "give either file: or at: and values:"),
        ("at: [-90 deg, 0, 90 deg], ", "", "forces.1.table: 'at' is missing; or give file:"),
        ("values: [-1 kN m, 0, 500]", "values: [1 kN m]", "3 times but 1 values"),
        ("-90 deg", "-90 mm", "table.at.0: expects an angle"),
    ):
        assert old in text
        with pytest.raises(InputError, match=sentence):
            forces(text.replace(old, new), tmp_path)


def test_a_signal_from_a_file(tmp_path):
    (tmp_path / "wind.txt").write_text("0 1\n500 3\n")
    text = """\
  - {type: force, name: f, marker: slider.origin, vector: [1, 0, 0],
     signal: {type: table, file: wind.txt, units: [ms, percent]}}
"""
    (found,) = forces(text, tmp_path)
    same(found.signal, Table((0, 0.5), (0.01, 0.03)))
    with pytest.raises(InputError, match=r"signal.columns: columns are those of a file"):
        forces(text.replace("file: wind.txt", "times: [0], values: [1], columns: [0, 1]"), tmp_path)


@pytest.mark.parametrize(
    "pattern",
    ["{end: [0, 1 kN, 0], start: [0, 0, 2]}", "[[0, 0, 2], [0, 0, 0], [0, 1 kN, 0]]", "loads.csv"],
)
def test_modal_loads(tmp_path, pattern):
    (tmp_path / "loads.csv").write_text("0,0,2\n0,0,0\n0,1000,0\n")
    text = f"  - {{type: modal-load, name: p, body: arm, pattern: {pattern}, signal: {{type: step, time: 1}}}}\n"  # noqa: E501
    (found,) = forces(text, tmp_path)
    same(found, ModalLoad("p", found.body, [[0, 0, 2], [0, 0, 0], [0, 1000, 0]], Step(1.0)))
    for new, sentence in (
        (
            "{ende: [0, 1, 0]}",
            "pattern.ende: body 'arm' has no node set 'ende'; did you mean",
        ),
        ("[[0, 0, 2]]", r"forces.1.pattern: .*\(1, 3\)"),
        ("no.csv", "forces.1.pattern: no such file"),
    ):
        with pytest.raises(InputError, match=sentence):
            forces(text.replace(pattern, new), tmp_path)


USER = "  - {type: user-force, name: u, marker: slider.origin, function: 'wind.py:drag'}\n"
CODE = """\
def drag(t, x):
    return (-2.0 * x[12], 0, 0, 0, 0, 0)

raise_it = 1
"""


def test_user_functions_run_only_in_a_trusted_file(tmp_path):
    mark = tmp_path / "ran"
    (tmp_path / "wind.py").write_text(f"open({str(mark)!r}, 'w').close()\n" + CODE)
    with pytest.raises(InputError) as error:
        forces(USER, tmp_path)
    assert str(error.value).startswith(
        "m.yaml:20: forces.1.function: 'wind.py:drag' is Python code, which may do anything"
    )
    assert "--trust" in str(error.value)
    assert not mark.exists()
    (found,) = forces(USER, tmp_path, trust=True)
    assert mark.exists()
    assert found.function(0.0, np.full(18, 3.0)) == (-6.0, 0, 0, 0, 0, 0)
    (found,) = forces(USER.replace("wind.py:drag", "numpy.linalg:norm"), tmp_path, trust=True)
    assert found.function is np.linalg.norm


@pytest.mark.parametrize(
    ("function", "sentence"),
    [
        ("wind.py:drg", "'wind.py' has no function 'drg'; did you mean 'drag'"),
        ("wind.py:raise_it", "function is 1, must be callable or compiled"),
        ("wnd.py:drag", "no such file '.*wnd.py'"),
        ("no_such_module:f", "'no_such_module' cannot be imported: ModuleNotFoundError"),
        ("broken.py:f", "'broken.py' cannot be imported: ZeroDivisionError: division by zero"),
        ("wind.py", "expects module:function or file.py:function such as wind.py:drag"),
    ],
)
def test_functions_that_cannot_be_found(tmp_path, function, sentence):
    (tmp_path / "wind.py").write_text(CODE)
    (tmp_path / "broken.py").write_text("1 / 0\n")
    with pytest.raises(InputError, match=f"m.yaml:20: forces.1.function: .*{sentence}"):
        forces(USER.replace("wind.py:drag", function), tmp_path, trust=True)


def test_the_command_line_asks_for_trust(tmp_path):
    from jousto.cli.group import app

    (tmp_path / "wind.py").write_text(CODE)
    path = tmp_path / "m.yaml"
    path.write_text(MODEL + USER + "simulation: {t_end: 1 ms}\n")
    refused = CliRunner().invoke(app, ["run", str(path)])
    assert refused.exit_code == 2
    assert "say --trust" in refused.stderr or "run it with --trust" in refused.stderr
    done = CliRunner().invoke(app, ["run", str(path), "--trust", "--quiet"])
    assert done.exit_code == 0, done.stderr
    assert read_model(path, trust=True).mechanism.forces[-1].name == "u"


def test_damage_by_a_named_curve_of_a_sensor_that_comes_later():
    text = (
        MODEL
        + """\
sensors:
  - {type: damage, name: life, sensor: root, components: "e1.a.top:s11", sn: welded, residue: half}
  - {type: stress, name: root, body: arm, sites: [e1.a.top]}
fatigue:
  curves: {welded: {S_D: 25 MPa, N_D: 1e6, k: 4}}
"""
    )
    life, root = parse_model(text).mechanism.sensors
    assert life.sensor is root
    assert (life.sn.name, life.sn.S_D) == ("welded", 25e6)
    with pytest.raises(jo.InputError, match="no sensor 'rot'; did you mean 'root'"):
        parse_model(text.replace("sensor: root", "sensor: rot"))
    with pytest.raises(jo.InputError, match="no S-N curve 'weldd'; did you mean 'welded'"):
        parse_model(text.replace("sn: welded", "sn: weldd"))


def test_a_class_that_is_declared_later_is_known_to_files():
    parse_model(MODEL)

    class Square(Signal, tag="square-of-time"):
        """The square of time, times a factor in the unit of its use."""

        factor: Number = field("Value at 1 s", unit=USE)

        def jet(self, t):
            """Return value, rate and acceleration."""
            return self.factor * t**2, 2 * self.factor * t, 0 * t + 2 * self.factor

    try:
        text = "sensors:\n  - {type: signal, name: s, signal: {type: square-of-time, factor: 3}}\n"
        (sensor,) = parse_model(MODEL + text).mechanism.sensors
        assert isinstance(sensor.signal, Square)
        assert sensor.signal(2.0) == 12.0
        assert "SquareEntry" in model_schema()["$defs"]
        with pytest.raises(InputError, match="sensors.0.signal: 'factor' is missing"):
            parse_model(MODEL + text.replace(", factor: 3", ""))
    finally:
        del SECTIONS["signals"]["square-of-time"]
