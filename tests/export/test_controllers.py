"""Exported machines with controllers: they begin with the integral part of their state at rest."""

from __future__ import annotations

import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import jousto as jo
from exported import CC
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
