"""Robots as parts of larger machines, against closed forms and the same machines by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import jousto as jo
from jousto.robots import RobotInMechanism, Tree, read_urdf
from robots.machines import ARM, CREATURE, SCARA

M, L, J = 2.0, 0.4, 0.05  # of the pendulum: mass, distance of its centre, inertia about it
PENDULUM = f"""<robot name="r"><link name="base"/><link name="rod">
<inertial><origin xyz="{L} 0 0"/><mass value="{M}"/>
<inertia ixx="0.06" ixy="0" ixz="0" iyy="0.06" iyz="0" izz="{J}"/></inertial></link>
<link name="tip"/>
<joint name="hinge" type="{{}}"><parent link="base"/><child link="rod"/>
<axis xyz="0 0 1"/>{{}}</joint>
<joint name="end" type="fixed"><parent link="rod"/><child link="tip"/>
<origin xyz="0.9 0 0" rpy="0 0 1.5707963267948966"/></joint></robot>"""
MC, G, TH0 = 3.0, 9.81, 0.9


@pytest.fixture
def pendulum(tmp_path: Path) -> Path:
    """The file of a pendulum along x that turns about z, with some damping."""
    path = tmp_path / "pendulum.urdf"
    path.write_text(PENDULUM.format("continuous", '<dynamics damping="0.3"/>'), encoding="utf-8")
    return path


def cart_and_pendulum(t: float, y: np.ndarray) -> list[float]:
    """Return the rates of (x, theta, x', theta'), theta from straight down, losses 0.3 theta'."""
    _, th, v, w = y
    A = [[MC + M, M * L * np.cos(th)], [M * L * np.cos(th), J + M * L**2]]
    b = [M * L * np.sin(th) * w**2, -M * G * L * np.sin(th) - 0.3 * w]
    return [v, w, *np.linalg.solve(A, b)]


@pytest.mark.parametrize("core", ["joint", "maximal"])
def test_a_pendulum_on_a_cart(core: str, pendulum: Path) -> None:
    """Against the equations of the textbook, and the cart stays where it is when an angle is given.

    The root of the robot is turned so that the rod at zero hangs down along -z and turns about y,
    which is x of the world for the rod at theta = 90 deg.
    """
    cart = jo.RigidBody("cart", MC, (0.1, 0.1, 0.1), markers={"pin": (0.05, 0.02, 0.3)})
    slide = jo.Prismatic("slide", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    down = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])  # columns x, y, z
    arm = RobotInMechanism(
        "arm", pendulum, cart["pin"], orientation=down, position=(0, 0, 0.1), at={"hinge": TH0}
    )
    x = jo.CoordinateSensor("x", slide.displacement)
    tip = jo.PositionSensor("tip", arm["tip"])
    machine = jo.Mechanism(cart, slide, arm, x, tip, jo.Gravity((0, 0, -G)))
    assert [body.name for body in machine.bodies] == ["cart", "arm_rod"]
    run = jo.simulate(jo.compile(machine, core=core), 1.5, solver=jo.RK4(5e-4))
    reference = solve_ivp(
        cart_and_pendulum, (0, 1.5), [0, TH0, 0, 0], t_eval=run.time, rtol=1e-11, atol=1e-12
    )
    # RK4 of 5e-4 s: (w h)^4 / 120 with w = 7 rad/s over 10 rad, some 1e-11; the reference 1e-10
    assert run["x"][:, 0] == pytest.approx(reference.y[0], abs=1e-9)
    assert run["arm_hinge"][:, 0] == pytest.approx(reference.y[1], abs=1e-9)
    th = reference.y[1]
    assert run["tip"][:, 0] == pytest.approx(0.05 + reference.y[0] + 0.9 * np.sin(th), abs=1e-9)
    assert run["tip"][:, 2] == pytest.approx(0.4 - 0.9 * np.cos(th), abs=1e-9)


def test_a_frame_has_the_axes_of_the_file(pendulum: Path) -> None:
    arm = RobotInMechanism("arm", pendulum, jo.ground.at((1, 2, 3)), at={"hinge": 0.5})
    tree, tip = Tree(read_urdf(pendulum)), arm["tip"]
    there = tree.pose("tip", [0.5])
    assert tip.r == pytest.approx(there.r + (1, 2, 3), abs=1e-14)
    assert tip.A == pytest.approx(there.A, abs=1e-14)
    assert arm["base"].r == pytest.approx((1, 2, 3), abs=1e-14)
    with pytest.raises(jo.InputError, match="robot 'arm': no frame 'tipp'; did you mean 'tip'"):
        arm["tipp"]


def test_what_stands_on_a_moving_body_moves_with_it(pendulum: Path) -> None:
    """All bodies have the velocity of one rigid body at the start: no blow, no loss of energy."""
    w, v = np.array([0.3, -1.0, 2.0]), np.array([1.0, 0.5, -0.2])
    base = jo.RigidBody(
        *("base", 5.0, (0.3, 0.4, 0.5)),
        position=(1, 0, 2),
        velocity=v,
        angular_velocity=w,
        markers={"seat": (0.2, -0.1, 0.3)},
    )
    arm = RobotInMechanism(
        "arm", pendulum, base["seat"], orientation=jo.Rotate((1, 1, 0), degrees=50)
    )
    rod = arm.bodies["rod"]
    assert rod.velocity == pytest.approx(v + np.cross(w, rod.position - base.position), abs=1e-14)
    c = rod["center"].r - base.position
    energy = 0.5 * 5.0 * v @ v + 0.5 * w @ np.diag([0.3, 0.4, 0.5]) @ w
    energy += 0.5 * M * np.sum((v + np.cross(w, c)) ** 2)
    own = rod["origin"].A @ np.diag([0.06, 0.06, J]) @ rod["origin"].A.T
    energy += 0.5 * w @ own @ w
    run = jo.simulate(jo.compile(jo.Mechanism(base, arm)), 0.01, solver=jo.RK4(1e-3))
    assert run.energy.kinetic[0] == pytest.approx(energy, rel=1e-13)


def test_a_robot_on_a_flexible_body(pendulum: Path) -> None:
    """Its root becomes a body of no account on the node; the same machine by hand agrees."""
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.03), 4, jo.material("S355"))
    reduced = jo.reduce(part, jo.CraigBampton(("start", "end"), 2))
    beam = jo.FlexibleBody("beam", reduced, damping=0.02)
    clamp = jo.Fixed("clamp", jo.ground["origin"], beam["start"])
    turn, axis = np.array([[0.0, 1, 0], [0, 0, -1], [-1, 0, 0]]), (0, -1, 0)
    down = jo.Gravity((0, 0, -9.81))
    arm = RobotInMechanism("arm", pendulum, beam["end"], orientation=turn, at={"hinge": 0.5})
    whole = jo.compile(jo.Mechanism(beam, clamp, arm, down))
    start = arm.bodies["rod"]
    rod = jo.RigidBody(
        *("rod", M, (0.06, 0.06, J)),
        center=(L, 0, 0),
        position=start.position,
        orientation=start.orientation,
    )
    hinge = jo.Revolute("hinge", beam["end"], rod["origin"], axis=axis)
    loss = jo.Spring("loss", hinge.angle, damping=0.3)
    angle = jo.CoordinateSensor("angle", hinge.angle)
    by_hand = jo.compile(jo.Mechanism(beam, clamp, rod, hinge, loss, angle, down))
    one, two = (jo.simulate(x, 0.3, solver=jo.ROS2(5e-4)) for x in (whole, by_hand))
    # the massless root weighs a millionth of the rod
    assert one["arm_hinge"][:, 0] - 0.5 == pytest.approx(two["angle"][:, 0], abs=1e-5)
    assert np.ptp(two["angle"]) > 0.3


def test_a_robot_on_a_robot(pendulum: Path) -> None:
    """Two pendulums, one on the tip of the other, are the double pendulum of one file."""
    one = RobotInMechanism("one", pendulum, at={"hinge": 0.4})
    two = RobotInMechanism("two", pendulum, one["tip"], at={"hinge": -0.7}, losses=False)
    machine = jo.Mechanism(one, two)
    assert {x.name for x in machine.joints} == {"one_hinge", "two_hinge"}
    tree = Tree(machine)
    C = one["tip"].r
    expected = J + M * L**2
    assert tree.mass_matrix(tree.initial)[1, 1] == pytest.approx(expected, rel=1e-12)
    # at the initial pose: inertia of all about the first axis
    c = two.bodies["rod"]["center"].r
    whole = 2 * J + M * L**2 + M * (c @ c)
    assert tree.mass_matrix(tree.initial)[0, 0] == pytest.approx(whole, rel=1e-12)
    assert C == pytest.approx((0.9 * np.cos(0.4), 0.9 * np.sin(0.4), 0), abs=1e-14)


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
def test_a_creature_moves_from_where_it_is_put(tmp_path: Path) -> None:
    """A robot that moves freely is put where it shall be as one."""
    path = tmp_path / "creature.xml"
    path.write_text(CREATURE, encoding="utf-8")
    turn = jo.Rotate((1, 2, 3), degrees=40)
    free = RobotInMechanism("it", path, position=(1, 2, 3), orientation=turn, at={"roll": -0.2})
    alone = RobotInMechanism("it", path, at={"roll": -0.2})
    A = turn.matrix
    for name, body in alone.bodies.items():
        moved = free.bodies[name]
        assert moved.position == pytest.approx(A @ body.position + (1, 2, 3), abs=1e-13)
    machine = jo.Mechanism(free)
    assert machine.mobility == jo.Mechanism(alone).mobility


def test_rotors_of_slides_weigh_nothing(tmp_path: Path) -> None:
    """A slide that stands upright falls as m / (m + armature) of gravity, however it is turned."""
    text = PENDULUM.format("prismatic", '<limit effort="1" velocity="1" lower="-9" upper="9"/>'
                           '<dynamics armature="3"/>')  # fmt: skip
    path = tmp_path / "slide.urdf"
    path.write_text(text, encoding="utf-8")
    arm = RobotInMechanism(
        "arm", path, orientation=jo.Rotate((0, 1, 0), degrees=0), at={"hinge": 0.2}
    )
    machine = jo.Mechanism(arm, jo.Gravity((0, 0, -G)))
    run = jo.simulate(jo.compile(machine), 0.5, solver=jo.RK4(1e-3))
    fall = 0.5 * G * M / (M + 3.0) * 0.5**2
    assert run["arm_hinge"][-1, 0] == pytest.approx(0.2 - fall, rel=1e-9)


def test_a_base_without_mass_weighs_nothing(tmp_path: Path) -> None:
    box = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
    text = PENDULUM.format("continuous", "").replace(
        '<link name="base"/>', f'<link name="base">{box}</link>'
    )
    path = tmp_path / "drawn.urdf"
    path.write_text(text, encoding="utf-8")
    arm = RobotInMechanism("arm", path)
    assert arm.bodies["base"].mass == pytest.approx(1e-6 * M)
    assert arm.bodies["base"].outline is not None


def test_all_that_is_wrong_is_told_at_once(tmp_path: Path) -> None:
    path = tmp_path / "scara.urdf"
    path.write_text(SCARA, encoding="utf-8")
    with pytest.raises(jo.InputError) as error:
        RobotInMechanism(
            *("arm", path, "cart"),
            at={"lift": 0.3, "spinn": 0, "elbow": "x", "shoulder": 1.0},
        )
    assert str(error.value).splitlines() == [
        "robot 'arm': base is 'cart', must be a rigid body, a marker or None for the ground",
        "robot 'arm': at['lift']: 0.3 m is outside the limits 0 and 0.2; start between them, or "
        "give stops=False",
        "robot 'arm': at['spinn']: no such joint; did you mean 'spin'?",
        "robot 'arm': at['elbow']: is 'x', must be a number",
    ]
    with pytest.raises(jo.InputError) as error:
        RobotInMechanism(
            *("arm", path),
            at={"lift": 0.3, "spinn": 0, "elbow": "x", "spin": 4.0},
            prefix="a.",
        )
    assert str(error.value).splitlines() == [
        "robot 'arm': prefix is 'a.', must contain no '.' and no '/'",
        "robot 'arm': at['lift']: 0.3 m is outside the limits 0 and 0.2; start between them, or "
        "give stops=False",
        "robot 'arm': at['spinn']: no such joint; did you mean 'spin'?",
        "robot 'arm': at['elbow']: is 'x', must be a number",
        "robot 'arm': at['spin']: is 4 rad, must be within half a turn",
    ]
    robot = read_urdf(path)
    with pytest.raises(jo.InputError) as error:
        jo.Mechanism(RobotInMechanism("a", robot), RobotInMechanism("b", robot, prefix="a_"))
    assert str(error.value) == (
        "robot 'b': the names of its bodies and joints begin with 'a_', as those of robot 'a'; "
        "give it another prefix"
    )


def test_a_tree_of_the_machine_knows_the_frames_of_the_robot(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(ARM, encoding="utf-8")
    alone = jo.robots.Tree(jo.robots.read_urdf(path))
    rig = jo.robots.RobotInMechanism("rig", path)
    tree = jo.robots.Tree(jo.Mechanism(rig, jo.Gravity((0, 0, -9.81))))
    q = 0.3 * np.arange(1, 7)
    here, there = tree.pose("rig_tcp", q), alone.pose("tcp", q)
    np.testing.assert_allclose(here.r, there.r, rtol=0, atol=1e-14)
    np.testing.assert_allclose(here.A, there.A, rtol=0, atol=1e-14)
