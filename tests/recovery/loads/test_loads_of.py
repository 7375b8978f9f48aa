"""Loads on a body of a run: closed forms, a separate Newton-Euler analysis, balance."""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.recovery import model_of_run
from jousto.recovery.fields.inertia import accelerations
from jousto.recovery.loads import gathered_loads
from jousto.schema.summary import mechanism_facts

Array = np.ndarray

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
G = 9.81
ROUND = 1e-9

pytestmark = pytest.mark.filterwarnings(
    "ignore:.*(moves freely|the first is kept|nothing will move):jousto.base.errors.JoustoWarning"
)


def rod(name: str, mass: float, length: float, start: float = 0.0, **more: object) -> jo.RigidBody:
    """Return a thin rod along x whose frame is at the origin, from x = start."""
    J = mass * length**2 / 12.0
    centre = (start + length / 2.0, 0.0, 0.0)
    return jo.RigidBody(name, mass, (1e-3 * J, J, J), center=centre, **more)


# ---- closed forms --------------------------------------------------------------------------------


def test_a_falling_body_has_weight_and_inertia_only() -> None:
    ball = jo.RigidBody("ball", 3.0, (1.0, 2.0, 3.0), center=(0.1, 0.2, 0.3))
    run = jo.simulate(jo.compile(jo.Mechanism(ball, jo.Gravity((0, 0, -G)))), 0.2)
    loads = jo.recovery.loads_of(run, "ball")
    assert list(loads) == ["gravity", "inertia", "centrifugal and gyroscopic"]
    assert np.allclose(loads["gravity"].force, (0, 0, -3 * G), rtol=1e-15)
    assert np.allclose(loads["inertia"].force, (0, 0, 3 * G), rtol=1e-12)
    assert np.abs(loads["inertia"].moment).max() < ROUND
    assert not loads.balance.any()


@pytest.mark.parametrize("core", ["joint", "maximal"])
def test_pin_force_of_a_rod_let_go_from_the_horizontal(core: str) -> None:
    """After the angle f the pin carries 5/2 m g sin f along the rod and 1/4 m g cos f across it."""
    bar = rod("bar", 2.0, 1.5)
    pin = jo.Revolute("pin", jo.ground["origin"], bar["origin"], axis=(0, 1, 0))
    model = jo.compile(jo.Mechanism(bar, pin, jo.Gravity((0, 0, -G))), core=core)
    assert bool(model.tree) == (core == "joint")
    run = jo.simulate(
        model, 0.8, solver=jo.simulation.DormandPrince(tolerance=1e-12), output_step=0.02
    )
    loads = jo.recovery.loads_of(run, "bar")
    fall = np.arctan2(-loads.rotation[:, 2, 0], loads.rotation[:, 0, 0])
    assert fall[-1] > 1.5
    force = loads["pin"].force
    assert np.allclose(force[:, 0], -2.5 * 2.0 * G * np.sin(fall), atol=1e-7)
    assert np.allclose(force[:, 2], 0.25 * 2.0 * G * np.cos(fall), atol=1e-7)
    assert loads["pin"].kind == "joint" and loads["pin"].place == "bar.origin"
    world = loads.resolved("world")["gravity"].force
    assert np.allclose(world, (0, 0, -2.0 * G), atol=1e-12)


@pytest.mark.parametrize("x", [0.0, 0.5, 1.2])
def test_axial_force_in_a_rotating_bar(x: float) -> None:
    """A bar turning about its end bears rho A w^2 (L^2 - x^2)/2 at the distance x."""
    rhoA, L, w = 6.28, 2.0, 30.0
    outer = rod("outer", rhoA * (L - x), L - x, x, angular_velocity=(0, 0, w))
    items: list[object] = [outer]
    hub = jo.ground["origin"]
    if x:
        inner = rod("inner", rhoA * x, x, angular_velocity=(0, 0, w))
        items += [inner, jo.Fixed("weld", inner.at((x, 0, 0)), outer.at((x, 0, 0)))]
        items += [jo.Revolute("hub", hub, inner["origin"], axis=(0, 0, 1))]
    else:
        items += [jo.Revolute("weld", hub, outer["origin"], axis=(0, 0, 1))]
    run = jo.simulate(jo.compile(jo.Mechanism(*items)), 0.05, output_step=0.01)
    loads = jo.recovery.loads_of(run, "outer")
    exact = rhoA * w**2 * (L**2 - x**2) / 2.0
    assert np.allclose(loads["weld"].force[:, 0], -exact, rtol=1e-9)
    assert np.allclose(loads["centrifugal and gyroscopic"].force[:, 0], exact, rtol=1e-9)


def test_gyroscopic_moment_of_a_wheel_on_a_turntable() -> None:
    """A wheel that spins with W about x on a table turning with w about z needs J W w about y."""
    table = jo.RigidBody("table", 5.0, (1, 1, 1), angular_velocity=(0, 0, 2.0))
    wheel = jo.RigidBody("wheel", 1.0, (0.4, 0.2, 0.2), angular_velocity=(50.0, 0, 2.0))
    post = jo.Revolute("post", jo.ground["origin"], table["origin"], axis=(0, 0, 1))
    axle = jo.Revolute("axle", table["origin"], wheel["origin"], axis=(1, 0, 0))
    run = jo.simulate(jo.compile(jo.Mechanism(table, wheel, post, axle)), 0.02, output_step=0.005)
    moment = jo.recovery.loads_of(run, "wheel")["axle"].moment
    # the wheel's frame turns with it: in the table's axes the moment is J W w about y
    world = jo.recovery.loads_of(run, "wheel").resolved("world")["axle"].moment
    assert np.allclose(np.linalg.norm(moment, axis=1), 0.4 * 50.0 * 2.0, rtol=1e-9)
    assert np.allclose(world[0], (0.0, 0.4 * 50.0 * 2.0, 0.0), atol=1e-8)


def test_forces_of_a_four_bar_equal_newton_euler() -> None:
    """Pin forces of a driven four-bar by a separate planar analysis with complex numbers."""
    a, b, c, d, w = 0.1, 0.35, 0.3, 0.32, 12.0
    masses = {"crank": 1.0, "coupler": 2.0, "rocker": 3.0}
    lengths = {"crank": a, "coupler": b, "rocker": c}

    def angles(t: complex) -> Array:
        """Return the angles of crank, coupler and rocker; t may be complex for derivatives."""
        one = w * t
        A = a * np.cos(one), a * np.sin(one)
        x, y = d - A[0], -A[1]
        r2 = x * x + y * y
        # intersection of the circles about the crank pin (b) and the ground pin (c)
        along = (r2 + b * b - c * c) / (2 * r2)
        across = np.sqrt(b * b / r2 - along * along)
        B = A[0] + along * x - across * y, A[1] + along * y + across * x
        two = np.arctan((B[1] - A[1]) / (B[0] - A[0]))
        # angle of the rocker from the ground pin by half-angle tangents, free of branches
        u, v = B[0] - d, B[1]
        three = 2 * np.arctan(v / (np.sqrt(u * u + v * v) + u))
        return np.array([one, two, three])

    def derivatives(t: float) -> tuple[Array, Array, Array]:
        h = 1e-4
        rate = [angles(t + s * h + 1e-30j).imag / 1e-30 for s in (-2, -1, 0, 1, 2)]
        second = (rate[0] - 8 * rate[1] + 8 * rate[3] - rate[4]) / (12 * h)
        return angles(t + 0j).real, rate[2], second

    start = angles(0j).real
    rate = derivatives(0.0)[1]
    bodies, places = {}, {"crank": (0.0, 0.0), "coupler": (a, 0.0), "rocker": (d, 0.0)}
    for k, (name, length) in enumerate(lengths.items()):
        x, y = places[name]
        speed = (0.0, a * w, 0.0) if name == "coupler" else (0.0, 0.0, 0.0)
        half = start[k] / 2.0
        bodies[name] = rod(
            name, masses[name], length, position=(x, y, 0.0), velocity=speed,
            orientation=(np.cos(half), 0, 0, np.sin(half)), angular_velocity=(0, 0, rate[k]),
        )  # fmt: skip
    crank, coupler, rocker = bodies.values()
    z = {"axis": (0, 0, 1)}
    frame = jo.ground.at((d, 0, 0))
    pin1 = jo.Revolute("O", jo.ground["origin"], crank["origin"], **z)
    # the loop is planar: a spherical and a universal joint leave no redundant rows
    pin2 = jo.Spherical("A", crank.at((a, 0, 0)), coupler["origin"])
    pin3 = jo.Universal(
        "B", coupler.at((b, 0, 0)), rocker.at((c, 0, 0)), axis_a=(0, 0, 1), axis_b=(0, 1, 0)
    )
    pin4 = jo.Revolute("C", frame, rocker["origin"], **z)
    motor = jo.Drive("motor", pin1.angle, jo.Ramp(0.0, 100.0, 0.0, 100.0 * w))
    machine = jo.Mechanism(crank, coupler, rocker, pin1, pin2, pin3, pin4, motor,
                           jo.Gravity((0, -G, 0)))  # fmt: skip
    run = jo.simulation.kinematics(jo.compile(machine), np.linspace(0.0, 0.5, 26))
    found = {name: jo.recovery.loads_of(run, name).resolved("world") for name in bodies}
    for k, t in enumerate(run.time):
        th, om, al = derivatives(float(t))
        e = np.stack([np.cos(th), np.sin(th)], axis=1)
        n = np.stack([-np.sin(th), np.cos(th)], axis=1)
        size = np.array(list(lengths.values()))[:, None]
        tip = size * (al[:, None] * n - om[:, None] ** 2 * e)  # acceleration of the end
        base = np.array([[0.0, 0.0], tip[0], [0.0, 0.0]])
        acc = base + 0.5 * tip
        m = np.array(list(masses.values()))
        # unknowns: forces on the crank at O and A, on the coupler at B, on the rocker at C, torque
        M, r = np.zeros((9, 9)), np.zeros(9)
        signs = {0: {0: 1, 1: 1}, 1: {1: -1, 2: 1}, 2: {2: -1, 3: 1}}
        ends = {0: {0: -1, 1: 1}, 1: {1: -1, 2: 1}, 2: {2: 1, 3: -1}}
        for body in range(3):
            r[3 * body : 3 * body + 2] = m[body] * (acc[body] + (0.0, G))
            r[3 * body + 2] = m[body] * size[body, 0] ** 2 / 12.0 * al[body]
            for pin, sign in signs[body].items():
                M[3 * body : 3 * body + 2, 2 * pin : 2 * pin + 2] = sign * np.eye(2)
                arm = 0.5 * size[body, 0] * ends[body][pin] * e[body]
                M[3 * body + 2, 2 * pin : 2 * pin + 2] = sign * np.array([-arm[1], arm[0]])
        M[2, 8] = 1.0
        x = np.linalg.solve(M, r)
        scale = np.abs(x).max()
        pairs = {
            ("crank", "O"): x[0:2],
            ("crank", "A"): x[2:4],
            ("coupler", "A"): -x[2:4],
            ("coupler", "B"): x[4:6],
            ("rocker", "B"): -x[4:6],
            ("rocker", "C"): x[6:8],
        }
        for (body_name, pin_name), force in pairs.items():
            assert np.allclose(found[body_name][pin_name].force[k, :2], force, atol=1e-6 * scale)
        assert found["crank"]["motor"].moment[k, 2] == pytest.approx(x[8], abs=1e-6 * scale)
        assert found["crank"]["motor"].kind == "drive"


# ---- balance -------------------------------------------------------------------------------------


def flexible() -> jo.Mechanism:
    """Return a bending and turning bar with a ball, springs, friction and loads of all places."""
    part = jo.Part.beam(1.0, jo.Rectangle(width=0.02, height=0.03), 6, STEEL)
    reduced = jo.reduce(part, jo.CraigBampton(["start", "end"], modes=4), stiffening=True)
    bar = jo.FlexibleBody("bar", reduced, damping=0.01)
    ball = jo.RigidBody("ball", 1.0, (0.1, 0.2, 0.3), position=(1, 0, 0), center=(0.02, 0.01, 0))
    pin = jo.Spherical("pin", jo.ground["origin"], bar["start"])
    hinge = jo.Revolute("hinge", bar["end"], ball["origin"], axis=(0, 0, 1))
    stay = jo.ground.at((0.3, 0.4, 0.5))
    return jo.Mechanism(
        bar, ball, pin, hinge,
        jo.Friction("rub", hinge, 0.2, radius=0.02),
        jo.Spring("coil", hinge.angle, 50.0, damping=0.1),
        jo.Spring("rope", jo.Distance(stay, bar["node4"]), 4e3, damping=5.0),
        jo.Bushing("mount", jo.ground.at((1, 0, 0.1)), ball["origin"],
                   np.diag([1e3, 2e3, 3e3, 10.0, 20.0, 30.0])),
        jo.Force("pull", bar["node3"], (0, 20, -100), follow=True),
        jo.Torque("twist", bar["end"], (5.0, 1.0, 2.0)),
        jo.mechanism.MovingLoad("trolley", bar, ("start", "end"), (0, 0, -50), jo.Ramp(0, 1, 0, 1)),
        jo.Gravity((1.0, 0, -G)),
    )  # fmt: skip


def sliding() -> jo.Mechanism:
    """Return a carriage on a bending rail, geared to a wheel, that drops a mass at an event."""
    part = jo.Part.beam(2.0, jo.Rectangle(width=0.05, height=0.05), 4, STEEL)
    rail = jo.FlexibleBody("rail", jo.reduce(part, jo.CraigBampton(["start", "end"], modes=3)))
    cart = jo.RigidBody("cart", 4.0, (0.1, 0.1, 0.1), position=(0, 0, 0), velocity=(0.5, 0, 0))
    load = jo.RigidBody("load", 2.0, (0.1, 0.1, 0.1), position=(0, 0, -0.2), velocity=(0.5, 0, 0))
    wheel = jo.RigidBody("wheel", 1.0, (0.1, 0.1, 0.1), angular_velocity=(0, 5.0, 0))
    foot = jo.Fixed("foot", jo.ground["origin"], rail["start"])
    slide = jo.Prismatic("slide", rail["start"], cart["origin"], axis=(1, 0, 0))
    hook = jo.Spherical("hook", cart.at((0, 0, -0.2)), load["origin"])
    axle = jo.Revolute("axle", jo.ground["origin"], wheel["origin"], axis=(0, 1, 0))
    place = jo.CoordinateSensor("place", slide.displacement)
    drop = jo.mechanism.Event("drop", place, 0.01, releases=hook)
    return jo.Mechanism(
        rail, cart, load, wheel, foot, slide, hook, axle, place, drop,
        jo.Rack("rack", axle.angle, slide.displacement, 0.1),
        jo.mechanism.Stop("buffer", slide.displacement, stiffness=1e4, upper=0.015),
        jo.Friction("rub", slide, 0.1, 0.2),
        jo.Gravity((0, 0, -G)),
    )  # fmt: skip


def spinning() -> jo.Mechanism:
    """Return a blade on a spinning hub whose frame is that of its root: I3 is not 0."""
    part = jo.Part.beam(1.0, jo.Rectangle(width=0.01, height=0.03), 4, STEEL)
    free = jo.reduce(part, jo.CraigBampton(["start", "end"], modes=2))
    reduced = jo.reduction.clamp(free, "start")
    assert np.abs(reduced.invariants.I3).max() > 0.1
    spin = {"velocity": (0.0, 1.5, 0.0), "angular_velocity": (0.0, 0.0, 15.0)}
    blade = jo.FlexibleBody("blade", reduced, position=(0.1, 0, 0), **spin)
    hub = jo.RigidBody("hub", 3.0, (0.1, 0.1, 0.1), angular_velocity=(0, 0, 15.0))
    axle = jo.Revolute("axle", jo.ground["origin"], hub["origin"], axis=(0, 0, 1))
    root = jo.Revolute("root", hub.at((0.1, 0, 0)), blade["start"], axis=(0, 1, 0))
    return jo.Mechanism(
        hub, blade, axle, root, jo.Force("hit", blade["end"], (0, 300, 200)),
        jo.Gravity((0, 0, -G)),
    )  # fmt: skip


MACHINES: dict[str, Callable[[], jo.Mechanism]] = {
    "flexible": flexible,
    "sliding": sliding,
    "spinning": spinning,
}


@pytest.mark.filterwarnings("ignore::jousto.base.errors.JoustoWarning")
@pytest.mark.parametrize("machine", MACHINES)
def test_all_loads_are_in_balance(machine: str) -> None:
    mechanism = MACHINES[machine]()
    run = jo.simulate(jo.compile(mechanism), 0.05, output_step=1e-3)
    for body in mechanism.bodies:
        loads = jo.recovery.loads_of(run, body.name)
        assert loads.balance.max() < ROUND
        # the sums by themselves: nothing hides behind a scale or a floor
        sums = sum(load.wrench for load in loads.loads)
        assert np.abs(sums).max() < ROUND * max(np.abs(x.wrench).max() for x in loads.loads)
        if loads.motion.p.shape[1]:
            modal = sum(load.modal for load in loads.loads)
            assert np.abs(modal).max() < ROUND * np.abs(loads["elastic"].modal).max()


@pytest.mark.filterwarnings("ignore::jousto.base.errors.JoustoWarning")
def test_every_kind_of_load_is_there_with_its_place() -> None:
    run = jo.simulate(jo.compile(flexible()), 0.01, output_step=1e-3)
    loads = jo.recovery.loads_of(run, "bar")
    kinds = {name: (load.kind, load.place) for name, load in loads.items()}
    assert kinds["hinge"] == ("joint", "bar.end") and kinds["rub"] == ("friction", "bar.end")
    assert kinds["trolley"] == ("moving load", "") and kinds["pull"] == ("force", "bar.node3")
    assert {"gravity", "inertia", "centrifugal and gyroscopic", "coriolis", "elastic", "damping"} \
        <= set(kinds)  # fmt: skip
    # the follower keeps its components in the body frame but for the small rotation of its node
    assert np.allclose(loads["pull"].force, (0, 20, -100), atol=3.0)
    other = jo.recovery.loads_of(run, "ball").resolved("world")["hinge"].force
    assert np.allclose(loads.resolved("world")["hinge"].force, -other, atol=1e-9)


@pytest.mark.filterwarnings("ignore::jousto.base.errors.JoustoWarning")
def test_a_load_that_is_left_out_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    run = jo.simulate(jo.compile(flexible()), 0.01, output_step=1e-3)
    whole = gathered_loads.sources
    monkeypatch.setattr(
        gathered_loads, "sources", lambda m, k: [x for x in whole(m, k) if x.name != "mount"]
    )
    with pytest.raises(jo.InputError, match=r"'ball': are not in balance: at .* s the sum of the"):
        jo.recovery.loads_of(run, "ball")


def test_an_elastic_body_at_rest_needs_no_loads() -> None:
    """Nothing acts: all sums are 0 and no scale is."""
    part = jo.Part.beam(1.0, jo.Circle(0.02), 2, STEEL)
    bar = jo.FlexibleBody("bar", jo.reduce(part, jo.CraigBampton(["start", "end"], modes=1)))
    loads = jo.recovery.loads_of(jo.simulate(jo.compile(jo.Mechanism(bar)), 0.01), "bar")
    assert not loads.balance.any() and "balance" in str(loads)


# ---- instants, files, errors ---------------------------------------------------------------------


def pendulum() -> tuple[jo.Model, jo.Solution]:
    bar = rod("bar", 2.0, 1.5)
    pin = jo.Revolute("pin", jo.ground["origin"], bar["origin"], axis=(0, 1, 0))
    model = jo.compile(jo.Mechanism(bar, pin, jo.Gravity((0, 0, -G))))
    return model, jo.simulate(model, 0.1, output_step=0.01)


def test_instants_between_stored_ones_are_in_balance() -> None:
    _, run = pendulum()
    loads = jo.recovery.loads_of(run, "bar", [0.034, 0.05])
    assert loads.time.tolist() == [0.034, 0.05] and loads.balance.max() < ROUND
    whole = jo.recovery.loads_of(run, "bar")
    assert np.allclose(loads["pin"].force[1], whole["pin"].force[5], rtol=1e-12)
    mixed = 0.6 * whole["pin"].force[3] + 0.4 * whole["pin"].force[4]
    assert np.allclose(loads["pin"].force[0], mixed, rtol=1e-12)
    with pytest.raises(jo.InputError, match="0.2 s is outside the run"):
        jo.recovery.loads_of(run, "bar", 0.2)


def test_results_of_a_file_need_their_model(tmp_path: Path) -> None:
    model, run = pendulum()
    stored = jo.load(run.save(tmp_path / "run.h5"))
    with pytest.raises(jo.InputError, match="give its model"):
        jo.recovery.loads_of(stored, "bar")
    force = jo.recovery.loads_of(stored, "bar", model=model)["pin"].force
    assert np.array_equal(force, jo.recovery.loads_of(run, "bar")["pin"].force)
    other = jo.compile(jo.Mechanism(rod("bar", 1.0, 1.0)))
    with pytest.raises(jo.InputError, match="is not that of"):
        jo.recovery.loads_of(stored, "bar", model=other)
    again = pickle.loads(pickle.dumps(run))
    assert np.array_equal(jo.recovery.loads_of(again, "bar")["pin"].force, force)


def test_unknown_names_and_beams_are_refused() -> None:
    _, run = pendulum()
    with pytest.raises(jo.InputError, match="did you mean 'bar'"):
        jo.recovery.loads_of(run, "baa")
    with pytest.raises(jo.InputError, match="did you mean 'pin'"):
        jo.recovery.loads_of(run, "bar")["pim"]
    with pytest.raises(jo.InputError, match="'body' or 'world'"):
        jo.recovery.loads_of(run, "bar").resolved("ground")  # type: ignore[arg-type]
    beam = jo.BeamBody("cable", [(0, 0, 0), (1, 0, 0)], jo.Circle(0.02), STEEL, elements=2)
    base = jo.Fixed("base", jo.ground["origin"], beam["start"])
    bent = jo.simulate(jo.compile(jo.Mechanism(beam, base)), 0.01)
    for name in ("cable", "cable.node1"):
        with pytest.raises(jo.InputError, match=r"exact beam; jo\.recovery\.section_forces\("):
            jo.recovery.loads_of(bent, name)


def test_a_table_has_all_loads(tmp_path: Path) -> None:
    _, run = pendulum()
    loads = jo.recovery.loads_of(run, "bar")
    path = loads.to_csv(tmp_path / "loads.csv", [0.05])
    rows = [line.split(",") for line in path.read_text().splitlines()]
    assert rows[0][:4] == ["time (s)", "load", "kind", "place"] and len(rows) == 1 + len(loads)
    total = np.sum([[float(x) for x in row[7:10]] for row in rows[1:]], axis=0)
    assert np.abs(total).max() < ROUND
    with pytest.raises(jo.InputError, match=r"must end with \.csv"):
        loads.to_csv(tmp_path / "loads.txt")


# ---- the model of results ------------------------------------------------------------------------


def slider(
    mass: float = 2.0, g: float = -G, push: float = 0.0, stiffness: float = 0.0, spin: float = 0.1
) -> jo.Model:
    """Return a pendulum with a reaction sensor, or other forces in the same layout."""
    arm = jo.RigidBody("arm", mass, (spin, spin, spin), center=(0.5, 0, 0))
    pin = jo.Revolute("pin", jo.ground["origin"], arm["origin"], axis=(0, 1, 0))
    items: list[object] = [arm, pin, jo.Gravity((0, 0, g)), jo.ReactionSensor("R", pin)]
    if push:
        items.append(jo.JointForce("push", pin.angle, jo.Constant(push)))
    if stiffness:
        items.append(jo.Spring("spring", pin.angle, stiffness))
    return jo.compile(jo.Mechanism(*items))


@pytest.mark.parametrize(
    ("other", "told"),
    [
        ({"mass": 20.0}, "20 kg, in the results 2 kg"),
        ({"g": -1.62}, r"gravity is \(0, 0, -1.62\) m/s2, in the results \(0, 0, -9.81\) m/s2"),
        ({"spin": 0.2}, "kinetic energy at"),
        ({"stiffness": 30.0}, "springs energy at"),
        ({"push": 3.0}, "sensor 'R' at"),
        ({"push": 3.0}, "reaction of 'pin' at"),
    ],
)
@pytest.mark.parametrize("implicit", [False, True])
def test_a_model_that_is_not_that_of_the_results_is_refused(
    other: dict[str, float], told: str, implicit: bool, tmp_path: Path
) -> None:
    solver = jo.GeneralizedAlpha(1e-3) if implicit else None
    run = jo.simulate(slider(), 0.3, output_step=0.01, solver=solver)
    stored = jo.load(run.save(tmp_path / "run.h5"))
    force = jo.recovery.loads_of(stored, "arm", model=slider())["pin"].force
    world = np.einsum("tab,tb->ta", jo.recovery.loads_of(run, "arm").rotation, force)
    assert np.allclose(world, run["R"][:, :3], rtol=1e-2, atol=0.1)
    for call in (
        lambda: jo.recovery.loads_of(stored, "arm", model=slider(**other)),
        lambda: accelerations(stored, slider(**other)),
    ):
        with pytest.raises(jo.InputError, match=told):
            call()


def test_a_force_along_a_free_motion_is_told(tmp_path: Path) -> None:
    """It changes neither energies nor reactions, but the accelerations."""

    def ball(push: float) -> jo.Model:
        one = jo.RigidBody("ball", 1.0, (1, 1, 1))
        force = [jo.Force("push", one["origin"], (push, 0, 0))] if push else []
        return jo.compile(jo.Mechanism(one, jo.Gravity((0, 0, -G)), *force))

    still, pushed = ball(0.0), ball(5.0)
    stored = jo.load(jo.simulate(still, 0.2, output_step=0.01).save(tmp_path / "run.h5"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        jo.recovery.loads_of(stored, "ball", model=still)
    with pytest.warns(jo.JoustoWarning, match="accelerations of model .* other forces"):
        jo.recovery.loads_of(stored, "ball", model=pushed)


@pytest.mark.filterwarnings("error:.*accelerations of model")
@pytest.mark.parametrize("step", [1.3e-3, 2.0 * np.pi * 1e-3])
def test_vibrations_between_stored_instants_are_no_other_forces(step: float) -> None:
    """A period is 2 pi ms: stored rarely, velocities do not show the accelerations."""
    ball = jo.RigidBody("ball", 1.0, (1, 1, 1), velocity=(1, 0, 0))
    way = jo.Displacement(jo.ground["origin"], ball["origin"], axis="x")
    model = jo.compile(jo.Mechanism(ball, jo.Spring("stiff", way, 1e6)))
    run = jo.simulate(model, 20 * step, output_step=step, solver=jo.RK4(1e-4))
    jo.recovery.loads_of(run, "ball", model=replace(model))


def test_an_empty_choice_is_refused() -> None:
    _, run = pendulum()
    loads = jo.recovery.loads_of(run, "bar")
    with pytest.raises(jo.InputError, match="no load of kind 'jont'; did you mean 'joint'"):
        loads.of_kind("jont")
    for call in (lambda: loads.at([]), lambda: jo.recovery.loads_of(run, "bar", [])):
        with pytest.raises(jo.InputError, match="at least one instant"):
            call()


def test_forces_have_the_kind_that_was_declared() -> None:
    arm = rod("arm", 2.0, 1.0)
    pin = jo.Revolute("pin", jo.ground["origin"], arm["origin"], axis=(0, 1, 0))
    forces = [
        jo.Spring("soft", pin.angle, 10.0),
        jo.Servo("drive", pin.angle, 0.2, 10.0, 1.0),
        jo.mechanism.Stop("end", pin.angle, upper=1.0, stiffness=1e5),
        jo.mechanism.PlasticSpring("yield", pin.angle, 1e4, 10.0),
        jo.mechanism.PID("control", pin.angle, 0.3, kp=10.0),
        jo.JointForce("push", pin.angle, jo.Constant(1.0)),
    ]
    mechanism = jo.Mechanism(arm, pin, *forces)
    run = jo.simulate(jo.compile(mechanism), 0.01, output_step=0.005)
    loads = jo.recovery.loads_of(run, "arm")
    assert {f.name: loads[f.name].kind for f in forces} == {f.name: f.kind for f in forces}
    rows = [label for label, _ in mechanism_facts(mechanism)]
    assert "plastic spring yield" in rows and "servo drive" in rows


def test_integrals_over_three_instants_are_exact_for_a_parabola() -> None:
    """Also where they are not equally far apart."""
    t = np.array([0.3, 0.5, 1.2])
    c = np.array([[1.0, -2.0, 3.0], [0.5, 4.0, -1.0]])
    y = np.stack([t**0, t, t**2], axis=1) @ c.T
    exact = c @ [t[2] - t[0], (t[2] ** 2 - t[0] ** 2) / 2, (t[2] ** 3 - t[0] ** 3) / 3]
    found, _, _ = model_of_run._simpson(t, y)
    assert found == pytest.approx(exact, rel=1e-14)
