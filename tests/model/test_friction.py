"""Friction of joints: its force, what it acts on, what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.model.native.native import Engine, displaced
from jousto.simulation.modes.linear import body_frame_increments
from verification.mechanisms import rod

pytestmark = pytest.mark.filterwarnings("ignore:.*nothing will move")

MU, STATIC = 0.3, 0.4
LENGTHS = {
    "revolute": {"radius": 0.04, "bearing_length": 0.2, "collar_radius": 0.06},
    "prismatic": {"bearing_length": 0.2, "collar_radius": 0.05},
    "cylindrical": {"radius": 0.04, "bearing_length": 0.2},
}
KINDS = {"revolute": jo.Revolute, "prismatic": jo.Prismatic, "cylindrical": jo.Cylindrical}
FAST = jo.mechanism.Regularised(0.5)  # m/s, so that the smooth part of the law is used


def machine(kind, *, flexible=True, law=None, spin=True, friction=True, extra=(), preload=2.0):
    """A carrier on a spherical joint and an arm on a joint with friction, moving in space."""
    w = np.array([0.4, -0.7, 1.1]) * spin
    axis = np.array([0.2, 1.0, 0.4]) / np.linalg.norm([0.2, 1.0, 0.4])
    if flexible:
        a = jo.FlexibleBody("carrier", rod(), angular_velocity=w)
    else:
        a = jo.RigidBody(
            *("carrier", 5.0, (0.02, 0.4, 0.4)),
            center=(0.5, 0, 0),
            markers={"start": (0, 0, 0), "end": (1, 0, 0)},
            angular_velocity=w,
        )
    end = np.array([1.0, 0.0, 0.0])
    own = w + (3.0 * axis if kind != "prismatic" else 0.0) * spin
    v = np.cross(w, end) + (0.6 * axis if kind != "revolute" else 0.0) * spin
    pose = {"position": end, "velocity": v, "angular_velocity": own}
    pose["orientation"] = jo.Rotate((0.3, 1.0, 0.2), degrees=50.0)
    if flexible:
        b = jo.FlexibleBody("arm", rod(), **pose)
    else:
        b = jo.RigidBody("arm", 4.0, (0.02, 0.3, 0.3), markers={"start": (0, 0, 0)}, **pose)
    joint = KINDS[kind]("joint", a["end"], b["start"], axis=axis)
    rub = jo.Friction("rub", joint, MU, STATIC, law=law, preload=preload, **LENGTHS[kind])
    return jo.Mechanism(
        a,
        b,
        jo.Spherical("pivot", jo.ground["origin"], a["start"]),
        joint,
        *((rub,) if friction else ()),
        jo.Gravity((0, 0, -9.81)),
        jo.ReactionSensor("reaction", joint, resolved_in="joint"),
        *(x(joint) for x in extra),
    )


def law_of(speed, velocity):
    """The regularised law as its docstring says it."""
    w = speed / velocity
    if w < 1:
        return STATIC * w * (15 - 10 * w**2 + 3 * w**4) / 8
    x = min(w - 1, 1.0)
    return STATIC + (MU - STATIC) * x**3 * (10 - 15 * x + 6 * x**2)


def expected(kind, y, rates, law):
    """Friction along the joint's coordinates from the reaction in joint axes and the rates."""
    size = LENGTHS[kind]
    N = 2.0 + np.hypot(*y[:2]) + np.hypot(*y[3:5]) / size["bearing_length"]
    if kind == "prismatic":
        N += abs(y[5]) / size["collar_radius"]
        arms = np.array([1.0])
    else:
        arms = np.array([size["radius"]] if kind == "revolute" else [1.0, size["radius"]])
    slip = arms * rates
    speed = np.linalg.norm(slip)
    mu = MU if isinstance(law, jo.mechanism.StickSlip) else law_of(speed, law.velocity)
    force = -mu * N * arms * slip / speed
    if kind == "revolute":
        force -= mu * size["collar_radius"] * abs(y[2]) * np.sign(rates)
    return force


LAWS = [
    jo.mechanism.StickSlip(),
    jo.mechanism.Regularised(1e-3),
    FAST,
    jo.mechanism.Regularised(0.2),
]


@pytest.mark.parametrize("law", LAWS, ids=repr)
@pytest.mark.parametrize("flexible", [False, True], ids=["rigid", "flexible"])
@pytest.mark.parametrize("kind", KINDS)
def test_the_force_fits_the_reaction_that_it_changes(kind, flexible, law):
    model = jo.compile(machine(kind, flexible=flexible, law=law))
    engine = jo.model.Engine(model)
    engine.accelerations()
    known = {"revolute": [3.0], "prismatic": [0.6], "cylindrical": [0.6, 3.0]}[kind]
    force = expected(kind, engine.sensors()[:6], np.array(known), law)
    assert engine.rub[: len(force)] == pytest.approx(force, rel=1e-10)
    assert not engine.rub[len(force) :].any()
    # and it matters: without friction the reaction is another
    free = jo.model.Engine(jo.compile(machine(kind, flexible=flexible, friction=False)))
    free.accelerations()
    assert np.abs(free.lam[:3] - engine.lam[:3]).max() > 1e-3


@pytest.mark.parametrize("kind", KINDS)
def test_it_acts_on_bodies_and_modes_like_a_force_along_the_coordinate(kind):
    """The same accelerations as with that force given, elastic modes included."""
    engine = jo.model.Engine(jo.compile(machine(kind, law=FAST)))
    a, lam = (x.copy() for x in engine.accelerations())
    f = engine.rub[: 2 if kind == "cylindrical" else 1]

    def given(k):
        return lambda joint: jo.JointForce(f"push {k}", joint.coordinates[k], float(f[k]))

    twin = jo.model.Engine(
        jo.compile(machine(kind, friction=False, extra=[given(k) for k in range(len(f))]))
    )
    b, mu = twin.accelerations()
    modes = engine.model.bodies[1].iv + 6
    assert b == pytest.approx(a, rel=1e-9, abs=1e-9 * np.abs(a).max())
    assert mu == pytest.approx(lam, rel=1e-9, abs=1e-9 * np.abs(lam).max())
    free = jo.model.Engine(jo.compile(machine(kind, friction=False)))
    assert np.abs(free.accelerations()[0] - a)[modes:].max() > 0.1  # the modes feel it


@pytest.mark.parametrize("law", [jo.mechanism.StickSlip(), FAST], ids=repr)
@pytest.mark.parametrize("kind", KINDS)
def test_the_residual_holds_the_same_friction(kind, law):
    engine = jo.model.Engine(jo.compile(machine(kind, law=law)))
    a, _ = engine.accelerations()
    assert np.abs(engine.residual()).max() < 1e-9 * np.abs(a).max()
    engine.lam[:] *= 1.1  # friction follows the multipliers that are given
    before = engine.rub.copy()
    engine.residual()
    assert engine.rub[0] / before[0] > 1.05


@pytest.mark.parametrize(
    "law", [jo.mechanism.StickSlip(), FAST, jo.mechanism.Regularised(0.4)], ids=repr
)
@pytest.mark.parametrize("kind", KINDS)
def test_newtons_matrix_knows_how_friction_follows_rates_and_multipliers(kind, law):
    """Against complex steps of the residual."""
    engine = jo.model.Engine(jo.compile(machine(kind, law=law)))
    engine.row()  # what moves is said to slip
    nv, rows = engine.model.nv, engine.model.permanent
    twin = jo.model.Engine(engine.model, complex_scalars=True)
    for name in jo.model.native.native.STATE:
        getattr(twin, name)[:] = getattr(engine, name)
    wanted = np.zeros((nv, nv + rows))
    for x, start in ((twin.v, 0), (twin.lam, nv)):
        for j in range(nv if start == 0 else rows):
            kept = x[j]
            x[j] += 1e-30j
            wanted[:, start + j] = twin.residual().imag / 1e-30
            x[j] = kept
    engine.residual()
    rates = engine.newton_matrix(0.0, 1.0, 0.0)[:nv, : nv + rows]
    np.testing.assert_allclose(rates, wanted, rtol=0, atol=1e-11 * np.abs(wanted).max())
    plain = jo.model.Engine(jo.compile(machine(kind, friction=False)))
    plain.accelerations()
    frictionless = plain.newton_matrix(0.0, 1.0, 0.0)[:nv, nv : nv + rows]
    assert np.abs(frictionless - rates[:, nv:]).max() > 1e-3


@pytest.mark.parametrize("law", [jo.mechanism.StickSlip(), FAST], ids=repr)
@pytest.mark.parametrize("kind", KINDS)
def test_linearised_motion_holds_its_derivatives(kind, law):
    """The complex step passes the iteration: against differences of the accelerations."""
    model = jo.compile(machine(kind, law=law))
    steps = jo.model.Engine(model, complex_scalars=True)
    plain = jo.model.Engine(model)
    rng = np.random.default_rng(3)
    dq, dv = rng.normal(size=(2, model.nv))
    dq, dv = body_frame_increments(model, model.q0) @ dq * 1e-2, dv * 1e-2
    steps.q[:] = displaced(model, model.q0, 1e-30j * dq)
    steps.v[:] = model.v0 + 1e-30j * dv
    exact = steps.accelerations()[0].imag / 1e-30
    found = []
    for h in (1e-6, -1e-6):
        plain.q[:], plain.v[:] = displaced(model, model.q0, h * dq), model.v0 + h * dv
        found.append(plain.accelerations()[0].copy())
    difference = (found[0] - found[1]) / 2e-6
    assert np.abs(exact - difference).max() < 1e-5 * np.abs(exact).max()


def slope(mu, angle, law, static=None, velocity=0.0):
    """A block on an incline of `angle`, rad; x along the slope, downwards."""
    along = np.array([np.cos(angle), 0.0, -np.sin(angle)])
    block = jo.RigidBody("block", 2.0, (0.1, 0.1, 0.1), velocity=velocity * along)
    joint = jo.Prismatic("slope", jo.ground["origin"], block["origin"], axis=along)
    return jo.compile(
        jo.Mechanism(
            block,
            joint,
            jo.Gravity((0, 0, -9.81)),
            jo.Friction("rub", joint, mu, static, law=law),
            jo.CoordinateSensor("s", joint.displacement),
            jo.RateSensor("rate", joint.displacement),
        )
    )


def test_a_block_on_an_incline_slides_as_coulomb_says():
    mu, angle = 0.3, 0.4
    a = 9.81 * (np.sin(angle) - mu * np.cos(angle))
    run = jo.simulate(slope(mu, angle, jo.mechanism.StickSlip()), 1.0, solver=jo.RK4(step=0.01))
    assert run["s"].ravel() == pytest.approx(0.5 * a * run.time**2, abs=1e-13)
    v = 1e-4
    run = jo.simulate(slope(mu, angle, jo.mechanism.Regularised(v)), 0.1, solver=jo.RK4(step=1e-5))
    assert abs(run["s"].ravel()[-1] - 0.5 * a * 0.1**2) < v * 0.1


def test_a_block_below_its_angle_of_friction_stays_for_ever():
    angle = np.arctan(0.3) - 1e-6
    run = jo.simulate(
        slope(0.1, angle, jo.mechanism.StickSlip(), static=0.3), 20.0, solver=jo.RK4(0.01)
    )
    assert np.abs(run["s"]).max() < 1e-14
    steep = jo.simulate(slope(0.1, angle + 2e-6, jo.mechanism.StickSlip(), static=0.3), 1.0)
    assert steep["s"].ravel()[-1] > 0.5
    # the regularised law creeps, with less than its velocity
    run = jo.simulate(slope(0.3, angle, jo.mechanism.Regularised(1e-3)), 1.0, solver=jo.RK4(1e-4))
    assert 1e-4 < run["s"].ravel()[-1] < 1e-3


def test_a_block_pushed_upwards_stops_and_holds_or_comes_back():
    mu, angle, v = 0.5, 0.4, -1.0
    stop = -v / (9.81 * (np.sin(angle) + mu * np.cos(angle)))
    run = jo.simulate(
        slope(mu, angle, jo.mechanism.StickSlip(), velocity=v), 0.5, solver=jo.RK4(1e-4)
    )
    assert run["s"].ravel()[-1] == pytest.approx(0.5 * v * stop, rel=1e-3)
    assert run["rate"].ravel()[-1] == 0.0 or abs(run["rate"].ravel()[-1]) < 1e-14
    run = jo.simulate(
        slope(0.2, angle, jo.mechanism.StickSlip(), velocity=v), 1.0, solver=jo.RK4(1e-4)
    )
    assert run["rate"].ravel()[-1] > 1.0


def test_a_ring_on_a_shaft_is_stopped_along_the_direction_of_its_slip():
    """J = m r^2: the slip velocity (s', r phi') keeps its direction and falls by mu P / m."""
    m, r, mu, P = 2.0, 0.1, 0.3, 40.0
    ring = jo.RigidBody(
        "ring",
        m,
        m * r**2 * np.array([0.6, 0.6, 1.0]),
        velocity=(0, 0, 0.8),
        angular_velocity=(0, 0, 6),
    )
    joint = jo.Cylindrical("shaft", jo.ground["origin"], ring["origin"])
    model = jo.compile(
        jo.Mechanism(
            ring,
            joint,
            jo.Friction("rub", joint, mu, radius=r, preload=P, law=jo.mechanism.StickSlip()),
            jo.CoordinateSensor("s", joint.displacement),
            jo.CoordinateSensor("phi", joint.angle),
        )
    )
    run = jo.simulate(model, 0.3, solver=jo.RK4(1e-4))
    T = m * 1.0 / (mu * P)  # |slip| = hypot(0.8, 0.6) = 1 m/s
    assert T < 0.3
    t = np.minimum(run.time, T)
    way = t - 0.5 * t**2 / T
    assert run["s"].ravel() == pytest.approx(0.8 * way, abs=1e-7)
    assert r * run["phi"].ravel() == pytest.approx(0.6 * way, abs=1e-7)
    assert run.energy.friction[-1] == pytest.approx(0.5 * m, rel=1e-8)


def loaded_ring(share):
    """A ring of 2 kg and 0.1 m on a shaft, pulled and twisted by a share of what friction holds."""
    r, mu, P = 0.1, 0.3, 40.0
    ring = jo.RigidBody("ring", 2.0, (0.01, 0.01, 0.02))
    joint = jo.Cylindrical("shaft", jo.ground["origin"], ring["origin"])
    load = share * mu * P
    model = jo.compile(
        jo.Mechanism(
            *(ring, joint),
            jo.Friction("rub", joint, 0.2, mu, radius=r, preload=P, law=jo.mechanism.StickSlip()),
            jo.JointForce("pull", joint.displacement, 0.8 * load),
            jo.JointForce("twist", joint.angle, -0.6 * load * r),
            jo.CoordinateSensor("s", joint.displacement),
            jo.CoordinateSensor("phi", joint.angle),
        )
    )
    return jo.simulate(model, 0.1, solver=jo.RK4(1e-3))


def test_a_ring_on_a_shaft_holds_while_friction_bears_force_and_torque_together():
    run = loaded_ring(0.9999)
    assert max(np.abs(run["s"]).max(), np.abs(run["phi"]).max()) < 1e-20


def test_a_ring_on_a_shaft_slips_where_force_and_torque_together_exceed_friction():
    run = loaded_ring(1.0001)
    # then mu_kinetic: 0.1 mu P is left, along the load at first; 1 %: the load's share
    first = run["s"][2, 0], 0.1 * run["phi"][2, 0]
    expected = np.array([0.8 / 2.0, -0.6 * 0.1**2 / 0.02]) * 4.0 * 2e-6
    assert first == pytest.approx(expected, rel=1e-2)


def test_the_direction_of_slip_may_turn_all_the_way_round():
    """A ring that springs along a shaft and turns slowly, against its two equations."""
    from scipy.integrate import solve_ivp

    m, r, J, k, mu, P = 2.0, 0.1, 0.02, 800.0, 0.05, 10.0
    ring = jo.RigidBody(*("ring", m, (J, J, J)), velocity=(0, 0, 0.8), angular_velocity=(0, 0, 1.0))
    joint = jo.Cylindrical("shaft", jo.ground["origin"], ring["origin"])
    model = jo.compile(
        jo.Mechanism(
            *(ring, joint),
            jo.Spring("spring", joint.displacement, k),
            jo.Friction("rub", joint, mu, radius=r, preload=P, law=jo.mechanism.StickSlip()),
            jo.CoordinateSensor("s", joint.displacement),
            jo.CoordinateSensor("phi", joint.angle),
        )
    )
    run = jo.simulate(model, 0.6, solver=jo.RK4(2e-4))

    def motion(_, y):
        speed = np.hypot(y[2], r * y[3])
        return [*y[2:], -(k * y[0] + mu * P * y[2] / speed) / m, -mu * P * r**2 * y[3] / speed / J]

    exact = solve_ivp(motion, (0, 0.6), [0, 0, 0.8, 1.0], rtol=1e-11, atol=1e-13, method="DOP853").y
    assert exact[2].min() < -0.5 < 0.5 < exact[3].min()  # it has turned, and does not stop
    assert run["s"][-1, 0] == pytest.approx(exact[0, -1], abs=1e-8)
    assert run["phi"][-1, 0] == pytest.approx(exact[1, -1], abs=1e-8)


def sleeve(mu, load=0.0):
    """A sleeve of length L = 0.5 m on a pole, weight and a moment at the arm e = 0.5 m."""
    body = jo.RigidBody("sleeve", 1.0, (0.1, 0.1, 0.1), center=(0.5, 0, 0), velocity=(0, 0, -1))
    joint = jo.Prismatic("pole", jo.ground["origin"], body["origin"])
    rub = jo.Friction("rub", joint, mu, bearing_length=0.5, preload=1.0)
    items = [body, joint, rub, jo.Gravity((0, 0, -9.81))]
    if load:
        items.append(jo.Torque("bend", body["origin"], (0, -0.5 * load, 0)))
    return jo.compile(jo.Mechanism(*items))


def test_friction_that_jams_is_said():
    """f = mu (1 + f e / L): the weight hangs in it; beyond mu e / L = 1 nothing fits."""
    engine = jo.model.Engine(sleeve(0.8))
    engine.accelerations()
    assert engine.rub[0] == pytest.approx(0.8 / (1 - 0.8), rel=1e-9)
    with pytest.raises(jo.InputError, match=r"friction 'rub'.*joint 'pole'.*jams.*lower mu"):
        sleeve(1.2)


@pytest.mark.parametrize(("mu", "load"), [(1.1, 2.0), (1.2, 5.0), (2.0, 20.0), (3.0, 20.0)])
def test_of_two_solutions_the_one_that_begins_without_friction_is_taken(mu, load):
    """f = mu (1 + |f - load|) has a second one where f outgrows the load."""
    engine = jo.model.Engine(sleeve(mu, load))
    engine.accelerations()
    assert abs(engine.rub[0]) == pytest.approx(mu * (1 + load) / (1 + mu), rel=1e-9)


def hinge():
    body = jo.RigidBody("arm", 1.0, (0.1, 0.1, 0.1), center=(0.5, 0, 0))
    return body, jo.Revolute("hinge", jo.ground["origin"], body["origin"])


def bad(**changes):
    given = {"name": "rub", "joint": hinge()[1], "mu_kinetic": 0.2, "radius": 0.1} | changes
    return jo.Friction(**given)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        (
            {"joint": jo.Spherical("ball", *(hinge()[1].a, hinge()[1].b))},
            "acts on Revolute, Prismatic",
        ),
        ({"radius": None}, "radius is missing: the pin radius"),
        ({"radius": 0.0}, "radius is 0 m, must be a positive number"),
        ({"mu_kinetic": -0.1}, "mu_kinetic is -0.1, must not be negative"),
        ({"mu_kinetic": 0.0}, "never acts; leave the friction out"),
        ({"mu_static": 0.1}, "mu_static is 0.1, must not be below mu_kinetic, 0.2"),
        ({"preload": -3.0}, "preload is -3 N, must not be negative"),
        ({"bearing_length": np.nan}, "bearing_length"),
        ({"law": "stick"}, r"must be Regularised\(velocity\) or StickSlip\(\)"),
    ],
)
def test_bad_input_gets_a_sentence(changes, sentence):
    with pytest.raises(jo.InputError, match=sentence):
        bad(**changes)


def test_lengths_that_carry_nothing_get_a_sentence():
    body = hinge()[0]
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"])
    with pytest.raises(jo.InputError, match="a prismatic joint does not turn"):
        jo.Friction("rub", slide, 0.1, radius=0.1)
    pin = jo.Cylindrical("pin", jo.ground["origin"], body["origin"])
    with pytest.raises(jo.InputError, match="no force along its axis that could load a collar"):
        jo.Friction("rub", pin, 0.1, radius=0.1, collar_radius=0.1)
    with pytest.raises(jo.InputError, match="velocity is 0 m/s"):
        jo.mechanism.Regularised(0.0)


def test_a_mechanism_refuses_frictions_that_cannot_be():
    body, joint = hinge()
    drive = jo.Drive("motor", joint.angle, jo.Ramp(0, 1))
    stick = jo.Friction("stick", joint, 0.2, radius=0.1, law=jo.mechanism.StickSlip())
    with pytest.raises(jo.InputError, match="drive 'motor' moves joint 'hinge'.*Regularised"):
        jo.Mechanism(body, joint, drive, stick)
    with pytest.raises(jo.InputError, match="joint 'hinge' has the friction 'rub' already"):
        jo.Mechanism(body, joint, jo.Friction("rub", joint, 0.2, radius=0.1), stick)
    with pytest.raises(jo.InputError, match="joint 'hinge' is not in the mechanism"):
        jo.Mechanism(body, stick)


def test_friction_on_reactions_that_are_not_unique_warns():
    b = (0.0, 0.0, 1.0)
    body = jo.RigidBody("door", 1.0, (0.1, 0.1, 0.1), center=(0.5, 0, 0), markers={"b": b})
    corner = jo.ground.at(b)
    lower = jo.Revolute("lower", jo.ground["origin"], body["origin"])
    upper = jo.Revolute("upper", corner, body["b"])
    rub = jo.Friction("rub", upper, 0.2, radius=0.1)
    with pytest.warns(jo.JoustoWarning) as said:
        jo.compile(jo.Mechanism(body, lower, upper, rub, jo.Gravity((0, -9.81, 0))))
    assert any("friction 'rub'" in str(w.message) and "not unique" in str(w.message) for w in said)


def test_driven_joints_feel_their_friction():
    """inverse_dynamics: the motor bears the friction torque; stick-slip is refused."""

    def crane(law, mu=0.2):
        body = jo.RigidBody("arm", 1.0, (0.1, 0.1, 0.1), center=(0.5, 0, 0))
        joint = jo.Revolute("hinge", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
        motor = jo.Drive("motor", joint.angle, jo.Ramp(0, 10, 0, 20))
        rub = (jo.Friction("rub", joint, mu, radius=0.1, law=law),) if mu else ()
        pin = jo.ReactionSensor("pin", joint)
        return jo.compile(jo.Mechanism(body, joint, motor, *rub, pin, jo.Gravity((0, -9.81, 0))))

    times = [0.3, 0.5]
    free, run = (jo.simulation.inverse_dynamics(crane(None, mu), times) for mu in (0.0, 0.2))
    N = np.hypot(*run["pin"][:, :2].T)
    row = 5  # after those of the hinge
    assert (run.multipliers - free.multipliers)[:, row] == pytest.approx(-0.2 * 0.1 * N, rel=1e-9)


@pytest.mark.filterwarnings("ignore:.*error of the energy balance")
def test_a_step_that_the_smooth_law_cannot_bear_is_said():
    model = slope(0.3, 0.2, jo.mechanism.Regularised(1e-3))
    with pytest.warns(jo.JoustoWarning, match=r"friction 'rub' stops the slip .* chatters") as said:
        jo.simulate(model, 0.1, solver=jo.RK4(1e-2))
    text = str(said[0].message)
    rate = 1.875 * 0.3 * 9.81 * np.cos(0.2) / 1e-3  # slope of the law at rest, per mass
    assert f"{rate:.3g} 1/s" in text
    limit = float(text.split("below ")[1].split(" s")[0])
    assert 0.85 * 2.785 / rate < limit < 2.785 / rate
    jo.simulate(model, 0.1, solver=jo.RK4(limit))  # warnings are errors


@pytest.mark.parametrize("solver", [jo.RK4(4e-3), jo.ROS2(4e-3), jo.simulation.DormandPrince(1e-6)])
def test_a_slip_that_turns_near_rest_is_not_stopped(solver):
    """Thrown up with a slow spin: the spin goes on through the turning point.

    The loss is mu N times the way, up and down 2 (v^2 / 2 g) and on, along which N = 1 N presses.
    """
    body = jo.RigidBody(
        "b", 1.0, (0.1, 0.1, 0.1), velocity=(0, 0, 0.5), angular_velocity=(0, 0, 0.1)
    )
    joint = jo.Cylindrical("joint", jo.ground["origin"], body["origin"], (0, 0, 1))
    rub = jo.Friction("rub", joint, 1e-4, radius=0.05, preload=1.0, law=jo.mechanism.StickSlip())
    spin = jo.RateSensor("spin", joint.angle)
    model = jo.compile(jo.Mechanism(body, joint, rub, spin, jo.Gravity((0, 0, -9.81))))
    run = jo.simulate(model, 0.2, solver=solver, output_step=0.02)
    t = np.linspace(0.0, 0.2, 20001)
    slip = np.hypot(0.5 - 9.81 * t, 0.05 * 0.1)  # friction changes the speeds by 1e-5 only
    loss = 1e-4 * np.sum(0.5 * (slip[1:] + slip[:-1]) * np.diff(t))
    np.testing.assert_allclose(run.energy.friction[-1], loss, rtol=2e-4)
    assert 0.0999 < run["spin"][-1, 0] < 0.1


def idle(kind):
    """A joint that slips but that nothing presses, for one of three reasons."""
    body = jo.RigidBody("b", 1.0, (0.1, 0.1, 0.1), velocity=(0, 0, 1.0 * (kind != "thrust")))
    if kind == "thrust":
        body = jo.RigidBody("b", 1.0, (0.1, 0.1, 0.1), angular_velocity=(0, 0, 5.0))
        joint = jo.Revolute("joint", jo.ground["origin"], body["origin"], (0, 0, 1))
        return body, joint, jo.Friction("rub", joint, 0.3, radius=0.05), jo.Gravity((0, 0, -9.81))
    joint = jo.Prismatic("joint", jo.ground["origin"], body["origin"], (0, 0, 1))
    load = jo.Torque("bend", body["origin"], (3.0, 0, 0)) if kind == "moment" else None
    rub = jo.Friction("rub", joint, 0.3)
    return tuple(x for x in (body, joint, rub, load) if x is not None)


@pytest.mark.parametrize("kind", ["nothing", "moment", "thrust"])
def test_friction_without_a_load_path_is_said(kind):
    model = jo.compile(jo.Mechanism(*idle(kind)))
    with pytest.warns(jo.JoustoWarning, match="'rub': dissipated no energy.*has no normal force"):
        jo.simulate(model, 0.1, solver=jo.RK4(1e-3))


def test_a_distance_of_nothing_has_no_direction():
    body = jo.RigidBody("b", 1.0, (0.1, 0.1, 0.1))
    distance = jo.Distance(jo.ground["origin"], body["origin"])
    with pytest.raises(jo.InputError, match="at one point, so that their distance has no direct"):
        jo.Mechanism(body, jo.Spring("spring", distance, stiffness=10.0))


@pytest.mark.parametrize("flexible", [False, True])
@pytest.mark.parametrize("count", [1, 2, 8, 9, 12])
@pytest.mark.parametrize("law", [None, jo.mechanism.StickSlip()])
def test_any_number_of_frictions_agree_with_the_reactions_of_all(law, count, flexible):
    # few frictions are found from what each adds to the reactions, many by repeated solutions; the
    # equations of motion, which take friction from the multipliers, tell whether either is right
    items, before = [jo.Gravity((1.0, 2.0, -9.81))], jo.ground["origin"]
    rates = (
        0.3 * np.arange(1, count + 1) * (-1.0) ** np.arange(count)
    )  # rad/s of the links, 1 m long
    speeds = np.cumsum(rates) - rates
    for k in range(count):
        spin = {"velocity": (0, speeds[k], 0), "angular_velocity": (0, 0, rates[k])}
        if flexible and k == count - 1:
            b = jo.FlexibleBody(f"b{k}", rod(), position=(k, 0, 0), **spin)
        else:
            shape = {"center": (0.5, 0, 0), "markers": {"start": (0, 0, 0), "end": (1, 0, 0)}}
            b = jo.RigidBody(f"b{k}", 2.0, (0.1, 0.2, 0.2), position=(k, 0, 0), **shape, **spin)
        joint = jo.Revolute(f"j{k}", before, b["start"], (0, 0, 1))
        size = {"radius": 0.03, "bearing_length": 0.2, "collar_radius": 0.04}
        items += [b, joint, jo.Friction(f"f{k}", joint, 0.2, law=law, **size)]
        before = b["end"]
    engine = Engine(jo.compile(jo.Mechanism(*items)))
    engine.assemble()
    a, _ = engine.accelerations()
    scale, rubbed = np.abs(a).max(), engine.rub.copy()
    assert np.count_nonzero(rubbed[::2]) == count
    # friction is found to 1e-12 of the largest one, the masses and levers are of size 1
    assert np.abs(engine.residual()).max() < 1e-9 * scale
    np.testing.assert_allclose(engine.rub, rubbed, atol=1e-9 * np.abs(rubbed).max())


@pytest.mark.parametrize("law", [jo.mechanism.StickSlip(), jo.mechanism.Regularised(1e-2)])
@pytest.mark.parametrize(
    "solver",
    [jo.RK4(1e-3), jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3), jo.simulation.DormandPrince()],
    ids=lambda solver: type(solver).__name__,
)
def test_a_sliding_block_dissipates_friction_times_its_way(solver, law):
    """mu m g s with s = v t - mu g t^2 / 2: quadratic, so that each method adds it up exactly."""
    mu, m, v, t = 0.2, 2.0, 3.0, 1.0
    block = jo.RigidBody("block", m, (1.0,) * 3, velocity=(v, 0, 0))
    slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    rub = jo.Friction("rub", slide, mu, mu, law=law, bearing_length=0.5)
    model = jo.compile(jo.Mechanism(block, slide, rub, jo.Gravity((0, 0, -9.81))))
    run = jo.simulate(model, t, solver=solver, output_step=0.1)
    way = v * run.time - 0.5 * mu * 9.81 * run.time**2
    np.testing.assert_allclose(run.energy.friction, mu * m * 9.81 * way, rtol=1e-11, atol=1e-12)
    assert np.abs(run.energy.error).max() < 1e-11
