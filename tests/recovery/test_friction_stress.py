"""Stress due to friction against the belt and the pin of which the motion is known.

Belt: m = 1 kg on a spring of 100 N/m, here an elastic rod of little mass, mu 0.4 and 0.2, belt
0.1 m/s: sticks 0.39240000 s, slips 0.40843222 s, x from -0.002401 to 0.041641 m (closed form). Pin:
a mass on a light rod of 1 m, pin radius 50 mm, mu 0.3, from rest at 90 degrees: it turns back after
1.172721 s at -85.069927 degrees (integrated with high accuracy).
"""

from __future__ import annotations

import csv

import numpy as np
import pytest

import jousto as jo

# springs and rods without mass are of no real material
pytestmark = [
    pytest.mark.filterwarnings("ignore:.*softer than most plastics"),
    pytest.mark.filterwarnings("ignore:.*lighter than air"),
]
M, K, V, STATIC, KINETIC, G = 1.0, 100.0, 0.1, 0.4, 0.2, 9.81
SIDE, LENGTH = 0.001, 0.5  # m, of the rod
AREA = SIDE**2
D, W = (STATIC - KINETIC) * M * G / K, np.sqrt(K / M)
STICK, SLIP = 2 * D / V, 2 / W * (np.pi - np.arctan(D * W / V))
MIDDLE = KINETIC * M * G / K


def exact(t):
    """Position of the block, from rest on the belt at x = 0, m."""
    late = np.mod(t, STICK + SLIP)
    slipped = late - STICK
    slipping = MIDDLE + D * np.cos(W * slipped) + V / W * np.sin(W * slipped)
    return np.where(late < STICK, MIDDLE - D + V * late, slipping)


def belt(law=None):
    """The block on the belt, held by a rod of the stiffness K; its mass of 1 g moves along."""
    rho = 1e-3 / (AREA * LENGTH)
    part = jo.Part.beam(
        length=LENGTH,
        section=jo.Rectangle(SIDE, SIDE),
        elements=2,
        material=jo.Material(E=K * LENGTH / AREA, nu=0.3, rho=rho),
    )
    rod = jo.FlexibleBody(
        "rod", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=0)), velocity=(0, 0, 0)
    )
    mass = M - 1e-3 / 3  # a rod that stretches evenly adds a third of its mass
    runs = jo.RigidBody(
        "belt", 5.0, (1, 1, 1), velocity=(V, 0, 0), markers={"seat": (LENGTH, 0, 0)}
    )
    block = jo.RigidBody("block", mass, (1, 1, 1), position=(LENGTH, 0, 0), velocity=(V, 0, 0))
    frame = jo.Prismatic("frame", jo.ground["origin"], runs["origin"], (1, 0, 0))
    contact = jo.Prismatic("contact", runs["seat"], block["origin"], (1, 0, 0))
    motor = jo.Drive("motor", frame.displacement, jo.Ramp(-10.0, 10.0, -1.0, 1.0))
    rub = jo.Friction(
        "rub", contact, KINETIC, STATIC, preload=M * G, law=law or jo.mechanism.StickSlip()
    )
    return jo.Mechanism(
        *(runs, block, rod, frame, contact, motor, rub),
        jo.Fixed("wall", jo.ground["origin"], rod["start"]),
        jo.Fixed("tip", rod["end"], block["origin"]),
        jo.ForceSensor("rub", rub),
        jo.PositionSensor("block", block["origin"]),
    )


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Both runs over three periods; the second one with other steps."""
    folder = tmp_path_factory.mktemp("belt")
    mechanism = belt()
    twin = jo.recovery.without_friction(mechanism)
    assert (twin.frictions, [s.name for s in twin.sensors]) == ((), ["block"])
    assert len(mechanism.frictions) == 1
    return tuple(
        jo.simulate(
            jo.compile(m), 2.4, solver=jo.RK4(step), output_step=out, path=folder / f"{out}.h5"
        )
        for m, step, out in ((mechanism, 1e-3, 2e-3), (twin, 1e-3, 5e-3))
    )


def test_stress_of_a_rod_dragged_by_a_belt_is_that_of_the_closed_form(runs):
    found = jo.recovery.friction_stress(*runs, "rod")
    t = found.time
    x, free = exact(t), V / W * np.sin(W * t)
    np.testing.assert_allclose(runs[0]["block"][:, 0] - LENGTH, x, atol=1e-7)
    for site in ("e1.a.top", "e2.b.left"):
        s11 = found.history(site)[:, 0]
        assert np.abs(s11 - K / AREA * (x - free)).max() < 1e-3 * K / AREA * MIDDLE
        np.testing.assert_allclose(found.history(site)[:, 1:], 0.0, atol=1.0e-3 * K / AREA * MIDDLE)
    change = found.change("von-mises", "e1.a.top")[:, 0]
    np.testing.assert_allclose(
        change, K / AREA * (np.abs(x) - np.abs(free)), atol=5e-4 * K / AREA * MIDDLE
    )
    # while it slips the mean stress is mu m g / A, and friction stress swings about it
    top = K / AREA * np.array([-0.002401, 0.041641])
    rubbed = found.with_friction.history("e1.a.top")[:, 0]
    # half of the last digit of the positions, um
    np.testing.assert_allclose([rubbed.min(), rubbed.max()], top, rtol=0, atol=0.5e-6 * K / AREA)
    assert 0.5 * top.sum() == pytest.approx(KINETIC * M * G / AREA, rel=1e-4)


def test_transitions_are_listed_with_joint_and_stress(runs):
    found = jo.recovery.friction_stress(
        *runs, "rod", start=2e-3
    )  # how it starts is decided at once
    expected = np.cumsum([STICK, SLIP, STICK, SLIP, STICK])
    times = [t.time for t in found.transitions]
    np.testing.assert_allclose(times, expected, atol=1e-6)
    np.testing.assert_allclose(times[:2], [0.39240000, 0.80083222], atol=1e-6)
    changes = [t.change for t in found.transitions]
    assert changes == ["slips backward", "sticks"] * 2 + ["slips backward"]
    assert {(t.friction, t.joint) for t in found.transitions} == {("rub", "contact")}
    # from the first slip until it sticks again: the change of what is due to friction
    t = np.linspace(STICK, STICK + SLIP, 20001)
    due = K / AREA * (exact(t) - V / W * np.sin(W * t))
    assert found.transitions[0].jump == pytest.approx(np.abs(due - due[0]).max(), rel=2e-3)
    assert found.transitions[0].at == pytest.approx(t[np.argmax(np.abs(due - due[0]))], abs=4e-3)
    short = jo.recovery.friction_stress(*runs, "rod", start=2e-3, window=0.05)
    soon = np.abs(due - due[0])[t < STICK + 0.05].max()
    assert short.transitions[0].jump == pytest.approx(soon, rel=0.05)
    assert found.peaks(1)[0].jump == max(t.jump for t in found.transitions)


def test_pin_friction_bends_the_rod_by_its_torque(tmp_path):
    """Moment at the pin is the friction torque: stress mu r N / (section modulus)."""
    side, radius, mu = 0.03, 0.05, 0.3
    part = jo.Part.beam(
        length=1.0,
        section=jo.Rectangle(side, side),
        elements=2,
        material=jo.Material(E=2e11, nu=0.3, rho=1e-4 / side**2),  # 0.1 g
    )
    rod = jo.FlexibleBody("rod", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=0)))
    bob = jo.RigidBody("bob", 1.0, (1e-8,) * 3, position=(1, 0, 0))
    pin = jo.Revolute("pin", jo.ground["origin"], rod["start"], (0, 0, 1))
    rub = jo.Friction("rub", pin, mu, radius=radius, law=jo.mechanism.StickSlip())
    mechanism = jo.Mechanism(
        *(rod, bob, pin, rub, jo.Gravity((0, -G, 0)), jo.Fixed("tip", rod["end"], bob["origin"])),
        jo.ForceSensor("rub", rub),
        jo.ReactionSensor("pin", pin),
        jo.CoordinateSensor("angle", pin.angle),
    )
    end = 1.4
    runs = [
        jo.simulate(jo.compile(m), end, solver=jo.ROS2(5e-4), output_step=5e-3, path=tmp_path / n)
        for m, n in (
            (mechanism, "with.h5"),
            (jo.recovery.without_friction(mechanism), "without.h5"),
        )
    ]
    found = jo.recovery.friction_stress(*runs, "rod")
    turn = found.transitions[0]
    assert turn.time == pytest.approx(1.172721, abs=2e-4)
    assert (turn.joint, found.transitions[-1].change) == ("pin", "slips forward")
    at = np.interp(turn.time, runs[0].time, runs[0]["angle"].ravel())
    assert np.degrees(at) + 90.0 == pytest.approx(-85.069927, abs=0.05)
    modulus = side**3 / 6
    torque = np.ravel(runs[0]["rub"])
    normal = np.linalg.norm(runs[0]["pin"][:, :2], axis=1)
    np.testing.assert_allclose(np.abs(torque), mu * radius * normal, rtol=1e-6)
    bending = found.with_friction.history("e1.a.left")[:, 0]
    bending = bending - found.with_friction.history("e1.a.right")[:, 0]
    # half the difference of the two sides is the bending alone
    wanted = torque / modulus
    sign = np.sign(bending[50] / wanted[50])
    np.testing.assert_allclose(0.5 * sign * bending, wanted, atol=2e-3 * np.abs(wanted).max())
    due = found.history("e1.a.left")[:, 0] - found.history("e1.a.right")[:, 0]
    np.testing.assert_allclose(0.5 * sign * due, wanted, atol=2e-3 * np.abs(wanted).max())


# -- what is written, and mistakes -------------------------------------------------------------


def test_tables_and_csv(runs, tmp_path):
    found = jo.recovery.friction_stress(
        *runs, "rod", sites=("e1.a.top", "e2.b.left"), start=2e-3, end=1.0
    )
    text = str(found)
    for part in ("due to friction", "e1.a.top", "2 transitions", "rub (contact) slips backward"):
        assert part in text
    row = found.table()[0]
    assert row["due"] == pytest.approx(np.abs(found.history(row["site"])[:, 0]).max(), rel=1e-3)
    found.to_csv(tmp_path / "f.csv")
    with open(tmp_path / "f.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    assert rows[0][0] == "site"
    assert len(rows) == 1 + 2 + 1 + 1 + 2
    assert rows[-1][2] == "contact"


def test_mistakes(runs, tmp_path):
    mechanism = belt()
    with pytest.raises(jo.InputError, match="has no friction to remove"):
        jo.recovery.without_friction(jo.recovery.without_friction(mechanism))
    with pytest.raises(jo.InputError, match="no instants in common"):
        jo.recovery.friction_stress(*runs, "rod", start=3.0)
    with pytest.raises(jo.InputError, match="window is 0 s"):
        jo.recovery.friction_stress(*runs, "rod", window=0.0)
    with pytest.raises(jo.InputError, match="rigid body"):
        jo.recovery.friction_stress(*runs, "block")
    with pytest.warns(jo.JoustoWarning, match="check the order of the runs"):
        jo.recovery.friction_stress(runs[1], runs[0], "rod")
    with pytest.warns(jo.JoustoWarning, match="lost no energy to friction"):
        jo.recovery.friction_stress(runs[1], runs[1], "rod")
