"""Damage counted while the engine steps, against the count of the stored history."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism.bodies.body import FlexibleBody

STEEL = jo.SN(S_D=1e6, N_D=1e6, k=5, rule="haibach")
SITE = "e1.a.top:s11"
SOLVERS = (
    *(jo.RK4(2e-4), jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3)),
    *(jo.simulation.SSPRK3(1e-4), jo.simulation.ROS3A(1e-3)),
)


@pytest.fixture(scope="module")
def rod():
    part = jo.Part.beam(
        length=1.0,
        section=jo.Rectangle(0.02, 0.025),
        elements=4,
        material=jo.Material(E=2e11, nu=0.3, rho=7850),
    )
    return jo.reduce(part, jo.CraigBampton(interfaces=("start",), modes=3))


def swing(rod, *more, **options):
    """A beam that falls about one end, with a meter of the stress near it."""
    arm = FlexibleBody("arm", rod)
    pin = jo.Revolute("pin", jo.ground["origin"], arm["start"], (0, 1, 0))
    stress = jo.StressSensor("stress", arm, "e1.a.top")
    given = {"residue": "half", "components": SITE, **options}
    life = jo.mechanism.DamageSensor("life", stress, STEEL, **given)
    further = [make(arm, pin, stress) for make in more]
    return jo.compile(
        jo.Mechanism(arm, pin, jo.Gravity((0, 0, -9.81)), stress, life, *further, name="swing")
    )


def offline(x, residue="half", **options):
    meter = jo.model.DamageMeter(STEEL, residue=residue, depth=500, **options)
    meter.push(x)
    return meter


@pytest.mark.parametrize("residue", ["half", "repeat", "ignore"])
@pytest.mark.parametrize("solver", SOLVERS, ids=lambda s: type(s).__name__)
def test_it_is_the_count_of_the_history_if_every_step_is_stored(rod, solver, residue):
    model = swing(rod, residue=residue, mean=jo.fatigue.Goodman(400e6), depth=200)
    run = jo.simulate(model, 0.4, solver=solver, output_step=solver.step)
    x = run["stress"][:, 0]
    meter = offline(x, residue, mean=jo.fatigue.Goodman(400e6))
    damage, cycles = run["life"][-1]
    assert cycles == meter.cycles[0] > 20
    assert damage == pytest.approx(meter.damage()[0], rel=1e-12)
    assert damage > 0.0
    # and at an instant on the way
    half = len(x) // 2
    assert run["life"][half, 0] == pytest.approx(
        offline(x[: half + 1], residue, mean=jo.fatigue.Goodman(400e6)).damage()[0], rel=1e-12
    )


def test_every_step_counts_whatever_is_stored(rod):
    model = swing(rod)
    fine, coarse = (
        jo.simulate(model, 0.4, solver=jo.ROS2(1e-3), output_step=h) for h in (1e-3, 2e-2)
    )
    np.testing.assert_array_equal(coarse["life"], fine["life"][::20])
    assert offline(coarse["stress"][:, 0]).cycles[0] < coarse["life"][-1, 1]


def test_a_run_counts_on_from_the_state_of_another(rod):
    model = swing(rod, residue="repeat", depth=8)
    whole = jo.simulate(model, 0.4, solver=jo.RK4(2e-4), output_step=1e-2)
    first = jo.simulate(model, 0.3, solver=jo.RK4(2e-4), output_step=1e-2)
    for state in (first.state(), whole.state(0.3)):
        rest = jo.simulate(model, 0.4, solver=jo.RK4(2e-4), output_step=1e-2, state=state)
        np.testing.assert_array_equal(rest.state().meters, whole.state().meters)
        np.testing.assert_array_equal(rest["life"][-1], whole["life"][-1])
    # stopped and gone on inside the simulator
    sim = jo.simulation.Simulator(model, jo.RK4(2e-4))
    sim.read("life")
    sim.step(700)
    sim = jo.simulation.Simulator(model, jo.RK4(2e-4), state=sim.state())
    assert sim.read("life")[1] > 0
    sim.step(1300)
    assert sim.read("life")[0] == pytest.approx(whole["life"][-1, 0], rel=1e-9)


def test_spoiled_memories_are_refused(rod):
    model = swing(rod)
    run = jo.simulate(model, 0.05, solver=jo.ROS2(1e-3), output_step=1e-3)
    state = run.state()
    state.meters[0] = 1e6
    with pytest.raises(jo.InputError, match="the meters of the state do not belong"):
        jo.simulate(model, 0.1, state=state)
    state = jo.simulation.State(state.q, state.v, state.lam, state.time, meters=np.zeros(3))
    with pytest.raises(jo.InputError, match="state has 3 meters, the model 45"):
        jo.simulate(model, 0.1, state=state)


def test_adaptive_steps_count_at_their_own_ends(rod):
    model = swing(rod)
    solver = jo.simulation.DormandPrince(1e-8)
    runs = [jo.simulate(model, 0.2, solver=solver, output_step=h) for h in (1e-4, 1e-2)]
    assert runs[0]["life"][-1, 1] == runs[1]["life"][-1, 1] > 10
    assert runs[0]["life"][-1, 0] == pytest.approx(runs[1]["life"][-1, 0], rel=1e-6)
    # peaks between steps are missed by little
    exact = offline(runs[0]["stress"][:, 0])
    assert runs[0]["life"][-1, 0] == pytest.approx(exact.damage()[0], rel=0.05)
    samples = runs[1].state().meters[1]
    assert samples == runs[1].work.steps[-1] + 1


def test_steps_that_events_interrupt_count_once(rod):
    plain = swing(rod)
    watched = swing(rod, lambda arm, pin, stress: jo.mechanism.Event("down", pin.angle, 0.3))
    runs = [
        jo.simulate(model, 0.5, solver=jo.ROS2(1e-3), output_step=1e-3)
        for model in (plain, watched)
    ]
    assert runs[1].events
    for run in runs:
        assert run.state().meters[1] == run.nt
        assert run["life"][-1, 0] == pytest.approx(
            offline(run["stress"][:, 0]).damage()[0], rel=1e-12
        )


def test_damage_stops_a_run(rod):
    model = swing(rod)
    limit = 0.5 * jo.simulate(model, 0.4, solver=jo.ROS2(1e-3))["life"][-1, 0]
    arm = FlexibleBody("arm", rod)
    pin = jo.Revolute("pin", jo.ground["origin"], arm["start"], (0, 1, 0))
    stress = jo.StressSensor("stress", arm, "e1.a.top")
    life = jo.mechanism.DamageSensor("life", stress, STEEL, residue="half", components=SITE)
    broken = jo.mechanism.Event("broken", life, limit, component="damage", stop=True)
    model = jo.compile(
        jo.Mechanism(arm, pin, jo.Gravity((0, 0, -9.81)), stress, life, broken, name="swing")
    )
    run = jo.simulate(model, 0.4, solver=jo.ROS2(1e-3), output_step=1e-3)
    assert run.attributes["ended"].startswith("stopped by event 'broken'")
    assert run["life"][-2, 0] >= limit > run["life"][-4, 0]


def test_reactions_are_measured_at_the_end_of_each_step(rod):
    """A sensor that needs accelerations, with a factor from N to Pa."""
    arm = FlexibleBody("arm", rod)
    pin = jo.Revolute("pin", jo.ground["origin"], arm["start"], (0, 1, 0))
    force = jo.ReactionSensor("force", pin)
    life = jo.mechanism.DamageSensor(
        "life", force, STEEL, residue="half", components="Fz", factor=2e3
    )
    model = jo.compile(jo.Mechanism(arm, pin, jo.Gravity((0, 0, -9.81)), force, life))
    run = jo.simulate(model, 0.2, solver=jo.ROS2(1e-3), output_step=1e-3)
    column = run.about("force")["components"].index("Fz")
    meter = offline(2e3 * run["force"][:, column])
    assert run["life"][-1].tolist() == [
        pytest.approx(meter.damage()[0], rel=1e-12),
        meter.cycles[0],
    ]


def test_the_build_for_derivatives_counts_real_parts(rod):
    model = swing(rod)
    engines = [jo.model.Engine(model), jo.model.Engine(model, complex_scalars=True)]
    for engine in engines:
        native = engine.native_solver("ros2", 1e-3, True)
        for _ in range(50):
            engine.step(native)
    np.testing.assert_allclose(engines[1].meters, engines[0].meters, rtol=1e-9, atol=1e-20)
    assert engines[0].meters[1] == 50


def test_mistakes(rod):
    arm = FlexibleBody("arm", rod)
    pin = jo.Revolute("pin", jo.ground["origin"], arm["start"], (0, 1, 0))
    stress, other = (jo.StressSensor(name, arm, "e1.a.top") for name in ("stress", "other"))
    with pytest.raises(jo.InputError) as error:
        jo.mechanism.DamageSensor(
            "life", stress, "steel", residue="all", components="e1.a.top:s12x"
        )
    for part in (
        "sn is 'steel', must be an S-N curve",
        "residue is 'all'",
        "sensor 'stress' has no 'e1.a.top:s12x'; did you mean 'e1.a.top:s12'?",
    ):
        assert part in str(error.value)
    with pytest.raises(jo.InputError, match="measures rad, the S-N curve is in Pa; give factor"):
        jo.mechanism.DamageSensor(
            "life", jo.CoordinateSensor("a", pin.angle), STEEL, residue="half"
        )
    with pytest.raises(jo.InputError, match="must be a sensor of stress"):
        jo.mechanism.DamageSensor("life", arm, STEEL, residue="half")
    for factor, text in ((0.0, "factor is 0"), (np.nan, "factor is nan")):
        with pytest.raises(jo.InputError, match=text):
            jo.mechanism.DamageSensor("life", stress, STEEL, residue="half", factor=factor)
    life = jo.mechanism.DamageSensor("life", other, STEEL, residue="half")
    with pytest.raises(jo.InputError, match=r"sensor 'other' is not in the mechanism"):
        jo.Mechanism(arm, pin, stress, life)
    with pytest.raises(jo.InputError, match="must be a sensor of stress"):
        jo.mechanism.DamageSensor("twice", life, STEEL, residue="half")
    with pytest.warns(jo.JoustoWarning, match="von Mises stress, which is never negative"):
        jo.mechanism.DamageSensor("life", jo.VonMisesSensor("m", arm), STEEL, residue="half")
