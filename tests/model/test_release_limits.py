"""What lets go at a force, moment, stress, damage or time, and what locks then: closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipk, ellipkinc

import jousto as jo
from jousto.mechanism import DamageSensor, Event, Lock, StateSensor, time

G = 9.81
METHODS = {
    "RK4": (jo.RK4(1e-3), 2e-11),
    "ROS2": (jo.ROS2(1e-4), 2e-8),
    "alpha": (jo.GeneralizedAlpha(1e-4, rho=0.5), 3e-8),
    "DormandPrince": (jo.simulation.DormandPrince(tolerance=1e-11), 1e-10),
}
pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely")


def rod_from_the_horizontal(bearable: float) -> jo.Model:
    """Return a point mass of 2 kg on a rod of 1 m, which breaks at a tension, N."""
    bob = jo.RigidBody("bob", 2.0, (0.1,) * 3, position=(1, 0, 0))
    rod = jo.Rod("rod", jo.ground["origin"], bob["origin"])
    pull = jo.ReactionSensor("pull", rod)
    size = ("Fx", "Fy", "Fz")
    breaks = Event("breaks", pull, bearable, "rising", component=size, releases=rod)
    place = jo.PositionSensor("place", bob["origin"])
    weight = jo.Gravity((0, 0, -G))
    return jo.compile(jo.Mechanism(bob, rod, pull, breaks, place, weight))


@pytest.mark.parametrize("name", METHODS)
def test_a_rod_breaks_at_twice_the_weight(name: str) -> None:
    """Tension 3 m g cos(angle): 48.19 degrees from the vertical, by an elliptic integral."""
    solver, small = METHODS[name]
    run = jo.simulate(rod_from_the_horizontal(2 * 2.0 * G), 0.6, solver=solver, output_step=0.01)
    (event,) = run.events
    a = np.arccos(2 / 3)
    assert np.degrees(a) == pytest.approx(48.18968510, abs=1e-8)
    turn = np.arcsin(np.sin(a / 2) / np.sqrt(0.5))
    t = (ellipk(0.5) - ellipkinc(turn, 0.5)) / np.sqrt(G)
    assert t == pytest.approx(0.3892114849, abs=1e-10)
    assert event.time == pytest.approx(t, abs=small)
    # then it flies on, its speed unchanged
    v = np.sqrt(2 * G * np.cos(a)) * np.array([-np.cos(a), 0, -np.sin(a)])
    start, left = np.array([np.sin(a), 0, -np.cos(a)]), 0.6 - t
    fly = start + v * left - np.array([0, 0, G / 2]) * left**2
    np.testing.assert_allclose(run["place"][-1], fly, atol=max(100 * small, 1e-9))
    assert np.all(run["pull"][run.time > t + 1e-6] == 0)


@pytest.mark.parametrize("h", [4e-4, 1e-4])
@pytest.mark.parametrize("rho", [1.0, 0.8, 0.5])
def test_the_instant_has_second_order_with_any_damping(h: float, rho: float) -> None:
    """A shortened step of generalised alpha has multipliers of its end, not of another instant."""
    run = jo.simulate(rod_from_the_horizontal(4 * G), 0.5, solver=jo.GeneralizedAlpha(h, rho=rho))
    assert run.events[0].time == pytest.approx(0.3892114849, abs=2.0 * h**2)


@pytest.mark.parametrize("name", METHODS)
def test_a_clamp_opens_at_the_size_of_its_moment(name: str) -> None:
    """Two ramps bend a rigid arm about both axes: M = L t sqrt(30^2 + 40^2)."""
    arm = jo.RigidBody("arm", 1.0, (1, 1, 1), position=(0.5, 0, 0))
    clamp = jo.Fixed("clamp", jo.ground["origin"], arm.at((-0.5, 0, 0)))
    tip = arm.at((0.5, 0, 0))
    ramps = [jo.Ramp(0, 1, before=0, after=rate) for rate in (30.0, 40.0)]
    forces = [
        jo.Force("across", tip, (0, 1, 0), signal=ramps[0]),
        jo.Force("down", tip, (0, 0, -1), signal=ramps[1]),
    ]
    held = jo.ReactionSensor("held", clamp)
    opens = Event("opens", held, 20.0, component=("Mx", "My", "Mz"), releases=clamp)
    model = jo.compile(jo.Mechanism(arm, clamp, *forces, held, opens))
    run = jo.simulate(model, 0.5, solver=METHODS[name][0])
    assert run.events[0].time == pytest.approx(0.4, abs=1e-10)


def pulled_bar() -> tuple[jo.FlexibleBody, list[object]]:
    """Return a bar of 6 cm2 on a clamp, whose pull rises by 120 kN in a second, and its items."""
    steel = jo.Material(E=210e9, nu=0.3, rho=7850.0)
    part = jo.Part.beam(0.5, jo.Rectangle(0.02, 0.03), 4, steel)
    bar = jo.FlexibleBody("bar", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4)))
    clamp = jo.Fixed("clamp", jo.ground["origin"], bar["start"])
    pull = jo.Force("pull", bar["end"], (1, 0, 0), signal=jo.Ramp(0, 1, before=0, after=120e3))
    return bar, [bar, clamp, pull]


@pytest.mark.parametrize("solver", [jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3, rho=0.5)], ids=str)
def test_a_part_tears_off_at_a_stress(solver: object) -> None:
    """120 kN/s on 6 cm2: 100 MPa at 0.5 s; the bar then flies away with its momentum."""
    bar, items = pulled_bar()
    stress = jo.VonMisesSensor("stress", bar, sites="e2.a.centre")
    tears = Event("tears", stress, 100e6, "rising", releases=items[1])
    model = jo.compile(jo.Mechanism(*items, stress, tears))
    run = jo.simulate(model, 0.6, solver=solver)
    # waves in the bar, period 0.4 ms: the stress lags by at most that
    assert run.events[0].time == pytest.approx(0.5, abs=4e-4)


def test_a_bolt_breaks_when_its_damage_is_full() -> None:
    """Cycles of 100 MPa at 10 Hz: 8e-6 each; of the four-point rule the third closes at 0.375 s."""
    block = jo.RigidBody("block", 1.0, (1, 1, 1))
    bolt = jo.Fixed("bolt", jo.ground["origin"], block["origin"])
    shake = jo.Harmonic(frequency=10.0, amplitude=100.0)
    wave = jo.Force("wave", block["origin"], (1, 0, 0), signal=shake)
    load = jo.ReactionSensor("load", bolt)
    curve = jo.SN(S_D=50e6, N_D=1e6, k=3, rule="original")
    given = {"residue": "ignore", "components": "Fx", "factor": 1e6}  # 1 MPa for each N
    life = DamageSensor("life", load, curve, **given)
    breaks = Event("breaks", life, 2.5 * 8e-6, "rising", component="damage", releases=bolt)
    speed = jo.VelocitySensor("speed", block["origin"])
    model = jo.compile(jo.Mechanism(block, bolt, wave, load, life, breaks, speed))
    run = jo.simulate(model, 0.5, solver=jo.RK4(1e-3), output_step=0.01)
    (event,) = run.events
    assert event.time == pytest.approx(0.375, abs=1.001e-3)  # counted at ends of steps
    w = 2 * np.pi * 10
    free = 100 / w * (np.cos(w * event.time) - np.cos(w * run.time))
    np.testing.assert_allclose(
        run["speed"][:, 0], np.where(run.time > event.time, free, 0), atol=1e-8
    )


@pytest.mark.parametrize("core", ["maximal", "joint"])
@pytest.mark.parametrize("name", METHODS)
def test_a_clock_locks_and_lets_go(name: str, core: str) -> None:
    """A wheel at 2 rad/s is held from 0.25 to 0.75 s, while its motor waits with 3 N m."""
    solver, _ = METHODS[name]
    wheel = jo.RigidBody("wheel", 1.0, (0.5, 0.5, 0.5))
    hinge = jo.Revolute("hinge", jo.ground["origin"], wheel["origin"])
    clock = StateSensor("clock", time, unit="s")
    on, off = Event("on", clock, 0.25, "rising"), Event("off", clock, 0.75, "rising")
    motor = jo.JointForce("motor", hinge.angle, 3.0)
    items = (wheel, hinge, clock, on, off, motor, Lock("brake", hinge.angle, on, off))
    sensors = (jo.CoordinateSensor("angle", hinge.angle), jo.RateSensor("rate", hinge.angle))
    start = jo.Initial(hinge.angle, rate=2.0)
    model = jo.compile(jo.Mechanism(*items, *sensors, start), core=core)
    run = jo.simulate(model, 1.0, solver=solver, output_step=0.01)
    assert [event.name for event in run.events] == ["on", "brake", "off", "brake"]
    assert run.events[1].impulse == pytest.approx(0.5 * (2 + 6 * 0.25), rel=1e-9)
    assert run["angle"][50, 0] == pytest.approx(2 * 0.25 + 3 * 0.25**2, rel=1e-9)
    assert run["rate"][-1, 0] == pytest.approx(6 * 0.25, rel=1e-9)


def test_the_model_file_watches_sizes() -> None:
    text = """
bodies:
  - {type: rigid, name: bob, mass: 2 kg, inertia: [0.1, 0.1, 0.1], position: [1 m, 0, 0]}
joints:
  - {type: rod, name: rod, a: ground.origin, b: bob.origin}
gravity: [0, 0, -9.81]
sensors:
  - {type: reaction, name: pull, joint: rod}
events:
  - {name: breaks, watch: pull, component: [Fx, Fy, Fz], threshold: 39.24 N, releases: [rod]}
"""
    from jousto.schema.read import parse_model

    file = parse_model(text)
    (event,) = file.mechanism.events
    assert event.component == (0, 1, 2)
    run = jo.simulate(jo.compile(file.mechanism), 0.6, solver=jo.RK4(1e-3))
    assert run.events[0].time == pytest.approx(0.3892114849, abs=1e-10)
    with pytest.raises(jo.InputError, match="has values in N and in N m"):
        parse_model(text.replace("[Fx, Fy, Fz]", "[Fx, Mz]"))
    with pytest.raises(jo.InputError, match="no component 'Fw'"):
        parse_model(text.replace("[Fx, Fy, Fz]", "[Fx, Fw]"))
    with pytest.raises(jo.InputError, match="threshold"):
        parse_model(text.replace("39.24 N,", "39.24 m,"))
    with pytest.raises(jo.InputError, match="a size is not negative"):
        parse_model(text.replace("39.24 N,", "-39.24 N,"))
