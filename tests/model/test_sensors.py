"""Sensors against the engine's own derivatives, laws of mechanics and closed forms."""

from __future__ import annotations

import dataclasses
import inspect

import numpy as np
import pytest

import jousto as jo
from jousto.base.declare import kinds
from verification.mechanisms import SECTION, SOFT, chain, rod

pytestmark = pytest.mark.filterwarnings(
    "ignore:.*(moves freely|nothing will move|constraint rows|redundant|cannot move)"
)

TINY = 1e-30
X = (1.0, 0.0, 0.0)
Z = (0.0, 0.0, 1.0)

SENSORS = tuple(kinds("sensors", "jousto.mechanism.sensors").values())


def ball(name="ball", **more):
    """Return a rigid body of 2 kg with its centre of mass in its origin."""
    return jo.RigidBody(name, 2.0, (0.3, 0.35, 0.4), markers={"tip": (0.7, -0.2, 0.1)}, **more)


def start(*items):
    """Return the engine at the initial state, and the values of all sensors by name."""
    return values(jo.model.Engine(jo.compile(jo.Mechanism(*items))))


def values(engine):
    """Return the sensors of a state after its accelerations, by name."""
    engine.accelerations()
    found = engine.sensors().real
    return {s.name: found[s.offset : s.offset + s.count].copy() for s in engine.model.sensors}


# -- derivatives ------------------------------------------------------------------------------


def stiff_rod():
    """Return a beam whose second-order displacements are kept."""
    part = jo.Part.beam(1.0, SECTION, 4, SOFT, theory=jo.parts.EulerBernoulli())
    return jo.reduce(part, jo.CraigBampton(("start", "end"), modes=1), stiffening=True)


def moving(reduced):
    """Return two flexible bodies that turn in space, and motion sensors of every kind."""
    arm = jo.FlexibleBody("arm", reduced, angular_velocity=(0.5, -1.0, 2.0), damping=0.01)
    hand = jo.FlexibleBody(
        "hand", reduced, position=(1.0, 0, 0), velocity=(0.0, 2.0, 1.0),
        angular_velocity=(1.0, 0.5, 3.0), orientation=jo.Rotate((1, 2, 3), degrees=20.0),
    )  # fmt: skip
    tip = hand["end"].turned(jo.Rotate((1, 1, 0), degrees=30))
    seat = arm["node3"].turned(jo.Rotate(Z, degrees=50))
    pairs = (
        ("position", jo.PositionSensor), ("velocity", jo.VelocitySensor),
        ("acceleration", jo.AccelerationSensor), ("turn", jo.OrientationSensor),
        ("spin", jo.AngularVelocitySensor), ("wheel", jo.mechanism.AngularAccelerationSensor),
    )  # fmt: skip
    sensors = [make(f"{key} world", tip) for key, make in pairs]
    sensors += [make(f"{key} seen", tip, relative_to=seat) for key, make in pairs]
    sensors += [make(f"{key} own", tip, relative_to=seat, resolved_in=tip) for key, make in pairs]
    sensors += [
        made(f"{kind} {body.name}", body, kind)
        for body, made in ((arm, jo.mechanism.BodyLoadSensor), (hand, jo.mechanism.ModalLoadSensor))
        for kind in ("joint", "gravity", "inertia", "elastic", "damping")
    ]
    origin = jo.ground["origin"]
    sensors += [
        make(f"{key} seen, world", tip, relative_to=seat, resolved_in=origin) for key, make in pairs
    ]
    return jo.Mechanism(
        arm, hand, jo.Spherical("pivot", origin, arm["start"]),
        jo.Spherical("elbow", arm["end"], hand["start"]), jo.Gravity((0, 0, -9.81)), *sensors,
    )  # fmt: skip


@pytest.fixture(scope="module", params=["linear", "stiffening"])
def derivatives(request):
    """Sensors of a bent, turning mechanism, and their exact time derivatives."""
    model = jo.compile(moving(rod() if request.param == "linear" else stiff_rod()))
    rng = np.random.default_rng(4)
    q, v = model.q0.copy(), model.v0.copy()
    for b in model.bodies:
        bend = 0.3 if request.param == "linear" else 0.1
        q[b.iq + 7 : b.iq + 7 + b.n] += bend * rng.uniform(0.5, 1, b.n) / (1 + np.arange(b.n))
        v[b.iv + 6 : b.iv + 6 + b.n] += rng.normal(size=b.n)
    engine = jo.model.Engine(model)
    engine.q[:], engine.v[:] = q, v
    engine.assemble()
    found = values(engine)
    q, v, a = engine.q.copy(), engine.v.copy(), engine.a.copy()
    # a complex step along the motion: q + i h q', v + i h a
    twin = jo.model.Engine(model, complex_scalars=True)
    twin.q[:] = q
    moves = twin.increments()
    twin.q += 1j * TINY * (moves @ v)
    twin.v[:] = v + 1j * TINY * a
    twin.accelerations()
    rates = twin.sensors().imag / TINY
    named = {s.name: rates[s.offset : s.offset + s.count] for s in model.sensors}
    return found, named


@pytest.mark.parametrize("how", ["world", "seen"])
@pytest.mark.parametrize(
    ("quantity", "rate"),
    [("position", "velocity"), ("velocity", "acceleration"), ("spin", "wheel")],
)
def test_each_sensor_is_the_derivative_of_the_one_before(derivatives, quantity, rate, how):
    # by a complex step: no truncation, round-off of both sides only
    found, rates = derivatives
    expected = rates[f"{quantity} {how}"]
    scale = np.abs(expected).max()
    assert scale > 1.0
    np.testing.assert_allclose(found[f"{rate} {how}"], expected, rtol=0, atol=1e-12 * scale)


@pytest.mark.parametrize("how", ["world", "seen"])
def test_angular_velocity_is_that_of_the_orientation(derivatives, how):
    # w = 2 e' o conj(e), vector part, resolved in the axes that the turn starts from
    found, rates = derivatives
    e, rate = found[f"turn {how}"], rates[f"turn {how}"]
    spin = 2 * (e[0] * rate[1:] - rate[0] * e[1:] + np.cross(e[1:], rate[1:]))
    np.testing.assert_allclose(found[f"spin {how}"], spin, rtol=0, atol=1e-12 * abs(spin).max())


def test_resolving_turns_the_components(derivatives):
    found, _ = derivatives
    A = rotation(found["turn world"])
    R = rotation(found["turn seen"])
    for key in ("position", "velocity", "acceleration", "spin", "wheel"):
        np.testing.assert_allclose(A.T @ found[f"{key} seen, world"], found[f"{key} own"], 1e-11)
        np.testing.assert_allclose(R.T @ found[f"{key} seen"], found[f"{key} own"], 1e-11)
    # the axis of a turn is the same in both of its frames
    np.testing.assert_allclose(found["turn seen"], found["turn own"], atol=1e-13)
    axis = found["turn seen, world"][1:]
    np.testing.assert_allclose(A.T @ axis, found["turn own"][1:], atol=1e-13)


def rotation(e):
    """Return the rotation matrix of Euler parameters."""
    w, x = e[0], np.asarray(e[1:])
    S = np.array([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]])
    return np.eye(3) + 2 * w * S + 2 * S @ S


@pytest.mark.filterwarnings("ignore:.*static work")
def test_accelerations_are_the_differences_of_velocities_of_a_run():
    # central differences over two steps of a rough motion: error h^2/6 a'' only
    base = chain("fixed", loads=True)
    tip = base.bodies[-1]["end"]
    sensors = [jo.VelocitySensor("v", tip), jo.AccelerationSensor("a", tip)]
    sensors += [
        jo.AngularVelocitySensor("w", tip),
        jo.mechanism.AngularAccelerationSensor("w'", tip),
    ]
    model = jo.compile(jo.Mechanism(*base.items, *sensors))
    errors = []
    for h in (2e-4, 1e-4):
        run = jo.simulate(model, 0.02, solver=jo.RK4(step=h))
        both = []
        for rate, second in (("v", "a"), ("w", "w'")):
            slope = (run[rate][2:] - run[rate][:-2]) / (2 * h)
            both.append(np.abs(slope - run[second][1:-1]).max() / np.abs(slope).max())
        errors.append(both)
    assert np.all(np.array(errors[1]) < 0.27 * np.array(errors[0]))
    assert np.max(errors[1]) < 2e-2


# -- laws -------------------------------------------------------------------------------------


def test_free_fall_is_the_acceleration_of_gravity():
    body = ball()
    found = start(
        body, jo.Gravity((0, 0, -9.81)), jo.AccelerationSensor("a", body["tip"]),
        jo.mechanism.AngularAccelerationSensor("w'", body["tip"]),
    )  # fmt: skip
    np.testing.assert_allclose(found["a"], (0, 0, -9.81), rtol=1e-14)
    np.testing.assert_allclose(found["w'"], 0, atol=1e-14)


def test_a_turning_arm_feels_the_centripetal_acceleration_in_its_own_axes():
    """a = -w^2 r: along -x of the arm in its own axes, turned with it in the world."""
    spin, radius, turn = 3.0, 0.8, 35.0
    arm = jo.RigidBody(
        "arm", 2.0, (0.3, 0.3, 0.3), center=(0.4, 0, 0), markers={"tip": (radius, 0, 0)},
        orientation=jo.Rotate(Z, degrees=turn), angular_velocity=(0, 0, spin),
    )  # fmt: skip
    hinge = jo.Revolute("hinge", jo.ground["origin"], arm["origin"], Z)
    found = start(
        arm, hinge,
        jo.AccelerationSensor("world", arm["tip"]),
        jo.AccelerationSensor("own", arm["tip"], resolved_in=arm["tip"]),
        jo.AccelerationSensor("seen", arm["tip"], relative_to=arm["origin"]),
    )  # fmt: skip
    c, s = np.cos(np.deg2rad(turn)), np.sin(np.deg2rad(turn))
    a = spin**2 * radius
    np.testing.assert_allclose(found["own"], (-a, 0, 0), atol=1e-12)
    np.testing.assert_allclose(found["world"], (-a * c, -a * s, 0), atol=1e-12)
    np.testing.assert_allclose(found["seen"], 0, atol=1e-12)


def test_coriolis_and_euler_terms_of_an_observer_on_a_turntable():
    """A free mass: a_world = 0, so an observer sees 2 u x W + (W x d) x W - W' x d."""
    spin, torque = 2.0, 0.9
    table = ball("table", angular_velocity=(0, 0, spin))
    hinge = jo.Revolute("hinge", jo.ground["origin"], table["origin"], Z)
    motor = jo.JointForce("motor", hinge.angle, torque)
    mass = ball("mass", position=(0.5, 0.3, 0.2), velocity=(1.5, -0.4, 0.6))
    seen = {"relative_to": table["origin"]}
    found = start(
        table, hinge, motor, mass,
        jo.VelocitySensor("u", mass["origin"], **seen),
        jo.AccelerationSensor("a", mass["origin"], **seen),
        jo.AccelerationSensor("world", mass["origin"]),
    )  # fmt: skip
    W, W1 = np.array([0, 0, spin]), np.array([0, 0, torque / 0.4])
    d, v = np.array([0.5, 0.3, 0.2]), np.array([1.5, -0.4, 0.6])
    u = v - np.cross(W, d)
    np.testing.assert_allclose(found["u"], u, atol=1e-13)
    expected = -2 * np.cross(W, u) - np.cross(W, np.cross(W, d)) - np.cross(W1, d)
    np.testing.assert_allclose(found["a"], expected, atol=1e-12)
    np.testing.assert_allclose(found["world"], 0, atol=1e-13)


def test_forces_on_a_free_body_add_up_to_its_mass_times_acceleration():
    """m a = sum F and J w' = sum M + sum r x F about the centre of mass, w = 0."""
    body = ball(orientation=jo.Rotate((1, 2, 3), degrees=40.0))
    ground, tip, origin = jo.ground.at((0.1, 0.2, 0.9)), body["tip"], body["origin"]

    def thrust(t, x):
        return (3.0, x[0], 2.0, 0.1, 0.2, -0.3)

    forces = (
        jo.Spring.between("spring", ground, tip, stiffness=40.0, free=0.3),
        jo.Bushing("bushing", ground, origin, (30, 40, 50, 3, 4, 5)),
        jo.Force("follow", tip, (5.0, 1.0, -2.0), follow=True),
        jo.Torque("torque", origin, (0.5, -0.2, 0.7)),
        jo.UserForce("user", origin, thrust),
    )
    where = {"spring": tip, "bushing": origin, "follow": tip, "torque": origin, "user": origin}
    found = start(
        body, *forces, *[jo.ForceSensor(f.name, f) for f in forces],
        jo.AccelerationSensor("a", origin), jo.mechanism.AngularAccelerationSensor("w'", origin),
    )  # fmt: skip
    along = (tip.r - ground.r) / np.linalg.norm(tip.r - ground.r)
    F = {
        "spring": found["spring"] * along, "bushing": found["bushing"][:3],
        "follow": found["follow"], "torque": np.zeros(3), "user": found["user"][:3],
    }  # fmt: skip
    M = found["bushing"][3:] + found["torque"] + found["user"][3:]
    M = M + sum(np.cross(where[k].r - body.position, f) for k, f in F.items())
    A = np.asarray(origin.A)
    J = A @ np.diag([0.3, 0.35, 0.4]) @ A.T
    np.testing.assert_allclose(2.0 * found["a"], sum(F.values()), rtol=1e-12)
    np.testing.assert_allclose(J @ found["w'"], M, rtol=1e-12)
    assert found["spring"].shape == (1,)
    assert found["follow"].shape == (3,)


def test_a_force_that_follows_keeps_its_components_in_the_axes_it_follows():
    body = ball(orientation=jo.Rotate((1, 2, 3), degrees=40.0))
    push = jo.Force("push", body["tip"], (5.0, 1.0, -2.0), follow=True)
    twist = jo.Torque("twist", body["tip"], (1.0, 2.0, 3.0), follow=True)
    axes = {"resolved_in": body["tip"]}
    found = start(
        body, push, twist, jo.ForceSensor("f", push, **axes), jo.ForceSensor("m", twist, **axes)
    )
    np.testing.assert_allclose(found["f"], (5, 1, -2), rtol=1e-13)
    np.testing.assert_allclose(found["m"], (1, 2, 3), rtol=1e-13)


def test_servo_and_actuator_forces_are_along_their_coordinate():
    block = ball()
    slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], X)
    servo = jo.Servo("servo", slide.displacement, 0.5, 100.0, limit=20.0)
    push = jo.JointForce("push", slide.displacement, -7.0)
    found = start(block, slide, servo, push, jo.ForceSensor("s", servo), jo.ForceSensor("p", push),
                  jo.AccelerationSensor("a", block["origin"]))  # fmt: skip
    assert found["s"] == pytest.approx(20.0)  # 50 N, limited
    assert found["p"] == pytest.approx(-7.0)
    np.testing.assert_allclose(found["a"], (6.5, 0, 0), atol=1e-13)


@pytest.mark.parametrize(
    "law", [jo.mechanism.Regularised(1e-4), jo.mechanism.StickSlip()], ids=["smooth", "stick"]
)
def test_friction_of_a_block_that_slides(law):
    """Coulomb: mu m g against the slip; the kinetic law holds far above the slip speed."""
    block = ball(velocity=(-0.5, 0, 0))
    slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], X)
    rub = jo.Friction("rub", slide, 0.2, law=law)
    sensors = (jo.ForceSensor("f", rub), jo.AccelerationSensor("a", block["origin"]))
    found = start(block, slide, rub, jo.Gravity((0, 0, -10.0)), *sensors)
    assert found["f"] == pytest.approx(0.2 * 2.0 * 10.0, rel=1e-12)
    assert found["a"][0] == pytest.approx(2.0, rel=1e-12)
    assert sensors[0].unit == "N"
    assert sensors[0].description == "friction rub along slide.displacement"


def test_friction_that_holds_is_as_large_as_the_push():
    block = ball()
    slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], X)
    rub = jo.Friction("rub", slide, 0.2, law=jo.mechanism.StickSlip())
    push = jo.JointForce("push", slide.displacement, 3.0)
    model = jo.compile(
        jo.Mechanism(block, slide, rub, push, jo.Gravity((0, 0, -10)), jo.ForceSensor("f", rub))
    )
    run = jo.simulate(model, 0.01, solver=jo.RK4(step=1e-3))
    np.testing.assert_allclose(run["f"], -3.0, rtol=1e-9)


def test_friction_of_a_cylindrical_joint_has_two_parts():
    ring = ball(velocity=(0.3, 0, 0), angular_velocity=(4.0, 0, 0))
    shaft = jo.Cylindrical("shaft", jo.ground["origin"], ring["origin"], X)
    rub = jo.Friction("rub", shaft, 0.1, radius=0.1, law=jo.mechanism.StickSlip())
    sensor = jo.ForceSensor("f", rub)
    found = start(ring, shaft, rub, jo.Gravity((0, 0, -10.0)), sensor)
    # 0.3 m/s along and 0.4 m/s around: 3/5 and 4/5 of mu N
    assert sensor.components == tuple(s.name for s in rub.coordinates)
    assert set(sensor.unit.split(", ")) == {"N", "N m"}
    along, about = sorted(zip(sensor.unit.split(", "), found["f"], strict=True))
    assert along[1] == pytest.approx(-0.6 * 2.0, rel=1e-12)
    assert about[1] == pytest.approx(-0.8 * 2.0 * 0.1, rel=1e-12)


@pytest.mark.filterwarnings("ignore:.*static work")
def test_modal_load_gives_its_resultant():
    part = rod()
    body = jo.FlexibleBody("body", part, orientation=jo.Rotate(Z, degrees=90.0))
    pattern = np.zeros((len(part.nodes), 3))
    pattern[2], pattern[-1] = (0.0, 4.0, 0.0), (1.0, 2.0, 3.0)
    load = jo.mechanism.ModalLoad("load", body, pattern, jo.Constant(0.5))
    found = start(body, load, jo.ForceSensor("r", load))
    force = pattern.sum(axis=0)
    moment = np.cross(part.nodes, pattern).sum(axis=0)
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    expected = 0.5 * np.concatenate([turn @ force, turn @ moment])
    np.testing.assert_allclose(found["r"], expected, atol=1e-13)


# -- reactions --------------------------------------------------------------------------------


@pytest.mark.parametrize("slid", [0.0, 0.7])
def test_the_moment_of_a_slide_is_about_its_marker_b(slid):
    """100 N at 0.3 m beyond marker b bends the slide by 30 N m there, wherever b has slid to; about
    marker a, on the ground, it is 100 (0.3 + slid) N m. Statics of a held slide."""
    block = jo.RigidBody("block", mass=2.0, inertia=(1, 1, 1), position=(slid, 0, 0))
    slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    weight = jo.Force("weight", block.at((0.3, 0, 0)), (0, 0, -100.0))
    sensor = jo.ReactionSensor("r", slide)
    found = start(block, slide, weight, sensor)["r"]
    np.testing.assert_allclose(found, [0, 0, 100.0, 0, -30.0, 0], atol=1e-11)
    about_a = found[3:] + np.cross([slid, 0, 0], found[:3])
    np.testing.assert_allclose(about_a, [0, -100.0 * (0.3 + slid), 0], atol=1e-11)
    assert sensor.description == "reaction of slide on block, moment about block.origin"


@pytest.mark.parametrize("degrees", [0.0, 25.0, -70.0])
def test_pendulum_reaction_in_joint_axes(degrees):
    """Angle th from straight down: Newton's law along and across the arm gives
    m (g cos th + c w^2) and m (g sin th + c th''), with (J + m c^2) th'' = -m g c sin th."""
    mass, c, J, g, spin = 2.0, 0.9, 0.3, 9.81, 1.7
    th = np.deg2rad(degrees)
    bar = jo.RigidBody(
        "bar", mass, (0.2, 0.2, J), center=(c, 0, 0),
        orientation=jo.Rotate(Z, degrees=degrees - 90.0),
        angular_velocity=(0, 0, spin),
    )  # fmt: skip
    seat = jo.ground["origin"].turned(jo.Rotate(Z, degrees=20.0))
    hinge = jo.Revolute("hinge", seat, bar["origin"], Z)
    found = start(
        bar, hinge, jo.Gravity((0, -g, 0)), jo.ReactionSensor("world", hinge),
        jo.ReactionSensor("joint", hinge, resolved_in="joint"),
        jo.ReactionSensor("arm", hinge, resolved_in=bar["origin"]),
    )  # fmt: skip
    second = -mass * g * c * np.sin(th) / (J + mass * c**2)
    along, across = mass * (g * np.cos(th) + c * spin**2), mass * (g * np.sin(th) + c * second)
    np.testing.assert_allclose(found["arm"], (-along, across, 0, 0, 0, 0), atol=1e-11)
    turn = rotation(np.asarray(bar.orientation))
    np.testing.assert_allclose(found["world"][:3], turn @ found["arm"][:3], atol=1e-11)
    # the frames of the joint are those of marker a, turned by 20 degrees
    A = np.asarray(hinge.frames[0].A)
    np.testing.assert_allclose(A, np.asarray(seat.A), atol=1e-15)
    np.testing.assert_allclose(found["joint"][:3], A.T @ found["world"][:3], atol=1e-11)


def test_drive_torque_of_a_driven_pendulum():
    """J phi'' + m g c sin phi: inertia and weight of a bar that follows phi(t)."""
    mass, c, J0, g = 3.0, 0.6, 0.2, 9.81
    bar = jo.RigidBody("bar", mass, (0.1, 0.1, J0), center=(0, -c, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], bar["origin"], Z)
    swing = jo.Harmonic(frequency=0.8, amplitude=0.7)
    drive = jo.Drive("drive", hinge.angle, swing)
    model = jo.compile(
        jo.Mechanism(bar, hinge, drive, jo.Gravity((0, -g, 0)), jo.ReactionSensor("M", drive))
    )
    run = jo.simulation.kinematics(model, np.linspace(0.0, 1.3, 14))
    w = 2 * np.pi * 0.8
    phi, second = 0.7 * np.sin(w * run.time), -0.7 * w**2 * np.sin(w * run.time)
    expected = (J0 + mass * c**2) * second + mass * g * c * np.sin(phi)
    np.testing.assert_allclose(run["M"][:, 0], expected, atol=1e-9)
    assert run.about("M")["unit"] == "N m"
    assert run.about("M")["components"] == ("f",)


def test_a_rack_and_pinion_push_each_other():
    """M of the pinion and F of the rack do no work together: M phi' + F s' = 0, s' = r phi'."""
    pinion, block = ball("pinion"), ball("block", position=(0, 0.1, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], pinion["origin"], Z)
    slide = jo.Prismatic("slide", jo.ground.at((0, 0.1, 0)), block["origin"], X)
    rack = jo.Rack("rack", hinge.angle, slide.displacement, 0.1)
    push = jo.Force("push", block["origin"], (12.0, 0, 0))
    sensor = jo.ReactionSensor("r", rack)
    found = start(pinion, block, hinge, slide, rack, push, sensor)
    # both sides by themselves: J phi'' = M, m s'' = 12 + F
    a = 12.0 / (2.0 + 0.4 / 0.1**2)
    np.testing.assert_allclose(found["r"], (0.4 * a / 0.1, 2.0 * a - 12.0), rtol=1e-12)
    assert sensor.unit == "N m, N"
    assert sensor.components == ("hinge.angle", "slide.displacement")


def test_reactions_that_are_not_unique_say_so():
    a, b = ball("a"), ball("b", position=(0, 0, 1.0))
    one = jo.Revolute("one", jo.ground["origin"], a["origin"], Z)
    two = jo.Fixed("two", a["origin"], b.at((0, 0, -1.0)))
    three = jo.Revolute("three", jo.ground.at((0, 0, 1.0)), b["origin"], Z)
    extra = ball("c", position=(3, 0, 0))
    four = jo.Revolute("four", jo.ground.at((3, 0, 0)), extra["origin"], Z)
    joints = (one, two, three, four)
    with pytest.warns(jo.JoustoWarning, match="not unique"):
        model = jo.compile(
            jo.Mechanism(
                a, b, extra, *joints, jo.Gravity((0, -9.81, 0)),
                *[jo.ReactionSensor(f"r {x.name}", x) for x in joints],
            )
        )  # fmt: skip
    flagged = {s.name: "(not unique: least norm)" in s.description for s in model.sensors}
    assert flagged == {"r one": True, "r two": True, "r three": True, "r four": False}


# -- stress and strain ------------------------------------------------------------------------


def cantilever(load):
    """Return a tip-loaded cantilever with all its modes, at rest under the load, and sensors."""
    section = jo.Rectangle(0.02, 0.04)
    steel = jo.Material(E=210e9, nu=0.3, rho=7850.0)
    part = jo.Part.beam(0.5, section, 3, steel, theory=jo.parts.EulerBernoulli())
    beam = jo.FlexibleBody("beam", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=12)))
    clamp = jo.Fixed("clamp", jo.ground["origin"], beam["start"])
    kinds = (jo.StressSensor, jo.VonMisesSensor, jo.mechanism.PrincipalStressSensor)
    site = "e1.a.top"
    sensors = [kind(kind.__name__, beam, site) for kind in kinds]
    sensors += [
        jo.gauges.Gauge("along", beam, site),
        jo.gauges.Gauge("across", beam, site, (0, 1, 0)),
        jo.gauges.Gauge("oblique", beam, site, (1, 1, 0)),
        jo.gauges.Gauge("between", beam, (0.1, 0.0, 0.02)),
    ]
    if load == "bending":
        pull = jo.Force(
            "load", beam["end"], (0, 0, -10.0)
        )  # N, small: a bent beam has a shorter arm
    elif load == "tension":
        pull = jo.Force("load", beam["end"], (8000.0, 0, 0))
    else:
        pull = jo.Torque("load", beam["end"], (50.0, 0, 0))
    model = jo.compile(jo.Mechanism(beam, clamp, pull, *sensors))
    state = jo.equilibrium(model)
    engine = jo.model.Engine(model)
    engine.q[:], engine.v[:] = state.q, 0.0
    return values(engine), section


def test_bending_strain_of_a_cantilever():
    """e = M y / (E I), nu times that across, and linear along the beam."""
    found, section = cantilever("bending")
    strain = 10.0 * 0.5 * 0.02 / (210e9 * section.Iy)
    assert found["along"][0] == pytest.approx(strain, rel=1e-6)
    assert found["across"][0] == pytest.approx(-0.3 * strain, rel=1e-6)
    # Mohr's circle at 45 degrees; the shear stress of bending is zero at the top
    assert found["oblique"][0] == pytest.approx(0.35 * strain, rel=1e-6)
    assert found["between"][0] == pytest.approx(0.8 * strain, rel=1e-6)


def test_uniaxial_stress():
    found, _ = cantilever("tension")
    s = 8000.0 / (0.02 * 0.04)
    np.testing.assert_allclose(found["StressSensor"], (s, 0, 0, 0, 0, 0), atol=1e-6 * s)
    assert found["VonMisesSensor"][0] == pytest.approx(s, rel=1e-6)
    np.testing.assert_allclose(found["PrincipalStressSensor"], (s, 0, 0), atol=1e-6 * s)


def test_pure_shear():
    """von Mises sqrt(3) tau, principal +-tau, strain tau / 2G at 45 degrees."""
    found, _ = cantilever("torsion")
    tau = np.linalg.norm(found["StressSensor"][3:])
    assert tau > 1e6
    np.testing.assert_allclose(found["StressSensor"][:3], 0, atol=1e-6 * tau)
    assert found["VonMisesSensor"][0] == pytest.approx(np.sqrt(3) * tau, rel=1e-9)
    np.testing.assert_allclose(found["PrincipalStressSensor"], (tau, 0, -tau), atol=1e-6 * tau)
    s12 = found["StressSensor"][3]
    G = 210e9 / 2.6
    assert found["oblique"][0] == pytest.approx(s12 / (2 * G), rel=1e-6)


def test_principal_stresses_are_eigenvalues(rng):
    part = rod()
    body = jo.FlexibleBody("b", part, modal_coordinates=rng.normal(size=part.n))
    # random stress modes: six full components
    stress = type(part.stress)(
        ("one", "two"), np.zeros((2, 3)), np.stack([np.eye(3)] * 2),
        1e6 * rng.normal(size=(2, 6, part.n)),
    )  # fmt: skip
    body = jo.FlexibleBody(
        "b", dataclasses.replace(part, stress=stress), modal_coordinates=rng.normal(size=part.n)
    )
    found = start(body, jo.StressSensor("s", body), jo.mechanism.PrincipalStressSensor("p", body),
                  jo.VonMisesSensor("m", body))  # fmt: skip
    for k in range(2):
        s = found["s"][6 * k : 6 * k + 6]
        S = np.array([[s[0], s[3], s[5]], [s[3], s[1], s[4]], [s[5], s[4], s[2]]])
        expected = np.linalg.eigvalsh(S)[::-1]
        size = np.abs(expected).max()
        p = found["p"][3 * k : 3 * k + 3]
        np.testing.assert_allclose(p, expected, atol=1e-13 * size)
        mises = np.sqrt(((p[0] - p[1]) ** 2 + (p[1] - p[2]) ** 2 + (p[2] - p[0]) ** 2) / 2)
        assert found["m"][k] == pytest.approx(mises, rel=1e-12)
    with pytest.raises(
        jo.InputError, match=r"E is missing; give it, part '.*' has no material data"
    ):
        jo.gauges.Gauge("e", body, "one")
    strain = jo.gauges.Gauge("e", body, "one", (0, 0, 1), E=2e11, nu=0.25)
    found = start(body, strain, jo.StressSensor("s", body))
    s = found["s"]
    assert found["e"][0] == pytest.approx((s[2] - 0.25 * (s[0] + s[1])) / 2e11, rel=1e-12)


def test_every_sensor_says_what_it_is():
    """Every class of sensor: as many components as the engine writes, unit and description."""
    beam = jo.FlexibleBody("beam", rod())
    hinge = jo.Revolute("hinge", jo.ground["origin"], beam["start"], Z)
    spring = jo.mechanism.PlasticSpring("spring", hinge.angle, 1.0, 9.0)  # it has states, too
    rope = jo.BeamBody("rope", [(0, 0, 0), (1, 0, 0)], jo.Circle(0.05), SOFT, elements=3)
    root = jo.Fixed("root", jo.ground["origin"], rope["start"])
    words = jo.mechanism
    ground, ball = jo.ground.at((0, 0, -5)), words.Sphere(0.01)
    law = words.Hertz.between(SOFT, SOFT)
    touch = words.Contact("touch", ground, words.HalfSpace(), beam["end"], ball, law)
    rail = words.RailContact(
        "rail", jo.ground.at((0, 0, -7)), beam["end"], 0.46, 0.05, axle=(0, 1, 0)
    )
    floor = words.CollisionShape("floor", jo.ground.at((0, 0, -6)), words.HalfSpace())
    tip = words.CollisionShape("tip", beam["end"], ball)
    given = {
        "contacts": words.Contacts("meet", [floor, tip], law=law), "contact": touch,
        "a": "floor", "b": "tip", "of": 2.0 * words.value(hinge.angle),
        "beam": rope, "marker": beam["end"], "body": beam, "joint": hinge, "force": spring,
        "coordinate": hinge.angle, "energy": "kinetic", "signal": jo.Step(1.0), "at": "e1.a.top",
        "load": "joint", "sn": jo.SN(S_D=1e8, N_D=1e6, k=5), "residue": "half",
        "arms": jo.gauges.Gauge("arm", beam, "e1.a.top"),
    }  # fmt: skip
    sensors = []
    for kind in SENSORS:
        needed = [
            key for key, p in inspect.signature(kind).parameters.items()
            if p.default is p.empty and key != "name"
        ]  # fmt: skip
        of_it = given | ({"contact": rail} if kind is words.RailContactSensor else {})
        sensors.append(kind(name=kind.__name__, **{key: of_it[key] for key in needed}))
        if kind is jo.StressSensor:
            given["sensor"] = sensors[-1]
    model = jo.compile(
        jo.Mechanism(
            *(beam, rope, hinge, root, spring, touch, rail, given["contacts"]),
            jo.Gravity((0, -9.81, 0)),
            *sensors,
        )
    )
    for sensor in model.sensors:
        units = sensor.unit.split(", ")
        assert sensor.count == len(sensor.components) > 0, sensor.name
        assert sensor.count % len(units) == 0, sensor.name
        assert all(units), sensor.name
        assert sensor.description, sensor.name
        assert sensor.resolved_in, sensor.name
    run = jo.simulate(model, 0.01, solver=jo.GeneralizedAlpha(step=1e-3))
    assert set(run.sensors) == {kind.__name__ for kind in SENSORS}
    for name in run.sensors:
        assert np.isfinite(run[name]).all()
        assert jo.plot(run, name) is not None
