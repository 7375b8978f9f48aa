"""The motion does not depend on how it is described.

Frame indifference, units, order of the items and sides of the joints must agree to round-off;
discretisations (mass matrix, modal basis, reference conditions, one body or two) must converge to
one motion. Reference conditions: Shabana, *Dynamics of Multibody Systems*, section 5.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest
import scipy.linalg

import jousto as jo
from verification.mechanisms import SECTION, chain, loop, march
from verification.particles import exponential, rotation
from verification.test_dense_reference import star

# -- the same mechanism written in another way ------------------------------------------------


def rewritten(mechanism, *, turn=None, shift=(0, 0, 0), bodies=None, joints=None, swap=False):
    """The mechanism turned and shifted in the world, its items in another order, sides swapped."""
    A, d = np.eye(3) if turn is None else turn, np.asarray(shift, dtype=float)
    new = {}

    def body_of(body):
        common = {
            "position": A @ body.position + d,
            "orientation": A @ rotation(np.asarray(body.orientation)),
            "velocity": A @ body.velocity,
            "angular_velocity": A @ body.angular_velocity,
        }
        if isinstance(body, jo.RigidBody):
            given = {"center": body.center, "markers": dict(body.markers)}
            return jo.RigidBody(body.name, body.mass, body.inertia, **given, **common)
        return jo.FlexibleBody(
            body.name,
            body.reduced,
            damping=body.damping,
            modal_coordinates=body.modal_coordinates,
            modal_velocities=body.modal_velocities,
            **common,
        )

    def marker_of(marker):
        if id(marker.body) in new:
            return replace(marker, body=new[id(marker.body)])
        at = A @ marker.position_local + d
        return replace(marker, position_local=at, axes=A @ marker.axes)

    def joint_of(joint):
        sides = (marker_of(joint.a), marker_of(joint.b))
        sides = sides[::-1] if swap else sides
        if isinstance(joint, jo.Revolute):
            return jo.Revolute(joint.name, *sides, axis=A @ joint.axis_world)
        return type(joint)(joint.name, *sides)

    def load_of(load):
        vector = load.vector if load.follow else A @ load.vector
        return type(load)(
            load.name, marker_of(load.marker), vector, follow=load.follow, signal=load.signal
        )

    for body in mechanism.bodies:
        new[id(body)] = body_of(body)
    order = range(len(mechanism.bodies)) if bodies is None else bodies
    turned_bodies = [new[id(mechanism.bodies[i])] for i in order]
    order = range(len(mechanism.joints)) if joints is None else joints
    turned_joints = [joint_of(mechanism.joints[i]) for i in order]
    return jo.Mechanism(
        *turned_joints,
        *turned_bodies,
        *[load_of(load) for load in mechanism.forces],
        jo.Gravity(A @ mechanism.gravity),
        *[jo.ReactionSensor(joint.name, joint) for joint in turned_joints],
        *[jo.PositionSensor(f"{b.name} position", b[point(b)]) for b in turned_bodies],
        *[jo.VelocitySensor(f"{b.name} velocity", b[point(b)]) for b in turned_bodies],
        *[jo.mechanism.ModalSensor(f"{b.name} modes", b) for b in turned_bodies if flexible(b)],
        name=mechanism.name,
    )


def flexible(body):
    return isinstance(body, jo.FlexibleBody)


def point(body):
    return "end" if flexible(body) else "center"


MECHANISMS = {
    "revolute chain": partial(chain, "revolute"),
    "fixed joint, loads": partial(chain, "fixed", loads=True, damping=0.02),
    "star": star,
    "loop": loop,
}
SOLVERS = [jo.RK4(step=2.5e-4), jo.ROS2(step=2.5e-4)]


@cache
def plain(name, solver):
    return march(jo.compile(rewritten(MECHANISMS[name]())), solver, 0.1, 0.02)


def compare(name, solver, changed, *, turn=None, shift=(0, 0, 0)):
    """The sensors of the changed mechanism, turned back, are those of the plain one."""
    A = np.eye(3) if turn is None else turn
    reference, run = plain(name, solver), march(jo.compile(changed), solver, 0.1, 0.02)
    assert set(run.sensors) == set(reference.sensors)
    for sensor, values in reference.sensors.items():
        found = run.sensors[sensor]
        if sensor.endswith(" position"):
            found = (found - shift) @ A
        elif sensor.endswith(" velocity"):
            found = found @ A
        elif not sensor.endswith(" modes"):
            found = (found.reshape(-1, 2, 3) @ A).reshape(-1, 6)
        # 1e-11 after 0.1 s is round-off; velocities see it times the highest frequency, 2e3 rad/s,
        # reactions times the axial stiffness of the rods, 6.6e6 N/m: 1e-14 m are 1e-7 N
        atol = 1e-11 * max(1.0, np.abs(values).max())
        if sensor.endswith((" modes", " velocity")):
            atol *= 10
        if found.shape[1] == 6 and not sensor.endswith(" modes"):
            atol += 1e-7
        np.testing.assert_allclose(found, values, rtol=0, atol=atol, err_msg=sensor)
    # without gravity's constant (the potential is measured from the origin) the energies agree
    for column in (0, 1, 3, 4):
        a, b = run.energy[:, column], reference.energy[:, column]
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-11 * max(1.0, np.abs(b).max()))


@pytest.mark.parametrize("solver", SOLVERS, ids=["RK4", "ROS2"])
@pytest.mark.parametrize("name", MECHANISMS)
def test_a_turned_and_shifted_model_moves_turned_and_shifted(name, solver):
    turn, shift = exponential(np.array([0.7, -1.9, 1.1])), np.array([3.0, -2.0, 1.0])
    changed = rewritten(MECHANISMS[name](), turn=turn, shift=shift)
    compare(name, solver, changed, turn=turn, shift=shift)


@pytest.mark.parametrize("solver", SOLVERS, ids=["RK4", "ROS2"])
@pytest.mark.parametrize("name", MECHANISMS)
def test_the_order_of_bodies_and_joints_does_not_matter(name, solver):
    mechanism = MECHANISMS[name]()
    rng = np.random.default_rng(4)
    bodies = rng.permutation(len(mechanism.bodies))
    joints = rng.permutation(len(mechanism.joints))
    assert (np.diff(bodies) < 0).any() or (np.diff(joints) < 0).any()
    compare(name, solver, rewritten(mechanism, bodies=bodies, joints=joints))


@pytest.mark.parametrize("name", MECHANISMS)
def test_swapping_the_markers_of_the_joints_only_turns_the_reactions_round(name):
    # force and moment on the other body are the opposite ones, at once and to round-off
    mechanism = MECHANISMS[name]()
    values = []
    for swap in (False, True):
        model = jo.compile(rewritten(mechanism, swap=swap))
        engine = jo.model.Engine(model)
        a = engine.accelerations()[0].copy()
        names = {s.name: slice(s.offset, s.offset + s.count) for s in model.sensors}
        values.append((a, engine.sensors(), names))
    (a, plain_values, names), (b, swapped, other) = values
    assert names == other
    np.testing.assert_allclose(b, a, rtol=0, atol=1e-11 * np.abs(a).max())
    largest = np.abs(plain_values).max()
    for joint in mechanism.joints:
        one, two = plain_values[names[joint.name]], swapped[names[joint.name]]
        np.testing.assert_allclose(two, -one, rtol=0, atol=1e-11 * largest)


@pytest.mark.parametrize("method", [jo.RK4, jo.ROS2])
@pytest.mark.parametrize("name", MECHANISMS)
def test_swapped_joints_converge_to_the_same_motion(name, method):
    # the rows of a revolute and a fixed joint change; between the points where the constraints
    # hold, the methods see this in their error, which falls with their order
    gaps = []
    for step in (2.5e-4, 1.25e-4):
        one, two = (
            march(jo.compile(rewritten(MECHANISMS[name](), swap=swap)), method(step=step), 0.05)
            for swap in (False, True)
        )
        gaps.append(float(np.abs(one.q - two.q).max()))
    assert gaps[0] < 1e-5
    assert gaps[1] < 1e-11 or np.log2(gaps[0] / gaps[1]) > method.order - 0.3, gaps


# -- units --------------------------------------------------------------------------------------


def crane(m, kg):
    """A flexible boom on a hinge with a rigid load, in units of which a metre has m, a kilogram kg.

    Seconds stay seconds: N = kg m / s^2, Pa = kg / (m s^2).
    """
    N = kg * m
    steel = jo.Material(E=5e9 * kg / m, nu=0.3, rho=7850.0 * kg / m**3)
    part = jo.Part.beam(1.5 * m, jo.Tube(0.08 * m, 0.01 * m), 5, steel)
    boom = jo.FlexibleBody(
        "boom",
        jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=2)),
        damping=0.01,
        position=(0.2 * m, 0.1 * m, 0.0),
        angular_velocity=(0.0, 0.0, 1.0),
    )
    tip = np.array([1.7, 0.1, 0.0]) * m
    load = jo.RigidBody(
        "load",
        12.0 * kg,
        np.array([0.3, 0.4, 0.5]) * kg * m**2,
        center=np.array([0.0, -0.3, 0.1]) * m,
        position=tip,
        velocity=(0.0, 1.5 * m, 0.0),
    )
    hinge = jo.Revolute("hinge", jo.ground.at((0.2 * m, 0.1 * m, 0.0)), boom["start"])
    hook = jo.Spherical("hook", boom["end"], load["origin"])
    return jo.Mechanism(
        boom,
        load,
        hinge,
        hook,
        jo.Gravity((0.0, -9.81 * m, 0.0)),
        jo.Force("wind", load["center"], (5.0 * N, 2.0 * N, 8.0 * N)),
        jo.Torque("drive", boom["start"], (0.0, 0.0, 20.0 * N * m)),
        jo.PositionSensor("load", load["center"]),
        jo.ReactionSensor("hinge", hinge),
        jo.StressSensor("stress", boom, [boom.reduced.stress.labels[0]]),
    )


@pytest.mark.filterwarnings("ignore:.*(softer than|lighter than|MPa|t/mm3)")
@pytest.mark.parametrize("solver", SOLVERS, ids=["RK4", "ROS2"])
def test_millimetres_and_tonnes_give_the_same_motion(solver):
    si = march(jo.compile(crane(1.0, 1.0)), solver, 0.5, 0.05)
    mm = march(jo.compile(crane(1e3, 1e-3)), solver, 0.5, 0.05)
    np.testing.assert_allclose(mm.sensors["load"] / 1e3, si.sensors["load"], rtol=0, atol=1e-11)
    factor = np.array([1, 1, 1, 1e3, 1e3, 1e3])  # N and N mm
    hinge = si.sensors["hinge"]
    np.testing.assert_allclose(
        mm.sensors["hinge"] / factor, hinge, rtol=0, atol=1e-9 * np.abs(hinge).max()
    )
    stress = si.sensors["stress"]
    np.testing.assert_allclose(
        mm.sensors["stress"] * 1e6, stress, rtol=0, atol=1e-9 * np.abs(stress).max()
    )
    # J = kg m^2 / s^2
    np.testing.assert_allclose(mm.energy / 1e3, si.energy, rtol=0, atol=1e-10 * si.energy.max())


# -- discretisations ----------------------------------------------------------------------------


def material(E):
    return jo.Material(E=E, nu=0.3, rho=7850.0)


def swinging(*pieces):
    """Rods in a row, fixed to one another, on a hinge; released horizontally in gravity."""
    bodies, joints, x, at = [], [], 0.0, jo.ground["origin"]
    for i, (length, reduced) in enumerate(pieces):
        body = jo.FlexibleBody(f"piece {i}", reduced, position=(x, 0, 0))
        if i == 0:
            joints.append(jo.Revolute("hinge", at, body["start"], axis=(0.0, 0.3, 1.0)))
        else:
            joints.append(jo.Fixed(f"weld {i}", at, body["start"]))
        at, x = body["end"], x + length
        bodies.append(body)
    return jo.Mechanism(
        *bodies, *joints, jo.Gravity((0.0, -9.81, 0.0)), jo.PositionSensor("tip", at)
    )


def tip(mechanism, step=5e-4):
    return march(jo.compile(mechanism), jo.ROS2(step=step), 0.4, 0.01).sensors["tip"]


def one_piece(reduced):
    return swinging((1.0, reduced))


def test_lumped_and_consistent_mass_converge_with_refinement():
    # both are of second order in the element length: halving it quarters the difference
    gaps = []
    for elements in (4, 8, 16):
        motions = []
        for lumped in (True, False):
            part = jo.Part.beam(1.0, SECTION, elements, material(1.1e9), lumped=lumped)
            method = jo.CraigBampton(interfaces=("start",), modes=8)
            motions.append(tip(one_piece(jo.reduce(part, method))))
        gaps.append(float(np.abs(motions[0] - motions[1]).max()))
    assert gaps[0] > 1e-5  # it is seen at all
    np.testing.assert_allclose(np.log2(np.divide(gaps[:-1], gaps[1:])), 2.0, atol=0.3)


def beam(E, elements=6, length=1.0):
    return jo.Part.beam(length, SECTION, elements, material(E), theory=jo.parts.EulerBernoulli())


@cache
def whole(E):
    """Every mode of six elements (mean axes)."""
    return tip(one_piece(jo.reduce(beam(E), jo.FreeFree(modes=36))))


@cache
def stiff():
    """The same rod without elasticity, to see how much of the motion is elastic."""
    part = beam(1.1e9)
    body = jo.RigidBody("rod", part.mass, part.inertia, center=part.center)
    end = body.at((1.0, 0.0, 0.0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], body["origin"], axis=(0.0, 0.3, 1.0))
    return tip(
        jo.Mechanism(body, hinge, jo.Gravity((0.0, -9.81, 0.0)), jo.PositionSensor("tip", end))
    )


def elastic(E):
    return float(np.abs(whole(E) - stiff()).max())


def test_two_pieces_fixed_together_converge_to_the_one_piece_beam():
    # static modes only, some, all 12 of three elements. All of them describe the same finite
    # elements; what remains is the second-order geometry that one frame cannot see
    E = 5e9
    gaps = []
    for modes in (0, 6, 12):
        half = jo.reduce(beam(E, 3, 0.5), jo.CraigBampton(("start", "end"), modes=modes))
        gaps.append(float(np.abs(tip(swinging((0.5, half), (0.5, half))) - whole(E)).max()))
    assert gaps[-1] < gaps[0]
    assert gaps[-1] < 0.01 * elastic(E), (gaps, elastic(E))


@pytest.mark.parametrize("description", ["two pieces", "tangent frame"])
def test_what_frames_differ_in_is_of_higher_order_in_the_deformation(description):
    # mean axes in one piece against (a) two pieces, (b) the frame tangent to the hinged end: with
    # complete bases they differ only by products of deformations and their rates. Four times the
    # stiffness quarters deformations and halves their rates: the difference falls eightfold, its
    # share in the elastic motion by two
    gaps = []
    for E in (5e9, 20e9):
        if description == "two pieces":
            half = jo.reduce(beam(E, 3, 0.5), jo.CraigBampton(("start", "end"), modes=12))
            motion = tip(swinging((0.5, half), (0.5, half)))
        else:
            motion = tip(one_piece(tangent(beam(E))))
        gaps.append(float(np.abs(motion - whole(E)).max()) / elastic(E))
    assert gaps[0] < 0.05
    assert 1.7 < gaps[0] / gaps[1] < 5.0, gaps


def tangent(part):
    """All modes of the part clamped at its first node: the frame is tangent to the beam there."""
    M, K = part.M.toarray(), part.K.toarray()
    w2, X = scipy.linalg.eigh(K[6:, 6:], M[6:, 6:])
    X = np.vstack([np.zeros((6, X.shape[1])), X])
    return jo.reduction.from_modes(part, X, np.sqrt(w2) / (2 * np.pi))


def test_complete_bases_of_both_reductions_are_the_same_body():
    # orthonormalised Craig-Bampton modes without the rigid ones are mean-axis modes
    E = 5e9
    craig = jo.reduce(beam(E), jo.CraigBampton(("start", "end"), modes=30))
    assert craig.n == 36
    np.testing.assert_allclose(tip(one_piece(craig)), whole(E), rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("method", "counts", "remaining"),
    [
        (partial(jo.CraigBampton, ("start",)), (2, 6, 14), 5e-4),
        # free-free modes carry no bending moment at their ends, so that a clamped end is slow
        (jo.FreeFree, (10, 20, 28), 0.2),
    ],
    ids=["Craig-Bampton", "free-free"],
)
def test_the_motion_converges_as_the_modal_basis_grows(method, counts, remaining):
    E = 1.1e9
    gaps = [
        float(np.abs(tip(one_piece(jo.reduce(beam(E), method(modes=n)))) - whole(E)).max())
        for n in counts
    ]
    assert gaps[2] < gaps[1] * 1.02 < gaps[0]
    assert gaps[2] < remaining * elastic(E), (gaps, elastic(E))
