"""Studies of machines that signals drive: the same inputs in all runs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo

END = 0.5


def cart(mass: float = 2.0) -> jo.Mechanism:
    body = jo.RigidBody("cart", mass, (1.0, 1.0, 1.0))
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    push = jo.Force("push", body["origin"], (1.0, 0, 0), signal=jo.Input("u"))
    return jo.Mechanism(body, slide, push, jo.PositionSensor("at", body["origin"]))


RAMP = jo.Table((0.0, END), (0.0, 3.0))
WAY = 3.0 * END**2 / 6  # of the ramp, m kg


def of_cart(inputs: Any, parameters: Any, model: Any = cart) -> Any:
    solver = jo.RK4(0.01)
    return jo.study(model, parameters, "last(at.x)", t_end=END, solver=solver, inputs=inputs)


def mass() -> jo.Parameter:
    return jo.Parameter("mass", 2.0, bounds=(1.0, 4.0), unit="kg")


def test_a_table_drives_all_runs() -> None:
    """x = F t^2 / (6 m) under a force that grows from 0 to F; its derivative is -x / m."""
    study = of_cart({"u": RAMP}, mass())
    masses = np.array([[1.0], [2.0], [4.0]])
    assert study(masses)[:, 0] == pytest.approx(WAY / masses[:, 0], rel=1e-12)
    slope = jo.design.gradient(study, [2.0])
    assert np.ravel(slope.jacobian) == pytest.approx([-WAY / 4], rel=1e-10)


def test_one_input_is_a_signal_and_another_a_parameter() -> None:
    body = jo.RigidBody("cart", 2.0, (1.0, 1.0, 1.0))
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    pushes = [
        jo.Force(name, body["origin"], (1.0, 0, 0), signal=jo.Input(name)) for name in ("u", "w")
    ]
    machine = jo.Mechanism(body, slide, *pushes, jo.PositionSensor("at", body["origin"]))
    study = of_cart({"u": RAMP}, jo.Parameter("w", 1.0, bounds=(0, 9)), machine)
    found = study([[0.0], [8.0]])[:, 0]
    assert found == pytest.approx([WAY / 2, WAY / 2 + 8.0 * END**2 / 4], rel=1e-12)


@pytest.mark.parametrize(
    ("inputs", "sentence"),
    [
        ({"v": RAMP}, "no input 'v'"),
        ({"u": np.zeros(51)}, "give jo.Table"),
        ({"u": np.sin}, "give jo.Table"),
        ({"u": "ramp"}, "must be a Signal"),
    ],
)
def test_what_cannot_drive_is_said(inputs: Any, sentence: str) -> None:
    with pytest.raises(jo.InputError, match=sentence):
        of_cart(inputs, mass())


def test_an_input_is_no_parameter_too() -> None:
    with pytest.raises(jo.InputError, match="parameter 'u'.*one of the inputs"):
        of_cart({"u": RAMP}, jo.Parameter("u", 1.0, bounds=(0, 2)), cart())


def test_tables_of_other_inputs_are_not_resumed(tmp_path: Any) -> None:
    path = tmp_path / "study.csv"
    of_cart({"u": RAMP}, mass()).run([[1.0]], path=path)
    with pytest.raises(jo.InputError, match="inputs|other"):
        of_cart({"u": 1.0}, mass()).run([[1.0], [2.0]], path=path)
