"""Elastic-plastic springs: closed forms of bumps and load paths, energy, repeated steps, slopes.

A rod of 20 kg, 2 m long and rigid, turns on a hinge at its root; a lump of 10 kg has stuck to its
tip: 66.67 kg m2, 1.8 rad/s after the hit, 108 J. The numbers are closed forms, or two integrations
of other programs that agree to 1e-8.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import jousto as jo
from jousto.mechanism.forces.plastic import STATES
from jousto.model.model import ForceModel
from model import test_forces

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely")

K, YIELD, H = 2e5, 3000.0, 2e4
INERTIA, SPEED, ENERGY = 200.0 / 3.0, 1.8, 108.0
LAWS: dict[str, dict[str, float]] = {
    "kinematic": {"kinematic": H},
    "isotropic": {"isotropic": H},
    "frederick": {"kinematic": 6e4, "recovery": 30.0},
    "all": {
        "kinematic": 6e4,
        "recovery": 30.0,
        "isotropic": 5e3,
        "saturation": 600.0,
        "rate": 40.0,
    },
}
TOPS = {"kinematic": 0.04138965489, "frederick": 0.03951389879}
"""First tops, rad: closed form, and two integrations."""
METHODS = {
    "RK4": jo.RK4(2e-5),
    "ROS2": jo.ROS2(1e-5),
    "GeneralizedAlpha": jo.GeneralizedAlpha(1e-5),
    "Newmark": jo.simulation.Newmark(1e-5),
    "DormandPrince": jo.simulation.DormandPrince(tolerance=1e-12),
}


def boom(*more: Any, **options: Any) -> jo.Mechanism:
    """Return the rod with its hinge; with "top" the run stops at the first top."""
    items = rod_items(**options)
    if "top" in more:
        rate = next(item for item in items if isinstance(item, jo.RateSensor))
        items += [jo.mechanism.Event("top", rate, 0.0, "falling", stop=True)]
    return jo.Mechanism(*items)


def rod_items(k: float = K, speed: float = SPEED, weight: float = 0.0, **law: float) -> list[Any]:
    """Return the rod, its joint, its hinge, a load and sensors."""
    body = jo.RigidBody("boom", 30.0, (INERTIA,) * 3, angular_velocity=(0, 0, speed))
    root = jo.Revolute("root", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    hinge = jo.mechanism.PlasticSpring("hinge", root.angle, k, YIELD, **law)
    sensors = [jo.CoordinateSensor("angle", root.angle), jo.RateSensor("rate", root.angle)]
    sensors += [jo.mechanism.ForceStateSensor(name, hinge, name) for name in STATES]
    sensors += [jo.ForceSensor("moment", hinge), jo.mechanism.EnergySensor("springs", "springs")]
    load = jo.JointForce("load", root.angle, jo.Input("load"))
    items = [body, root, hinge, load, *sensors]
    if weight:
        items += [jo.Force("weight", body.at((1.0, 0, 0)), (0, weight, 0))]
    return items


def swung(method: Any, duration: float = 0.4, *more: Any, core: str = "joint", **law: Any) -> Any:
    return jo.simulate(jo.compile(boom(*more, **law), core=core), duration, solver=method)


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("law", TOPS)
def test_first_top(law: str, method: str, core: str) -> None:
    run = swung(METHODS[method], 0.4, "top", core=core, **LAWS[law])
    assert run["angle"][-1, 0] == pytest.approx(TOPS[law], rel=1e-8)
    if law == "kinematic":
        assert run["plastic"][-1, 0] == pytest.approx(0.02399059536, rel=1e-8)


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("method", METHODS)
def test_two_plastic_swings_then_shakedown(method: str, core: str) -> None:
    run = swung(METHODS[method], 0.4, core=core, kinematic=H)
    p, angle, rate = (run[name][:, 0] for name in ("plastic", "angle", "rate"))
    assert p[-1] == pytest.approx(0.01890099929, rel=1e-8)
    assert (p[run.time > 0.15] == p[-1]).all()
    # the middle is where the moment is 0; amplitude from the energy of the free vibration
    amplitude = np.hypot(angle - p, rate / np.sqrt(K / INERTIA))[-1]
    assert amplitude == pytest.approx(
        0.01310990007, rel=2e-7 if method == "DormandPrince" else 1e-8
    )


def test_isotropic_hardening_yields_in_one_swing() -> None:
    run = swung(METHODS["RK4"], isotropic=H)
    p = run["plastic"][:, 0]
    assert p[-1] == pytest.approx(0.02399059536, rel=1e-8)  # the first swing of kinematic
    assert (np.diff(p) >= 0.0).all() and (p[run.time > 0.05] == p[-1]).all()


@pytest.mark.parametrize("weight", [0.0, 392.4])
def test_without_hardening(weight: float) -> None:
    """The work of the moment is the energy; a stiff spring tends to the rigid, plastic hinge."""

    def left(top: float, k: float) -> float:
        given = ENERGY + weight * np.sin(top)
        return given - YIELD * (top - YIELD / (2 * k))

    tops = {k: brentq(left, 0.0, 0.2, args=(k,), xtol=1e-15) for k in (2e5, 2e7, 1e30)}
    assert tops[1e30] == pytest.approx(0.04141561378 if weight else 0.036, rel=1e-9)
    for k in (2e5, 2e7):
        run = swung(jo.RK4(1e-5), 0.2, "top", k=k, weight=weight)
        assert run["angle"][-1, 0] == pytest.approx(tops[k], rel=1e-8)
        if not weight:
            assert run.time[-1] == pytest.approx(0.04, rel=0.2 if k == 2e5 else 2e-3)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("law", LAWS)
def test_energy(law: str, method: str) -> None:
    run = swung(METHODS[method], **LAWS[law])
    coarse = method not in ("RK4", "DormandPrince", "Newmark")
    assert np.abs(run.energy.error).max() < (1e-5 if coarse else 2e-6 if law == "all" else 1e-6)
    lost, M, X = (run[name][:, 0] for name in ("dissipated", "moment", "back"))
    assert (np.diff(lost) >= 0.0).all()
    assert lost[-1] > 50.0
    assert np.abs(run.energy.dissipated - lost).max() < 1e-9
    C = LAWS[law].get("kinematic", 0.0)
    stored = M**2 / (2 * K) + (X**2 / (2 * C) if C else 0.0)
    assert np.abs(run["springs"][:, 0] - stored).max() < 1e-9
    assert (np.abs(M + X) <= YIELD + 6e2 + 5e3 * run["path"][:, 0] + H * run["path"][:, 0]).all()


@pytest.mark.parametrize("method, order", [("RK4", 4), ("ROS2", 2), ("GeneralizedAlpha", 2)])
def test_order_is_kept_through_yielding_and_unloading(method: str, order: int) -> None:
    """Steps end at both; without that the order would be 2 at most, with jumps of the error."""
    ends = [
        swung(type(METHODS[method])(h), 0.1, **LAWS["all"])["angle"][-1, 0]
        for h in (1e-3, 5e-4, 2.5e-4, 1e-6 if order == 2 else 1e-5)
    ]
    errors = np.abs(np.array(ends[:3]) - ends[3])
    assert errors[0] < 1e-4
    assert errors[2] < errors[0] / 2 ** (2 * order - 1.2)


def test_yielding_is_seen_between_the_rows_of_adaptive_steps() -> None:
    fine = swung(jo.RK4(2e-5), 0.1, **LAWS["all"])
    model = jo.compile(boom(**LAWS["all"]))
    run = jo.simulate(
        model, 0.1, solver=jo.simulation.DormandPrince(tolerance=1e-11), output_step=2e-5
    )
    for name in ("plastic", "back", "path", "dissipated", "moment"):
        scale = np.abs(fine[name]).max()
        assert np.abs(run[name] - fine[name]).max() < 2e-7 * scale, name
    assert np.abs(run.energy.error).max() < 1e-6


# -- load paths ---------------------------------------------------------------------------------


def paths(loads: list[float], by: str, **law: float) -> list[jo.simulation.State]:
    model = jo.compile(boom(speed=0.0, **law))
    state, out = jo.equilibrium(model), []
    for load in loads:
        if by == "equilibrium":
            state = jo.equilibrium(model, replace(state, inputs={"load": load}))
        else:
            state = jo.simulation.load_path(model, "load", to=load, state=state, steps=7).states[-1]
        out.append(state)
    return out


@pytest.mark.parametrize("by", ["equilibrium", "load_path"])
def test_load_path_with_kinematic_and_isotropic_hardening(by: str) -> None:
    """Tip loads of 2000, -2000, 1800 and 0 N on a lever of 2 m."""
    loads = [4000.0, -4000.0, 3600.0, 0.0]
    kinematic = [state.states[0] for state in paths(loads, by, kinematic=H)]
    assert kinematic == pytest.approx([0.05, -0.05, 0.03, 0.03], rel=1e-8)
    isotropic = [state.states[0] for state in paths(loads, by, isotropic=H)]
    assert isotropic == pytest.approx([0.05] * 4, rel=1e-8)


def test_armstrong_frederick_saturates_to_tanh() -> None:
    """Between loads of equal size the range of p becomes that of X = (C/G) tanh(G dp / 2)."""
    M = YIELD + 1074.099134
    ends = [state.states[0] for state in paths([M, -M] * 14, "equilibrium", **LAWS["frederick"])]
    assert abs(ends[-1] - ends[-2]) == pytest.approx(0.04, rel=1e-8)


def test_ratchet_of_armstrong_frederick() -> None:
    """A cycle between M1 and -M2 adds ln((B^2 - (M2 - Y)^2) / (B^2 - (M1 - Y)^2)) / G, B = C/G."""
    M1, M2, B, G = 4000.0, 3500.0, 2000.0, 30.0
    ends = [state.states[0] for state in paths([M1, -M2] * 12, "equilibrium", **LAWS["frederick"])]
    wanted = np.log((B**2 - (M2 - YIELD) ** 2) / (B**2 - (M1 - YIELD) ** 2)) / G
    assert ends[-1] - ends[-3] == pytest.approx(wanted, rel=1e-8)
    assert ends[-2] - ends[-4] == pytest.approx(wanted, rel=1e-8)


def test_bumps_of_equal_energy_harden_until_they_are_elastic() -> None:
    """Each from rest, swing-out damped away: p tends to (sqrt(2 k E) - M_y) / H."""
    model = jo.compile(boom("top", isotropic=H))
    p, states = 0.0, None
    for _ in range(2):
        start = at_rest_with(model, p, states)
        top = jo.simulate(model, 0.4, solver=METHODS["RK4"], state=start)
        p, states = top["plastic"][-1, 0], top.state().states
    assert p == pytest.approx(0.04323261364, rel=1e-8)
    limit = (np.sqrt(2 * K * ENERGY) - YIELD) / H
    assert limit == pytest.approx(0.1786335345, rel=1e-9)
    for path, yields in ((limit - 1e-4, True), (limit + 1e-9, False)):
        start = at_rest_with(model, 0.0, np.array([0.0, 0.0, path, 0.0, 0.0]))
        last = jo.simulate(model, 0.4, solver=METHODS["RK4"], state=start)["plastic"][-1, 0]
        assert (abs(last) > 1e-6) == yields


def at_rest_with(model: jo.Model, p: float, states: Any) -> jo.simulation.State:
    """Return the boom where the hinge has no moment, hit again."""
    turned = np.array(model.q0)
    turned[3], turned[6] = np.cos(p / 2), np.sin(p / 2)
    return jo.simulation.State(turned, model.v0, np.zeros(model.nrow), states=states)


# -- repeated steps, states, slopes --------------------------------------------------------------


@pytest.mark.parametrize("method", ["RK4", "ROS2", "GeneralizedAlpha", "DormandPrince"])
def test_a_repeated_run_from_the_middle_of_a_flow_is_the_same_to_the_bit(method: str) -> None:
    model = jo.compile(boom(**LAWS["all"]))
    coarse = {"RK4": jo.RK4(1e-3), "ROS2": jo.ROS2(1e-3)}
    solver = coarse.get(method, METHODS[method])
    first = jo.simulate(model, 0.03, solver=solver)
    assert first["flow"][-1, 0] != 0.0 and first["plastic"][-1, 0] > 0.0
    ends = [jo.simulate(model, 0.1, solver=solver, state=first.state()) for _ in range(2)]
    for one, other in zip(*(end.state().states for end in ends), strict=True):
        assert one == other
    whole = jo.simulate(model, 0.1, solver=solver)
    exact = method in coarse  # the others begin anew at a state
    for name in ("plastic", "back", "path", "dissipated"):
        gap = abs(whole[name][-1, 0] - ends[0][name][-1, 0])
        assert gap <= (0.0 if exact else 1e-7 * max(1.0, abs(whole[name][-1, 0]))), name


def test_rejected_steps_leave_nothing_behind() -> None:
    """First steps that are far too long are rejected; what yields is that of short ones."""
    model = jo.compile(boom(**LAWS["all"]))
    runs = [
        jo.simulate(
            model,
            0.1,
            solver=jo.simulation.DormandPrince(tolerance=1e-12, first_step=first),
        )
        for first in (1e-5, 0.1)
    ]
    assert runs[1].work.rejected[-1] > runs[0].work.rejected[-1]
    for name in ("plastic", "path", "dissipated", "angle"):
        a, b = (run[name][-1, 0] for run in runs)
        assert a == pytest.approx(b, rel=1e-9), name


def test_a_start_beyond_the_yield_force_has_flowed_there() -> None:
    model = jo.compile(boom(speed=0.0, kinematic=H))
    run = jo.simulate(model, 0.1, solver=jo.RK4(1e-4), state=at_rest_with(model, 0.07, None))
    assert run["plastic"][0, 0] == pytest.approx(0.05, rel=1e-9)
    assert run["dissipated"][0, 0] == run.energy.dissipated[0] == 0.0
    assert np.abs(run.energy.error).max() < 1e-7


@pytest.mark.parametrize("turn", [0.005, 0.04, -0.04], ids=["elastic", "flows", "flows back"])
@pytest.mark.parametrize("kind", [0, 1, 2], ids=["distance", "along", "angle"])
def test_slopes_are_those_of_complex_steps(kind: int, turn: float) -> None:
    data = np.array([300.0, coordinate_value(kind) - turn, 2.0, 90.0, 7.0, 20.0, 0.5, 9.0])
    names = tuple(STATES)
    force = ForceModel("x", "plastic", data, coordinate=kind, state=0, state_names=names)
    engine = jo.model.Engine(test_forces.two_bodies(force))
    engine.states[:] = 0.001, 0.05, 0.002, 0.0, 0.0
    engine.accelerations()
    exact = engine.tangent()
    n = len(exact.K)
    found = engine.newton_matrix(0.0, 0.0, 1.0)[:n, :n]
    assert np.abs(found - exact.K).max() < 1e-12 * max(np.abs(exact.K).max(), 1.0)
    engine.yield_forces()
    assert (engine.states[2] > 0.002) == (abs(turn) > 0.01)


def coordinate_value(kind: int) -> float:
    """Return the value of a coordinate, the change of s^2 / 2 - f s by f = 1."""
    energies = []
    for preload in (0.0, 1.0):
        force = ForceModel("x", "along", np.array([1.0, 0.0, 0.0, preload, 0.0]), coordinate=kind)
        engine = jo.model.Engine(test_forces.two_bodies(force))
        energies.append(float(engine.energy()[3]))
    return energies[0] - energies[1]


def test_an_event_at_a_plastic_deformation_stops_there() -> None:
    items = rod_items(kinematic=H)
    plastic = next(item for item in items if item.name == "plastic")
    bent = jo.mechanism.Event("bent", plastic, 0.01, "rising", stop=True)
    run = jo.simulate(jo.compile(jo.Mechanism(*items, bent)), 0.4, solver=jo.RK4(1e-3))
    assert run["plastic"][-1, 0] == pytest.approx(0.01, rel=1e-9)
    M = YIELD + H * 0.01
    assert run["moment"][-1, 0] == pytest.approx(-M, rel=1e-9)
    left = ENERGY - M**2 / (2 * K) - H * 0.01**2 / 2 - YIELD * 0.01
    assert run["rate"][-1, 0] == pytest.approx(np.sqrt(2 * left / INERTIA), rel=1e-7)


def test_a_hinge_that_tears_takes_its_energy_with_it() -> None:
    items = rod_items(kinematic=H)
    plastic = next(item for item in items if item.name == "plastic")
    hinge = next(item for item in items if item.name == "hinge")
    tears = jo.mechanism.Event("tears", plastic, 0.01, "rising", releases=hinge)
    run = jo.simulate(jo.compile(jo.Mechanism(*items, tears)), 0.2, solver=jo.RK4(1e-4))
    assert len(run.events) == 1
    assert run["moment"][-1, 0] == run["springs"][-1, 0] == 0.0
    assert run["plastic"][-1, 0] == pytest.approx(0.01, rel=1e-9)
    M = YIELD + H * 0.01
    lost = M**2 / (2 * K) + H * 0.01**2 / 2 + YIELD * 0.01
    assert run.energy.dissipated[-1] == pytest.approx(lost, rel=1e-8)
    assert np.abs(run.energy.error).max() < 1e-6


def test_kinematics_refuses_what_depends_on_the_way() -> None:
    items = rod_items(speed=0.0, kinematic=H)
    root = next(item for item in items if item.name == "root")
    model = jo.compile(jo.Mechanism(*items, jo.Drive("turns", root.angle, jo.Constant(0.0))))
    with pytest.raises(jo.InputError, match="force 'hinge': yields, so that its force depends"):
        jo.simulation.inverse_dynamics(model, [0.0, 0.1])


def test_numbers_are_checked() -> None:
    body = jo.RigidBody("boom", 30.0, (INERTIA,) * 3)
    root = jo.Revolute("root", jo.ground["origin"], body["origin"])
    make = jo.mechanism.PlasticSpring
    with pytest.raises(jo.InputError, match="must be finite; for a hinge that is rigid until it"):
        make("x", root.angle, np.inf, YIELD)
    with pytest.raises(jo.InputError) as error:
        make("x", root.angle, K, YIELD, recovery=3.0, saturation=2.0)
    assert len(error.value.problems) == 2
    hinge = make("x", root.angle, K, YIELD)
    with pytest.raises(jo.InputError, match="no state 'plastik'; did you mean 'plastic'"):
        jo.mechanism.ForceStateSensor("p", hinge, "plastik")
    with pytest.raises(jo.InputError, match="spring 's' has no states; take a PlasticSpring"):
        jo.mechanism.ForceStateSensor("p", jo.Spring("s", root.angle, 1.0))


@pytest.mark.parametrize(
    "law, load", [({}, 3001.0), ({"kinematic": 6e4, "recovery": 30.0}, 5001.0)]
)
def test_a_load_beyond_the_plastic_limit_is_named(law: dict[str, float], load: float) -> None:
    """The limit is M_y without hardening, M_y + C/G by Armstrong and Frederick."""
    body = jo.RigidBody("boom", 30.0, (66.67,) * 3)
    root = jo.Revolute("root", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    hinge = jo.mechanism.PlasticSpring("hinge", root.angle, 2e5, 3000.0, **law)
    push = jo.JointForce("load", root.angle, jo.Input("load"))
    model = jo.compile(jo.Mechanism(body, root, hinge, push))
    named = r"'hinge' \(3000 N m\) carries the full strength .* likely the plastic limit"
    with pytest.raises(jo.SimulationError, match=named):
        jo.simulation.load_path(model, "load", to=load, steps=10)
    with pytest.raises(jo.SimulationError, match=named):
        jo.equilibrium(model, replace(jo.equilibrium(model), inputs={"load": load}))
    # below it there is an equilibrium
    assert jo.simulation.load_path(model, "load", to=load - 10.0, steps=10).states


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("path", -1e-3, "state 'path' of plastic spring 'hinge' is -0.001, must not be negative"),
        ("dissipated", -1.0, "state 'dissipated' .* must not be negative"),
        ("flow", 0.5, "state 'flow' .* must be -1, 0 or 1"),
        ("flow", 2.0, "state 'flow' .* must be -1, 0 or 1"),
    ],
)
def test_a_state_that_the_law_cannot_reach_is_refused(name: str, value: float, told: str) -> None:
    model = jo.compile(boom(kinematic=H))
    state = jo.simulate(model, 0.02, solver=jo.RK4(1e-3), output_step=1e-2).state()
    assert state.states is not None
    jo.simulate(model, 0.03, solver=jo.RK4(1e-3), state=state)
    states = state.states.copy()
    states[list(STATES).index(name)] = value
    with pytest.raises(jo.InputError, match=told):
        jo.simulate(model, 0.03, solver=jo.RK4(1e-3), state=replace(state, states=states))


def test_a_state_of_words_is_refused() -> None:
    model = jo.compile(boom(kinematic=H))
    state = jo.simulate(model, 0.02, solver=jo.RK4(1e-3), output_step=1e-2).state()
    words: Any = ("a",) * 5
    for name in ("states", "q", "turn"):
        with pytest.raises(jo.InputError, match="of the state are not all numbers"):
            jo.simulate(model, 0.03, state=replace(state, **{name: words}))
