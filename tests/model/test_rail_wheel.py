"""Conical wheels on rails: Klingel's motion, tangents, both cores, geometry, bad input."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import fsolve, minimize

import jousto as jo
from jousto.base.errors import InputError
from jousto.mechanism import RailWheel
from jousto.model.native.native import displaced
from jousto.schema.read import parse_model
from model.test_newton import assert_exact

R, S, CONE, V = 0.46, 0.75, 0.05, 20.0  # m, half the distance of the contacts, conicity, m/s
pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")


def joints_of(y: float, z: float, roll: float, head: float) -> tuple[Any, ...]:
    """An axle with two conical wheels, displaced across by y, and its joints."""
    turn = jo.Rotate((1, 0, 0), degrees=float(np.degrees(roll)))
    axle = jo.RigidBody(
        "axle", 1200.0, (700, 100, 700), position=(0, y, z), orientation=turn,
        velocity=(V, 0, 0), angular_velocity=(0, V / R, 0),
    )  # fmt: skip
    joints = [
        RailWheel(
            *(name, jo.ground.at((0, side * S, 0)), axle.at((0, side * S, 0)), R, -side * CONE),
            head=head,
            across=side > 0,
            axle=axle["origin"].A[:, 1],
        )
        for name, side in (("left", 1), ("right", -1))
    ]
    return axle, joints


def wheelset(y: float, head: float = 0.0, core: str = "auto") -> jo.Model:
    """A wheelset on both rails that rolls along x, displaced across by y."""

    def gaps(at: Any) -> list[float]:
        _, joints = joints_of(y, at[0], at[1], head)
        return [joint.gap.initial for joint in joints]

    z, roll = fsolve(gaps, (R, CONE * y / S), xtol=1e-12)
    axle, joints = joints_of(y, z, roll, head)
    p = jo.PositionSensor("p", axle["origin"])
    e = jo.mechanism.EnergySensor("e", "kinetic")
    items = (axle, *joints, p, e, jo.Gravity((0, 0, -9.81)))
    return jo.compile(jo.Mechanism(*items), core=core)


@pytest.mark.parametrize("core", ["maximal", "joint"])
def test_a_wheelset_sways_with_the_wavelength_of_klingel(core):
    """2 pi sqrt(r s / l), exact for small motions of cones on edges, for any radius and gauge."""
    model = wheelset(1e-4, core=core)
    run = jo.simulate(model, 1.5, solver=jo.RK4(2e-3))
    x, y = run["p"][:, 0], run["p"][:, 1]
    wave = 2 * np.pi * np.sqrt(R * S / CONE)
    np.testing.assert_allclose(y, y[0] * np.cos(2 * np.pi * x / wave), atol=2e-5 * y[0])
    assert x[-1] > 1.5 * wave
    assert np.ptp(run["e"]) < 1e-9 * run["e"][0]


@pytest.mark.parametrize(("method", "order"), [(jo.RK4, 4), (jo.ROS2, 2), (jo.GeneralizedAlpha, 2)])
def test_the_methods_keep_their_order(method, order):
    ends = [
        jo.simulate(wheelset(5e-3, 0.3), 0.4, solver=method(h))["p"][-1, 1]
        for h in (5e-3, 2.5e-3, 1.25e-3)
    ]
    ratio = (ends[0] - ends[1]) / (ends[1] - ends[2])
    assert np.log2(abs(ratio)) == pytest.approx(order, abs=0.45)


@pytest.mark.parametrize("head", [0.0, 0.3])
def test_gap_is_the_smallest_distance_of_tread_and_head(head):
    """Against a search over the tread and the line in the middle of the head."""
    rng = np.random.default_rng(2)
    for _ in range(5):
        axle = jo.RigidBody(
            "axle", 1.0, (1, 1, 1), position=(0.1, *0.02 * rng.normal(size=1), R + 0.05),
            orientation=jo.Rotate(rng.normal(size=3), degrees=4.0),
        )  # fmt: skip
        wheel = RailWheel(
            *("w", jo.ground["origin"], axle["origin"], R, 0.2), head=head,
            axle=axle["origin"].A[:, 1],
        )  # fmt: skip
        n, at = axle["origin"].A[:, 1], axle["origin"].r
        one = np.cross(n, (0, 0, 1.0))
        one /= np.linalg.norm(one)
        other = np.cross(n, one)

        def apart(z: Any, n: Any = n, at: Any = at, one: Any = one, other: Any = other) -> float:
            tread = at + z[0] * n + (R + 0.2 * z[0]) * (np.cos(z[1]) * one + np.sin(z[1]) * other)
            return float(np.linalg.norm(tread - (z[2], 0, -head)))

        low = min(
            (
                minimize(apart, (0.0, a, 0.1), method="BFGS", options={"gtol": 1e-12})
                for a in (1.5, -1.5)
            ),
            key=lambda found: found.fun,
        )
        assert wheel.gap.initial == pytest.approx(low.fun - head, abs=1e-7)


def test_tangent_is_the_derivative():
    rng = np.random.default_rng(6)
    engine = jo.model.Engine(wheelset(2e-3, 0.25))
    engine.q[:] = displaced(engine.model, engine.q, 0.02 * rng.normal(size=6))
    engine.v[:] += rng.normal(size=6)
    engine.accelerations()
    assert_exact(engine, 1e-11)


def test_a_cylinder_is_a_rolling_wheel():
    """Without conicity on an edge the rows are those of `RollingWheel`."""
    found = []
    for kind in ("rail", "plane"):
        disc = jo.RigidBody(
            "d", 2.0, (0.02, 0.03, 0.02), position=(0, 0, 0.2), velocity=(1, 0.2, 0),
            angular_velocity=(0, 5.0, 0),
        )  # fmt: skip
        joint: Any = RailWheel("r", jo.ground["origin"], disc["origin"], 0.2, axle=(0, 1, 0))
        if kind == "plane":
            joint = jo.mechanism.RollingWheel(
                "r", jo.ground["origin"], disc["origin"], 0.2, axle=(0, 1, 0)
            )
        hold = jo.mechanism.ParallelAxes("up", jo.ground["origin"], disc["origin"], axis=(0, 1, 0))
        p = jo.PositionSensor("p", disc["origin"])
        pull = jo.Gravity((1.0, 0, -9.81))
        found.append(jo.simulate(jo.compile(jo.Mechanism(disc, joint, hold, p, pull)), 0.5)["p"])
    np.testing.assert_allclose(found[0], found[1], atol=1e-9)


def test_bad_input_is_refused():
    axle = jo.RigidBody("a", 1.0, (1, 1, 1), position=(0, 0, R))
    rail = jo.ground["origin"]
    with pytest.raises(InputError, match="axle is along the rail"):
        RailWheel("w", rail, axle["origin"], R, axle=(1, 0, 0))
    with pytest.raises(InputError, match="along the z axis"):
        RailWheel("w", rail, axle["origin"], R, rail=(0, 0, 1), axle=(0, 1, 0))
    with pytest.raises(InputError, match="cone"):
        RailWheel("w", rail, axle["origin"], R, 2.0, axle=(0, 1, 0))


def test_a_model_file_declares_it():
    model = parse_model(
        """
        bodies:
          - {type: rigid, name: axle, mass: 1, inertia: [1, 1, 1], position: [0, 0, 0.46]}
        joints:
          - {type: rail-wheel, name: w, a: ground.origin, b: axle.origin, radius: 460 mm,
             cone: 0.05, axle: [0, 1, 0], across: true}
        """
    )
    (wheel,) = model.mechanism.joints
    assert isinstance(wheel, RailWheel) and wheel.rows == 3
