"""Model files say the same as the Python constructors, exactly."""

from __future__ import annotations

import inspect
import json
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.sparse
from scipy.spatial.transform import Rotation

from jousto.base.declare import kinds
from jousto.base.errors import InputError, JoustoWarning
from jousto.base.rotations import Rotate, rotation_matrix
from jousto.materials.material import Material
from jousto.mechanism.bodies.body import FlexibleBody, RigidBody, ground
from jousto.mechanism.event import Event
from jousto.mechanism.forces.friction import Friction
from jousto.mechanism.forces.loads import Force, Gravity, Torque
from jousto.mechanism.foreign.fmu import Fmu
from jousto.mechanism.initial import Initial
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
from jousto.mechanism.signals.harmonic import Harmonic
from jousto.mechanism.signals.piecewise import Step, Table
from jousto.model.compile import compile
from jousto.parts.frames.element import EulerBernoulli, Timoshenko
from jousto.parts.frames.members import Member
from jousto.parts.mass import PointMass
from jousto.parts.part import Part
from jousto.reduction.damping import Rayleigh
from jousto.reduction.methods import CraigBampton, FreeFree
from jousto.reduction.reducer import reduce
from jousto.schema.read import model_schema, parse_model, read_model, read_part
from jousto.sections.profiles import Box, IBeam
from jousto.sections.section import Circle, GeneralSection, Rectangle, SectionPoint, Tube
from jousto.simulation.running.simulate import simulate
from jousto.simulation.solvers.base import Baumgarte, solvers
from jousto.simulation.solvers.rosenbrock import ROS2
from jousto.simulation.solvers.runge_kutta import RK4
from schema.models import EVERYTHING, PENDULUM, same

ROOT = Path(__file__).parents[2]

# -- the same as in Python ------------------------------------------------------------------


def steel() -> Material:
    return Material(E=210e9, nu=0.3, rho=7850.0)


def test_pendulum_equals_the_python_constructors():
    part = Part.beam(
        2.0, Rectangle(0.1, 0.1), 4, steel(), lumped=True, theory=EulerBernoulli(), name="rod"
    )
    rod = reduce(part, CraigBampton(interfaces=("start",), modes=4))
    arm = FlexibleBody("arm", rod, damping=0.0)
    expected = Mechanism(
        arm,
        Spherical("pivot", ground["origin"], arm["start"]),
        Gravity((0.0, -9.81, 0.0)),
        PositionSensor("middle", arm["node3"]),
        name="flexible pendulum",
    )
    model = parse_model(PENDULUM)
    same(model.mechanism, expected)
    assert model.simulation.t_end == 10.0
    assert model.simulation.given() == {"solver": RK4(step=1e-3), "output_step": 0.01}
    assert model.text == PENDULUM


def everything() -> Mechanism:
    """Return the same mechanism, written in Python."""
    metal = Material(210e9, 0.3, 7850.0, name="steel")
    boom = Part.from_members(
        [
            Member(
                (0, 0, 0), (1, 0, 0), Tube(0.06, 0.003), metal, elements=3,
                orientation=(0, 1, 0), end_offset=(-0.01, 0, 0), name="leg",
            ),
            Member(
                (1, 0, 0),
                (1, 1, 0),
                IBeam(height=0.1, width=0.05, web=0.005, flange=0.006, fillet=0.002),
                metal,
            ),
        ],
        points={"tip": (1, 1, 0)},
        theory=Timoshenko(0.8, 0.9),
        rotary_inertia=True,
        point_masses=[PointMass("tip", 2.0, inertia=(0.1, 0.1, 0.1), offset=(0, 0, 0.1))],
        name="boom",
    )  # fmt: skip
    boom = reduce(boom, CraigBampton(("leg.start", "tip"), frequency_limit=500.0))
    plane = Part.frame(
        [[0, 0, 0], [1, 0, 0], [2, 0, 0]],
        [[0, 1], [1, 2]],
        sections=[Circle(0.03), Box(0.04, 0.03, web=0.002, flange=0.003)],
        materials=metal,
        orientations=[[0, 0, 1], [0, 1, 0]],
        offsets=[[[0, 0, 0], [0, 0, 0.01]], [[0, 0, 0.01], [0, 0, 0]]],
        lumped=False,
        node_sets={"hub": (0,)},
        name="plane",
    )
    plane = reduce(plane, FreeFree(modes=8)).keep((0, 2, 3))
    points = (
        SectionPoint("top", 0.0, 0.01, ((1, 2, 3), (4, 5, 6))),
        SectionPoint("side", 1.0, 0.0),
    )
    general = GeneralSection(A=2e-4, Iy=1e-8, Iz=2e-8, J=1.5e-8, ky=0.8, kz=0.8, points=points)
    flat = Part.beam(1.0, general, 3, metal, orientation=(0, 1, 0), name="flat")
    method = CraigBampton("start", modes=6)
    flat = reduce(flat, method, stiffening=True, residual_stress=True)
    flat = flat.keep(flat.in_plane("xy"))
    crank = RigidBody(
        "crank", 0.5, (1e-3, 2e-3, 2e-3), center=(0.1, 0, 0),
        markers={"pin": (0.2, 0, 0), "eye": (0, 0, 0)},
        orientation=Rotate((0, 0, 1), degrees=30),
        angular_velocity=(0, 0, 2 * np.pi), outline=[[0, 0, 0], [0.2, 0, 0]],
    )  # fmt: skip
    block = RigidBody(
        "block", 1, [[2, -0.1, 0], [-0.1, 2, 0], [0, 0, 2]], position=(5, 0, 0),
        orientation=(0, 1, 0, 0), velocity=(1, 0, 0),
    )  # fmt: skip
    arm = FlexibleBody(
        "arm", boom, position=(10, 0, 0), orientation=[[0, -1, 0], [1, 0, 0], [0, 0, 1]],
        damping=Rayleigh(0.5, 1e-3), drop_invariants=("I5", "I9"),
    )  # fmt: skip
    wing = FlexibleBody(
        "wing", plane, position=(20, 0, 0), damping=(0.01, 0.02, 0.03),
        modal_coordinates=(1e-3, 0, 0), modal_velocities=(0, 1e-3, 0),
    )  # fmt: skip
    tail = FlexibleBody("tail", flat, damping=0.01, position=(30, 0, 0))
    hinge = Revolute("hinge", ground["origin"], crank["eye"], axis=(0, 0, 1))
    turned = ground.at((5, 0, 0)).turned(Rotate((1, 0, 0), degrees=90))
    return Mechanism(
        crank, block, arm, wing, tail, hinge,
        Revolute("bare", turned, block["origin"]),
        Fixed("clamp", ground.at((10, 0, 0)), arm["leg.start"]),
        Spherical("ball", ground.at((30, 0, 0)), tail["start"]),
        Force(
            "push", crank["pin"], (0, 1000, 0), follow=True,
            signal=Harmonic(frequency=2, amplitude=3, phase=np.pi / 2, offset=1),
        ),
        Torque("twist", arm["tip"], (0, 0, 5), signal=Table((0, 0.5, 1), (0, 1, 0))),
        Force("pull", arm["tip"], (0, 0, 1), signal=Step(1, 2, 3)),
        Gravity((0, 0, -9.80665)),
        PositionSensor("s1", crank["pin"]),
        VelocitySensor("s2", crank["pin"]),
        OrientationSensor("s3", crank["pin"]),
        AngularVelocitySensor("s4", crank["pin"]),
        ModalSensor("s5", wing),
        ReactionSensor("s6", hinge),
        StressSensor("s7", arm, sites=("e1.a.top", "e2.b.left")),
        StressSensor("s8", tail),
        name="everything",
    )  # fmt: skip


def test_everything_equals_the_python_constructors():
    with pytest.warns(JoustoWarning, match="wing"):
        expected = everything()
    line = EVERYTHING.splitlines().index("  - name: wing") + 1
    with pytest.warns(
        JoustoWarning, match=f"m.yaml:{line}: bodies.3: has no joint to another body"
    ):
        model = parse_model(EVERYTHING, name="m.yaml")
    same(model.mechanism, expected)
    assert model.simulation.solver == ROS2(2e-3, projection=False, baumgarte=Baumgarte(50.0, 50.0))


def test_every_class_can_be_said_in_a_file():
    """A new joint, force, signal, sensor, solver or section must be added to the file too."""
    sensors = set(kinds("sensors", "jousto.mechanism.sensors").values())
    signals = set(kinds("signals", "jousto.mechanism.signals").values())
    joints = set(kinds("joints", "jousto.mechanism.joints").values())
    couplings = set(kinds("couplings", "jousto.mechanism.joints").values())
    definitions = model_schema()["$defs"]
    assert set(kinds("solvers", "jousto.simulation.solvers").values()) == set(solvers())
    loose = (
        Rectangle, Circle, Tube, Box, IBeam, GeneralSection, SectionPoint,
        Material, PointMass, Timoshenko, EulerBernoulli, Member,
        CraigBampton, FreeFree, Rayleigh, RigidBody,
        Baumgarte,
    )  # fmt: skip

    def keys(cls: type) -> set[str]:
        found = set(definitions[f"{cls.__name__}Entry"]["properties"]) - {"type"}
        return found - {"file", "columns", "units"} if cls is Table else found

    def given(cls: type) -> set[str]:
        return set(inspect.signature(cls).parameters)

    assert [cls for cls in loose if not keys(cls) <= given(cls)] == []
    forces = kinds("forces", "jousto.mechanism.forces").values()
    exact = [*sensors, *forces, *couplings, *joints, *signals, *solvers(), Friction, Initial, Event]
    exact.append(Fmu)
    assert [cls for cls in exact if keys(cls) != given(cls)] == []


def test_json_says_the_same_as_yaml(tmp_path):
    from jousto.schema.file.document import parse_document

    path = tmp_path / "m.json"
    path.write_text(json.dumps(parse_document(PENDULUM).data, indent="\t"))
    same(read_model(path).mechanism, parse_model(PENDULUM).mechanism)


# -- files that a model refers to -----------------------------------------------------------


def test_reduced_parts_and_matrices_are_read_from_files(tmp_path):
    part = Part.beam(2.0, Rectangle(0.1, 0.05), 4, steel(), name="rod")
    reduced = reduce(part, CraigBampton("start", modes=6))
    reduced.save(tmp_path / "rod.h5")
    scipy.io.mmwrite(tmp_path / "K.mtx", part.K, symmetry="general", precision=17)
    scipy.sparse.save_npz(tmp_path / "M.npz", scipy.sparse.csr_matrix(part.M))
    np.save(tmp_path / "M.npy", part.M.toarray())
    np.savetxt(tmp_path / "nodes.csv", part.nodes, delimiter=",", fmt="%.17g")
    text = """
parts:
  a: {file: rod.h5}
  b: {type: reduced, file: rod.h5, in_plane: xz}
  c: {type: matrices, M: M.npz, K: K.mtx, nodes: nodes.csv, node_sets: {start: [0]},
      reduce: {type: craig-bampton, interfaces: [start], modes: 6}}
  d: {type: matrices, M: M.npy, K: K.mtx, dofs_per_node: 6, node_sets: {start: [0]},
      nodes: [[0, 0, 0], [0.5, 0, 0], [1, 0, 0], [1.5, 0, 0], [2, 0, 0]],
      elements: [[0, 1], [1, 2], [2, 3], [3, 4]],
      reduce: {type: craig-bampton, interfaces: [start], modes: 6}}
bodies:
  - {name: a, part: a}
  - {name: b, part: b}
  - {name: c, part: c}
  - {name: d, part: d}
joints:
  - {type: fixed, name: a, a: ground.origin, b: a.start}
  - {type: fixed, name: b, a: ground.origin, b: b.start}
  - {type: fixed, name: c, a: ground.origin, b: c.start}
  - {type: fixed, name: d, a: ground.origin, b: d.start}
gravity: [0, 0, -9.81]
"""
    (tmp_path / "m.yaml").write_text(text)
    a, b, c, d = read_model(tmp_path / "m.yaml").mechanism.bodies
    same(a.reduced, reduced)
    same(b.reduced, reduced.keep(reduced.in_plane("xz")))
    np.testing.assert_allclose(c.reduced.frequencies, reduced.frequencies, rtol=1e-8)
    np.testing.assert_allclose(d.reduced.frequencies, reduced.frequencies, rtol=1e-8)
    np.testing.assert_array_equal(d.reduced.elements, part.elements)


@pytest.mark.parametrize(
    ("part", "sentence"),
    [
        ("{file: no.h5}", "m.yaml:2: parts.a.file: {folder}/no.h5: there is no such file"),
        ("{file: m.yaml}", "m.yaml:2: parts.a.file: {folder}/m.yaml: is not an HDF5 file"),
        (
            "{type: matrices, M: M.dat, K: K.mtx, nodes: n.csv, "
            "reduce: {type: free-free, modes: 1}}",
            "m.yaml:2: parts.a.M: 'M.dat' cannot be read, must end with .mtx, .npz, .npy, .hb,"
            " .rb, .rsa, .rua\n"
            "m.yaml:2: parts.a.K: no such file '{folder}/K.mtx'\n"
            "m.yaml:2: parts.a.nodes: no such file '{folder}/n.csv'",
        ),
        (
            "{type: matrices, M: bad.npy, K: bad.mtx, nodes: bad.csv, "
            "reduce: {type: free-free, modes: 1}}",
            "m.yaml:2: parts.a.M: bad.npy: cannot be read as a NumPy file: ",
        ),
    ],
)
def test_missing_and_damaged_files_have_their_place(tmp_path, part, sentence):
    for name in ("bad.npy", "bad.mtx", "bad.csv"):
        (tmp_path / name).write_text("rubbish")
    path = tmp_path / "m.yaml"
    path.write_text(f"parts:\n  a: {part}\nbodies:\n  - {{name: a, part: a}}\n")
    with pytest.raises(InputError) as error:
        read_model(path)
    assert str(error.value).startswith(sentence.format(folder=tmp_path))


@pytest.mark.parametrize(
    ("text", "degrees"),
    [("30", 30), ("30 deg", 30), ("'30'", 30), ("30°", 30), ("0.5 rad", np.degrees(0.5))],
)
def test_degrees_of_an_angle_are_those_written(text, degrees):
    model = parse_model(
        "bodies: [{name: a, mass: 1, inertia: [1, 1, 1], velocity: [1, 0, 0], "
        f"orientation: {{axis: [0, 0, 1], angle_deg: {text}}}}}]\n"
        "joints: [{type: spherical, name: j, a: ground.origin, b: a.origin}]"
    )
    expected = Rotate((0, 0, 1), degrees=degrees).euler_parameters
    np.testing.assert_array_equal(model.mechanism.bodies[0].orientation, expected)


@pytest.mark.parametrize("convention", ["ZXZ", "xyz"])
def test_euler_angles_name_their_convention(convention):
    model = parse_model(
        "bodies: [{name: a, mass: 1, inertia: [1, 1, 1], "
        f"orientation: {{euler_deg: [30, 0.5 rad, -20 deg], convention: {convention}}}}}]\n"
        "joints: [{type: spherical, name: j, a: ground.origin, b: a.origin}]"
    )
    angles = (30, np.degrees(0.5), -20)
    expected = Rotation.from_euler(convention, angles, degrees=True).as_matrix()
    found = rotation_matrix(model.mechanism.bodies[0].orientation)
    np.testing.assert_allclose(found, expected, atol=1e-15)


# -- parts alone ----------------------------------------------------------------------------


def test_a_part_is_read_alone_or_out_of_a_model(tmp_path):
    model = tmp_path / "m.yaml"
    model.write_text(PENDULUM)
    expected = parse_model(PENDULUM).mechanism.bodies[0].reduced
    same(read_part(model), expected)
    same(read_part(model, "rod"), expected)
    with pytest.raises(InputError) as error:
        read_part(model, "rdo")
    assert str(error.value) == "m.yaml:2: parts: no part 'rdo'; did you mean 'rod'?"

    alone = tmp_path / "rod.yaml"
    lines = [line[4:] for line in PENDULUM.splitlines()[3:11]]
    alone.write_text("\n".join(lines))
    same(read_part(alone), expected)
    alone.write_text("\n".join(lines).replace("elements: 4", "elements: 0\nnmae: x"))
    with pytest.raises(InputError) as error:
        read_part(alone)
    assert str(error.value).startswith("rod.yaml:6: nmae: unknown key 'nmae'; known: ")

    model.write_text(PENDULUM.replace("2 m\n", "2 kg\n"))
    with pytest.raises(InputError) as error:
        read_part(model, "rod")
    assert str(error.value).startswith("m.yaml:5: parts.rod.length: expects a length")

    model.write_text(EVERYTHING)
    with pytest.raises(InputError) as error:
        read_part(model)
    assert str(error.value) == "m.yaml:3: parts: which part? there are: boom, plane, flat"


# -- the published schema -------------------------------------------------------------------


def test_the_schema_knows_every_key_of_the_file():
    schema = model_schema()
    assert set(schema["properties"]) == {
        "$schema", "name", "parts", "bodies", "joints", "couplings", "forces", "frictions",
        "parameters", "gravity", "sensors", "events", "fmus", "initial", "simulation", "fatigue",
        "states", "robots", "elastic_joints", "monitor", "limits", "reliability", "optimisation",
    }  # fmt: skip
    assert schema["required"] == ["bodies"]
    assert schema["additionalProperties"] is False
    assert all(d.get("additionalProperties") is False for d in schema["$defs"].values())


# -- where a run starts -----------------------------------------------------------------------


def test_a_run_starts_from_rest_if_asked():
    """A mass on a spring starts sagged by m g / k and stays there."""
    text = """
bodies: [{name: block, mass: 2 kg, inertia: [0.01, 0.01, 0.01]}]
joints: [{type: prismatic, name: slide, a: ground.origin, b: block.origin, axis: [0, 0, 1]}]
forces:
  - {type: spring, name: spring, coordinate: slide.displacement, stiffness: 1 kN/m, free: 0}
gravity: [0, 0, -9.81]
sensors: [{type: position, name: block, marker: block.origin}]
simulation: {t_end: 100 ms, start: rest}
"""
    file = parse_model(text)
    model = compile(file.mechanism)
    run = simulate(model, file.simulation.t_end, **file.simulation.given(model))
    assert run["block"][:, 2] == pytest.approx(-2 * 9.81 / 1000, rel=1e-9)
    plain = parse_model(text.replace(", start: rest", ""))
    assert "state" not in plain.simulation.given(model)


# -- rigid ----------------------------------------------------------------------------------


def test_the_rigid_twin_has_mass_inertia_and_nodes_of_its_part(tmp_path):
    """A slender rod: m L^2 / 12 and the section's own m h^2 / 12 (Timoshenko, rotary inertia)."""
    path = tmp_path / "rod.yaml"
    path.write_text("""
parts:
  rod:
    type: beam
    length: 2 m
    section: {type: rectangle, width: 40 mm, height: 60 mm}
    elements: 4
    material: {E: 210 GPa, nu: 0.3, rho: 7850}
    reduce: {type: craig-bampton, interfaces: [start], modes: 2}
bodies:
  - name: arm
    part: rod
    damping: 1 %
    position: [0, 1, 0]
    orientation: {axis: [0, 0, 1], angle_deg: 30}
joints: [{type: revolute, name: pivot, a: {body: ground, at: [0, 1, 0]}, b: arm.start}]
gravity: [0, -9.81, 0]
sensors:
  - {type: modal, name: modes, body: arm}
  - {type: stress, name: stress, body: arm}
  - {type: position, name: middle, marker: arm.node3}
""")
    flexible, rigid = read_model(path).mechanism, read_model(path, rigid=True).mechanism
    assert [sensor.name for sensor in rigid.sensors] == ["middle"]
    (arm,), (soft,) = rigid.bodies, flexible.bodies
    m = 7850 * 2 * 0.04 * 0.06
    assert arm.mass == pytest.approx(m, rel=1e-12)
    assert arm.center == pytest.approx((1, 0, 0), abs=1e-12)
    closed = m / 12 * np.array([0.04**2 + 0.06**2, 2**2 + 0.06**2, 2**2 + 0.04**2])
    assert arm.inertia == pytest.approx(np.diag(closed), rel=1e-9, abs=1e-9)
    assert rigid.sensors[0].marker.r == pytest.approx(flexible.sensors[-1].marker.r, abs=1e-12)
    assert arm.orientation == pytest.approx(soft.orientation)
    # drawn from end to end and back
    assert arm.outline[:, 0] == pytest.approx([0, 0.5, 1, 1.5, 2, 1.5, 1, 0.5, 0], abs=1e-12)
