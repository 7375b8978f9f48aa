"""Gradients through parts: sections, materials and lengths, modes of equal and close frequency."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.design.studies.outcomes.outcomes import Damage

P = jo.Parameter
CANTILEVER = {"E": 2.1e11, "rho": 7850.0, "width": 0.04, "height": 0.03, "length": 1.2}
REDUCTIONS = {
    "Craig-Bampton": jo.CraigBampton(("start", "end"), modes=4),
    "inertia relief": jo.CraigBampton(("start",), modes=4, inertia_relief=True),
    "free-free": jo.FreeFree(modes=8),
}
LOAD = 1e-3  # deflections are small enough for linear theory to hold to 1e-14


def cantilever(method, load, E, rho, width, height, length):
    steel = jo.Material(E, 0.3, rho)
    theory = jo.parts.EulerBernoulli()
    part = jo.Part.beam(length, jo.Rectangle(width, height), 4, steel, theory=theory)
    beam = jo.FlexibleBody("beam", jo.reduce(part, method))
    fixed = jo.Fixed("clamp", jo.ground["origin"], beam["start"])
    push = jo.Force("push", beam["end"], (0, 0, -load))
    return jo.Mechanism(beam, fixed, push, jo.PositionSensor("tip", beam["end"]))


def study_of(method, outcomes, load=LOAD, **changes):
    def made(E, rho, width, height, length):
        return cantilever(method, load, E, rho, width, height, length)

    values = CANTILEVER | changes
    parameters = [P(name, value) for name, value in values.items()]
    return jo.study(made, parameters, outcomes, t_end=1e-3, state=jo.equilibrium), values


def test_static_deflection_of_a_cantilever():
    # F L^3 / (3 E I) with I = b h^3 / 12
    study, at = study_of(REDUCTIONS["Craig-Bampton"], "first(tip.z)")
    found = jo.design.gradient(study)
    I = at["width"] * at["height"] ** 3 / 12
    down = -LOAD * at["length"] ** 3 / (3 * at["E"] * I)
    powers = {"E": -1, "rho": 0, "width": -1, "height": -3, "length": 3}
    wanted = [power * down / at[name] for name, power in powers.items()]
    assert found.exact, str(found)
    np.testing.assert_allclose(found.values, [down], rtol=1e-9)
    np.testing.assert_allclose(found.jacobian[0], wanted, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("method", REDUCTIONS)
def test_frequencies_of_a_cantilever(method):
    # of the discrete beam, too: sqrt(E / rho) over a length, by all lengths together
    study, at = study_of(REDUCTIONS[method], ["frequency(1)", "frequency(2)"], load=0.0)
    found = jo.design.gradient(study)
    assert found.exact, str(found)
    x = np.array(list(at.values()))
    shares = found.jacobian * x / found.values[:, None]
    np.testing.assert_allclose(shares[:, 0], 0.5, rtol=1e-8)
    np.testing.assert_allclose(shares[:, 1], -0.5, rtol=1e-8)
    np.testing.assert_allclose(shares[:, 2:].sum(axis=1), -1.0, rtol=1e-8)


@pytest.mark.parametrize("apart", [0.0, 1e-5], ids=["square", "nearly square"])
@pytest.mark.parametrize("method", ["Craig-Bampton", "free-free"])
def test_equal_and_close_pairs(method, apart):
    # bending along the height is mode 1 of flat beams and mode 2 of high ones, so that differences
    # follow each of the two across the square
    side, step = 0.03, 1e-4
    outcomes = ["frequency(1)", "frequency(2)"]
    given = {"width": side * (1 + apart), "height": side}
    study, at = study_of(REDUCTIONS[method], outcomes, load=0.0, **given)
    # at the crossing the check would compare with differences across it
    found = jo.design.gradient(study, check=False)
    assert found.exact, str(found)
    x, column = np.array(list(at.values())), list(at).index("height")
    up = np.eye(len(x))[column] * side * step
    low, high = study([x - up, x + up])
    along = (high[1] - low[0]) / (2 * side * step)
    across = (high[0] - low[1]) / (2 * side * step)
    assert along > 0.9 * found.values[0] / side > 10 * abs(across)
    wanted = [along, across] if apart else [across, along]
    got = [found[name, "height"] for name in outcomes]
    np.testing.assert_allclose(got, wanted, rtol=0, atol=1e-6 * along)


def four_bar(crank, coupler, rocker, width, height, rho, E, stiffness, angle):
    """A driven four-bar whose coupler bends."""
    base = 0.5
    d2 = (base - crank) ** 2
    beta = np.arccos((d2 + rocker**2 - coupler**2) / (2 * np.sqrt(d2) * rocker))
    A = np.array([crank, 0, 0])
    B = np.array([base - rocker * np.cos(beta), rocker * np.sin(beta), 0])
    n = (B - A) / coupler
    tilt = [[n[0], -n[1], 0], [n[1], n[0], 0], [0, 0, 1]]
    steel = jo.Material(E, 0.3, rho)
    part = jo.Part.beam(coupler, jo.Rectangle(width, height), 4, steel, orientation=(0, 1, 0))
    reduced = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4))
    one = jo.RigidBody("crank", 0.4, (1e-4, 2e-3, 2e-3), center=(crank / 2, 0, 0))
    two = jo.FlexibleBody("coupler", reduced, position=A, orientation=tilt, damping=0.02)
    three = jo.RigidBody("rocker", 1.5, (1e-2, 1e-2, 1e-2), position=(base, 0, 0))
    pin = jo.Revolute("pin", jo.ground["origin"], one["origin"])
    joints = [
        jo.Revolute("A", one.at((crank, 0, 0)), two["start"]),
        jo.Spherical("B", three.at(B - [base, 0, 0]), two["end"]),
        jo.Revolute("D", jo.ground.at((base, 0, 0)), three["origin"]),
    ]
    turn = jo.Drive("turn", pin.angle, jo.SCurve((0.0, 0.5, 1.0), (0.0, angle, 0.0)))
    anchor = jo.ground.at((0.2, 0.6, 0))
    spring = jo.Spring.between("spring", anchor, three.at((0, 0.2, 0)), stiffness, damping=2.0)
    place = jo.PositionSensor("end", two["end"])
    return jo.Mechanism(
        one, two, three, pin, *joints, turn, spring, jo.Gravity((0, -9.81, 0)), place
    )


FOUR_BAR = {
    "crank": 0.12,
    "coupler": 0.5,
    "rocker": 0.35,
    "width": 0.03,
    "height": 0.004,
    "rho": 7850.0,
    "E": 2.1e11,
    "stiffness": 400.0,
    "angle": 2.0,
}


@pytest.mark.slow
def test_run_of_a_flexible_four_bar():
    curve = jo.SN.basquin(1758e6, -0.2)
    study = jo.study(
        four_bar,
        [P(name, value) for name, value in FOUR_BAR.items()],
        [
            "stress(coupler)",
            Damage("damage", "coupler", sn=curve, options={"residue": "half"}),
            "max(end.y)",
            "mass",
        ],
        t_end=1.0,
        solver=jo.ROS2(1e-3),
    )
    found = jo.design.gradient(study)
    assert found.exact, str(found)
    # 3 for values and direction, and 4 for each of 8 parameters that the direction hides
    assert found.runs == {"real": 3 + 4 * 8, "complex": 9, "models": 2 + 9 + 4 * 8}
    assert found.how[:2] == 2 * (9 * ("complex motion",),)
    assert found.how[2:] == 2 * (9 * ("complex step",),)
    # Turning points go from one stored instant to the next where the length changes by 2e-5 of
    # itself: differences agree with smaller steps alone. These leave the round-off of the outcomes,
    # some 1e-11 of them after 1000 steps
    x = study.nominal
    shares = np.array([1e-4, 3e-5, 1e-5, 6e-6, 3e-6])
    for j in range(len(x)):
        errors = []
        for share in shares:
            h = np.zeros(len(x))
            h[j] = share * x[j]
            high, low = study([x + h, x - h])
            slope = (high - low) / (2 * h[j])
            noise = 1e-11 * np.abs(found.values) / h[j]
            errors.append(np.abs(found.jacobian[:, j] - slope) / (1e-6 * np.abs(slope) + noise))
        assert np.all(np.min(errors, axis=0) <= 1.0), (study.parameters[j].name, errors)


@pytest.mark.parametrize("life", [False, True])
@pytest.mark.parametrize("criterion", ["signed-von-mises", "critical-plane"])
def test_damage_of_a_load(criterion, life):
    # stress is proportional to a small load, damage to its power k
    steel = jo.Material(2.1e11, 0.3, 7850.0)
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 2, steel)
    beam = jo.FlexibleBody("beam", jo.reduce(part, REDUCTIONS["Craig-Bampton"]), damping=0.01)
    shake = jo.Force("shake", beam["end"], (0, 0, 1), signal=jo.Input("load"))
    fixed = jo.Fixed("clamp", jo.ground["origin"], beam["start"])
    # released at once, it rings: many cycles of different size, so fast that instants matter
    options = {"residue": "half", "criterion": criterion, "planes": 8}
    curve = jo.SN(1e6, 1e6, 5.0, rule="elementary")
    damage = Damage("D", "beam", sn=curve, life=life, options=options)
    machine = jo.Mechanism(beam, fixed, shake)
    solver = jo.ROS2(1e-3)
    study = jo.study(machine, P("load", LOAD / 100, unit="N"), [damage], t_end=0.3, solver=solver)
    found = jo.design.gradient(study)
    assert found.how == (("complex motion",),)
    power = -5.0 if life else 5.0
    # of fourth order with steps of 1e-5: round-off of 1e-11
    np.testing.assert_allclose(found.jacobian * LOAD / 100 / found.values, power, rtol=1e-10)
