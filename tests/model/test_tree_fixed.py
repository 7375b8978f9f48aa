"""Bodies on fixed joints, which join what they are fixed to before the recursion of a tree."""

from __future__ import annotations

from typing import Any

import pytest

import jousto as jo
from model.test_tree import compared, tree

FIXED = ("fixed", "fixed", "revolute", "spherical", "universal")


# as of random trees with few of them: positions closed to 1e-12 by assembly
@pytest.mark.parametrize("seed", range(8))
def test_trees_of_many_fixed_joints(seed: int) -> None:
    a, lam = compared(tree(seed, count=10, kinds=FIXED), seed)
    assert a < 1e-10
    assert lam < 1e-10


@pytest.mark.filterwarnings("ignore:.*nothing can move")
@pytest.mark.parametrize("seed", [0, 1])
def test_trees_of_fixed_joints_alone(seed: int) -> None:
    """On the ground nothing moves; the body on which all are fixed is free with seed 0."""
    a, lam = compared(tree(seed, kinds=("fixed",)), seed)
    assert a < 1e-10
    assert lam < 1e-10


def test_links_hang_on_what_moves() -> None:
    bodies = [jo.RigidBody(f"body{k}", 1.0, (1, 1, 1), position=(k, 0, 0)) for k in range(5)]
    joints: list[Any] = []
    for k, body in enumerate(bodies):
        a = bodies[k - 1].at((1, 0, 0)) if k else jo.ground.at((0, 0, 0))
        kind = jo.Fixed if k in (1, 2, 4) else jo.Revolute
        joints.append(kind(f"joint{k}", a, body.at((0, 0, 0))))
    model = jo.compile(jo.Mechanism(*bodies, *joints), core="joint")
    assert [link.parent for link in model.links] == [-1, 0, 0, 0, 3]
