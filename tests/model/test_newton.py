"""Newton's matrix of the implicit methods: its terms against complex steps, its factors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import SimulationError
from jousto.model import newton_pattern as pattern_module
from jousto.model.model import ForceModel
from jousto.model.native.native import Engine, displaced
from jousto.model.newton_pattern import newton_pattern
from model import (
    test_forces,
    test_friction,
    test_joints,
    test_layouts,
    test_moving_load,
    test_tangent,
)
from verification.mechanisms import chain, loop
from verification.test_stiffening import spinning_chain

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
STEP = 1e-30


def rate_tangent(engine):
    """Return d(Cq v)/dq by complex steps."""
    model = engine.model
    twin = jo.model.Engine(model, complex_scalars=True)
    for name in ("q", "v", "time", "input", "turn", "locked"):
        getattr(twin, name)[:] = getattr(engine, name)
    out = np.zeros((model.nrow, model.nv))
    for j, x in enumerate(np.eye(model.nv)):
        twin.q[:] = displaced(model, engine.q.astype(complex), 1j * STEP * x)
        out[:, j] = twin.constraints()[1].imag / STEP
    return out


def multiplier_tangent(engine):
    """Return dr/dlam by complex steps: Cq^T, and what friction makes of the multipliers."""
    twin = jo.model.Engine(engine.model, complex_scalars=True)
    names = ("q", "v", "a", "lam", "time", "input", "turn", "locked", "slip", "direction")
    for name in names:
        getattr(twin, name)[:] = getattr(engine, name)
    out = np.zeros((engine.model.nv, engine.model.nrow))
    for j in range(engine.model.nrow):
        twin.lam[j] += 1j * STEP
        out[:, j] = twin.residual().imag / STEP
        twin.lam[j] = engine.lam[j]
    return out


def assert_exact(engine, tolerance=1e-12):
    """The formulas agree with complex steps, term by term, at any accelerations."""
    nv = engine.model.nv
    by_lam = multiplier_tangent(engine)
    engine.a += np.random.default_rng(1).normal(size=nv)
    t, zero = engine.tangent(), np.zeros((engine.model.nrow, nv))
    for weights, wanted, rows in (
        ((1.0, 0.0, 0.0), t.M, zero),
        ((0.0, 1.0, 0.0), t.D, t.Cq),
        ((0.0, 0.0, 1.0), t.K, rate_tangent(engine)),
    ):
        found = engine.newton_matrix(*weights)
        scale = np.abs(wanted).max()
        np.testing.assert_allclose(found[:nv, :nv], wanted, rtol=0, atol=tolerance * scale)
        scale = max(1.0, np.abs(rows).max(initial=0.0))
        np.testing.assert_allclose(found[nv:, :nv], rows, rtol=0, atol=tolerance * scale)
        np.testing.assert_allclose(found[:nv, nv:], by_lam, rtol=0, atol=1e-11)
        absent = [j for j in engine.model.joints if j.lock >= 0 and not engine.locked[j.lock]]
        ones = np.zeros(engine.model.nrow)
        for joint in absent:  # their multipliers are zero
            ones[joint.row : joint.row + joint.rows] = 1.0
        np.testing.assert_array_equal(found[nv:, nv:], np.diag(ones))


@pytest.mark.parametrize("case", test_tangent.CASES)
def test_mechanisms_with_following_loads(case):
    assert_exact(test_tangent.bent(case))


@pytest.mark.parametrize("flexible", [False, True], ids=["rigid", "flexible"])
@pytest.mark.parametrize("name", test_joints.NAMES)
def test_every_joint(name, flexible):
    engine = test_joints.disturbed(test_joints.build(name, flexible))
    engine.accelerations()
    assert_exact(engine)


SERVO = np.array([300.0, 20.0, 0.7, 5.0, 0.0])
LIMITED = np.array([300.0, 20.0, 0.7, 5.0, 1.0])
FORCES = {
    "distance": test_forces.spring(0, 4.0),
    "along": test_forces.spring(1, 4.0),
    "angle": test_forces.spring(2, 0.3),
    "servo": ForceModel("servo", "along", SERVO, coordinate=2, active=True),
    "limited servo": ForceModel("servo", "along", LIMITED, coordinate=2, active=True),
    "gear spring": test_forces.gear(),
    "bushing": test_forces.bushing(1.0),
    "modal load": ForceModel("push", "modal load", np.arange(6.0) - 2.0, body=1),
}


@pytest.mark.parametrize("turn", [0.003, 1.0])
@pytest.mark.parametrize("name", FORCES)
def test_every_force(name, turn):
    model = test_forces.two_bodies(FORCES[name])
    engine = jo.model.Engine(model)
    rng = np.random.default_rng(2)
    engine.q[10:14] = [1.0, 0.4 * turn, -0.6 * turn, 0.9 * turn]
    engine.q[10:14] /= np.linalg.norm(engine.q[10:14])
    engine.v[:] = rng.normal(size=model.nv)
    engine.accelerations()
    assert_exact(engine)
    # all but a servo at its limit and a load that stays as it is have stiffness and damping
    yields = name not in ("limited servo", "modal load")
    assert (np.abs(engine.newton_matrix(0.0, 0.0, 1.0)).max() > 100.0) == yields
    assert (np.abs(engine.newton_matrix(0.0, 1.0, 0.0)).max() > 0.2) or not yields


@pytest.mark.parametrize(
    "law", [jo.mechanism.StickSlip(), test_friction.FAST, jo.mechanism.Regularised(0.2)], ids=repr
)
@pytest.mark.parametrize("kind", test_friction.KINDS)
def test_rubbing_joints(kind, law):
    engine = jo.model.Engine(jo.compile(test_friction.machine(kind, law=law)))
    rng = np.random.default_rng(6)
    engine.q[:] = displaced(engine.model, engine.q, 0.02 * rng.normal(size=engine.model.nv))
    engine.v += 0.1 * rng.normal(size=engine.model.nv)
    engine.accelerations()
    engine.slip[:] = np.where(engine.slip == 0, 1, engine.slip) * isinstance(
        law, jo.mechanism.StickSlip
    )
    assert_exact(engine, tolerance=1e-11)
    change = multiplier_tangent(engine) - engine.tangent().Cq.T
    assert np.abs(change).max() > 1e-3


@pytest.mark.parametrize("follow", [False, True])
def test_a_force_on_its_way_along_a_body(follow):
    body = test_moving_load.bridge(4, 6)
    place = jo.Ramp(0, 1.0, before=0, after=test_moving_load.LENGTH)
    load = jo.mechanism.MovingLoad(
        "wheel", body, ("start", "end"), (30.0, 20.0, -500.0), place, follow=follow
    )
    engine = jo.model.Engine(test_moving_load.supported(body, load))
    engine.time[0] = 0.41
    rng = np.random.default_rng(6)
    engine.q[:] = displaced(engine.model, engine.q, 0.05 * rng.normal(size=engine.model.nv))
    engine.v += rng.normal(size=engine.model.nv)
    engine.accelerations()
    assert_exact(engine)


def test_user_functions_by_differences():
    def pull(t, x):
        return np.concatenate([-30.0 * x[:3] - 2.0 * x[12:15], 4.0 * x[3:6] - 3.0 * x[15:18]])

    model = test_forces.two_bodies(ForceModel("f", "user", np.zeros(1), a=0, b=1, function=pull))
    engine = jo.model.Engine(model)
    engine.v[:] = np.random.default_rng(2).normal(size=model.nv)
    engine.accelerations()
    K, D = engine.newton_matrix(0.0, 0.0, 1.0), engine.newton_matrix(0.0, 1.0, 0.0)
    q, v, step = engine.q.copy(), engine.v.copy(), 1e-6
    for j, x in enumerate(step * np.eye(model.nv)):
        far = []
        for sign in (1.0, -1.0):
            engine.q[:] = displaced(model, q, sign * x)
            far.append(engine.residual())
        engine.q[:] = q
        for sign in (1.0, -1.0):
            engine.v[:] = v + sign * x
            far.append(engine.residual())
        engine.v[:] = v
        np.testing.assert_allclose(K[:, j], (far[0] - far[1]) / (2 * step), atol=1e-4)
        np.testing.assert_allclose(D[:, j], (far[2] - far[3]) / (2 * step), atol=1e-4)


def test_second_order_markers():
    engine = jo.model.Engine(spinning_chain(True))
    rng = np.random.default_rng(4)
    for b in engine.model.bodies:
        engine.q[b.iq + 7 : b.iq + 7 + b.n] = 0.05 * rng.normal(size=b.n)
    engine.v += rng.normal(size=engine.model.nv)
    engine.accelerations()
    assert_exact(engine)


@pytest.mark.parametrize("n", [1, 4, 31, 33, 41])
def test_small_and_large_bodies(rng, n):
    mass, u0, Phi = test_layouts.cloud(rng, n, 3 + n)
    K, D = rng.uniform(1, 10, n), rng.uniform(0.1, 1, n)
    body = test_layouts.body_model(mass, u0, Phi, K, D)
    e = rng.normal(size=4)
    q = np.concatenate([rng.normal(size=3), e / np.linalg.norm(e), 0.3 * rng.normal(size=n)])
    model = jo.Model(
        "cloud",
        np.array([1.0, -9.0, 3.0]),
        (body,),
        (),
        0,
        (),
        (),
        (),
        (),
        test_layouts.eliminate([], []),
        q,
        rng.normal(size=6 + n),
    )
    engine = jo.model.Engine(model)
    engine.accelerations()
    assert_exact(engine)


def long_chain(count):
    bodies = [
        jo.RigidBody(
            f"link {i}",
            1.0,
            (0.1, 0.1, 0.1),
            center=(0.5, 0, 0),
            markers={"end": (1.0, 0, 0)},
            position=(float(i), 0, 0),
        )
        for i in range(count)
    ]
    places = [jo.ground["origin"], *(body["end"] for body in bodies)]
    joints = [
        jo.Revolute(f"hinge {i}", places[i], bodies[i]["origin"], ((0, 0, 1), (0, 1, 0))[i % 2])
        for i in range(count)
    ]
    return jo.compile(jo.Mechanism(*bodies, *joints, jo.Gravity((0, -9.81, 0))))


def test_memory_and_products_grow_with_the_length_of_a_chain():
    small, large = (newton_pattern(long_chain(count)) for count in (10, 40))
    per_link = [(p.reals, len(p.fills), len(p.branches)) for p in (small, large)]
    growth = np.subtract(per_link[1], per_link[0]) / 30
    np.testing.assert_allclose(per_link[0], 10 * growth, atol=1.5 * growth.max())
    assert growth[1] == growth[2] == 1.0  # one branch, one product and no fill for a link


@pytest.mark.parametrize("case", ["chain", "loop"])
def test_nodes_hold_every_unknown_once(case):
    model = jo.compile(chain() if case == "chain" else loop())
    pattern = newton_pattern(model)
    unknowns = [range(node[3], node[3] + node[1]) for node in pattern.nodes]
    assert sorted(i for r in unknowns for i in r) == list(range(model.nv + model.nrow))
    assert len({*pattern.places}) == len(model.bodies) + len(model.joints)
    loops = [node for node in pattern.nodes if node[0] < 0]
    assert len(loops) == (case == "loop")  # a ring has one joint too many for a tree
    # that joint waits for the bodies of the ring, so that its pivot is regular
    assert all(pattern.nodes.index(node) == len(pattern.nodes) - 1 for node in loops)


def test_models_without_joints_or_bodies():
    pattern = newton_pattern(replace(long_chain(1), joints=()))
    assert [node[:3] for node in pattern.nodes] == [(0, 6, 6)]


def test_compile_does_not_order_newtons_matrix() -> None:
    """Of nets it is far larger than the mechanism; only implicit methods and statics use it."""
    body = jo.RigidBody("ball", 1.0, (1.0, 1.0, 1.0))
    joint = jo.Spherical("pivot", jo.ground["origin"], body["origin"])
    model = jo.compile(jo.Mechanism(body, joint))
    jo.doctor(model).lines()
    assert model not in pattern_module._KNOWN
    jo.simulate(model, 1e-2, solver=jo.GeneralizedAlpha(1e-2))
    assert model in pattern_module._KNOWN


def test_an_engine_without_newtons_matrix_refuses_what_needs_it() -> None:
    model = jo.compile(jo.Mechanism(jo.RigidBody("ball", 1.0, (1.0, 1.0, 1.0))))
    engine = Engine(model, implicit=False)
    asks = (
        lambda: engine.native_solver("generalized_alpha", 1e-3, True),
        lambda: engine.newton_matrix(1.0, 0.0, 0.0),
        lambda: engine.newton_sparse(1.0, 0.0, 0.0),
    )
    for ask in asks:
        with pytest.raises(ValueError, match="Newton matrix"):
            ask()


def test_a_step_that_fails_leaves_time_and_state():
    """A step of 24 turns of a hinge, in which Newton's iteration finds nothing."""
    arm = jo.RigidBody("arm", 1.0, (0.1, 0.2, 0.3), center=(1.0, 0, 0))
    pin = jo.Revolute("pin", jo.ground["origin"], arm["origin"], axis=(0, 0, 1))
    start = jo.Initial(pin.angle, rate=30.0)
    engine = Engine(jo.compile(jo.Mechanism(arm, pin, start, jo.Gravity((0, -9.81, 0)))))
    options = jo.GeneralizedAlpha(1e-2).options
    engine.step(engine.native_solver("alpha", 1e-2, True, **options))
    before = engine.time.copy(), engine.q.copy(), engine.v.copy()
    with pytest.raises(SimulationError, match="did not converge"):
        engine.step(engine.native_solver("alpha", 5.0, True, **options | {"iterations": 1}))
    for found, kept in zip((engine.time, engine.q, engine.v), before, strict=True):
        np.testing.assert_array_equal(found, kept)


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
def test_derivatives_of_inertia_save_iterations_and_change_no_result():
    """A body that turns by 6 degrees a step about no principal axis."""
    spin = {"center": (1.0, 0, 0.2), "angular_velocity": (3, 5, 20)}
    body = jo.RigidBody("body", 1.0, (0.1, 0.2, 0.3), **spin)
    ball = jo.Spherical("ball", jo.ground["origin"], body["origin"])
    model = jo.compile(jo.Mechanism(body, ball, jo.Gravity((0, 0, -9.81))))
    with_them, without = (
        jo.simulate(
            model,
            0.1,
            solver=jo.GeneralizedAlpha(5e-3, tangent="exact", tolerance=1e-10, inertia_tangents=on),
        )
        for on in (True, False)
    )
    np.testing.assert_allclose(with_them.q, without.q, rtol=0, atol=1e-9)
    assert with_them.work.iterations[-1] < 0.6 * without.work.iterations[-1]


def test_steps_of_a_pace_that_have_time_are_not_missed():
    """A step of some microseconds every 40 ms; a computer under load may miss some of them."""
    body = jo.RigidBody("body", 1.0, (0.1, 0.2, 0.3))
    pin = jo.Revolute("pin", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    engine = Engine(jo.compile(jo.Mechanism(body, pin)))
    native, steps = engine.native_solver("rk4", 1e-3, True), 8
    late = np.zeros(2, dtype=np.int64)
    pace = {"step": 0.04, "farthest": 10.0, "edges": np.array([10.0]), "late": late}
    rows = np.zeros((steps + 1, engine.row_size))
    status, written, found = engine.paced(native, steps, 1, rows, pace)
    assert (status, written, found["done"], late.tolist()) == ("ok", steps, steps, [steps, 0])
    assert found["missed"] < steps
    assert 0.0 < found["worst"] < 10.0
