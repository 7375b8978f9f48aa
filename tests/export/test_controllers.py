"""Exported machines with controllers: they begin with the integral part of their state at rest."""

from __future__ import annotations

import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import jousto as jo
from exported import CC
from jousto.cli.group import app
from jousto.export.fmu import write_fmu

fmpy = pytest.importorskip("fmpy")
pytestmark = pytest.mark.skipif(CC is None, reason="no C compiler")


def arm() -> jo.Model:
    """A link that a PID holds against gravity, from rest."""
    link = jo.RigidBody("link", 2.0, (0.01, 0.1, 0.1), center=(0.4, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], link["origin"], axis=(0, -1, 0))
    hold = jo.mechanism.PID("hold", hinge.angle, 0.6, kp=60.0, ki=80.0, kd=12.0)
    sensors = jo.CoordinateSensor("angle", hinge.angle), jo.ForceSensor("torque", hold)
    gravity = jo.Gravity((0, 0, -9.81))
    return jo.compile(jo.Mechanism(link, hinge, hold, *sensors, gravity, start="rest"))


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_a_unit_from_rest_stays_there(kind: str, tmp_path: Path) -> None:
    path = write_fmu(arm(), tmp_path / "arm.fmu", jo.ROS2(step=1e-3), version=2)
    result = fmpy.simulate_fmu(str(path), stop_time=0.2, fmi_type=kind, output_interval=0.01)
    assert np.abs(result["angle"] - 0.6).max() < 1e-6
    weight = 2.0 * 9.81 * 0.4 * np.cos(0.6)
    assert np.abs(result["torque"] - weight).max() < 1e-3
    with zipfile.ZipFile(path) as archive:
        about = ElementTree.fromstring(archive.read("modelDescription.xml"))
    states = {x.get("name"): x.find("Real") for x in about.iter("ScalarVariable")}
    integral, filtered = states["x.hold.integral"], states["x.hold.filtered"]
    assert integral is not None and filtered is not None
    assert (integral.get("unit"), filtered.get("unit")) == ("N m", "rad")
    assert float(integral.get("start", "0")) == pytest.approx(weight, rel=1e-8)


FILE = """
parameters:
  kp: {value: 60 N m/rad, bounds: [20 N m/rad, 200 N m/rad]}
bodies:
  - {type: rigid, name: link, mass: 2 kg, inertia: [0.01, 0.1, 0.1], center: [0.4, 0, 0]}
joints:
  - {type: revolute, name: hinge, a: ground.origin, b: link.origin, axis: [0, -1, 0]}
forces:
  - type: pid
    name: hold
    coordinate: hinge.angle
    reference: 0.6 rad
    kp: ${kp}
    ki: 80 N m/rad/s
    kd: 12 N m s/rad
    limit: 20 N m
sensors:
  - {type: coordinate, name: angle, coordinate: hinge.angle}
gravity: [0, 0, -9.81]
simulation: {t_end: 1 s, solver: {type: RK4, step: 1 ms}}
"""


def test_a_gain_of_the_file_can_be_changed_in_the_unit(tmp_path: Path) -> None:
    """Filter and tracking times follow, as in a file with that gain."""
    path, unit = tmp_path / "arm.yaml", tmp_path / "arm.fmu"
    path.write_text(FILE)
    with pytest.raises(SystemExit):
        app(["export", str(path), "-o", str(unit)])
    result = fmpy.simulate_fmu(
        str(unit), stop_time=1.0, start_values={"kp": 90.0}, output_interval=0.01
    )
    path.write_text(FILE.replace("value: 60", "value: 90"))
    model = jo.compile(jo.read_model(path).mechanism)
    run = jo.simulate(model, 1.0, solver=jo.RK4(step=1e-3), output_step=0.01)
    np.testing.assert_allclose(result["angle"], run["angle"][:, 0], rtol=0, atol=1e-9)
