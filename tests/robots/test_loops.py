"""Inverse kinematics of machines with loops: closed forms, limits, and what cannot be closed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.rotations import euler_parameters, exp_rotation
from jousto.model.native.native import Engine
from jousto.robots import Tree, inverse_kinematics, state_at
from robots.loops import (
    BASE,
    COUPLER,
    CRANK,
    GROUND,
    INERTIA,
    PLATE,
    ROCKER,
    about_z,
    compiled,
    delta,
    delta_angles,
    four_bar,
    freudenstein,
    quietly,
    slider_crank,
    stewart,
)
from robots.machines import ARM

# the frame is 1e-8 rad or m from its place: angles of these machines move by up to ten times that
NEAR = 1e-7


def heading(tree: Tree, body: str, q: Any) -> float:
    A = tree.forward_kinematics(q)[body].A
    return float(np.arctan2(A[1, 0], A[0, 0]))


@pytest.mark.parametrize("theta", [-2.5, -0.7, 0.3, 2.0])
def test_the_rocker_of_a_four_bar_follows_freudenstein(theta: float) -> None:
    tree = Tree(four_bar())
    assert tree.cut == ("link",) and tree.nv == 3
    found = inverse_kinematics(tree, "crank", axes=about_z(theta))
    assert found.reached, found
    assert found.gap < 1e-12 and found.open == ()
    phi = heading(tree, "rocker", found.q)
    branches = [freudenstein(theta, branch) for branch in (1, -1)]
    assert min(abs(np.sin(0.5 * (phi - x))) for x in branches) < NEAR


def test_a_start_nearby_keeps_the_branch() -> None:
    tree = Tree(four_bar(0.9))
    q = tree.initial
    for theta in np.arange(0.9, 0.9 + 2.0 * np.pi, 0.3):
        found = inverse_kinematics(tree, "crank", axes=about_z(theta), start=q)
        assert found.reached and found.starts == 1
        q = found.q
        assert abs(np.sin(0.5 * (heading(tree, "rocker", q) - freudenstein(theta)))) < NEAR


@pytest.mark.parametrize("kind", ["bar", "rod"])
def test_the_stroke_of_a_slider_crank(kind: str) -> None:
    tree = Tree(slider_crank(kind))
    theta, r, length = 1.1, 0.1, 0.25
    x = r * np.cos(theta) + np.sqrt(length**2 - (r * np.sin(theta)) ** 2)
    # away from the dead centre, where nothing says which way
    found = inverse_kinematics(
        tree, "block", (x, 0, 0), start=tree.moved(tree.initial, [0.1] + [0.0] * (tree.nv - 1))
    )
    assert found.reached, found
    assert np.cos(heading(tree, "crank", found.q)) == pytest.approx(np.cos(theta), abs=NEAR)
    # the slide is cut where it is declared last, and its coordinate is known all the same
    assert tree.coordinate("slide.displacement", found.q) == pytest.approx(x, abs=1e-8)


def test_legs_of_a_stewart_platform() -> None:
    tree = Tree(stewart())
    assert tree.cut == tuple(f"ball{i}" for i in range(1, 6))
    r, A = np.array([0.08, -0.05, 0.66]), exp_rotation([0.15, -0.2, 0.3])
    found = inverse_kinematics(tree, "plate", r, A)
    assert found.reached and found.starts == 1, found
    for i in range(6):
        length = np.linalg.norm(r + A @ PLATE[i] - BASE[i])
        assert tree.coordinate(f"leg{i}.displacement", found.q) == pytest.approx(length, abs=NEAR)


def test_motors_of_a_delta_robot() -> None:
    tree = Tree(delta())
    assert len(tree.cut) == 6 and tree.nv == 9
    position = np.array([0.06, -0.04, -0.42])
    found = inverse_kinematics(tree, "plate", position)
    assert found.reached, found
    motors = [tree.coordinate(f"motor{k}.angle", found.q) for k in range(3)]
    np.testing.assert_allclose(motors, delta_angles(position), atol=NEAR)
    # the parallelograms keep the plate level
    np.testing.assert_allclose(tree.pose("plate", found.q).A, np.eye(3), atol=NEAR)


def test_out_of_reach_loops_stay_closed() -> None:
    tree = Tree(four_bar())
    found = inverse_kinematics(tree, "crank.end", (0.3, 0.4, 0.0), starts=3)
    assert not found and found.open == ()
    # the end of the crank goes round a circle: the nearest point, quadratic in the angle
    assert found.distance == pytest.approx(0.5 - CRANK, abs=1e-9)
    assert found.gap < 1e-12
    assert "loops" not in str(found)


def test_out_of_reach_of_a_rocker_is_its_dead_centre() -> None:
    # crank and coupler in line: the law of cosines between the pivots; the end of the rocker is
    # wanted 0.2 rad further on its circle
    long = CRANK + COUPLER
    inner = np.arccos((GROUND**2 + ROCKER**2 - long**2) / (2.0 * GROUND * ROCKER))
    beyond = np.pi - inner - 0.2
    target = np.array([GROUND + ROCKER * np.cos(beyond), ROCKER * np.sin(beyond), 0.0])
    found = inverse_kinematics(Tree(four_bar()), "rocker.end", target, starts=4)
    assert not found and found.open == (), found
    # stationary there: quadratic in the angle of the crank
    assert found.distance == pytest.approx(2.0 * ROCKER * np.sin(0.1), abs=1e-9)


def test_limits_of_joints_in_and_out_of_the_tree() -> None:
    # the crank at 0.7 rad: two ways to close, the angle of the rocker tells which
    for low, high in ((-0.5, 0.6), (2.2, 2.9)):
        limits = {"drive.angle": (-1.0, 1.0), "swing.angle": (low, high), "link.angle": (-3, 3)}
        tree = Tree(four_bar(), limits=limits)
        found = inverse_kinematics(tree, "crank", axes=about_z(0.7), starts=40)
        assert found.reached, found
        for name, (lower, upper) in limits.items():
            assert lower - 1e-12 <= tree.coordinate(name, found.q) <= upper + 1e-12
    # an angle is the same after a turn
    turn = 2.0 * np.pi
    tree = Tree(four_bar(), limits={"link.angle": (turn - 3.0, turn + 3.0)})
    assert inverse_kinematics(tree, "crank", axes=about_z(0.7), starts=1).reached
    tree = Tree(four_bar(), limits={"link.angle": (0.01, 0.02)})
    held = inverse_kinematics(tree, "crank", axes=about_z(2.5), starts=3)
    assert not held and "link.angle" in held.at_limit and held.open == ()
    assert 0.01 - 1e-12 <= tree.coordinate("link.angle", held.q) <= 0.02 + 1e-12


def test_loops_that_cannot_be_closed_are_said() -> None:
    limits = {"drive.angle": (1.0, 1.1), "swing.angle": (-0.01, 0.01), "pin.angle": (0.5, 0.6)}
    found = inverse_kinematics(Tree(four_bar(), limits=limits), "coupler", (0, 0, 0), starts=3)
    assert not found and found.open == ("link",) and found.gap > 1e-3
    assert f"the loops cannot be closed, link by {found.gap:.3g} m" in str(found)
    # a place that can be reached with the loop open alone
    limits = {"drive.angle": (1.0, 1.1), "swing.angle": (-0.01, 0.01)}
    assert not inverse_kinematics(Tree(four_bar(), limits=limits), "crank", axes=np.eye(3))


KINDS = (
    *("Spherical", "Universal", "Revolute", "Prismatic", "Cylindrical", "Screw", "Planar"),
    *("PointOnLine", "PointOnPlane", "ConstantOrientation", "ParallelAxes", "Perpendicular"),
    *("Fixed", "Rod"),
)


def ring(kind: str) -> jo.Mechanism:
    """Two branches of two bodies each, hinged across, and a joint of a kind between their ends."""
    items: list[Any] = []
    ends = []
    for name, x in (("a", 0.0), ("b", 0.5)):
        turned = jo.Rotate((1, 2, 3), degrees=40 + 50 * x)
        one = jo.RigidBody(f"{name}1", 1.0, INERTIA, position=(x, 0, 0.1))
        two = jo.RigidBody(f"{name}2", 1.0, INERTIA, position=(x, 0.3, 0), orientation=turned)
        first = jo.Revolute(f"{name}.first", jo.ground.at((x, 0, 0.1)), one["origin"])
        near = one.at((0, 0.3, -0.1))
        items += [one, two, first, jo.Revolute(f"{name}.next", near, two["origin"], axis=(1, 1, 0))]
        meet = np.array([0.25, 0.5, 0.1]) + (1.0 * x if kind in ("Rod", "Distance") else 0.0)
        ends.append(two.at(two["origin"].A.T @ (meet - two.position)))
    if kind == "Gear":
        last: Any = jo.Revolute("last", *ends)
        items += [last, jo.Gear("more", items[2].angle, last.angle, -0.5)]
    elif kind == "Distance":
        far = jo.Distance(*ends)
        items += [jo.Coupling("more", (items[2].angle, far), (0.7, 2.0))]
    else:
        more = {"pitch": 0.02} if kind == "Screw" else {}
        made = getattr(jo, kind, None) if kind in dir(jo) else getattr(jo.mechanism, kind)
        items += [made("last", *ends, **more)]
    return quietly(*items)


@pytest.mark.parametrize("kind", [*KINDS, "Gear", "Distance"])
def test_what_is_missing_is_what_the_engine_says(kind: str) -> None:
    machine = ring(kind)
    tree, model = Tree(machine), compiled(machine)
    rng = np.random.default_rng(7)
    q = tree.moved(tree.initial, rng.uniform(-0.4, 0.4, tree.nv))
    engine = Engine(model)
    for body, pose in zip(model.bodies, tree.forward_kinematics(q).values(), strict=True):
        engine.q[body.iq : body.iq + 3] = pose.r
        engine.q[body.iq + 3 : body.iq + 7] = euler_parameters(pose.A)
    wanted = np.concatenate(
        [
            engine.constraints()[0][j.row : j.row + j.rows]
            for name in tree.cut
            for j in model.joints
            if j.name == name
        ]
    )
    if kind == "Screw":  # the engine counts turns from the start, here any number of them will do
        wanted[4] -= 0.02 * np.round((wanted[4] - tree.constraints(q)[4]) / 0.02)
    # of 1 m and 1 rad
    np.testing.assert_allclose(tree.constraints(q), wanted, rtol=0, atol=1e-13)
    assert np.abs(wanted).max() > 1e-3
    # central differences: third derivatives of 1 times h^2, rounding over h
    h = 1e-5
    found = tree.constraint_jacobian(q)
    for j in range(tree.nv):
        step = h * np.eye(tree.nv)[j]
        ahead, back = (tree.constraints(tree.moved(q, s * step)) for s in (1, -1))
        np.testing.assert_allclose(found[:, j], (ahead - back) / (2 * h), rtol=0, atol=1e-9)


@pytest.mark.parametrize("core", ["maximal", "joint"])
@pytest.mark.parametrize("make", [four_bar, stewart, delta])
def test_a_run_starts_where_the_loops_are_closed(make: Any, core: str) -> None:
    machine = make()
    tree, model = Tree(machine), compiled(machine, core=core)
    frame, axes = ("crank", about_z(2.0)) if make is four_bar else ("plate", None)
    place = None if make is four_bar else (0.04, 0.03, machine.bodies[0].position[2] - 0.02)
    found = inverse_kinematics(tree, frame, place, axes)
    assert found.reached, found
    state = state_at(tree, model, found.q)
    run = jo.simulate(model, 0.01, state=state, solver=jo.ROS2(1e-3))
    engine = Engine(model)
    engine.q[:] = run.q[0]
    # of 1 m: rounding
    assert np.abs(engine.constraints()[0]).max() < 1e-13
    first = run.q[0].reshape(-1, 7)
    for row, pose in zip(first, tree.forward_kinematics(found.q).values(), strict=True):
        np.testing.assert_allclose(row[:3], pose.r, atol=1e-12)
    assert np.abs(run.q[-1] - run.q[0]).max() < 1e-2  # it does not jump


def test_whole_turns_of_gears_in_a_loop() -> None:
    # a wheel geared to the angle of the joint that is cut
    machine = four_bar()
    link = machine.joints[3]
    wheel = jo.RigidBody("wheel", 1.0, INERTIA)
    axle = jo.Revolute("axle", jo.ground["origin"], wheel["origin"])
    gear = jo.Gear("gear", link.angle, axle.angle, 8.0)
    whole = quietly(*machine.items, wheel, axle, gear)
    tree, model = Tree(whole), compiled(whole)
    assert set(tree.cut) == {"link", "gear"}
    found = inverse_kinematics(tree, "crank", axes=about_z(3.0), start=tree.initial)
    assert found.reached, found
    angle = tree.coordinate(link.angle, found.q)
    off = tree.coordinate("axle.angle", found.q) - 8.0 * angle
    assert abs(off) < 1e-11 and abs(angle) > np.pi / 8.0
    start = tree.moved(found.q, [2 * np.pi * 8.0 * (n == "axle.angle") for n in tree.velocities])
    assert np.abs(tree.constraints(start)).max() < 1e-11
    state = state_at(tree, model, start)
    run = jo.simulate(model, 0.005, state=state, solver=jo.ROS2(1e-3))
    np.testing.assert_allclose(run.q[-1], run.q[0], atol=1e-2)


def test_a_flexible_body_keeps_its_shape() -> None:
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    part = jo.Part.beam(0.25, jo.Rectangle(0.02, 0.01), 4, steel)
    reduced = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2))
    crank = jo.RigidBody("crank", 1.0, INERTIA, markers={"end": (0.1, 0, 0)})
    block = jo.RigidBody("block", 1.0, INERTIA, position=(0.35, 0, 0))
    bar = jo.FlexibleBody("bar", reduced, position=(0.1, 0, 0))
    machine = quietly(
        *(crank, bar, block, jo.Revolute("drive", jo.ground["origin"], crank["origin"])),
        jo.Revolute("big", crank["end"], bar["start"]),
        jo.Revolute("small", bar["end"], block["origin"]),
        jo.Prismatic("slide", jo.ground["origin"], block["origin"], axis=(1, 0, 0)),
    )
    tree, model = Tree(machine), compiled(machine)
    found = inverse_kinematics(tree, "crank", axes=about_z(1.1))
    assert found.reached
    x = 0.1 * np.cos(1.1) + np.sqrt(0.25**2 - (0.1 * np.sin(1.1)) ** 2)
    assert tree.pose("bar.end", found.q).r[0] == pytest.approx(x, abs=NEAR)
    state = state_at(tree, model, found.q)
    engine = Engine(model)
    engine.q[:] = state.q
    assert np.abs(engine.constraints()[0]).max() < 1e-12
    # the mass of the part, swung about its start: rho A L^3 / 3, its width as of a beam
    swing = Tree(quietly(bar, jo.Revolute("pivot", jo.ground.at((0.1, 0, 0)), bar["start"])))
    J = 7850 * 0.02 * 0.01 * 0.25**3 / 3
    assert swing.mass_matrix([0.3])[0, 0] == pytest.approx(J, rel=0.02)


def test_what_cannot_be_is_said() -> None:
    machine = four_bar()
    tree, model = Tree(machine), compiled(machine)
    for call in (tree.mass_matrix, tree.gravity_forces):
        with pytest.raises(jo.InputError, match="machines without loops, but 'link' close"):
            call(tree.initial)
    with pytest.raises(jo.InputError, match=r"no coordinate 'swing\.angel'; did you mean 'swing"):
        tree.coordinate("swing.angel", tree.initial)
    with pytest.raises(jo.InputError, match=r"no coordinate '\[\]'"):
        tree.coordinate([], tree.initial)  # type: ignore[arg-type]
    open_ = tree.moved(tree.initial, [0.2, 0.0, 0.0])
    with pytest.raises(jo.InputError, match="joint 'link': is open by 0.0.* at these positions"):
        state_at(tree, model, open_)
    with pytest.raises(jo.InputError, match="the tree has no body 'block' of"):
        state_at(tree, compiled(slider_crank("rod")), tree.initial)
    with pytest.raises(jo.InputError, match="model is 3, must be a Model"):
        state_at(tree, 3, tree.initial)  # type: ignore[arg-type]
    drive = jo.Drive("motor", machine.joints[0].angle, jo.Constant(0.0))
    whole = quietly(*machine.items, drive)
    found = inverse_kinematics(Tree(whole), "crank", axes=about_z(1.4))
    assert found.reached
    with pytest.raises(jo.InputError, match="drive 'motor': begins 0.5 .* change its signal"):
        state_at(Tree(whole), compiled(whole), found.q)
    with pytest.raises(jo.InputError, match="no such coordinate; did you mean 'link.angle'"):
        Tree(machine, limits={"lnk.angle": (0, 1)})


def test_the_mechanism_of_a_robot_starts_there_too(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(ARM, encoding="utf-8")
    robot = jo.robots.read_urdf(path)
    tree, machine = Tree(robot), jo.robots.mechanism(robot)
    wanted = tree.pose("tcp", 0.5 * (np.maximum(tree.lower, -2) + np.minimum(tree.upper, 2.2)))
    found = inverse_kinematics(tree, "tcp", wanted.r, wanted.A)
    assert found.reached
    run = jo.simulate(
        jo.compile(machine), 0.001, state=state_at(tree, jo.compile(machine), found.q)
    )
    # sensors of the names of the joints read their coordinates
    for name, value in zip(tree.positions, found.q, strict=True):
        assert run[name.partition(".")[0]][0, 0] == pytest.approx(value, abs=1e-12)


@pytest.mark.parametrize("kind", ["bar", "rod"])
def test_angles_stay_within_half_a_turn_of_the_start(kind: str) -> None:
    """Least squares may go round: 1.1 rad of the crank came out as -5.2 rad."""
    tree = Tree(slider_crank(kind))
    angles = [name.endswith(".angle") for name in tree.velocities]
    for x in np.linspace(0.2, 0.34, 8):
        found = inverse_kinematics(tree, "block", (x, 0, 0))
        assert found.reached and found.gap < 1e-12, found
        assert np.abs((found.q - tree.initial)[angles]).max() <= np.pi + 1e-12


def test_a_pose_outside_the_limits_is_no_start() -> None:
    machine = four_bar()
    tree = Tree(machine, limits={"swing.angle": (-1.0, 1.0)})
    place = tree.velocities.index("swing.angle")
    with pytest.raises(jo.InputError, match="swing.angle is 2, outside its limits -1 and 1"):
        state_at(tree, compiled(machine), tree.moved(tree.initial, 2.0 * np.eye(tree.nv)[place]))
