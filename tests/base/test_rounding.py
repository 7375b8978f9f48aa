"""One rule for rounding: what is below that of the numbers it comes from is shown as zero."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from cli.test_meshes import call
from jousto.base import rounding
from jousto.base.rounding import DIGITS, Scales, difference, without_rounding
from jousto.scene.machine import run_scene
from jousto.viewer.live.initial_scene import scene_at

# at rest in a frame that is turned by odd angles: nothing there cancels exactly
REST = """\
parts:
  rod:
    type: beam
    length: 1 m
    section: {type: rectangle, width: 20 mm, height: 10 mm}
    material: S355
    elements: 4
    reduce: {type: craig-bampton, interfaces: [start], modes: 4}
bodies:
  - {name: arm, part: rod, position: [0.1, 0.2, 0.3], orientation: {axis: [1, 2, 3], angle_deg: 40}}
sensors:
  - {type: position, name: tip, marker: arm.end}
  - {type: velocity, name: speed, marker: arm.end}
  - {type: stress, name: bending, body: arm, sites: [e1.a.top]}
  - {type: damage, name: life, sensor: bending, sn: fat71, residue: half}
simulation: {t_end: 0.2 s, solver: {type: ROS2, step: 1 ms}, output_step: 10 ms}
"""


def test_differences_below_rounding_are_none() -> None:
    one = 123.4
    assert difference(np.nextafter(one, 200.0), one) == 0.0
    assert difference(one * (1.0 + 1e-11), one) == pytest.approx(1e-11 * one, rel=1e-4)
    assert difference(0.0, 0.0) == 0.0 and difference(1e-300, 0.0) == 1e-300


def test_readings_below_rounding_are_zero() -> None:
    assert without_rounding([1.0, -3e-17, 2e-12]).tolist() == [1.0, 0.0, 2e-12]
    assert without_rounding([9e-17, 0.0], floor=1e-14).tolist() == [0.0, 0.0]
    assert without_rounding([np.nan, 1.0, 1e-13, np.inf])[2] == 0.0
    assert without_rounding([]).shape == (0,)


@pytest.mark.parametrize(
    ("unit", "scale"),
    [
        ("m", 4.0),
        ("m/s", (4.0 * 9.80665) ** 0.5),
        ("m/s^2", 9.80665),
        ("N", 3.0 * 9.80665),
        ("N m", 3.0 * 9.80665 * 4.0),
        ("J", 3.0 * 9.80665 * 4.0),
        ("rad", 1.0),
        ("m/m", 1.0),
        ("Pa", 2e11),
        ("1", 0.0),
        ("V", 0.0),
    ],
)
def test_a_quantity_has_the_scale_of_its_dimension(unit: str, scale: float) -> None:
    """Weight, weight times size, speed and time of a fall through the size of the machine."""
    floor = Scales(mass=3.0, length=4.0, stress=2e11).floor(unit)
    assert floor == pytest.approx(DIGITS * scale, rel=1e-12)


def test_a_machine_at_rest_reads_zero(tmp_path: Any) -> None:
    model = tmp_path / "rest.yaml"
    model.write_text(REST)
    code, text = call("run", model, "-q")
    assert code == 0, text
    run = jo.load(tmp_path / "rest.h5")
    # the page shows readings by the same rule, of results and of live machines
    with pytest.warns(jo.JoustoWarning, match="moves freely"):
        compiled = jo.compile(jo.read_model(model).mechanism)
    for scene in (run_scene(run), scene_at(compiled, None, "rest")[1]):
        floors = {one.name: one.floors for one in scene.sensors}
        assert 1e-15 < floors["tip"][0] < 1e-13 and 1e-9 < floors["bending"][0] < 1e-2
    shift = run["tip"] - run["tip"][0]
    assert np.abs(shift).max() < 1e-12  # it does not move
    code, text = call("peaks", tmp_path / "rest.h5", "speed", "bending", "life")
    assert code == 0, text
    rows = [line.split() for line in text.splitlines()[1:]]
    assert len(rows) >= 5
    for row in rows:
        if row[0].startswith(("speed", "bending")):
            assert (row[1], row[4]) == ("0", "0"), text
    # no turn of rounding is a cycle
    assert np.all(run["life"] == 0.0), run["life"][-1]
    # what moves is shown, however little: a nanometre a second
    moving = model.with_name("slow.yaml")
    moving.write_text(REST.replace("name: arm, part", "name: arm, velocity: [1e-9, 0, 0], part"))
    assert call("run", moving, "-q")[0] == 0
    code, text = call("peaks", tmp_path / "slow.h5", "speed")
    row = text.splitlines()[1].split()
    assert float(row[1]) == pytest.approx(1e-9, rel=1e-3)


@pytest.mark.parametrize("unit", rounding.POWERS)
def test_the_usual_units_have_the_dimension_that_the_library_of_units_gives(unit):
    assert rounding.dimension(unit) == rounding.parsed_dimension(unit)
