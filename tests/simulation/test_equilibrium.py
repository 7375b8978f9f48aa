"""Rest of a crane with a payload on a rope: what it takes to find it, and that it is one."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import jousto as jo
from jousto.simulation.statics import equilibrium as statics
from jousto.simulation.statics.residual import Balance

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
G, PAYLOAD, ROPE = 9.81, 2000.0, 2.0
LINKS = ((2.0, 90.0), (4.0, 40.0), (3.0, 0.0), (2.0, -40.0))  # m, degrees above the horizon
SECTION = jo.Box(0.16, 0.2, web=0.006, flange=0.006)


def crane(*extra: object) -> jo.Model:
    """Four modal links, held by drives; the payload hangs aside, on a rope between two bolts."""
    at, end, bodies, joints = np.zeros(3), jo.ground["origin"], [], []
    for i, (length, degrees) in enumerate(LINKS):
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        part = jo.Part.beam(length, SECTION, 10, STEEL)
        method = jo.CraigBampton(interfaces=("start", "end"), modes=6)
        R = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
        link = jo.FlexibleBody(f"link{i}", jo.reduce(part, method), position=at, orientation=R)
        hinge = jo.Revolute(f"hinge{i}", end, link["start"], axis=(0, 1, 0) if i else (0, 0, 1))
        joints += [hinge, jo.Drive(f"drive{i}", hinge.angle, 0.0)]
        bodies.append(link)
        at, end = at + length * np.array([c, 0, s]), link["end"]
    aside = ROPE * np.array([0.3, 0.4, -np.sqrt(0.75)])
    load = jo.RigidBody("load", PAYLOAD, (100.0, 100.0, 100.0), position=at + aside)
    joints.append(jo.Spherical("rope", end, load.at(-aside)))
    sensors = [jo.PositionSensor("tip", end), jo.PositionSensor("payload", load["origin"])]
    return jo.compile(
        jo.Mechanism(*bodies, load, *joints, *sensors, jo.Gravity((0, 0, -G)), *extra)
    )


def seen(model: jo.Model, state: jo.simulation.State) -> dict[str, np.ndarray]:
    run = jo.simulate(model, 1e-9, solver=jo.RK4(step=1e-9), state=state)
    return {name: run[name][0] for name in ("tip", "payload")}


def test_a_payload_hangs_below_its_hook_after_few_evaluations(monkeypatch):
    """The matrix of the engine at every iteration, not a column for every unknown (15 600 once)."""
    count = {"residual": 0, "matrix": 0}

    def counting(name: str):
        plain = getattr(Balance, name)

        def counted(*values: object):
            count[name] += 1
            return plain(*values)

        return counted

    for name in count:
        monkeypatch.setattr(Balance, name, counting(name))
    monkeypatch.setattr(statics, "at_rest", None)
    model = crane()
    rest = jo.equilibrium(model)
    at = seen(model, rest)
    assert at["payload"] - at["tip"] == pytest.approx([0, 0, -ROPE], abs=1e-8)
    assert at["tip"][2] < sum(l * np.sin(np.radians(a)) for l, a in LINKS) - 5e-3  # it bends
    assert count["residual"] + count["matrix"] < 200


def test_both_ways_find_the_same_rest():
    """A block on springs, pulled aside: by steps through a viscous medium and by modes."""
    block = jo.RigidBody("block", 10.0, (0.1, 0.2, 0.3))
    model = jo.compile(
        jo.Mechanism(
            block,
            jo.Bushing(
                "mount",
                jo.ground["origin"],
                block.at((0.1, 0.2, 0.1)),
                stiffness=(1e4, 2e4, 3e4, 100.0, 200.0, 300.0),
            ),
            jo.Force("pull", block.at((0, 0, 0.3)), (50.0, 20.0, 0.0), follow=True),
            jo.Gravity((0, 0, -G)),
        )
    )
    found = statics._by_modes(model, None, 1e-12)
    assert found.q == pytest.approx(jo.equilibrium(model).q, abs=1e-9)


@pytest.mark.parametrize("law", [jo.mechanism.StickSlip(), jo.mechanism.Regularised()])
def test_friction_does_not_hold_at_rest(law):
    """As the page on theory says: a pendulum hangs down, also from a state that sticks."""
    rod = jo.RigidBody("rod", 1.0, (0.1, 0.1, 0.1), center=(1, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], rod["origin"], axis=(0, 1, 0))
    friction = jo.Friction("friction", hinge, 0.6, 0.6, radius=1.0, law=law)
    tip = jo.PositionSensor("tip", rod.at((1, 0, 0)))
    model = jo.compile(jo.Mechanism(rod, hinge, friction, tip, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 3.0, solver=jo.RK4(step=1e-3))
    stuck = run["tip"][-1]
    assert stuck[2] > -0.995  # it rests, or creeps, aside
    for start in (None, run.state(run.time[-1])):
        rest = jo.equilibrium(model, start)
        e = rest.q[3:7]
        assert np.degrees(2 * np.arctan2(e[2], e[0])) == pytest.approx(90.0, abs=1e-6)


def chain(n: int, *more: object) -> jo.Model:
    """Links of 1 m and 1 kg, level, hinged to one another."""
    links = [jo.RigidBody(f"b{i}", 1.0, (0.1,) * 3, position=(i, 0, 0)) for i in range(n)]
    hinges = [
        jo.Revolute(f"hinge{i}", a.at((0.5, 0, 0)), b.at((-0.5, 0, 0)), axis=(0, 1, 0))
        for i, (a, b) in enumerate(pairwise(links))
    ]
    ends = [make(links) for make in more]  # type: ignore[operator]
    return jo.compile(jo.Mechanism(*links, *hinges, *ends))


def gravity(links: list[jo.RigidBody]) -> jo.Gravity:
    return jo.Gravity((0, 0, -G))


@pytest.mark.parametrize("n", [2, 32])
def test_a_machine_that_falls_freely_is_said_at_once(n, monkeypatch):
    """No force but its weight has a resultant, at any position: not a step is needed."""
    monkeypatch.setattr(statics, "settle", None)
    with pytest.raises(
        jo.SimulationError, match="a force acts on body 'b0' in a direction in which nothing"
    ):
        jo.equilibrium(chain(n, gravity))


def test_loads_of_a_fixed_direction_that_carry_a_free_machine():
    """A level chain under its weight, each link carried at its centre: it rests as it is."""
    lifts = [
        lambda links, i=i: jo.Force(f"lift{i}", links[i].at((0, 0, 0)), (0, 0, G)) for i in range(3)
    ]
    model = chain(3, gravity, *lifts)
    assert jo.equilibrium(model).q == pytest.approx(model.q0, abs=1e-9)
    with pytest.raises(jo.SimulationError, match="in which nothing holds it"):
        jo.equilibrium(chain(3, gravity, *lifts[1:]))


def test_what_a_level_spring_alone_holds_finds_its_rest():
    """Its stiffness across is 0 at the start. It hangs below: ``k (l - 1 m) = m g``."""
    ball = jo.RigidBody("ball", 1.0, (0.1,) * 3, position=(1, 0, 0))
    hold = jo.Spring.between("hold", jo.ground["origin"], ball["origin"], 100.0)
    model = jo.compile(jo.Mechanism(ball, hold, jo.Gravity((0, 0, -G))))
    assert jo.equilibrium(model).q[:3] == pytest.approx([0, 0, -1.0 - G / 100.0], abs=1e-7)


@pytest.mark.filterwarnings("ignore:.*has no joint to another body")
def test_thrust_that_follows_may_carry_a_machine():
    """A body on its thrust stands where both are opposite; nothing else holds it."""
    body = jo.RigidBody("b0", 1.0, (0.1,) * 3)
    thrust = jo.Force("thrust", body.at((0, 0, 0.5)), (0, 0, G), follow=True)
    model = jo.compile(jo.Mechanism(body, thrust, jo.Gravity((0, 0, -G))))
    assert jo.equilibrium(model).q == pytest.approx(model.q0, abs=1e-9)
