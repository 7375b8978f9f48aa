"""Machines whose drives move from the start begin as the rigid mechanism, without a blow."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import jousto as jo
from jousto.model import initial_conditions as start_module

STEEL = jo.Material(210e9, 0.3, 7850.0)
SPEED = 30.0  # rad/s
LENGTHS = {"crank": 0.1, "coupler": 0.28, "follower": 0.27}  # m
FRAME = 0.25  # m


def four_bar(flexible: bool, speed: float = SPEED) -> jo.Mechanism:
    """A four-bar linkage in the xy plane, its crank up and driven at constant speed from t = 0."""
    tip = np.array([0.0, LENGTHS["crank"]])
    across = np.array([FRAME, 0.0]) - tip
    d = float(np.hypot(*across))
    a, b = LENGTHS["coupler"], LENGTHS["follower"]
    turn = np.arctan2(across[1], across[0]) + np.arccos((a * a + d * d - b * b) / (2 * a * d))
    end = tip + a * np.array([np.cos(turn), np.sin(turn)])
    places = {"crank": (np.zeros(2), tip), "coupler": (tip, end),
              "follower": (np.array([FRAME, 0.0]), end)}  # fmt: skip
    bodies = {}
    for name, (first, last) in places.items():
        angle = float(np.degrees(np.arctan2(*(last - first)[::-1])))
        at = {"position": (*first, 0.0), "orientation": jo.Rotate((0, 0, 1), degrees=angle)}
        length = LENGTHS[name]
        if flexible:
            part = jo.Part.beam(length, jo.Rectangle(0.025, 0.004), 6, STEEL)
            reduced = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4))
            bodies[name] = jo.FlexibleBody(name, reduced, damping=0.01, **at)
        else:
            mass = 7850.0 * 0.025 * 0.004 * length
            inertia = (1e-6, mass * length**2 / 12, mass * length**2 / 12)
            bodies[name] = jo.RigidBody(
                name,
                mass,
                inertia,
                center=(length / 2, 0, 0),
                markers={"start": (0, 0, 0), "end": (length, 0, 0)},
                **at,
            )
    crank, coupler, follower = bodies.values()
    z = (0, 0, 1)
    pivot = jo.Revolute("pivot", jo.ground["origin"], crank["start"], axis=z)
    return jo.Mechanism(
        *bodies.values(),
        pivot,
        jo.Revolute("pin", crank["end"], coupler["start"], axis=z),
        jo.PointOnLine("knee", coupler["end"], follower["end"], axis=z),
        jo.Revolute("foot", jo.ground.at((FRAME, 0, 0)), follower["start"], axis=z),
        jo.Drive("motor", pivot.angle, jo.Ramp(-1.0, 9.0, before=-speed, after=9.0 * speed)),
        name="four-bar",
    )


@pytest.fixture(scope="module")
def models() -> tuple[jo.Model, jo.Model]:
    return jo.compile(four_bar(True)), jo.compile(four_bar(False))


def rigid_part(model: jo.Model) -> np.ndarray:
    return np.concatenate([model.v0[b.iv : b.iv + 6] for b in model.bodies])


def modal_part(model: jo.Model) -> np.ndarray:
    return np.concatenate([model.v0[b.iv + 6 : b.iv + 6 + b.n] for b in model.bodies])


def test_starts_as_the_rigid_mechanism(models: tuple[jo.Model, jo.Model]) -> None:
    flexible, rigid = models
    assert np.abs(rigid_part(rigid)).max() > 0.9 * SPEED
    assert np.allclose(rigid_part(flexible), rigid_part(rigid), atol=1e-9 * SPEED)
    assert np.abs(modal_part(flexible)).max() < 1e-12 * SPEED


def test_no_blow_to_the_modes(
    models: tuple[jo.Model, jo.Model], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The nearest velocities in the mass metric ring; least elastic ones do not."""
    quiet = jo.simulate(models[0], 0.02, solver=jo.ROS2(2e-5))
    # the function of this name hides the module
    module = sys.modules["jousto.model.compile"]
    monkeypatch.setattr(module, "quiet_velocities", lambda *_: None)
    struck = jo.simulate(jo.compile(four_bar(True)), 0.02, solver=jo.ROS2(2e-5))
    assert struck.energy.kinetic[0] < quiet.energy.kinetic[0]  # a blow leaves the least
    peaks = [
        max(float(jo.stress_field(run, b).envelope().max.max()) for b in LENGTHS)
        for run in (quiet, struck)
    ]
    assert peaks[1] > 2.0 * peaks[0]


def test_only_what_rigid_bodies_cannot_do_is_elastic() -> None:
    """A beam whose ends are driven apart: the rate of stretching is asked of its modes alone."""
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.02), 6, STEEL)
    beam = jo.FlexibleBody("beam", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4)))
    rate = 1e-3  # m/s
    slide = jo.Prismatic("slide", jo.ground.at((1.0, 0, 0)), beam["end"], axis=(1, 0, 0))
    model = jo.compile(
        jo.Mechanism(
            beam,
            jo.Fixed("wall", jo.ground["origin"], beam["start"]),
            slide,
            jo.Drive(
                "pull", slide.displacement, jo.Ramp(-1.0, 9.0, before=-rate, after=9.0 * rate)
            ),
        )
    )
    engine = jo.model.Engine(model)
    assert engine.residuals()[1] < 1e-12
    p = model.v0[6:]
    # the least rates that stretch: u(1) = rate and u(0) = 0, and nothing else moves
    phi = beam.reduced.modes
    u = phi @ p + model.v0[:3]
    assert u[-1, 0] - u[0, 0] == pytest.approx(rate, rel=1e-9)


@pytest.mark.filterwarnings("ignore:.*has no joint to another body")
def test_free_bodies_and_given_rates_stay() -> None:
    """Velocities that fit are not touched, elastic ones included."""
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.02), 4, STEEL)
    reduced = jo.reduce(part, jo.FreeFree(modes=4))
    rates = (0.1, -0.2, 0.3, 0.4)
    body = jo.FlexibleBody("beam", reduced, modal_velocities=rates, velocity=(1.0, 2.0, 3.0))
    model = jo.compile(jo.Mechanism(body))
    assert np.array_equal(model.v0, [1, 2, 3, 0, 0, 0, *rates])
    assert start_module.quiet_velocities(model, jo.model.Engine(model), model.v0) is None


def test_a_mechanism_that_is_too_large_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    module = sys.modules["jousto.model.initial_conditions"]
    monkeypatch.setattr(module, "MOST", 5)
    with pytest.warns(
        jo.JoustoWarning, match="rows exceed the limit 5.*jo.simulation.vibration_free_state.model"
    ):
        jo.compile(four_bar(True))


def test_a_driven_start_tells_what_removes_the_ringing(caplog: pytest.LogCaptureFixture) -> None:
    model = jo.compile(four_bar(True, speed=3.0))
    with caplog.at_level("INFO", logger="jousto"):
        jo.simulate(model, 0.01)
        assert (
            "state=jo.simulation.vibration_free_state(model)" in caplog.text
            and "jo.simulation.steady_rotation" in caplog.text
        )
        caplog.clear()
        jo.simulate(model, 0.01, state=jo.simulation.vibration_free_state(model))
        jo.simulate(jo.compile(four_bar(False, speed=3.0)), 0.01)
        assert "vibration_free_state" not in caplog.text
