"""Ports and coordinates of an exported machine, beside those of the mechanism."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.export.constants import constants
from jousto.export.ports import Ports, ports
from jousto.export.program import program
from jousto.model.native.native import Engine

STIFFNESS = np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]) + 0.1


@pytest.fixture(scope="module")
def found() -> Ports:
    """A slide and a hinge with forces by inputs, and a bushing."""
    block, wheel = (jo.RigidBody(name, 1.0, (0.1,) * 3) for name in ("block", "wheel"))
    slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], wheel["origin"], axis=(0, 0, 1))
    both, one = jo.Input("both"), jo.Input("one")
    items = (
        *(block, wheel, slide, hinge),
        jo.JointForce("pull", slide.displacement, both),
        jo.JointForce("turn", hinge.angle, both),
        jo.JointForce("push", slide.displacement, one),
        jo.Bushing("bush", jo.ground["origin"], wheel["origin"], STIFFNESS, 0.01 * STIFFNESS),
    )
    model = jo.compile(jo.Mechanism(*items))
    return ports(model, constants(Engine(model)))


def test_an_input_of_a_force_and_a_torque_has_no_unit(found: Ports) -> None:
    assert {port.name: port.unit for port in found.inputs} == {"both": "1", "one": "N"}


def test_parameters_of_a_bushing_are_its_diagonals(found: Ports) -> None:
    for letter, matrix in (("k", STIFFNESS), ("d", 0.01 * STIFFNESS)):
        starts = [p.start for p in found.parameters if p.name.startswith(f"bush.{letter}")]
        np.testing.assert_array_equal(starts, np.diag(matrix))


@pytest.mark.parametrize("solver", [jo.RK4(1e-3), jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3)])
def test_a_program_has_joint_coordinates_if_its_method_integrates_them(solver: object) -> None:
    arm = jo.RigidBody("arm", 1.0, (0.1,) * 3)
    pin = jo.Revolute("pin", jo.ground["origin"], arm["origin"], axis=(0, 0, 1))
    made = program(jo.compile(jo.Mechanism(arm, pin), core="joint"), solver)
    assert bool(made.model.links) == (not isinstance(solver, jo.GeneralizedAlpha))
