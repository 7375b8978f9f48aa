"""doctor: mobility, bodies that cannot move, repeated and contradicting rows."""

import warnings

import numpy as np
import pytest

import jousto as jo
from reduction.bodies import bent

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
ORIGIN, Z = jo.ground["origin"], (0, 0, 1)


def rigid(name: str, length: float, position, turn: float = 0.0) -> jo.RigidBody:
    orientation = (np.cos(turn / 2), 0.0, 0.0, np.sin(turn / 2))
    return jo.RigidBody(
        name,
        1.0,
        (0.01, 0.1, 0.1),
        center=(length / 2, 0, 0),
        position=position,
        orientation=orientation,
    )


def fourbar(last=jo.Revolute):
    """A parallelogram that stands upright: crank and rocker 1 m, coupler 2 m."""
    crank = rigid("crank", 1.0, (0, 0, 0), np.pi / 3)
    end = np.array([np.cos(np.pi / 3), np.sin(np.pi / 3), 0.0])
    coupler, rocker = rigid("coupler", 2.0, end), rigid("rocker", 1.0, (2, 0, 0), np.pi / 3)
    joints = [
        jo.Revolute("A", ORIGIN, crank["origin"], Z),
        jo.Revolute("B", crank.at((1, 0, 0)), coupler["origin"], Z),
        jo.Revolute("C", coupler.at((2, 0, 0)), rocker.at((1, 0, 0)), Z),
        jo.Revolute("D", jo.ground.at((2, 0, 0)), rocker["origin"], Z),
    ]
    return [crank, coupler, rocker, *joints]


def test_a_planar_fourbar_has_three_rows_too_many_and_one_motion():
    found = jo.doctor(jo.Mechanism(*fourbar()))
    # Gruebler in space: 3 bodies, 4 x 5 rows; in the plane one motion remains
    assert (found.rows, found.mobility, found.rigid_mobility) == (20, 1, 1)
    assert found.redundancy is not None
    assert found.redundancy.count == 3
    assert not found.healthy
    assert not found.problems
    assert set(found.moving) == {"crank", "coupler", "rocker"}
    assert "replace the revolute joint" in str(found)


def test_bodies_that_cannot_move_are_named():
    crank, coupler, rocker, *joints = fourbar()
    held = jo.Fixed("weld", ORIGIN, crank["origin"])
    found = jo.doctor(jo.Mechanism(crank, coupler, rocker, held, *joints[:2]))
    assert found.still == ("crank",)
    assert found.mobility == 18 - 16 + found.redundancy.count == 1 + 6
    assert set(found.moving) == {"coupler", "rocker"}


def test_nothing_moves_and_the_sentence_says_so():
    wheel = rigid("wheel", 1.0, (0, 0, 0))
    hinges = [jo.Revolute("one", ORIGIN, wheel["origin"], Z)]
    hinges.append(jo.Revolute("two", ORIGIN, wheel["origin"], (0, 1, 0)))
    found = jo.doctor(jo.Mechanism(wheel, *hinges))
    assert found.mobility == 0
    assert found.still == ("wheel",)
    assert "nothing can move" in str(found)


def test_a_loop_that_cannot_close_is_a_problem_not_an_exception():
    crank, _, rocker, *joints = fourbar()
    rod = jo.Rod(
        "rod", crank.at((1, 0, 0)), rocker.at((1, 0, 0)), length=4.5, as_placed=False
    )  # 4 at most
    found = jo.doctor(jo.Mechanism(crank, rocker, joints[0], joints[3], rod))
    assert found.mobility is None
    assert any("cannot be closed" in str(problem) for problem in found.problems)
    assert "cannot be closed" in str(found)


def test_elastic_motions_are_counted_beside_the_rigid_ones():
    part = jo.reduce(bent(), jo.CraigBampton(interfaces=("start",), modes=3))
    body = jo.FlexibleBody("bent", part)
    hinge = jo.Revolute("hinge", jo.ground.at((0.1, -0.2, 0.3)), body["start"], Z)
    found = jo.doctor(jo.Mechanism(body, hinge))
    assert found.healthy
    assert found.rigid_mobility == 1
    assert found.mobility == 1 + part.n


# -- mobility by rank, said once -------------------------------------------------------------------


def said_of(*items: object) -> list[str]:
    """All warnings of a mechanism, its compilation and its diagnosis."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        jo.compile(jo.Mechanism(*items))
    return [str(w.message) for w in caught]


def with_a_ball() -> tuple[list, jo.Revolute]:
    """The parallelogram with a spherical joint: 18 rows, 18 coordinates, and one motion."""
    crank, coupler, rocker, a, b, _, d = fourbar()
    c = jo.Spherical("C", coupler.at((2, 0, 0)), rocker.at((1, 0, 0)))
    return [crank, coupler, rocker, a, b, c, d], a


def test_a_fourbar_with_a_spherical_joint_moves_and_that_is_said_once():
    items, _ = with_a_ball()
    (text,) = said_of(*items, jo.Gravity((0, -9.81, 0)))
    assert "1 of the constraint rows" in text
    assert "the motion is right" in text
    assert "cannot move" not in text
    assert "nothing can move" not in text


USES = {
    "drive": lambda s: jo.Drive("motor", s, jo.Ramp(0, 1)),
    "motor": lambda s: jo.JointForce("motor", s, 5.0),
    "controller": lambda s: jo.Servo("control", s, 0.0, 10.0),
    "spring": lambda s: jo.Spring("spring", s, 10.0),
    "sensor": lambda s: jo.CoordinateSensor("encoder", s),
}


@pytest.mark.parametrize("use", USES)
def test_a_joint_whose_coordinate_is_used_is_never_to_be_replaced(use):
    items, crank = with_a_ball()
    (free,) = said_of(*items)
    assert "replace the revolute joint 'A'" in free  # the first choice where nothing uses it
    (text,) = said_of(*items, USES[use](crank.angle))
    assert "'A' by" not in text
    assert "leave out the joint 'A'" not in text
    assert "replace the revolute joint 'B'" in text
    # driven completely it moves all the same
    assert "the motion is right" in text


def test_the_advice_that_is_left_makes_all_rows_independent():
    items, a = with_a_ball()
    drive = USES["drive"](a.angle)
    crank, coupler = items[:2]
    items[4] = jo.Universal("B", crank.at((1, 0, 0)), coupler["origin"], Z)
    assert said_of(*items, drive) == []


def test_held_bodies_are_told_by_rank():
    wheel = rigid("wheel", 1.0, (0, 0, 0))
    (text,) = said_of(wheel, jo.Fixed("weld", ORIGIN, wheel["origin"]))
    assert "nothing can move: its 6 constraint rows prevent every motion" in text
    hinge = jo.Revolute("hinge", ORIGIN, wheel["origin"], Z)
    assert said_of(wheel, hinge, jo.Drive("motor", hinge.angle, jo.Ramp(0, 1))) == []
