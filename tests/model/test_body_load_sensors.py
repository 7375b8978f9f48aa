"""Sensors of the loads of one kind on a body: closed forms, sums of every load by itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.mechanism import BodyLoadSensor, ModalLoadSensor
from jousto.mechanism.sensors.body_load import LOADS
from jousto.recovery.loads.own_loads import CORIOLIS, INERTIA, SPIN

Array = np.ndarray
G = 9.81
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
EXACT = jo.simulation.DormandPrince(tolerance=1e-12)

pytestmark = pytest.mark.filterwarnings("ignore:.*(moves freely|the first is kept|nothing will)")


def sensors(*bodies: Any) -> list[Any]:
    """Return a sensor of every kind of load on each body, "rod inertia", and on its modes."""
    found: list[Any] = [
        BodyLoadSensor(f"{body.name} {kind}", body, kind) for body in bodies for kind in LOADS
    ]
    for body in bodies:
        if isinstance(body, jo.FlexibleBody):
            for kind in LOADS:
                found.append(ModalLoadSensor(f"{body.name} {kind} modal", body, kind))
    return found


def rod(name: str, mass: float, length: float, **more: Any) -> jo.RigidBody:
    J = mass * length**2 / 12.0
    return jo.RigidBody(name, mass, (1e-3 * J, J, J), center=(length / 2.0, 0.0, 0.0), **more)


def crane(core: str, flexible: bool, measured: bool = True) -> jo.Model:
    """A boom on a slewing post, with friction, a spring, a drive, a servo and hanging rods."""
    part = jo.Part.beam(1.5, jo.Tube(0.06, 0.004), 4, STEEL, name="boom")
    reduced = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=3))
    post = jo.RigidBody("post", 8.0, (0.3, 0.3, 0.1), center=(0.0, 0.1, 0.4))
    place: dict[str, Any] = {"position": (0.1, 0.0, 0.9)}
    boom: Any = jo.FlexibleBody("boom", reduced, damping=0.02, **place)
    if not flexible:
        ends = {"start": (0, 0, 0), "end": (1.5, 0, 0)}
        boom = rod("boom", 12.0, 1.5, markers=ends, **place)
    load = rod("load", 3.0, 0.7, position=(1.6, 0.0, 0.9))
    slew = jo.Revolute("slew", jo.ground["origin"], post["origin"], (0, 0, 1))
    luff = jo.Revolute("luff", post.at((0.1, 0, 0.9)), boom["start"], (0, 1, 0))
    hook = jo.Spherical("hook", boom["end"], load["origin"])
    tail = rod("tail", 1.0, 0.4, position=(2.3, 0.0, 0.9))
    elbow = jo.Revolute("elbow", load.at((0.7, 0, 0)), tail["origin"], (0, 0, 1))
    rub = jo.Friction("rub", luff, 0.2, radius=0.05, law=jo.mechanism.Regularised(0.2))
    return jo.compile(
        jo.Mechanism(
            *(post, boom, load, tail, slew, luff, hook, elbow, jo.Gravity((0.3, 0, -G))),
            jo.Spring("soft", elbow.angle, 5.0, damping=0.2),
            jo.Drive("turn", slew.angle, jo.Harmonic(amplitude=0.4, frequency=1.0)),
            jo.Servo("hold", luff.angle, jo.Constant(0.1), kp=4e3, kd=60.0),
            jo.Spring("rope", jo.Distance(post.at((0, 0, 1.4)), boom["end"]), 2e3, damping=30.0),
            jo.Force("wind", load.at((0.7, 0, 0)), (0.0, 2.0, 0.0)),
            jo.Torque("twist", boom["end"], (1.0, 0.0, 2.0), follow=True),
            *(() if flexible and core == "joint" else (rub,)),
            *(sensors(post, boom, load, tail) if measured else ()),
        ),
        core=core,
    )


def gathered(loads: Any, kind: str) -> tuple[Array, Array]:
    """Return the sum (nt, 6) of the loads of a kind about the body's origin, and on the modes."""
    names = {"joint": ("joint", "coupling", "drive"), "inertia": (INERTIA, SPIN, CORIOLIS)}
    known = {kind for kinds in names.values() for kind in kinds} | set(LOADS)
    rows, modes = np.zeros((len(loads.time), 6)), 0.0
    for load in (loads[name] for name in loads):
        if load.kind in names.get(kind, (kind,)) or kind == "applied" and load.kind not in known:
            rows[:, :3] += load.force
            rows[:, 3:] += load.moment + np.cross(load.point, load.force)
            modes = modes + load.modal
    return rows, np.asarray(modes)


BODIES = ("post", "boom", "load", "tail")
CORES = [("joint", False), ("joint", True), ("maximal", False), ("maximal", True)]


@pytest.mark.parametrize(("core", "flexible"), CORES)
def test_sums_are_those_of_every_load_by_itself(core: str, flexible: bool) -> None:
    model = crane(core, flexible)
    assert bool(model.tree) == (core == "joint")
    run = jo.simulate(model, 0.3, solver=EXACT, output_step=0.05)
    for body in BODIES:
        loads = jo.recovery.loads_of(run, body)
        size = sum(np.abs(gathered(loads, kind)[0]).max(axis=0) for kind in LOADS)
        size = np.repeat([size[:3].max(), size[3:].max()], 3)
        for kind in LOADS:
            rows, modes = gathered(loads, kind)
            np.testing.assert_allclose(
                run[f"{body} {kind}"] / size, rows / size, atol=1e-9, err_msg=f"{body} {kind}"
            )
            if body == "boom" and flexible:
                scale = np.abs(run["boom elastic modal"]).max()
                np.testing.assert_allclose(
                    run[f"boom {kind} modal"] / scale, modes / scale, atol=1e-9, err_msg=kind
                )
    # no kind is tested on zeros alone
    rigid, smooth = not flexible, flexible and core == "joint"
    absent = [*LOADS[5:]] * rigid + ["friction"] * smooth
    for kind in set(LOADS) - set(absent):
        names = [f"{body} {kind}{end}" for body in BODIES for end in ("", " modal")]
        assert max(np.abs(run[name]).max() for name in names if name in run.sensors) > 0.1, kind


def rests(run: jo.Solution, flexible: bool) -> dict[str, float]:
    """Return what is left of the sum over all kinds, relative to their sizes; not at the start."""
    found = {}
    for body in BODIES:
        for end in ["", " modal"] if body == "boom" and flexible else [""]:
            parts = np.array([run[f"{body} {kind}{end}"] for kind in LOADS])
            total, size = parts.sum(axis=0), np.abs(parts).sum(axis=0).max()
            found[body + end] = np.abs(total[1:]).max() / size
    return found


def unchanged(run: jo.Solution, solver: Any, core: str, flexible: bool) -> bool:
    """Return whether a run without the sensors has the same bits."""
    model = crane(core, flexible, measured=False)
    other = jo.simulate(model, 0.02, solver=solver, output_step=0.005)
    return np.array_equal(run.q, other.q) and np.array_equal(run.v, other.v)


@pytest.mark.parametrize(("core", "flexible"), CORES)
@pytest.mark.parametrize("solver", [jo.RK4(step=1e-5), jo.ROS2(step=1e-4)], ids=["RK4", "ROS2"])
def test_loads_vanish_together_and_change_no_bit(solver: Any, core: str, flexible: bool) -> None:
    run = jo.simulate(crane(core, flexible), 0.02, solver=solver, output_step=0.005)
    for body, rest in rests(run, flexible).items():
        assert rest < 1e-9, body
    assert unchanged(run, solver, core, flexible)


@pytest.mark.parametrize("flexible", [False, True])
def test_rest_under_generalised_alpha_is_of_third_order(flexible: bool) -> None:
    """The state is moved onto the joints after the accelerations were found."""
    found = []
    for step in (2e-4, 1e-4):
        solver = jo.GeneralizedAlpha(step=step)
        run = jo.simulate(crane("maximal", flexible), 0.02, solver=solver, output_step=0.005)
        found.append(max(rests(run, flexible).values()))
        assert unchanged(run, solver, "maximal", flexible)
    assert found[1] < found[0] / 6 < 2e-6


def test_pin_force_of_a_rod_let_go_from_the_horizontal() -> None:
    """5/2 m g sin f along the rod and 1/4 m g cos f across it, at its frame in the pin."""
    bar = rod("bar", 2.0, 1.5)
    pin = jo.Revolute("pin", jo.ground["origin"], bar["origin"], axis=(0, 1, 0))
    mechanism = jo.Mechanism(
        bar, pin, jo.Gravity((0, 0, -G)), jo.CoordinateSensor("fall", pin.angle), *sensors(bar)
    )
    run = jo.simulate(jo.compile(mechanism), 0.6, solver=EXACT, output_step=0.02)
    fall = run["fall"][:, 0]
    np.testing.assert_allclose(run["bar joint"][:, 0], -2.5 * 2.0 * G * np.sin(fall), atol=1e-7)
    np.testing.assert_allclose(run["bar joint"][:, 2], 0.25 * 2.0 * G * np.cos(fall), atol=1e-7)
    # moment of the weight about the pin
    np.testing.assert_allclose(run["bar gravity"][:, 4], 2.0 * G * 0.75 * np.cos(fall), atol=1e-7)
    # a pin of one body bears no moment about its axis, and nothing else acts
    assert not run["bar applied"].any() and not run["bar friction"].any()


def test_sticking_friction_is_friction_and_no_joint() -> None:
    """A block on a rough slope of 15 degrees: m g sin a by friction, nothing of it by the rail."""
    block = jo.RigidBody("block", 2.0, (0.1, 0.1, 0.1))
    along = (np.cos(np.pi / 12), 0.0, -np.sin(np.pi / 12))
    rail = jo.Prismatic("rail", jo.ground["origin"], block["origin"], axis=along)
    rough = jo.Friction("rough", rail, 0.4, 0.5, law=jo.mechanism.StickSlip())
    model = jo.compile(jo.Mechanism(block, rail, rough, jo.Gravity((0, 0, -G)), *sensors(block)))
    run = jo.simulate(model, 0.05, output_step=0.01)
    held = run["block friction"][1:, :3] @ along
    np.testing.assert_allclose(held, -2.0 * G * np.sin(np.pi / 12), rtol=1e-9)
    np.testing.assert_allclose(run["block joint"][1:, :3] @ along, 0.0, atol=1e-9)
    np.testing.assert_allclose(run["block inertia"][1:], 0.0, atol=1e-9)


def test_what_a_body_does_not_have_is_refused() -> None:
    ball = jo.RigidBody("ball", 1.0, (1, 1, 1))
    with pytest.raises(InputError, match="must be a flexible body"):
        ModalLoadSensor("s", ball, "inertia")
    with pytest.raises(InputError, match="must be 'joint', 'applied', .* or 'damping'"):
        BodyLoadSensor("s", ball, "inertial")
