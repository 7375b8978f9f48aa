"""States in model files equal those of Python; what is wrong is named with its line."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.mechanism import States, StateSensor, rate
from jousto.schema.read import parse_model

MODEL = """
bodies: [{name: wheel, mass: 1, inertia: [1e-4, 1e-4, 1e-4]}]
joints: [{type: revolute, name: axle, a: ground.origin, b: wheel.origin, axis: [0, 0, 1]}]
states:
  - type: states
    name: winding
    initial: {i: 100 mA}
    inputs: {u: 12 V, w: rate(axle.angle), q: {type: harmonic, frequency: 2}}
    rates: {i: (u + q - 1.0*i - 0.05*w)/0.5e-3}
    outputs: {torque: 0.05*i}
    forces: {axle.angle: 0.05*i}
    sizes: {i: 2 A}
  - {type: states, name: lag, initial: {y: 0}, inputs: {x: winding.torque},
     rates: {y: (x - y)/0.01}}
sensors:
  - {type: state, name: i, of: winding.i, unit: A}
  - {type: state, name: y, of: lag.y, unit: N m}
"""


def test_states_equal_the_python_constructors() -> None:
    read = parse_model(MODEL).mechanism
    (axle,) = read.joints
    winding = States(
        "winding",
        {"i": 0.1},
        {"i": "(u + q - 1.0*i - 0.05*w)/0.5e-3"},
        inputs={"u": 12.0, "w": rate(axle.angle), "q": jo.Harmonic(frequency=2.0)},
        outputs={"torque": "0.05*i"},
        forces={axle.angle: "0.05*i"},
        sizes={"i": 2.0},
    )
    lag = States("lag", {"y": 0.0}, {"y": "(x - y)/0.01"}, inputs={"x": "winding.torque"})
    sensors = StateSensor("i", winding["i"], unit="A"), StateSensor("y", lag["y"], unit="N m")
    made = jo.Mechanism(*read.bodies, axle, winding, lag, *sensors)
    runs = [jo.simulate(jo.compile(one), 0.01, solver=jo.RK4(1e-4)) for one in (read, made)]
    for name in ("i", "y"):
        assert np.array_equal(runs[0][name], runs[1][name])
        assert runs[0][name][-1, 0] != 0.0
    assert [x.unit for x in read.sensors] == ["A", "N m"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("i: 100 mA", "i: many", "7: states.0.initial.i: 'many' is no number with a unit"),
        ("rate(axle.angle)", "rate(axle.angel)", "8: .*joint 'axle' has no angel"),
        ("rate(axle.angle)", "rate(2)", "8: "),
        ("rate(axle.angle)", "open('x')", "8: .*not allowed"),
        ("0.05*w)", "0.05*v)", "nothing is called 'v'"),
        ("winding.torque}", "winding.tork}", "needs 'tork' of block 'winding'"),
        ("winding.torque}", "winder.torque}", "no block 'winder'; did you mean 'winding'"),
        ("axle.angle: 0.05*i", "axl.angle: 0.05*i", "11: .*unknown joint 'axl'|axl"),
        ("of: winding.i", "of: winding.j", "needs 'j' of block 'winding'"),
        ("unit: A}", "unit: X}", "unknown unit 'X'"),
        ("    sizes:", "    size:", "12: states.0: unknown key 'size'|size"),
    ],
)
def test_what_is_wrong_is_named(old: str, new: str, message: str) -> None:
    assert old in MODEL
    with pytest.raises(InputError, match=message):
        jo.compile(parse_model(MODEL.replace(old, new)).mechanism)
