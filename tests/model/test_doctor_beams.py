"""What the doctor says of geometrically exact beams."""

import pytest

import jousto as jo

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)


@pytest.mark.parametrize("elements", [1, 7])
def test_a_beam_counts_as_one_rigid_body(elements):
    """A rod that turns on a hinge: one motion if it were rigid, with its nodes 6 n more."""
    beam = jo.BeamBody("rod", [(0, 0, 0), (1, 1, 0)], jo.Circle(0.01), STEEL, elements=elements)
    hinge = jo.Revolute("hinge", jo.ground["origin"], beam["start"], (0, 0, 1))
    found = jo.doctor(jo.Mechanism(beam, hinge, jo.Gravity((0, -9.81, 0))))
    assert found.rigid_mobility == 1
    assert found.mobility == 1 + 6 * elements
    assert found.moving == ("rod",) and not found.still and found.healthy


def test_a_clamped_end_is_still_and_both_clamps_hold_a_rigid_rod_twice():
    beam = jo.BeamBody("rod", [(0, 0, 0), (1, 0, 0)], jo.Circle(0.01), STEEL, elements=3)
    clamps = (
        jo.Fixed("a", jo.ground["origin"], beam["start"]),
        jo.Fixed("b", jo.ground.at((1, 0, 0)), beam["end"]),
    )
    found = jo.doctor(jo.Mechanism(beam, *clamps, jo.Gravity((0, -9.81, 0))))
    assert found.rigid_mobility == 0 and found.mobility == 12
    assert found.still == ("rod.node1", "rod.node4")
    assert found.moving == ("rod.node2", "rod.node3")
