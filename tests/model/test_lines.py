"""Joints, couplings and drives as rows of the engine, against closed forms and differences."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.base.declare import kinds
from jousto.mechanism.joints import coupling as c
from jousto.mechanism.joints.hinges import Revolute
from jousto.mechanism.signals.piecewise import SCurve
from scene.machines import APART, joint_of


def body(name, position=(0, 0, 0), **more):
    """Return a rigid body without symmetry, moving."""
    return jo.RigidBody(
        name, 2.0, (0.3, 0.4, 0.5), center=(0.1, 0.2, -0.1), position=position, **more
    )


@pytest.mark.parametrize("kind", kinds("joints", "jousto.mechanism.joints").values())
@pytest.mark.filterwarnings("ignore::jousto.base.errors.JoustoWarning")
def test_accelerations_keep_the_rows_closed(kind):
    """One step without projection leaves C and Cq v at O(h^5): rows, rates, biases agree."""
    one, two = body("one"), body("two", APART.get(kind.tag, (0, 0, 0)))
    model = jo.compile(jo.Mechanism(one, two, joint_of(kind, one["origin"], two["origin"])))
    engine = jo.model.Engine(model)
    random = np.random.default_rng(7)
    engine.v[:] = random.normal(size=model.nv)
    engine.assemble()
    q0, v0 = engine.q.copy(), engine.v.copy()
    assert max(np.abs(x).max() for x in engine.constraints()) < 1e-9
    # a step of order 4 along the solution keeps C = C' = 0 to h^5
    drift = []
    for h in (0.02, 0.01):
        engine.q[:], engine.v[:] = q0, v0
        native = engine.native_solver(jo.RK4(step=h).method, h, False)
        rows = np.zeros((1, engine.row_size))
        assert engine.run(native, 1, 1, rows) == ("ok", 1)
        drift.append(np.abs(np.concatenate(engine.constraints())).max())
    assert drift[1] < max(drift[0] / 20, 1e-13)


def wheel(name, position=(0, 0, 0)):
    """Return a disc about its own origin."""
    return jo.RigidBody(name, 1.0, (0.02, 0.02, 0.03), position=position)


def test_gear_shares_a_torque():
    """I1 a1 + r I2 a2 = T with a2 = r a1; the torque on b is I2 a2."""
    one, two = wheel("one"), wheel("two", (1, 0, 0))
    p = Revolute("p", jo.ground["origin"], one["origin"])
    s = Revolute("s", jo.ground.at((1, 0, 0)), two["origin"])
    gear = c.Gear("gear", p.angle, s.angle, -2.0)
    push = jo.Torque("push", one["origin"], (0, 0, 0.6))
    model = jo.compile(jo.Mechanism(one, two, p, s, gear, push))
    engine = jo.model.Engine(model)
    a, lam = engine.accelerations()
    assert a[5] == pytest.approx(0.6 / (0.03 + 4 * 0.03), rel=1e-12)
    assert a[11] == pytest.approx(-2 * a[5], rel=1e-12)
    assert -lam[-1] == pytest.approx(0.03 * a[11], rel=1e-12)


@pytest.mark.parametrize("method", [jo.RK4, jo.ROS2])
@pytest.mark.filterwarnings("ignore::jousto.base.errors.JoustoWarning")
def test_drive_follows_its_signal_and_closes_the_energy(method):
    """A driven crank with an eccentric mass: exact angle; kinetic energy is the drive's work."""
    crank = jo.RigidBody("crank", 2.0, (0.1, 0.1, 0.1), center=(0.4, 0, 0))
    hinge = Revolute("hinge", jo.ground["origin"], crank["origin"])
    drive = c.Drive("drive", hinge.angle, SCurve([0.0, 1.0], [0.0, 8.0]))
    model = jo.compile(jo.Mechanism(crank, hinge, drive))
    engine = jo.model.Engine(model)
    solver = method(step=1e-3)
    native = engine.native_solver(solver.method, 1e-3, True)
    rows = np.zeros((1, engine.row_size))
    assert engine.run(native, 500, 500, rows) == ("ok", 1)
    speed = 8 * 30 * 0.25**2  # derivative of 10 s^3 - 15 s^4 + 6 s^5 at s = 1/2
    assert engine.v[5] == pytest.approx(speed, abs=1e-9)
    kinetic = 0.5 * (0.1 + 2.0 * 0.16) * speed**2
    assert engine.work[2] == pytest.approx(kinetic, rel=1e-4)
