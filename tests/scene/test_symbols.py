"""Symbols of scenes: every declared kind has one, where it is and which way it points."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism.sensors.scalar import EnergySensor, SignalSensor
from jousto.mechanism.sensors.state import StateSensor
from jousto.output.scenes.symbols import KINDS
from jousto.recovery.shape import rotation_matrices
from jousto.scene.make import make_scene
from jousto.scene.scene import Scene, Side, Symbol
from scene.machines import COUPLINGS, FORCES, JOINTS, SENSORS, Z, ball, everything, jointed

pytestmark = pytest.mark.filterwarnings("ignore::jousto.base.errors.JoustoWarning")

NOWHERE = {EnergySensor.tag, SignalSensor.tag, StateSensor.tag}
NO_ENDS = {"parallel-axes", "perpendicular", "constant-orientation"}
"""Joints that pictures leave out: they hold directions and have no point."""
PAGE = Path(__file__).parents[2] / "frontend/src/render/symbols/kinds.ts"


@pytest.fixture(scope="module")
def scene() -> Scene:
    return make_scene(everything())


def place(row: np.ndarray, side: Side) -> np.ndarray:
    """Return where a side is in the world, by the scene's formula."""
    u = np.array(side.u)
    if side.place < 0:
        return u
    at = row[side.place :]
    if side.phi is not None:
        u = u + side.phi @ at[7 : 7 + side.n]
    return at[:3] + rotation_matrices(at[3:7]) @ u


def named(scene: Scene, name: str, group: str) -> Symbol:
    (found,) = [one for one in scene.symbols if (one.name, one.group) == (name, group)]
    return found


@pytest.mark.parametrize("tag", JOINTS)
def test_every_joint_has_a_symbol_of_its_kind_with_its_axis(tag):
    model = jointed(JOINTS[tag])
    symbol = named(make_scene(model), "joint", "joint")
    assert symbol.kind == tag
    assert len(symbol.sides) == 2
    joint = model.joints[0]
    # bodies are not turned, so that their axes are those of the world
    np.testing.assert_allclose(symbol.axis, joint.axis_world, rtol=0, atol=1e-14)
    for side, marker in zip(symbol.sides, joint.frames, strict=True):
        np.testing.assert_allclose(side.u, marker.position_local, rtol=0, atol=0)


@pytest.mark.parametrize("tag", JOINTS)
def test_the_page_and_pictures_draw_every_joint(tag):
    assert f'"{tag}"' in PAGE.read_text(encoding="utf-8")
    assert (tag in KINDS) != (tag in NO_ENDS)


def test_the_machine_has_every_kind():
    machine = everything()
    assert {one.tag for one in machine.forces} == set(FORCES)
    assert {one.tag for one in machine.sensors} == set(SENSORS)


@pytest.mark.parametrize("tag", FORCES)
def test_every_force_has_a_symbol(scene, tag):
    for force in (one for one in everything().forces if one.tag == tag):
        symbol = named(scene, force.name, "force")
        assert symbol.sides
        assert symbol.text.startswith(f"{tag} '{force.name}'")


@pytest.mark.parametrize("tag", SENSORS)
def test_every_sensor_with_a_place_has_a_symbol(scene, tag):
    for sensor in (one for one in everything().sensors if one.tag == tag):
        found = [one for one in scene.symbols if one.sensor == sensor.name]
        assert len(found) == (0 if tag in NOWHERE else 1)
        (described,) = [one for one in scene.sensors if one.name == sensor.name]
        assert (described.side is None) == (tag in NOWHERE)


@pytest.mark.parametrize("tag", COUPLINGS)
def test_every_coupling_has_a_symbol(tag):
    one, two = ball("one"), ball("two", (0, 3, 0))
    p = jo.Revolute("p", jo.ground["origin"], one["origin"], Z)
    q = jo.Prismatic("q", jo.ground.at((0, 3, 0)), two["origin"], (1, 0, 0))
    r = jo.Revolute("r", jo.ground.at((0, 3, 0)), two["origin"], Z)
    more, item = {
        "gear": lambda: (r, COUPLINGS["gear"]("c", p.angle, r.angle, -2.0)),
        "rack": lambda: (q, COUPLINGS["rack"]("c", p.angle, q.displacement, 0.1)),
        "coupling": lambda: (q, COUPLINGS["coupling"]("c", (p.angle, q.displacement), (1.0, 2.0))),
        "drive": lambda: (q, COUPLINGS["drive"]("c", p.angle, jo.Constant(0.0))),
        "rigid-stop": lambda: (q, COUPLINGS["rigid-stop"]("c", p.angle, upper=1.0)),
        "disc-on-plane": lambda: (
            q,
            COUPLINGS["disc-on-plane"](
                *("c", jo.ground.at((0, 3, -0.1)), two["origin"], 0.1), axle=(1, 0, 0)
            ),
        ),
        "lock": lambda: (
            (q, event := jo.mechanism.Event("e", p.angle, 1.0)),
            COUPLINGS["lock"]("c", p.angle, event),
        ),
    }[tag]()
    more = more if isinstance(more, tuple) else (more,)
    symbol = named(make_scene(jo.Mechanism(one, two, p, *more, item)), "c", "joint")
    kinds = {"drive": "motor"} | dict.fromkeys(("rigid-stop", "lock", "disc-on-plane"), "coupling")
    assert symbol.kind == kinds.get(tag, tag)
    assert len(symbol.sides) == (2 if tag in kinds else 4)
    np.testing.assert_allclose(symbol.axis, Z, rtol=0, atol=1e-14)


def test_friction_stands_at_its_joint(scene):
    assert named(scene, "rub", "force").kind == "friction"


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("spring", "spring-damper"),
        ("stop", "torsion-damper"),
        ("torque", "motor"),
        ("servo", "actuator"),
        ("twist", "moment"),
        ("felt", "force-sensor"),
    ],
)
def test_kinds_are_as_fine_as_their_pictures(scene, name, kind):
    assert {one.kind for one in scene.symbols if one.name == name} == {kind}


def test_forces_point_where_they_push(scene):
    pull, thrust = named(scene, "pull", "force"), named(scene, "thrust", "force")
    assert (pull.fixed, thrust.fixed) == (True, False)
    np.testing.assert_allclose(pull.axis, (0, 3, 0))
    np.testing.assert_allclose(thrust.axis, (1, 0, 0))


def test_vectors_of_sensors_are_arrows(scene):
    found = {one.name: (one.arrow, one.columns) for one in scene.sensors}
    assert found["velocity"] == ("velocity", (0, 1, 2))
    assert found["acceleration"] == ("acceleration", (0, 1, 2))
    assert found["reaction"] == ("force", (0, 1, 2))
    assert found["position"] == (None, None)
    assert found["section"] == (None, None)  # in the axes of the section


def test_points_of_sensors_are_where_they_measure(tmp_path):
    """Nodes, points between the nodes of beams and points of rigid bodies, over a run."""
    from scene.machines import reduced

    arm = jo.FlexibleBody("arm", reduced(), position=(0, 0, 1))
    slider = ball("slider", (0, 2, 0), markers={"tip": (0.3, 0, 0)}, angular_velocity=(1, 2, 3))
    hinge = jo.Revolute("hinge", jo.ground.at((0, 0, 1)), arm["start"], (0, 1, 0))
    markers = {"node": arm["end"], "between": arm.at((0.37, 0.01, 0.005)), "rigid": slider["tip"]}
    sensors = [jo.PositionSensor(name, marker) for name, marker in markers.items()]
    model = jo.compile(jo.Mechanism(arm, slider, hinge, jo.Gravity((0, 0, -9.81)), *sensors))
    run = jo.simulate(model, 0.2, output_step=0.02)
    for source in (run, jo.load(run.save(tmp_path / "run.h5"))):
        scene = make_scene(source)
        rows = scene.motion.rows(slice(None))
        for sensor in scene.sensors:
            found = np.array([place(row, sensor.side) for row in rows])
            np.testing.assert_allclose(found, run[sensor.name], rtol=0, atol=1e-13)
        assert [mark.name for mark in scene.markers] == ["arm.start", "arm.end", "slider.tip"]
