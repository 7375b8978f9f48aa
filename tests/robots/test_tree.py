"""Trees: against closed forms, against Pinocchio, and against the engine."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.rotations import rotation_matrix
from jousto.robots import Tree, mechanism, read_urdf
from robots.machines import ARM, GRIPPER, SCARA

ROBOTS = {"arm": (ARM, True, "tcp"), "scara": (SCARA, True, "spindle")}
ROBOTS |= {"gripper": (GRIPPER, False, "right")}
# rounding of some hundred products, against the largest number that is compared
ROUNDING = 1e-12


def read(text: str, folder: Path, **options: Any) -> jo.robots.Robot:
    path = folder / "robot.urdf"
    path.write_text(text, encoding="utf-8")
    return read_urdf(path, **options)


def near(found: Any, wanted: Any) -> None:
    scale = max(1e-3, float(np.abs(wanted).max()))
    np.testing.assert_allclose(found, wanted, rtol=0, atol=ROUNDING * scale)


def test_the_planar_arm_of_the_textbooks() -> None:
    # Murray, Li and Sastry, A Mathematical Introduction to Robotic Manipulation (1994), example
    # 4.3: alpha = I1 + I2 + m1 r1^2 + m2 (l1^2 + r2^2), beta = m2 l1 r2, delta = I2 + m2 r2^2
    m1, m2, l1, r1, r2, I1, I2 = 3.0, 2.0, 0.8, 0.35, 0.3, 0.2, 0.1
    one = jo.RigidBody("one", m1, (I1, I1, I1), center=(r1, 0, 0), markers={"end": (l1, 0, 0)})
    two = jo.RigidBody("two", m2, (I2, I2, I2), center=(r2, 0, 0), position=(l1, 0, 0))
    first = jo.Revolute("first", jo.ground["origin"], one["origin"])
    second = jo.Revolute("second", one["end"], two["origin"])
    tree = Tree(jo.Mechanism(one, two, first, second, jo.Gravity((0, -9.81, 0))))
    assert tree.velocities == ("first.angle", "second.angle")
    alpha, beta = I1 + I2 + m1 * r1**2 + m2 * (l1**2 + r2**2), m2 * l1 * r2
    delta, g = I2 + m2 * r2**2, 9.81
    q, v = np.array([0.4, -1.1]), np.array([0.7, 1.9])
    c, s = np.cos(q[1]), np.sin(q[1])
    M = [[alpha + 2 * beta * c, delta + beta * c], [delta + beta * c, delta]]
    C = [[-beta * s * v[1], -beta * s * (v[0] + v[1])], [beta * s * v[0], 0.0]]
    far = m2 * r2 * g * np.cos(q.sum())
    G = [(m1 * r1 + m2 * l1) * g * np.cos(q[0]) + far, far]
    near(tree.mass_matrix(q), M)
    near(tree.gravity_forces(q), G)
    near(tree.bias_forces(q, v), C @ v + G)
    tip = two.at((0.6, 0, 0))
    x = l1 * np.cos(q[0]) + 0.6 * np.cos(q.sum()), l1 * np.sin(q[0]) + 0.6 * np.sin(q.sum())
    near(tree.pose(tip, q).r, [*x, 0.0])
    J = np.zeros((6, 2))
    J[:2] = [[-x[1], -0.6 * np.sin(q.sum())], [x[0], 0.6 * np.cos(q.sum())]]
    J[5] = 1.0
    near(tree.jacobian(tip, q), J)


def test_the_arm_on_a_slide_of_the_textbooks() -> None:
    # a turn about z, then a slide along the turned x: r'' - r w^2, d(m r^2 + I) w / dt
    m, I = 2.0, 0.3
    arm = jo.RigidBody("arm", 1.0, (0.3, 0.3, 0.4))
    load = jo.RigidBody("load", m, (I, I, I))
    turn = jo.Revolute("turn", jo.ground["origin"], arm["origin"])
    slide = jo.Prismatic("slide", arm["origin"], load["origin"], axis=(1, 0, 0))
    tree = Tree(jo.Mechanism(arm, load, turn, slide))
    r, w, u = 0.7, 1.3, -0.4
    near(tree.mass_matrix([0.5, r]), np.diag([0.4 + I + m * r * r, m]))
    near(tree.bias_forces([0.5, r], [w, u]), [2 * m * r * w * u, -m * r * w * w])


@pytest.mark.parametrize("name", ROBOTS)
def test_against_pinocchio(name: str, tmp_path: Path) -> None:
    pin = pytest.importorskip("pinocchio")
    text, fixed, frame = ROBOTS[name]
    tree = Tree(read(text, tmp_path, fixed_base=fixed))
    base = () if fixed else (pin.JointModelFreeFlyer(),)
    model = pin.buildModelFromXML(text, *base)
    data = model.createData()
    rng = np.random.default_rng(7)
    for _ in range(5):
        q = pin.randomConfiguration(model, np.full(model.nq, -2.0), np.full(model.nq, 2.0))
        v, a = rng.normal(size=(2, model.nv))
        own, T = translated(tree, model, q)
        own_v, own_a = T @ v, T @ a
        if not fixed:  # its velocity is resolved in the turning body
            own_a[:3] += T[:3, :3] @ np.cross(v[3:6], v[:3])
        M = np.triu(pin.crba(model, data, q))
        near(T.T @ tree.mass_matrix(own) @ T, M + np.triu(M, 1).T)
        near(T.T @ tree.inverse_dynamics(own, own_v, own_a), pin.rnea(model, data, q, v, a))
        gravity = pin.computeGeneralizedGravity(model, data, q)
        near(T.T @ tree.gravity_forces(own), gravity)
        number = model.getFrameId(frame)
        J = pin.computeFrameJacobian(model, data, q, number, pin.LOCAL_WORLD_ALIGNED)
        near(tree.jacobian(frame, own) @ T, J)
        pin.updateFramePlacements(model, data)
        near(tree.pose(frame, own).r, data.oMf[number].translation)
        near(tree.pose(frame, own).A, data.oMf[number].rotation)


def translated(tree: Tree, model: Any, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return positions of the tree, and T of ``v = T v_pin``."""
    own, T = np.zeros(tree.nq), np.zeros((tree.nv, model.nv))
    if "body.vx" in tree.velocities:
        own[:7] = q[[0, 1, 2, 6, 3, 4, 5]]
        T[:3, :3], T[3:6, 3:6] = rotation_matrix(own[3:7]), np.eye(3)
    for i, coordinate in enumerate(tree.velocities):
        if coordinate in tree.positions:
            joint = model.joints[model.getJointId(coordinate.partition(".")[0])]
            values = q[joint.idx_q : joint.idx_q + joint.nq]
            # a turn without limits is kept as cosine and sine
            value = values[0] if joint.nq == 1 else np.arctan2(values[1], values[0])
            own[tree.positions.index(coordinate)] = value
            T[i, joint.idx_v] = 1.0
    return own, T


def several() -> jo.Mechanism:
    """A machine with joints of all kinds, some of them the wrong way round, and couplings."""
    rng = np.random.default_rng(3)

    def body(name: str, mass: float, at: tuple[float, ...]) -> jo.RigidBody:
        B = rng.normal(size=(3, 3))
        S = B @ B.T
        inertia = 0.01 * (np.trace(S) * np.eye(3) - S)
        turn = jo.Rotate(rng.normal(size=3), radians=1.0)
        center = 0.1 * rng.normal(size=3)
        return jo.RigidBody(name, mass, inertia, center=center, position=at, orientation=turn)

    places = {"a": (0, 0, 1), "b": (0.5, 0, 1), "c": (1, 0.2, 1), "d": (1, 0.2, 0.4)}
    places |= {"e": (0.3, 0.9, 1), "f": (-0.4, 0.1, 1.2), "g": (-1, 0, 0.3), "h": (-1, 1, 0.2)}
    bodies = {name: body(name, 1.0 + i, at) for i, (name, at) in enumerate(places.items())}

    def at(name: str, world: tuple[float, ...]) -> Any:
        one = bodies[name]
        return one.at(rotation_matrix(one.orientation).T @ (np.array(world) - one.position))

    ground = jo.ground.at
    hinge = jo.Revolute("hinge", at("a", (0, 0, 0.8)), ground((0, 0, 0.8)), axis=(0, 0.3, 1))
    wrist = jo.Universal(
        "wrist", at("a", (0.2, 0, 1)), at("b", (0.2, 0, 1)), axis_a=(0, 0, 1), axis_b=(1, 1, 0)
    )
    ball = jo.Spherical("ball", at("c", (0.9, 0.1, 1)), at("b", (0.9, 0.1, 1)))
    post = jo.Cylindrical("post", at("c", (1, 0.2, 0.8)), at("d", (1, 0.2, 0.4)), axis=(0, 0, 1))
    table = jo.Planar("table", at("e", (0.3, 0.5, 1)), at("a", (0.3, 0.2, 1)), normal=(0, 0, 1))
    weld = jo.Fixed("weld", at("a", (-0.2, 0, 1)), at("f", (-0.2, 0, 1)))
    thread = jo.Screw("thread", at("h", (-1, 0.5, 0.2)), at("g", (-1, 0, 0.2)), 0.3, axis=(0, 1, 0))
    gear = jo.Gear("gear", wrist.angle1, wrist.angle2, -1.5)
    joints = (hinge, wrist, ball, post, table, weld, thread, gear)
    return jo.Mechanism(*bodies.values(), *joints, jo.Gravity((0.3, -0.2, -9.0)))


def test_against_the_engine() -> None:
    machine = several()
    tree = Tree(machine)
    model = jo.compile(machine)
    engine = jo.model.Engine(model)
    rng = np.random.default_rng(5)
    for _ in range(3):
        away = 0.6 * rng.normal(size=tree.nv)
        away[-1] *= 0.1  # the engine counts the turns of the thread, 0.3 m each, from the start
        q, v = tree.moved(tree.initial, away), rng.normal(size=tree.nv)
        poses = tree.forward_kinematics(q)
        for body in model.bodies:
            at, J = poses[body.name], tree.jacobian(body.name, q)
            engine.q[body.iq : body.iq + 3] = at.r
            engine.q[body.iq + 3 : body.iq + 7] = jo.base.rotations.euler_parameters(at.A)
            engine.v[body.iv : body.iv + 3] = J[:3] @ v
            engine.v[body.iv + 3 : body.iv + 6] = at.A.T @ J[3:] @ v
        engine.accelerations()
        assert engine.residuals()[0] < 1e-9  # the joints are closed
        a = tree.forward_dynamics(q, v, np.zeros(tree.nv))
        # accelerations of the bodies by a central difference of J v along the motion
        h = 1e-5
        ahead, behind = (tree.moved(q, s * h * (v + 0.5 * s * h * a)) for s in (1, -1))
        for body in model.bodies:
            J = [
                tree.jacobian(body.name, x) @ (v + s * h * a) for x, s in ((ahead, 1), (behind, -1))
            ]
            rate = (J[0] - J[1]) / (2 * h)
            found = np.array(engine.a[body.iv : body.iv + 6])
            found[3:] = poses[body.name].A @ found[3:]
            # the error of the difference is of the order h^2, 1e-10, of numbers of size 100
            np.testing.assert_allclose(found, rate, rtol=0, atol=1e-6 * np.abs(rate).max())


@pytest.mark.parametrize("name", ROBOTS)
def test_the_mechanism_of_a_robot_is_the_same_tree(name: str, tmp_path: Path) -> None:
    text, fixed, frame = ROBOTS[name]
    robot = read(text, tmp_path, fixed_base=fixed)
    one, two = Tree(robot), Tree(mechanism(robot))
    kept = Tree(read(text, tmp_path, fixed_base=fixed, merge=False))
    assert one.velocities == two.velocities == kept.velocities
    rng = np.random.default_rng(1)
    q, v, a = one.moved(one.initial, rng.normal(size=one.nv)), *rng.normal(size=(2, one.nv))
    for other in (two, kept):
        near(other.mass_matrix(q), one.mass_matrix(q))
        near(other.inverse_dynamics(q, v, a), one.inverse_dynamics(q, v, a))
    near(kept.pose(frame, q).r, one.pose(frame, q).r)
    near(one.forward_dynamics(q, v, one.inverse_dynamics(q, v, a)), a)


def test_power_of_gravity_is_the_rate_of_the_potential() -> None:
    tree = Tree(several())
    rng = np.random.default_rng(2)
    q, v = tree.moved(tree.initial, rng.normal(size=tree.nv)), rng.normal(size=tree.nv)
    machine = several()

    def potential(x: np.ndarray) -> float:
        return -sum(
            body.mass * tree.gravity @ tree.pose(body["center"], x).r for body in machine.bodies
        )

    h = 1e-5
    rate = (potential(tree.moved(q, h * v)) - potential(tree.moved(q, -h * v))) / (2 * h)
    assert tree.gravity_forces(q) @ v == pytest.approx(rate, rel=1e-7)


def test_what_is_no_tree_is_refused() -> None:
    rod = jo.RigidBody("rod", 1.0, (1.0, 1.0, 1.0), markers={"end": (1, 0, 0)})
    one = jo.Revolute("one", jo.ground["origin"], rod["origin"])
    two = jo.Revolute("two", jo.ground.at((1, 0, 0)), rod["end"])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        loop = Tree(jo.Mechanism(rod, one, two))
    with pytest.raises(jo.InputError, match="for machines without loops, but 'two' close loops"):
        loop.inverse_dynamics([0.0], [0.0], [0.0])
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    beam = jo.BeamBody("beam", [(0, 0, 0), (1, 0, 0)], jo.Circle(0.05), steel, elements=2)
    with pytest.raises(jo.InputError, match="belongs to a beam; a tree has no exact beams"):
        Tree(jo.Mechanism(beam, jo.Revolute("foot", jo.ground["origin"], beam["start"])))
    tree = Tree(jo.Mechanism(rod, one))
    with pytest.raises(jo.InputError, match=r"q has shape \(2,\), must be \(1\)"):
        tree.mass_matrix([0.0, 1.0])
    with pytest.raises(jo.InputError, match=r"no frame 'rod\.and'; did you mean 'rod\.end'"):
        tree.jacobian("rod.and", [0.0])
    with pytest.raises(jo.InputError, match="lower limit 1 is above the upper limit 0"):
        Tree(jo.Mechanism(rod, one), limits={"one.angle": (1, 0)})
