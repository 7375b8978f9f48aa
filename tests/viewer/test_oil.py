"""Hydraulic cylinders in the viewer: where they are, and the pressures that colour them."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

import jousto as jo
from jousto.hydraulics import FlowSource, HydraulicCylinder, HydraulicNetwork, Node, Tank
from jousto.mechanism import StateSensor
from jousto.scene.scene import Scene
from jousto.viewer.packing import scene_header
from jousto.viewer.viewable import scenes_of
from viewer.machines import swing

BORE, ROD, CLOSED, STROKE = 0.08, 0.04, 0.6, 0.4


def press(*, watched: bool = True) -> jo.Mechanism:
    """A cylinder that stands on the ground lifts 500 kg by a constant flow."""
    load = jo.RigidBody.box("load", (0.3, 0.3, 0.1), mass=500.0, position=(0, 0, 0.7))
    foot, head = jo.ground["origin"], load["origin"]
    guide = jo.Prismatic("guide", foot, head, axis=(0, 0, 1))
    lift = HydraulicCylinder(
        *("lift", foot, head, "below", "above"),
        bore=BORE,
        rod=ROD,
        closed=CLOSED,
        stroke=STROKE,
        damping=2e4,
    )
    parts = [FlowSource("pump", "below", 2e-4), Node("below", 1e-3), Tank("above"), lift]
    oil = HydraulicNetwork("oil", parts)
    sensors = [StateSensor("p", oil["below"], unit="Pa")] if watched else []
    return jo.Mechanism(load, guide, oil, *sensors, jo.Gravity((0, 0, -9.81)), name="press")


@functools.cache
def lifted() -> jo.Solution:
    """The press after 0.2 s."""
    return jo.simulate(jo.compile(press()), 0.2, solver=jo.ROS2(1e-3), output_step=0.01)


def cylinder(scene: Scene) -> dict[str, Any]:
    (found,) = [one for one in scene_header(scene, None, half=True)["symbols"] if one["cylinder"]]
    return found


def test_a_cylinder_has_its_sizes_and_sensors(tmp_path: Path) -> None:
    """In memory and in a file; a chamber without sensor, and one at a tank, has no pressure."""
    for thing in (lifted(), lifted().save(tmp_path / "press.h5")):
        found = cylinder(scenes_of([thing])[0])
        assert found["name"] == "oil.lift" and found["kind"] == "hydraulic-cylinder"
        assert found["cylinder"] == {
            "bore": BORE, "rod": ROD, "closed": CLOSED, "stroke": STROKE, "pressures": ["p", ""],
        }  # fmt: skip
        assert [side["place"] for side in found["sides"]] == [-1, 0]
        assert found["text"] == "cylinder 'lift' of hydraulics 'oil'"


def test_a_machine_without_oil_has_no_cylinders() -> None:
    symbols = scene_header(scenes_of([swing()])[0], None, half=True)["symbols"]
    assert {one["cylinder"] for one in symbols} == {None}


def test_the_text_names_missing_sensors() -> None:
    found = cylinder(scenes_of([press(watched=False)])[0])
    assert found["cylinder"]["pressures"] == ["", ""]
    assert found["text"] == (
        "cylinder 'lift' of hydraulics 'oil'; a StateSensor of oil.below colours it"
    )
