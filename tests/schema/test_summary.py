"""What checks and notebooks say of the forces of a machine."""

from __future__ import annotations

from typing import Any

import pytest

import jousto as jo
from jousto.schema.summary import given, mechanism_facts
from scene.machines import JOINTS, jointed

ARM = jo.RigidBody("arm", 1.0, (0.1, 0.1, 0.1))
HINGE = jo.Revolute("hinge", jo.ground["origin"], ARM["origin"])
ROPE = jo.BeamBody(
    "rope",
    [(0, 0, 0), (1, 0, 0)],
    jo.Circle(0.01),
    jo.Material(E=2.1e11, nu=0.3, rho=7850.0),
    elements=2,
)


@pytest.mark.parametrize(
    ("force", "said"),
    [
        (
            jo.mechanism.Stop("stop", HINGE.angle, -1.0, 2.5, stiffness=5e3, restitution=0.4),
            "hinge.angle, lower -1 rad, upper 2.5 rad, stiffness 5000 N m/rad, restitution 0.4",
        ),
        (
            jo.Spring.between("spring", jo.ground["origin"], ARM.at((1, 0, 0)), 250.0, damping=3.0),
            "ground.origin to arm.at(1, 0, 0), stiffness 250 N/m, damping 3 N s/m",
        ),
        (jo.Spring("hinge", HINGE.angle, 100.0), "hinge.angle, stiffness 100 N m/rad"),
        (jo.Force("push", ARM["origin"], (0, -30, 0)), "arm.origin, vector (0, -30, 0) N"),
        (jo.mechanism.LineLoad("wind", ROPE, (0, 5, 0), follow=True), "rope, follow"),
    ],
)
def test_forces_say_where_they_act_and_what_they_were_given(force: Any, said: str) -> None:
    assert given(force) == said


def test_kinds_of_joints_are_words_of_a_file() -> None:
    """The kind of every joint is its word in a model file, with blanks."""
    for tag in JOINTS:
        facts = dict(mechanism_facts(jointed(JOINTS[tag])))
        assert facts["joint joint"].startswith(f"{tag.replace('-', ' ')}, "), tag
