"""Findings on the contacts of a run: what is wrong is found, and rest is no wrong rebound."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import (
    CollisionShape,
    Contact,
    Contacts,
    Cuboid,
    HalfSpace,
    PowerLaw,
    Sphere,
)

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")

G = 9.81
BOX = Cuboid((0.4, 0.3, 0.1))


def falling(resolve: str, tilt: float, many: bool) -> jo.Model:
    """A box with the restitution 0.1 that falls on its edge and comes to rest."""
    turn = (np.cos(tilt / 2), 0, np.sin(tilt / 2), 0)
    box = jo.RigidBody("box", 1.0, (0.01, 0.012, 0.015), position=(0, 0, 0.3), orientation=turn)
    law, floor = PowerLaw(1e8, 1.0, restitution=0.1), jo.ground["origin"]
    how: dict[str, Any] = {"mu_kinetic": 0.3, "resolve": resolve}
    touch: Any = Contact("touch", floor, HalfSpace(), box["origin"], BOX, law, **how)
    if many:
        shapes = [
            CollisionShape("floor", floor, HalfSpace()),
            CollisionShape("box", box["origin"], BOX),
        ]
        touch = Contacts("touch", shapes, law=law, **how)
    return jo.compile(jo.Mechanism(box, touch, jo.Gravity((0, 0, -G))))


@pytest.mark.parametrize("many", [False, True], ids=["contact", "set"])
@pytest.mark.parametrize(("events", "tilt"), [("located", 0.04), ("located", 1.2), ("step", 1.2)])
def test_rest_after_impulses_is_no_wrong_rebound(many, events, tilt):
    """What is left for the law is slow: the next impulse ends it, after a step or at any speed."""
    run = jo.simulate(falling("impulse", tilt, many), 0.6, solver=jo.ROS2(1e-3, events=events))
    assert len(run.contacts) >= 4
    assert not [text for text in run.contacts.findings if "restitution" in text]


def test_rebounds_in_few_steps_are_found():
    """A ball by its law in steps of a third of the touch."""
    ball = jo.RigidBody.sphere("ball", radius=0.05, mass=1.0, position=(0, 0, 0.2))
    law, floor = PowerLaw(1e6, 1.0, restitution=0.8), jo.ground["origin"]
    touch = Contact(
        "touch", floor, HalfSpace(), ball["origin"], Sphere(0.05), law, resolve="report"
    )
    run = jo.simulate(
        jo.compile(jo.Mechanism(ball, touch, jo.Gravity((0, 0, -G)))), 0.3, solver=jo.ROS2(1e-3)
    )
    (text, *_) = run.contacts.findings
    assert "had fewer than 10 steps" in text


@pytest.mark.parametrize("many", [False, True], ids=["contact", "set"])
def test_files_have_the_same_findings(tmp_path, many):
    run = jo.simulate(falling("impulse", 0.04, many), 0.3, solver=jo.ROS2(1e-3))
    assert jo.load(run.save(tmp_path / "run.h5")).contacts.findings == run.contacts.findings == ()
