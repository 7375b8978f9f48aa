"""Mechanisms of robots: stops, dry friction and rotors, by closed forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.robots import Robot, mechanism, read_urdf
from robots.machines import ARM

WHEEL = """<robot name="r"><link name="base"/><link name="wheel"><inertial><mass value="2"/>
<inertia ixx="0.5" ixy="0" ixz="0" iyy="0.5" iyz="0" izz="0.5"/></inertial></link>
<joint name="axle" type="{}"><parent link="base"/><child link="wheel"/><axis xyz="1 0 0"/>{}</joint>
</robot>"""
LIMIT = '<limit lower="-1" upper="0.5" effort="{}" velocity="9"/>'


def turning(
    folder: Path,
    inner: str,
    kind: str = "revolute",
    rate: float = 0.0,
    t_end: float = 1.0,
    restitution: float = 1.0,
) -> jo.Solution:
    """Run the wheel without weight from a rate."""
    path = folder / "wheel.urdf"
    path.write_text(WHEEL.format(kind, inner), encoding="utf-8")
    machine = mechanism(read_urdf(path), gravity=(0, 0, 0), restitution=restitution)
    (axle,) = machine.joints
    begun = jo.Initial(axle.coordinates[0], rate=rate)
    speed = jo.RateSensor("speed", axle.coordinates[0])
    whole = jo.Mechanism(*machine.items, begun, speed)
    return jo.simulate(jo.compile(whole), t_end, solver=jo.RK4(1e-4))


@pytest.mark.parametrize(
    ("kind", "inertia", "give"), [("revolute", 0.5, 0.01), ("prismatic", 2.0, 1e-3)]
)
@pytest.mark.parametrize("effort", [10.0, 1e4])
def test_a_stop_is_a_spring(
    kind: str, inertia: float, give: float, effort: float, tmp_path: Path
) -> None:
    # the stiffer of 50 Hz, and of the largest effort at 0.01 rad or 1 mm
    k = max(inertia * (2 * np.pi * 50) ** 2, effort / give)
    rate, t_end = 2.0, 0.5
    run = turning(tmp_path, LIMIT.format(effort), kind, rate, t_end)
    s, speed = run["axle"][:, 0], run["speed"][:, 0]
    # half a period in the stop, which gives back all: v sqrt(M / k) deep
    deep, stay = rate * np.sqrt(inertia / k), np.pi * np.sqrt(inertia / k)
    # instants of 1e-4 s miss the deepest point by (w h / 2)^2 / 2 of it, 1.3e-3 at most
    assert s.max() - 0.5 == pytest.approx(deep, rel=2e-3)
    # a step over the kink of the force misses up to k v h^2 / M of the speed, here 1e-3
    assert speed[-1] == pytest.approx(-rate, rel=2e-3)
    assert s[-1] == pytest.approx(0.5 - rate * (t_end - 0.25 - stay), abs=1e-3)


@pytest.mark.parametrize(("kind", "unit"), [("revolute", 0.1), ("prismatic", 0.02)])
def test_a_stop_gives_back_a_share_of_the_speed(kind: str, unit: float, tmp_path: Path) -> None:
    """``v_out^2 = e^2 v_in^2 + C speed^2`` with C = 0.2127 for e = 0.5, by quadrature."""
    speed = max(unit, 9 / 20)  # a twentieth of what the file allows
    run = turning(tmp_path, LIMIT.format(10.0), kind, 2.0, 0.5, restitution=0.5)
    back = np.sqrt(0.25 * 2.0**2 + 0.21266 * speed**2)
    # a step over a kink misses up to k v h^2 / M of the speed, 1e-3, twice
    assert run["speed"][-1, 0] == pytest.approx(-back, abs=4e-3)


def test_dry_friction_stops_the_wheel(tmp_path: Path) -> None:
    limits = '<limit lower="-9" upper="9" effort="1" velocity="9"/>'
    run = turning(tmp_path, f'{limits}<dynamics friction="0.4"/>', rate=0.5)
    s, speed = run["axle"][:, 0], run["speed"][:, 0]
    # 0.5 - 0.8 t until 0.01 rad/s, from where it fades
    i = np.searchsorted(run.time, 0.5)
    assert speed[i] == pytest.approx(0.5 - 0.8 * 0.5, abs=1e-9)
    assert s[-1] == pytest.approx(0.5**2 / (2 * 0.8), abs=1e-3)
    assert abs(speed[-1]) < 1e-3


def test_a_rotor_adds_its_inertia(tmp_path: Path) -> None:
    path = tmp_path / "wheel.urdf"
    path.write_text(WHEEL.format("continuous", '<dynamics armature="0.3"/>'), encoding="utf-8")
    robot = read_urdf(path)
    machine = mechanism(robot, efforts={"axle": 2.0})
    run = jo.simulate(jo.compile(machine), 1.0, solver=jo.RK4(1e-3))
    assert run["axle"][-1, 0] == pytest.approx(0.5 * 2.0 / 0.8, rel=1e-10)
    assert jo.robots.Tree(robot).mass_matrix([0.0])[0, 0] == pytest.approx(0.8, rel=1e-14)


def test_wrong_names_and_stiffness_are_told(tmp_path: Path) -> None:
    path = tmp_path / "wheel.urdf"
    path.write_text(WHEEL.format("continuous", ""), encoding="utf-8")
    robot = read_urdf(path)
    with pytest.raises(jo.InputError, match=r"at\['axl'\]: no such joint; did you mean 'axle'"):
        mechanism(robot, at={"axl": 0.1})
    with pytest.raises(jo.InputError, match="stops is -1 N/m or N m/rad, must be a positive"):
        mechanism(robot, stops=-1.0)
    with pytest.raises(jo.InputError, match="restitution is 2, must be between 0 and 1"):
        mechanism(robot, restitution=2.0)


def read(text: str, folder: Path) -> Robot:
    path = folder / "robot.urdf"
    path.write_text(text, encoding="utf-8")
    return read_urdf(path)


def test_joints_start_where_their_drives_begin_and_the_others_where_they_shall(
    tmp_path: Path,
) -> None:
    robot = read(ARM, tmp_path)
    made = mechanism(robot, at={"j3.angle": 0.4}, drives={"j2": jo.Constant(0.3)})
    starts = {
        joint.name: joint.coordinates[0].initial for joint in made.joints if joint.coordinates
    }
    # positions of bodies are rounded at 1e-16 m beside arms of some 0.1 m
    assert starts["j2"] == pytest.approx(0.3, abs=1e-12)
    assert starts["j3"] == pytest.approx(0.4, abs=1e-12)
    rig = jo.robots.RobotInMechanism("rig", robot, at={"j2": 0.3})
    motor = jo.Drive("motor", rig.joints["j2"].angle, jo.Constant(0.25))
    with pytest.raises(jo.InputError, match="'motor'.*begins at 0.25 rad, but .* stands at 0.3"):
        jo.Mechanism(rig, motor)
    jo.Mechanism(rig, jo.Drive("motor", rig.joints["j2"].angle, jo.Constant(0.3 + 2 * np.pi)))


FOLLOWER = """<robot name="r"><link name="base"/>
<link name="a"><inertial><mass value="1"/><inertia ixx=".1" ixy="0" ixz="0" iyy=".1" iyz="0" izz=".1"/></inertial></link>
<link name="b"><inertial><mass value="1"/><inertia ixx=".1" ixy="0" ixz="0" iyy=".1" iyz="0" izz=".1"/></inertial></link>
<joint name="lead" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" effort="10" velocity="3"/></joint>
<joint name="other" type="revolute"><parent link="base"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="-0.5" upper="0.5" effort="10" velocity="3"/><mimic joint="lead" multiplier="2"/></joint>
</robot>"""  # noqa: E501


def test_a_start_keeps_the_limits_of_the_joints_that_follow(tmp_path: Path) -> None:
    robot = read(FOLLOWER, tmp_path)
    jo.robots.RobotInMechanism("r", robot, at={"lead": 0.2})
    with pytest.raises(jo.InputError, match="0.3 rad is outside the limits -0.25 and 0.25"):
        jo.robots.RobotInMechanism("r", robot, at={"lead": 0.3})
    with pytest.raises(jo.InputError, match="outside the limits"):
        mechanism(robot, at={"lead": 0.3})


def test_whether_there_are_stops_and_losses_is_checked(tmp_path: Path) -> None:
    robot = read(FOLLOWER, tmp_path)
    bare = jo.robots.RobotInMechanism("r", robot, stops=np.bool_(False))
    assert not [x for x in bare.items if isinstance(x, jo.mechanism.Stop)]
    with pytest.raises(jo.InputError, match="losses is 'no', must be True or False"):
        jo.robots.RobotInMechanism("r", robot, losses="no")  # type: ignore[arg-type]
    with pytest.raises(jo.InputError, match="robot 'r'.*stops is 'yes', must be True, False or a"):
        jo.robots.RobotInMechanism("r", robot, stops="yes")
