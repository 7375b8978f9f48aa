"""Initial values and rates of coordinates: closed loops follow as closed forms say."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
import pytest

import jousto as jo

Z = (0, 0, 1)
CRANK, COUPLER, ROCKER, GROUND = 0.1, 0.28, 0.27, 0.25  # m
RATE = 5.24  # rad/s
START = np.radians(60.0)


def bar(name: str, first: np.ndarray, last: np.ndarray, flexible: bool) -> jo.FlexibleBody:
    along = last - first
    length = float(np.hypot(*along))
    angle = float(np.degrees(np.arctan2(along[1], along[0])))
    pose = {"position": (*first, 0.0), "orientation": jo.Rotate(Z, degrees=angle)}
    if flexible:
        part = jo.Part.beam(length, jo.Rectangle(0.02, 0.004), 4, jo.Material(210e9, 0.3, 7850.0))
        reduced = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2))
        return jo.FlexibleBody(name, reduced, **pose)
    mass = 7850.0 * 0.02 * 0.004 * length
    return jo.RigidBody(
        name,
        mass,
        (1e-6, mass * length**2 / 12, mass * length**2 / 12),
        center=(length / 2, 0, 0),
        markers={"start": (0, 0, 0), "end": (length, 0, 0)},
        **pose,
    )


def closed(phi: float) -> tuple[float, float]:
    """Angles of coupler and rocker of the open four-bar (Freudenstein's loop, elbow up)."""
    tip = CRANK * np.array([np.cos(phi), np.sin(phi)])
    across = np.array([GROUND, 0.0]) - tip
    d = float(np.hypot(*across))
    inner = np.arccos((COUPLER**2 + d**2 - ROCKER**2) / (2 * COUPLER * d))
    coupler = float(np.arctan2(across[1], across[0]) + inner)
    knee = tip + COUPLER * np.array([np.cos(coupler), np.sin(coupler)])
    rocker = float(np.arctan2(knee[1], knee[0] - GROUND))
    return coupler, rocker


def rates(phi: float, w: float) -> tuple[float, float]:
    """Rates of coupler and rocker (Norton, Design of Machinery, eq. 6.18)."""
    t3, t4 = closed(phi)
    w3 = w * CRANK / COUPLER * np.sin(t4 - phi) / np.sin(t3 - t4)
    w4 = w * CRANK / ROCKER * np.sin(phi - t3) / np.sin(t4 - t3)
    return float(w3), float(w4)


def four_bar(*more: object, flexible: bool = False) -> tuple[list, dict[str, jo.Revolute]]:
    tip = CRANK * np.array([np.cos(START), np.sin(START)])
    t3, _ = closed(START)
    knee = tip + COUPLER * np.array([np.cos(t3), np.sin(t3)])
    crank = bar("crank", np.zeros(2), tip, flexible)
    coupler = bar("coupler", tip, knee, flexible)
    rocker = bar("rocker", np.array([GROUND, 0.0]), knee, flexible)
    main = jo.Revolute("main", jo.ground["origin"], crank["start"], Z)
    pin = jo.Revolute("pin", crank["end"], coupler["start"], Z)
    foot = jo.Revolute("foot", jo.ground.at((GROUND, 0, 0)), rocker["start"], Z)
    knee_joint = jo.PointOnLine("knee", coupler["end"], rocker["end"], Z)
    items = [crank, coupler, rocker, main, pin, foot, knee_joint, jo.Gravity((0, -9.81, 0))]
    return items, {"main": main, "pin": pin, "foot": foot}


def turning(model: jo.Model) -> list[float]:
    """Angular velocity about z of every body, rad/s."""
    return [float(model.v0[b.iv + 5]) for b in model.bodies]


def turned(model: jo.Model) -> list[float]:
    """Angle about z of every body, rad."""
    return [float(2 * np.arctan2(model.q0[b.iq + 6], model.q0[b.iq + 3])) for b in model.bodies]


def same_angles(found: Sequence[float], wanted: Sequence[float], tolerance: float) -> None:
    miss = np.subtract(found, wanted)
    assert np.abs(np.arctan2(np.sin(miss), np.cos(miss))).max() < tolerance


@pytest.mark.parametrize("flexible", [False, True])
@pytest.mark.parametrize("joint", ["main", "foot"])
def test_a_four_bar_follows_the_rate_of_one_joint(joint: str, flexible: bool) -> None:
    items, joints = four_bar(flexible=flexible)
    w3, w4 = rates(START, RATE)
    given = {"main": RATE, "foot": w4}[joint]
    model = jo.compile(jo.Mechanism(*items, jo.Initial(joints[joint].angle, rate=given)))
    # round-off of a few solves, far below the rates of some rad/s
    assert turning(model) == pytest.approx([RATE, w3, w4], rel=1e-9)
    for b in model.bodies:
        assert np.abs(model.v0[b.iv + 6 : b.iv + 6 + b.n]).max(initial=0.0) < 1e-9
    assert jo.model.Engine(model).residuals()[1] < 1e-10


@pytest.mark.parametrize("flexible", [False, True])
@pytest.mark.parametrize("degrees", [30.0, -170.0])
def test_a_four_bar_follows_the_value_of_one_joint(degrees: float, flexible: bool) -> None:
    items, joints = four_bar(flexible=flexible)
    phi = START + np.radians(degrees)
    start = jo.Initial(joints["main"].angle, value=np.radians(degrees), rate=-RATE)
    model = jo.compile(jo.Mechanism(*items, start))
    same_angles(turned(model), [phi, *closed(phi)], 1e-10)
    assert turning(model) == pytest.approx([-RATE, *rates(phi, -RATE)], rel=1e-9)
    for b in model.bodies:  # loops turn as rigid bodies, nothing is bent
        assert np.abs(model.q0[b.iq + 7 : b.iq + 7 + b.n]).max(initial=0.0) < 1e-9
    assert jo.model.Engine(model).residuals()[0] < 1e-12


def test_a_slider_crank_follows_the_speed_of_its_slider() -> None:
    r, length, phi, speed = 0.1, 0.3, np.radians(50.0), 0.8
    tip = r * np.array([np.cos(phi), np.sin(phi)])
    x = tip[0] + np.sqrt(length**2 - tip[1] ** 2)
    crank = bar("crank", np.zeros(2), tip, False)
    rod = bar("rod", tip, np.array([x, 0.0]), False)
    slider = jo.RigidBody("slider", 0.5, (1e-4, 1e-4, 1e-4), position=(x, 0, 0))
    main = jo.Revolute("main", jo.ground["origin"], crank["start"], Z)
    guide = jo.Prismatic("guide", jo.ground["origin"], slider["origin"], (1, 0, 0))
    mechanism = jo.Mechanism(
        *(crank, rod, slider, main, guide),
        jo.Spherical("pin", crank["end"], rod["start"]),
        jo.Universal("wrist", rod["end"], slider["origin"], Z, (0, 1, 0)),
        jo.Initial(guide.displacement, rate=speed),
        jo.Gravity((0, -9.81, 0)),
    )
    model = jo.compile(mechanism)
    # x = r cos(phi) + sqrt(l^2 - r^2 sin^2(phi))
    slope = -r * np.sin(phi) * (1 + r * np.cos(phi) / np.sqrt(length**2 - tip[1] ** 2))
    assert turning(model)[0] == pytest.approx(speed / slope, rel=1e-9)
    v = model.v0[model.bodies[2].iv :][:3]
    assert v == pytest.approx([speed, 0.0, 0.0], abs=1e-10)


def test_what_rates_leave_free_moves_with_the_least_energy() -> None:
    """A double pendulum struck at its first hinge: momentum balance of the second link alone.

    The free joint passes no torque: the second link's angular momentum about it is zero,
    ``J w2 + m c L w1 = 0`` with J about the joint, c to the centre and the links in line.
    """
    upper = jo.RigidBody("upper", 1.0, (0.01, 0.1, 0.1), markers={"end": (1, 0, 0)})
    lower = jo.RigidBody("lower", 2.0, (0.01, 0.2, 0.2), center=(0.4, 0, 0), position=(1, 0, 0))
    first = jo.Revolute("first", jo.ground["origin"], upper["origin"], Z)
    second = jo.Revolute("second", upper["end"], lower["origin"], Z)
    parts = (upper, lower, first, second)
    model = jo.compile(jo.Mechanism(*parts, jo.Initial(first.angle, rate=3.0)))
    J = 0.2 + 2.0 * 0.4**2
    assert turning(model) == pytest.approx([3.0, -2.0 * 0.4 * 1.0 * 3.0 / J], rel=1e-10)
    both = (jo.Initial(first.angle, rate=3.0), jo.Initial(second.angle, rate=0.0, value=0.5))
    model = jo.compile(jo.Mechanism(*parts, *both))
    assert turning(model) == pytest.approx([3.0, 3.0], rel=1e-10)
    same_angles(np.diff(turned(model)), [0.5], 1e-12)


def sentence(*items: object) -> str:
    with pytest.raises(jo.InputError) as error, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        jo.compile(jo.Mechanism(*items))
    return str(error.value)


def test_contradictions_are_named() -> None:
    items, j = four_bar()
    crank = jo.Initial(j["main"].angle, rate=RATE)
    text = sentence(*items, crank, jo.Initial(j["foot"].angle, rate=-RATE))
    assert "initial 'main.angle': the rate 5.24 rad/s contradicts the rate of 'foot.angle'" in text
    assert "give only as many rates as there are free" in text
    # more than is free, but it fits
    _, w4 = rates(START, RATE)
    jo.compile(jo.Mechanism(*items, crank, jo.Initial(j["foot"].angle, rate=w4)))
    text = sentence(*items, crank, jo.Drive("motor", j["foot"].angle, jo.ConstantSpeed(1.0)))
    assert "contradicts drive 'motor'" in text
    text = sentence(*items, crank, jo.Drive("motor", j["main"].angle, jo.ConstantSpeed(1.0)))
    assert "drive 'motor' gives value and rate of main.angle" in text
    assert "given twice" in sentence(*items, crank, jo.Initial(j["main"].angle, value=0.1))


def test_values_out_of_reach_say_how_far_it_goes() -> None:
    items, j = four_bar()
    text = sentence(*items, jo.Initial(j["foot"].angle, value=2.0))
    assert "initial 'foot.angle': the value 114.592 deg cannot be reached" in text
    with pytest.raises(jo.InputError, match="within half a turn.*give -90 deg"):
        jo.Initial(j["main"].angle, value=1.5 * np.pi)
    with pytest.raises(jo.InputError, match="neither a value nor a rate"):
        jo.Initial(j["main"].angle)


def test_constant_speed_from_the_start_needs_no_ramp() -> None:
    items, j = four_bar()
    drive = jo.Drive("motor", j["main"].angle, jo.ConstantSpeed(RATE))
    model = jo.compile(jo.Mechanism(*items, drive, jo.CoordinateSensor("foot", j["foot"].angle)))
    assert turning(model) == pytest.approx([RATE, *rates(START, RATE)], rel=1e-9)
    run = jo.simulate(model, 0.5, solver=jo.RK4(1e-3))
    phi = START + RATE * run.time
    wanted = np.array([closed(p)[1] for p in phi]) - closed(START)[1]
    # RK4 with projection at 1 ms
    assert np.abs(run["foot"][:, 0] - wanted).max() < 1e-7
    assert np.abs(run.v[:, model.bodies[0].iv + 5] - RATE).max() < 1e-9
