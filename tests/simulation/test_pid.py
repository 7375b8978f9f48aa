"""PID controllers: step responses beside SciPy, poles, rest, and what has to carry their states."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import jousto as jo
from jousto.cli.group import app
from jousto.model.native.native import Engine
from jousto.natural.rebuilt_mechanism import transfer_state
from jousto.simulation import DormandPrince, Newmark
from jousto.simulation.controllers import tracking_warning

G = 9.81


def cart(**how: Any) -> jo.Mechanism:
    """y'' + y'/2 = u of a mass of 1 kg, controlled with K = 8, Ti = 2 s, Td = 0.5 s."""
    mass = jo.RigidBody("mass", 1.0, (0.1, 0.1, 0.1))
    rail = jo.Prismatic("rail", jo.ground["origin"], mass["origin"], axis=(1, 0, 0))
    drag = jo.Spring("drag", rail.displacement, damping=0.5)
    given: dict[str, Any] = {"kp": 8.0, "ki": 4.0, "kd": 4.0, "limit": 1.5} | how
    hold = jo.mechanism.PID("hold", rail.displacement, given.pop("reference", 1.0), **given)
    y, f = jo.CoordinateSensor("y", rail.displacement), jo.ForceSensor("f", hold)
    return jo.Mechanism(mass, rail, drag, hold, y, f)


def response(t: Any, tracking: float, cut: float = 20.0) -> Any:
    """The same loop by SciPy: y, y', I, y_f."""

    def rates(_: float, x: Any) -> list[float]:
        y, v, integral, filtered = x
        u = 8.0 * (1.0 - y) + integral - 4.0 * cut * (y - filtered)
        f = min(max(u, -1.5), 1.5)
        wound = 4.0 * (1.0 - y) + (f - u) / tracking
        return [v, f - 0.5 * v, wound, cut * (y - filtered)]

    how = {"rtol": 1e-11, "atol": 1e-12, "max_step": 2e-3}
    return solve_ivp(rates, (0.0, t[-1]), [0.0] * 4, t_eval=t, **how).y


METHODS = (
    (jo.RK4(step=1e-3), 1e-7),
    (jo.ROS2(step=1e-3), 2e-5),
    (jo.GeneralizedAlpha(step=1e-3), 1e-6),
    (Newmark(step=1e-3), 1e-6),
    (DormandPrince(tolerance=1e-9), 1e-8),
)


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize(("method", "small"), METHODS, ids=lambda x: type(x).__name__)
@pytest.mark.parametrize(("tracking", "peak"), [(1.8, 1.185558148), (1e9, 1.360858220)])
def test_a_limited_step_response_is_that_of_scipy(
    core: str, method: Any, small: float, tracking: float, peak: float
) -> None:
    """The peaks were found by another program, with 0.9 Ti and without back-calculation."""
    model = jo.compile(cart(tracking=tracking), core=core)
    run = jo.simulate(model, 6.0, solver=method, output_step=2e-3)
    y, f = run["y"][:, 0], run["f"][:, 0]
    assert np.abs(y - response(run.time, tracking)[0]).max() < small
    assert y.max() == pytest.approx(peak, abs=2e-6 + small)
    assert f.max() == 1.5


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize(
    ("method", "order"), [(jo.RK4, 4), (jo.ROS2, 2), (jo.GeneralizedAlpha, 2), (Newmark, 2)]
)
def test_methods_keep_their_order(core: str, method: Any, order: int) -> None:
    """A smooth reference, no limit: the error falls with the order of the method."""
    swing = jo.Harmonic(amplitude=0.3, frequency=0.7)
    model = jo.compile(cart(reference=swing, limit=None, weight=0.4), core=core)

    def end(step: float) -> Any:
        return jo.simulate(model, 2.0, solver=method(step=step))["y"][-1, 0]

    exact = jo.simulate(model, 2.0, solver=DormandPrince(tolerance=1e-13))["y"][-1, 0]
    errors = [abs(end(step) - exact) for step in (8e-3, 4e-3)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.35)


@pytest.mark.parametrize("method", [None, jo.GeneralizedAlpha(step=1e-3)])
def test_a_fast_filter_is_seen(method: Any) -> None:
    """Then the derivative is the rate: (s^3 + 4.5 s^2 + 8 s + 4) y = 8 + 4 / s."""
    model = jo.compile(cart(filter=1e-5, limit=None))
    run = jo.simulate(model, 4.0, solver=method)
    poles = [0.0, *np.roots([1.0, 4.5, 8.0, 4.0])]
    residues = [(8.0 * p + 4.0) / np.prod([p - q for q in poles if q != p]) for p in poles]
    exact = sum(c * np.exp(p * run.time) for c, p in zip(residues, poles, strict=True)).real
    assert np.abs(run["y"][:, 0] - exact).max() < 1e-4


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("method", [jo.RK4(1e-3), jo.ROS2(1e-3), jo.GeneralizedAlpha(step=1e-3)])
def test_a_speed_loop_has_its_closed_form(core: str, method: Any) -> None:
    """J w' = kp (r - w) + I, I' = ki (r - w): w = r (1 - e^(-a t) (cos b t - ...)), a PI loop."""
    J, r, kp, ki = 0.02, 50.0, 0.12, 1.0
    wheel = jo.RigidBody("wheel", 1.0, (J / 2, J / 2, J))
    axle = jo.Revolute("axle", jo.ground["origin"], wheel["origin"], (0, 0, 1))
    motor = jo.mechanism.SpeedPID("motor", axle.angle, r, kp=kp, ki=ki)
    w = jo.RateSensor("w", axle.angle)
    model = jo.compile(jo.Mechanism(wheel, axle, motor, w), core=core)
    run = jo.simulate(model, 1.0, solver=method)
    a = kp / (2 * J)
    b = np.sqrt(ki / J - a * a)
    t = run.time
    exact = r * (1.0 - np.exp(-a * t) * (np.cos(b * t) - (kp / J - a) / b * np.sin(b * t)))
    assert np.abs(run["w"][:, 0] - exact).max() < (2e-3 if isinstance(method, jo.ROS2) else 3e-4)


def test_newton_needs_no_more_iterations_than_for_a_spring() -> None:
    """The loop is linear: with the exact tangent one iteration finds the end of a step."""
    model = jo.compile(cart(limit=None), core="maximal")
    run = jo.simulate(model, 1.0, solver=jo.GeneralizedAlpha(step=1e-2, tangent="exact"))
    assert run.work.iterations[-1] <= 2 * 100


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("tracking", [5e-4, 1e-4, 3e-5])
def test_the_step_is_chosen_for_a_fast_back_calculation(core: str, tracking: float) -> None:
    """A step that is longer would throw the force from limit to limit."""
    model = jo.compile(cart(kd=0.0, limit=1.0, tracking=tracking), core=core)
    run = jo.simulate(model, 1.0)
    exact = jo.simulate(model, 1.0, solver=DormandPrince(tolerance=1e-8), output_step=0.1)
    assert run["y"][-1, 0] == pytest.approx(exact["y"][-1, 0], abs=2e-3)
    said = tracking_warning(model, 1e-3)
    assert "'hold' comes back from its limit within" in said and not tracking_warning(model, 1e-5)


def test_a_long_step_beside_a_fast_back_calculation_warns() -> None:
    model = jo.compile(cart(kd=0.0, limit=1.0, tracking=5e-4))
    with pytest.warns(jo.JoustoWarning, match=r"within 0\.0005 s, less than the step of 0\.001 s"):
        jo.simulate(model, 1.0, solver=jo.GeneralizedAlpha(step=1e-3))


@pytest.mark.parametrize("core", ["joint", "maximal"])
def test_a_derivative_alone_is_a_damper(core: str) -> None:
    """m v' = -kd v_f - v/2 with a filter that is fast beside it: v falls by e^(-4.5 t)."""
    mass = jo.RigidBody("mass", 1.0, (0.1, 0.1, 0.1), velocity=(1.0, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], mass["origin"], axis=(1, 0, 0))
    hold = jo.mechanism.PID("hold", rail.displacement, 0.0, kp=0.0, kd=4.5, filter=1e-4)
    v = jo.RateSensor("v", rail.displacement)
    model = jo.compile(jo.Mechanism(mass, rail, hold, v), core=core)
    for method in (None, DormandPrince(tolerance=1e-8), jo.GeneralizedAlpha(step=1e-3)):
        run = jo.simulate(model, 0.5, solver=method, output_step=0.01)
        assert np.abs(run["v"][:, 0] - np.exp(-4.5 * run.time)).max() < 1e-3


# -- rest and small motions ---------------------------------------------------------------------


def arm(reference: Any = 0.6, **how: Any) -> jo.Mechanism:
    """A link of 2 kg, its centre 0.4 m from a hinge, which a PID holds at an angle."""
    link = jo.RigidBody("link", 2.0, (0.01, 0.1, 0.1), center=(0.4, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], link["origin"], axis=(0, -1, 0))
    given: dict[str, Any] = {"kp": 60.0, "ki": 80.0, "kd": 12.0} | how
    hold = jo.mechanism.PID("hold", hinge.angle, reference, **given)
    sensors = jo.CoordinateSensor("angle", hinge.angle), jo.ForceSensor("torque", hold)
    return jo.Mechanism(link, hinge, hold, *sensors, jo.Gravity((0, 0, -G)))


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("method", [jo.RK4(1e-3), jo.ROS2(1e-3), jo.GeneralizedAlpha(step=1e-3)])
def test_equilibrium_is_where_the_controller_wants_it(core: str, method: Any) -> None:
    """The integral part is m g l cos(angle); a run from there stays there."""
    model = jo.compile(arm(), core=core)
    rest = jo.equilibrium(model)
    weight = 2.0 * G * 0.4 * np.cos(0.6)
    assert rest.states == pytest.approx([weight, 0.6], rel=1e-8)
    run = jo.simulate(model, 0.5, solver=method, state=rest)
    assert np.abs(run["angle"] - 0.6).max() < 1e-8
    assert np.abs(run["torque"] - weight).max() < 1e-6


def test_a_limited_controller_rests_where_its_limit_does() -> None:
    """cos(angle) = limit / (m g l), below the reference."""
    model = jo.compile(arm(limit=5.0))
    with pytest.warns(jo.JoustoWarning, match=r"'hold' is at a limit of its force and stays 1\."):
        rest = jo.equilibrium(model)
    engine = Engine(model)
    engine.q[:], engine.v[:] = rest.q, 0.0
    engine.start_states()
    assert np.cos(engine.states[1]) == pytest.approx(5.0 / (2.0 * G * 0.4), rel=1e-6)
    u = 60.0 * (0.6 - rest.states[1]) + rest.states[0]
    assert 80.0 * (0.6 - rest.states[1]) + (5.0 - u) / (0.9 * 60.0 / 80.0) == pytest.approx(
        0.0, abs=1e-5
    )


def test_what_has_no_rest_is_one_sentence() -> None:
    wheel = jo.RigidBody("wheel", 1.0, (0.01, 0.01, 0.02))
    axle = jo.Revolute("axle", jo.ground["origin"], wheel["origin"])
    motor = jo.mechanism.SpeedPID("motor", axle.angle, 5.0, kp=0.1, ki=1.0)
    with pytest.raises(jo.SimulationError, match="'motor' has a reference speed other than 0"):
        jo.equilibrium(jo.compile(jo.Mechanism(wheel, axle, motor)))
    integral = jo.compile(arm(kp=0.0, ki=8.0, kd=0.0, tracking=0.3, limit=10.0))
    with pytest.raises(jo.SimulationError):  # unstable there: gravity is stiffer than kp
        jo.equilibrium(integral)
    model, machine = jo.compile(arm()), arm()
    turn = jo.Drive("turn", machine.joints[0].angle, 0.0)
    driven = jo.Mechanism(*machine.items, turn)
    with pytest.raises(jo.InputError, match="PID 'hold' has states"):
        jo.simulation.inverse_dynamics(jo.compile(driven), np.linspace(0.0, 1.0, 3))
    with pytest.raises(jo.InputError, match="PID 'hold' has states"):
        jo.simulation.buckling(model, "gravity")
    with pytest.raises(jo.InputError, match="PID 'hold' has states"):
        jo.simulation.load_path(model, "gravity", to=1.0)


def test_poles_of_the_closed_loop() -> None:
    """(s^2 + s/2)(s + cut) s + (kp s + ki)(s + cut) + kd cut s^2 = 0."""
    model = jo.compile(cart(limit=None))
    cut = 20.0
    plant = np.polymul([1.0, 0.5, 0.0], np.polymul([1.0, 0.0], [1.0, cut]))
    control = np.polymul([8.0, 4.0], [1.0, cut])
    exact = np.roots(np.polyadd(np.polyadd(plant, control), [4.0 * cut, 0.0, 0.0]))
    found = jo.simulation.linearise(model)
    assert found.state_names == ("y0", "u0", "hold.integral", "hold.filtered")
    assert np.sort_complex(found.eigenvalues) == pytest.approx(np.sort_complex(exact), rel=1e-9)
    damped = jo.modes(model, damped=True).eigenvalues
    wanted = np.sort_complex(exact[exact.imag >= 0.0])
    assert np.sort_complex(damped) == pytest.approx(wanted, rel=1e-9)


def test_undamped_modes_count_the_proportional_part() -> None:
    """omega^2 = (kp - m g l sin(angle)) / J about the rest."""
    model = jo.compile(arm())
    found = jo.modes(model, jo.equilibrium(model)).frequencies
    J = 0.1 + 2.0 * 0.4**2
    omega = np.sqrt((60.0 - 2.0 * G * 0.4 * np.sin(0.6)) / J)
    assert found == pytest.approx([omega / (2 * np.pi)], rel=1e-7)


def test_without_vibration_the_filter_follows() -> None:
    """What bends under the load stands still: the derivative begins at 0."""
    steel = jo.Material(E=210e9, nu=0.3, rho=7850)
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 4, steel)
    rod = jo.FlexibleBody("rod", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2)))
    root = jo.Fixed("root", jo.ground["origin"], rod["start"])
    tip = jo.Displacement(jo.ground["origin"], rod["end"], axis="z", name="tip")
    hold = jo.mechanism.PID("hold", tip, 0.0, kp=300.0, ki=1.0, kd=40.0, initial=8.0)
    f = jo.ForceSensor("f", hold)
    s = jo.CoordinateSensor("s", tip)
    model = jo.compile(jo.Mechanism(rod, root, hold, f, s))
    state = jo.simulation.vibration_free_state(model)
    first = jo.simulate(model, 1e-3, state=state)
    assert state.states == pytest.approx([8.0, first["s"][0, 0]])
    assert first["f"][0, 0] == pytest.approx(8.0 - 300.0 * first["s"][0, 0], rel=1e-9)


@pytest.mark.parametrize("core", ["joint", "maximal"])
def test_a_rope_only_pulls(core: str) -> None:
    """Along a distance pulling is negative: 0 above, and a mass hangs at the height wanted."""
    mass = jo.RigidBody("mass", 100.0, (1, 1, 1), position=(0, 0, -3))
    guide = jo.Prismatic("guide", jo.ground["origin"], mass["origin"], axis=(0, 0, 1))
    rope = jo.Distance(jo.ground.at((0, 0, 4.0)), mass["origin"], name="rope")
    winch = jo.mechanism.PID("winch", rope, 5.0, kp=2e3, ki=800.0, kd=2e3, limit=0.0, lower=-1500.0)
    s, f = jo.CoordinateSensor("s", rope), jo.ForceSensor("f", winch)
    items = (mass, guide, winch, s, f, jo.Gravity((0, 0, -G)))
    model = jo.compile(jo.Mechanism(*items), core=core)
    run = jo.simulate(model, 20.0, output_step=0.01)
    assert run["f"].max() <= 0.0 and run["f"].min() == -1500.0
    assert run["s"][-1, 0] == pytest.approx(5.0, abs=1e-4)
    assert run["f"][-1, 0] == pytest.approx(-100.0 * G, rel=1e-3)
    rest = jo.equilibrium(model)
    assert rest.states == pytest.approx([-100.0 * G, 5.0], rel=1e-8)


# -- states everywhere --------------------------------------------------------------------------


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("method", [jo.RK4(1e-3), jo.ROS2(1e-3)])
def test_a_run_goes_on_where_it_stopped(core: str, method: Any, tmp_path: Path) -> None:
    model = jo.compile(cart(), core=core)
    whole = jo.simulate(model, 2.0, solver=method)
    half = jo.simulate(model, 1.0, solver=method, path=tmp_path / "half.h5")
    stored = jo.load(tmp_path / "half.h5").state(-1)
    assert stored.states is not None and abs(stored.states[0]) > 1e-3
    rest = jo.simulate(model, 2.0, solver=method, state=stored)
    np.testing.assert_array_equal(rest["y"][1:], whole["y"][1001:])
    anew = jo.simulate(model, 2.0, solver=method, state=replace(half.state(-1), states=None))
    assert np.abs(anew["y"] - rest["y"]).max() > 1e-3


def test_a_state_for_other_parts_keeps_the_integral() -> None:
    machine = arm()
    rest = jo.equilibrium(jo.compile(machine))
    np.testing.assert_array_equal(transfer_state(rest, machine, arm()).states, rest.states)


def test_derivatives_of_a_run_are_exact() -> None:
    def machine(kp: float, ki: float) -> jo.Mechanism:
        return cart(kp=kp, ki=ki, tracking=1.5)

    gains = [jo.Parameter("kp", 8.0, bounds=(1, 20)), jo.Parameter("ki", 4.0, bounds=(1, 20))]
    study = jo.study(machine, gains, "last(y)", t_end=3.0, solver=jo.RK4(step=2e-3))
    found = jo.design.gradient(study, [8.0, 4.0])
    assert found.how == (("complex step", "complex step"),)
    h = 1e-4
    steps = [(study([8.0 + h, 4.0]) - study([8.0 - h, 4.0]))[0] / (2 * h),
             (study([8.0, 4.0 + h]) - study([8.0, 4.0 - h]))[0] / (2 * h)]  # fmt: skip
    assert found.jacobian[0] == pytest.approx(steps, rel=1e-5)


def test_a_released_controller_lets_go() -> None:
    mass = jo.RigidBody("mass", 1.0, (0.1, 0.1, 0.1))
    rail = jo.Prismatic("rail", jo.ground["origin"], mass["origin"], axis=(1, 0, 0))
    hold = jo.mechanism.PID("hold", rail.displacement, 1.0, kp=8.0, ki=4.0, kd=4.0)
    y = jo.CoordinateSensor("y", rail.displacement)
    speed, f = jo.RateSensor("speed", rail.displacement), jo.ForceSensor("f", hold)
    over = jo.mechanism.Event("over", y, threshold=0.5, releases=hold)
    model = jo.compile(jo.Mechanism(mass, rail, hold, y, speed, f, over))
    for method in (jo.RK4(1e-3), jo.ROS2(1e-3), jo.GeneralizedAlpha(step=1e-3), DormandPrince()):
        run = jo.simulate(model, 1.5, solver=method, output_step=0.01)
        after = run["y"][:, 0] > 0.5
        assert after.sum() > 20 and not run["f"][after].any()
        assert np.ptp(run["speed"][after]) < 1e-9


def test_the_work_of_a_controller_closes_the_balance() -> None:
    model = jo.compile(arm(limit=9.0))
    for method, small in ((jo.RK4(1e-3), 1e-5), (jo.ROS2(5e-4), 1e-4)):
        run = jo.simulate(model, 2.0, solver=method)
        assert np.abs(run.energy.error).max() < small * np.abs(run.energy.work).max()


# -- what is declared ---------------------------------------------------------------------------

FILE = """
bodies:
  - {type: rigid, name: mass, mass: 1 kg, inertia: [0.1, 0.1, 0.1]}
joints:
  - {type: prismatic, name: rail, a: ground.origin, b: mass.origin, axis: [1, 0, 0]}
forces:
  - {type: spring, name: drag, coordinate: rail.displacement, damping: 0.5 N s/m}
  - type: pid
    name: hold
    coordinate: rail.displacement
    reference: 1000 mm
    kp: 8 N/m
    ki: 4 N/m/s
    kd: 4 N s/m
    limit: 1.5 N
sensors:
  - {type: coordinate, name: y, coordinate: rail.displacement}
"""


def test_a_model_file_has_the_same_controller(tmp_path: Path) -> None:
    path = tmp_path / "loop.yaml"
    path.write_text(FILE)
    model = jo.compile(jo.read_model(path).mechanism)
    run, same = (jo.simulate(m, 2.0, solver=jo.RK4(1e-3)) for m in (model, jo.compile(cart())))
    np.testing.assert_array_equal(run["y"], same["y"])


def test_the_command_shows_the_force_at_rest(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the states of rest: without load the controller does nothing at its reference."""
    path = tmp_path / "loop.yaml"
    more = "  - {type: force, name: f, force: hold}\ngravity: [-3, 0, 0]\n"
    path.write_text(FILE.replace("limit: 1.5 N", "limit: 15 N") + more)
    with pytest.raises(SystemExit):
        app(["equilibrium", str(path)])
    said = capsys.readouterr().out
    assert re.search(r"sensor f +3 N", said) and re.search(r"sensor y +1 m", said)
    with pytest.raises(SystemExit):
        app(["check", str(path)])
    said = capsys.readouterr().out
    assert "rail.displacement, limit 15 N, reference 1 m, kp 8 N/m, ki 4 N/m/s, kd 4 N s/m" in said


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"kp": 0.0}, "filter is missing"),
        ({"kp": 0.0}, "tracking is missing"),
        ({"kp": 0.0, "ki": 0.0, "kd": 0.0}, "kp, ki and kd are all 0"),
        ({"limit": None, "lower": 0.0}, "lower needs limit"),
        ({"lower": 2.0}, "lower is 2, must be below the limit of 1.5"),
        ({"ki": -1.0}, "ki is -1, must not be negative"),
        ({"limit": -1.0}, "limit is -1, must not be negative; None for no limit"),
        ({"limit": 0.0}, "limit is 0: the controller has no effect; for a force that only"),
        ({"filter": 0.0}, "filter is 0 s, must be positive"),
    ],
)
def test_what_makes_no_sense_is_said(how: dict[str, Any], said: str) -> None:
    with pytest.raises(jo.InputError, match=said.replace("(", r"\(")):
        cart(**how)
