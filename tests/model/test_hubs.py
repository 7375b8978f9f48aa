"""Bodies with many joints: the effort grows with the joints, the motion is that of other methods.

A hub's velocities are unknowns of the factorisation. What they give is compared with the dense
matrix of all joints, with joint coordinates, which know no rows, and with a solution of the whole
linear system by NumPy.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import jousto as jo
from jousto.base.rotations import rotation_matrix
from jousto.mechanism import Event, StickSlip
from jousto.model import hubs
from jousto.model.native.native import Engine
from jousto.model.rank.redundancy import RANK
from jousto.simulation import DormandPrince

SPOKES = 30
# of accelerations and multipliers: two factorisations of one matrix differ by rounding, 1e-16,
# times its condition, some 1e3 for bodies whose masses and arms differ tenfold
ROUNDING = 1e-11


def star(spokes, *, more=lambda middle, joints: ()):
    """A moving body on whose points others are hinged, each with an axis of its own."""
    rng = np.random.default_rng(1)
    spin = np.array([0.0, 1.2, 0.0])  # of all as one
    middle = jo.RigidBody("middle", 5.0, (1, 2, 2.5), center=(0.1, 0, 0), angular_velocity=spin)
    bodies, joints = [middle], []
    for i in range(spokes):
        place, center = rng.uniform(-1, 1, 3), rng.uniform(-0.2, 0.2, 3)
        mass = rng.uniform(0.1, 1.0)
        motion = {"velocity": np.cross(spin, place), "angular_velocity": spin}
        pose = {"position": place, "center": center}
        bodies.append(jo.RigidBody(f"w{i}", mass, (0.02, 0.03, 0.04), **pose, **motion))
        ends = middle.at(place), bodies[-1]["origin"]
        joints.append(jo.Revolute(f"j{i}", *ends, axis=rng.normal(size=3)))
    items = (*bodies, *joints, *more(middle, joints))
    return jo.Mechanism(*items, jo.Gravity((0, 0, -9.81)))


def hinged(middle, joints):
    return [jo.Revolute("g", jo.ground["origin"], middle["origin"], axis=(0, 1, 0))]


def driven(middle, joints):
    """Drives of every second joint, and springs at the others."""
    curve = jo.SCurve([0.0, 1.0], [0.0, 0.3])
    return [
        *(jo.Drive(f"d{i}", joint.angle, curve) for i, joint in enumerate(joints[::2])),
        *(jo.Spring(f"s{i}", joint.angle, stiffness=5.0) for i, joint in enumerate(joints[1::2])),
        *hinged(middle, joints),
    ]


def geared(middle, joints):
    """Each spoke turns against its neighbour: rows with two sides on the hub."""
    pairs = zip(joints[::2], joints[1::2], strict=True)
    return [jo.Gear(f"k{i}", a.angle, b.angle, 2.0) for i, (a, b) in enumerate(pairs)]


def looped(middle, joints):
    """The first spoke stands on the ground, too, so that a loop passes the hub."""
    foot = joints[0].b.body.at((0.3, 0.1, 0.2))
    place = jo.ground.at(foot.r)
    return [jo.Spherical("foot", place, foot)]


def overheld(middle, joints):
    """The loop has more rows than motions: reactions are not unique, those of least norm count."""
    return [*looped(middle, joints), *hinged(middle, joints)]


def repeated(middle, joints):
    """One joint repeats another."""
    first = joints[0]
    twin = jo.Revolute("twin", first.a, first.b, axis=first.axis)
    return [twin, *hinged(middle, joints)]


def rubbing(middle, joints):
    """The hub sticks to the ground, and so do spokes to the hub: rows that are switched."""
    carrier = hinged(middle, joints)
    law = StickSlip()
    rubs = [
        jo.Friction(f"f{i}", joint, mu_kinetic=0.1, mu_static=0.2, radius=0.05, law=law)
        for i, joint in enumerate((*joints[:3], *carrier))
    ]
    return [*carrier, *rubs]


def released(middle, joints):
    """The first joint breaks."""
    turn = jo.CoordinateSensor("turn", joints[1].angle)
    event = Event("break", turn, threshold=0.02, direction="both", releases=(joints[0],))
    return [turn, event]


MACHINES = [lambda middle, joints: [], hinged, driven, geared, looped, overheld, repeated]
MACHINES += [rubbing, released]
NAMES = ["free", *(make.__name__ for make in MACHINES[1:])]


def dense(monkeypatch, mechanism):
    """Compile with the joints of all bodies in one matrix."""
    with monkeypatch.context() as patch:
        patch.setattr(hubs, "MANY", 10**9)
        model = jo.compile(mechanism, core="maximal")
    assert not model.elimination.hubs
    return model


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
@pytest.mark.parametrize("more", MACHINES, ids=NAMES)
def test_accelerations_and_multipliers_are_those_of_the_dense_matrix(monkeypatch, more):
    mechanism = star(SPOKES, more=more)
    found = []
    for model in (jo.compile(mechanism, core="maximal"), dense(monkeypatch, mechanism)):
        engine = Engine(model)
        a, lam = engine.accelerations()
        found.append((a.copy(), lam.copy(), engine.q.copy(), engine.v.copy()))
    # how rows that repeat one another share their multiplier is known to the rounding over the
    # share by which their diagonal is raised; what they do together is in the accelerations
    shared = np.finfo(float).eps / RANK if model.redundant else ROUNDING
    for one, other, small in zip(*found, (ROUNDING, shared, ROUNDING, ROUNDING), strict=True):
        np.testing.assert_allclose(one, other, atol=small * max(1.0, np.abs(other).max()))


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
@pytest.mark.parametrize("more", [MACHINES[0], hinged, driven], ids=lambda m: m.__name__)
def test_they_solve_the_equations_of_motion(more):
    """``[M Cq^T; Cq 0] [da; dlam] = [f; 0]`` for a further force f, by NumPy."""
    model = jo.compile(star(SPOKES, more=more), core="maximal")
    assert model.elimination.hubs == (0,)
    engine = Engine(model)
    before = np.concatenate(engine.accelerations())
    other = Engine(replace(model, gravity=np.array([3.0, -2.0, 1.0])))
    change = np.concatenate(other.accelerations()) - before
    tangent = engine.tangent()
    rows = len(tangent.Cq)
    K = np.block([[tangent.M, tangent.Cq.T], [tangent.Cq, np.zeros((rows, rows))]])
    right = K @ change
    # the further weight of each body acts at its centre of mass
    pull = np.array([3.0, -2.0, 1.0 + 9.81])
    for body in model.bodies:
        force = right[body.iv : body.iv + 3]
        np.testing.assert_allclose(force, body.mass[0] * pull, atol=1e-9 * np.abs(change).max())
    np.testing.assert_allclose(right[model.nv :], 0.0, atol=1e-9 * np.abs(change).max())


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
@pytest.mark.parametrize("solver", [jo.RK4(1e-3), jo.ROS2(1e-3), DormandPrince(1e-9), None])
@pytest.mark.parametrize("more", [MACHINES[0], hinged, driven], ids=lambda m: m.__name__)
def test_motion_is_that_of_joint_coordinates(more, solver):
    """Which solve no rows at all; both follow the same solution to the order of the method."""
    mechanism = star(SPOKES, more=more)
    exact = jo.simulate(jo.compile(mechanism, core="joint"), 0.1, solver=jo.RK4(2e-4)).q[-1]
    run = jo.simulate(jo.compile(mechanism, core="maximal"), 0.1, solver=solver).q[-1]
    # ROS2 is of second order: 1e-6 s2 times rates of rates of 10 /s2 or so; the default meets the
    # tolerance that it is made for, 1e-6 of the motion
    tolerance = {jo.ROS2: 1e-4, type(None): 1e-6}.get(type(solver), 1e-7)
    np.testing.assert_allclose(run, exact, atol=tolerance)


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
@pytest.mark.parametrize("more", [geared, looped, overheld, repeated, rubbing, released])
def test_motion_is_that_of_the_dense_matrix(monkeypatch, more):
    mechanism = star(SPOKES, more=more)
    models = jo.compile(mechanism, core="maximal"), dense(monkeypatch, mechanism)
    one, other = (jo.simulate(model, 0.1, solver=jo.RK4(1e-3)) for model in models)
    np.testing.assert_allclose(one.q[-1], other.q[-1], atol=1e-9)
    assert [str(event) for event in one.events] == [str(event) for event in other.events]


def test_a_free_star_keeps_its_momentum_and_energy():
    """Without gravity nothing acts from outside; RK4 keeps both to its order, here 1e-10."""
    items = [x for x in star(60).items if not isinstance(x, jo.Gravity)]
    model = jo.compile(jo.Mechanism(*items), core="maximal")
    run = jo.simulate(model, 0.5, solver=jo.RK4(1e-3))
    momenta = []
    for q, v in ((run.q[0], run.v[0]), (run.q[-1], run.v[-1])):
        total = np.zeros(3)
        for body, item in zip(model.bodies, items, strict=False):
            A = rotation_matrix(q[body.iq + 3 : body.iq + 7])
            w = v[body.iv + 3 : body.iv + 6]
            total += body.mass[0] * (v[body.iv : body.iv + 3] + A @ np.cross(w, item.center))
        momenta.append(total)
    np.testing.assert_allclose(momenta[1], momenta[0], atol=1e-9)


def test_derivatives_pass_the_hub():
    """A complex step in a mass of the hub, against central differences."""
    model = jo.compile(star(SPOKES), core="maximal")

    def accelerate(mass):
        override = {("body", 0, "mass"): np.array([mass])}
        engine = Engine(model, complex_scalars=True, override=override)
        return engine.accelerations()[0].copy()

    slope = accelerate(5.0 + 1e-30j).imag / 1e-30
    h = 1e-4
    central = (accelerate(5.0 + h).real - accelerate(5.0 - h).real) / (2 * h)
    np.testing.assert_allclose(slope, central, atol=1e-6 * np.abs(slope).max())


@pytest.mark.parametrize("more", [MACHINES[0], hinged, driven], ids=lambda m: m.__name__)
def test_blocks_grow_with_the_joints(more):
    """The dense matrix has n^2 / 2 blocks and n^3 / 6 products."""
    counts = []
    for n in (40, 80, 160):
        plan = jo.compile(star(n, more=more)).elimination
        assert plan.fill <= n
        counts.append((plan.count, sum(map(len, plan.updates))))
    (a, x), (b, y), (c, z) = counts
    assert c - b == 2 * (b - a)
    assert z - y == 2 * (y - x)


def test_a_moving_body_with_thousands_of_joints_runs_and_is_examined():
    model = jo.compile(star(3000))
    assert "joint coordinates" in str(jo.doctor(model))
    assert jo.doctor(model).mobility == 3006
    jo.simulate(model, 1e-3, solver=jo.RK4(1e-3))


def test_spokes_between_two_hubs_are_too_dense():
    """Each repeats the others; they are refused instead of a matrix that fills the memory."""
    rim, middle = (jo.RigidBody(name, 1.0, (1, 1, 1)) for name in ("rim", "middle"))
    items = [rim, middle]
    for i in range(600):
        rod = jo.RigidBody(f"r{i}", 1.0, (1, 1, 1))
        items.append(rod)
        items += [jo.Spherical(f"{x.name}{i}", x["origin"], rod["origin"]) for x in (rim, middle)]
    with pytest.raises(jo.InputError, match="has so many loops"):
        jo.compile(jo.Mechanism(*items))
