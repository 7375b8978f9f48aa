"""Interfaces before reduction: which nodes, which point, which weights."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from jousto.base.errors import InputError, JoustoWarning
from jousto.materials.material import Material
from jousto.mesh.area import area_matrix
from jousto.mesh.picks import InBox, InCylinder, InSphere, Nearest
from jousto.parts.interface import Interface
from jousto.parts.part import Part
from jousto.sections.section import Rectangle
from reduction.hexes import box

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)


def tie(part: Part, *args: Any, **options: Any) -> Any:
    return part.with_interfaces(Interface("i", *args, **options)).ties[0]


# -- picks ----------------------------------------------------------------------------------


def test_picks_take_the_same_end() -> None:
    part = box()
    right = np.array(part.node_sets["right"])
    for pick in (
        InBox((0.4, -np.inf, -np.inf), (np.inf, np.inf, np.inf)),
        InBox((0.39, -1, -1), (0.41, 1, 1)),
        InCylinder((0.4, 0, 0), (-2, 0, 0), np.hypot(0.05, 0.03), length=0.01),
        InSphere((0.4, 0, 0), np.hypot(0.05, 0.03)),
        Nearest((0.5, 0, 0), count=len(right)),
    ):
        assert np.array_equal(tie(part, pick).nodes, right)
        # in any order
        assert np.array_equal(tie(part, right[::-1]).nodes, right)


def test_pick_in_millimetres_says_where_the_nodes_are() -> None:
    with pytest.raises(
        InputError, match=r"the pick contains no node; the nodes lie in \(0, -0.05, -0.03\)"
    ):
        tie(box(), InBox((399, -100, -100), (401, 100, 100)))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: InBox((1, 0, 0), (0, 1, 1)), "low is 1 m along x, above high, 0 m"),
        (lambda: InBox((1, 0), (0, 1, 1)), r"low is \(1, 0\), must be three numbers"),
        (lambda: InCylinder((0, 0, 0), (0, 0, 0), 1.0), "axis is zero"),
        (lambda: InCylinder((0, 0, 0), (0, 0, 1), -1.0), "radius is -1 m"),
        (lambda: InSphere((0, 0), 1.0), "point has shape"),
        (lambda: Nearest((0, 0, 0), 0), "count is 0"),
    ],
)
def test_impossible_picks(make: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()


# -- reference point ------------------------------------------------------------------------


def bore(angles: Any, inner: float = 0.02, turn: Any = None) -> Part:
    """Nodes of a ring of bars about a bore, in three layers along its axis."""
    t, z = np.meshgrid(angles, [0.0, 0.01, 0.03], indexing="ij")
    x = np.stack([inner * np.cos(t), inner * np.sin(t), z], axis=-1).reshape(-1, 3)
    e = [(3 * i + a, 3 * i + b) for i in range(len(angles)) for a, b in ((0, 1), (1, 2))]
    e += [(3 * i, 3 * i + 3) for i in range(len(angles) - 1)]
    x = x if turn is None else x @ turn.T
    return Part.frame(x + [0.3, 0.1, 0.2], e, sections=Rectangle(0.002, 0.002), materials=STEEL)


@pytest.mark.parametrize("span", [np.linspace(0, 6, 20), np.linspace(0, 2.8, 9) ** 1.1])
def test_reference_point_of_a_bore_is_on_its_axis(span: Any) -> None:
    from scipy.spatial.transform import Rotation

    A = Rotation.from_rotvec([0.4, 1.0, -0.3]).as_matrix()
    part = bore(span, turn=A)
    found = tie(part, np.arange(len(part.nodes)))
    np.testing.assert_allclose(found.at, A @ [0, 0, 0.015] + [0.3, 0.1, 0.2], atol=1e-9)
    # a third of a turn tells no axis: the centroid
    part = bore(np.linspace(0, 2.0, 9))
    found = tie(part, np.arange(len(part.nodes)))
    np.testing.assert_allclose(found.at, part.nodes.mean(axis=0), atol=1e-12)


def test_reference_point_of_a_surface_is_its_centroid_by_area() -> None:
    part = box()
    nodes = part.nodes.copy()
    # nodes crowd at one side
    nodes[:, 1] = 0.05 * (2 * ((nodes[:, 1] + 0.05) / 0.1) ** 2 - 1)
    crowded = replace(part, nodes=nodes, faces=())
    assert tie(crowded, "right").at[1] < -0.01
    faces = [f for f in part.faces[0] if np.all(np.isin(f, part.node_sets["right"]))]
    found = tie(crowded, faces)
    np.testing.assert_allclose(found.at, [0.4, 0, 0], atol=1e-15)
    assert found.by_area and not tie(crowded, "right").by_area


# -- weights --------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["rigid", "average"])
@pytest.mark.parametrize("nodes", ["right", [3, 40, 75, 12]])
def test_average_of_a_rigid_motion_is_that_motion(kind: Any, nodes: Any) -> None:
    part = box()
    found = tie(part, nodes, kind=kind, at=(0.5, 0.2, -0.1))
    np.testing.assert_allclose(
        found.averaging @ found.following.reshape(-1, 6), np.eye(6), atol=1e-11
    )
    # and its transpose is equivalent to the force and moment
    R = part.rigid_modes()[found.dofs]
    a = found.at
    wrench = np.block([[np.eye(3), np.zeros((3, 3))], [np.cross(a, np.eye(3)).T, np.eye(3)]])
    np.testing.assert_allclose(R.T @ found.averaging.T, wrench, atol=1e-10)


def test_even_traction_over_quadratic_faces() -> None:
    # shares of an even traction: 1/3 at the middles of tri6, -1/12 and 1/3 of quad8
    x = np.array([[0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0], [1, 0, 0], [2, 1.5, 0], [1, 3, 0],
                  [0, 1.5, 0], [1, 1.5, 0]], float)  # fmt: skip
    tri = np.array([[0, 1, 2, 4, 5, 8], [0, 2, 3, 8, 6, 7]])
    share = area_matrix(x, [tri]).sum(axis=0)
    np.testing.assert_allclose(share, [0, 0, 0, 0, 1, 1, 1, 1, 2], atol=1e-14)
    quad = area_matrix(x, [np.array([[0, 1, 2, 3, 4, 5, 6, 7]])])
    np.testing.assert_allclose(quad.sum(axis=0)[:8], [-0.5] * 4 + [2.0] * 4, atol=1e-14)
    # int y^2 dA of nodal values y is exact
    np.testing.assert_allclose(x[:, 1] @ (quad @ x[:, 1]), 2 * 27 / 3, rtol=1e-13)
    np.testing.assert_allclose(
        area_matrix(x, [tri[:, :3]]).sum(axis=0), [2, 1, 2, 1, 0, 0, 0, 0, 0], atol=1e-14
    )


def test_own_weights() -> None:
    part = box()
    found = tie(part, [75, 3, 40, 12], kind="average", weights=[1, 2, 0, 4.0])
    x = part.nodes[[75, 3, 12]]
    np.testing.assert_allclose(found.at, np.array([1, 2, 4]) @ x / 7, atol=1e-14)
    assert not np.any(found.averaging[:, 3 * 2 : 3 * 3])  # node 40, the third


# -- what cannot be tied --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("rihgt",), "no node set 'rihgt'; did you mean 'right'?"),
        (([3],), "its 1 node lies on one point, so that the rotation"),
        (([0, 3, 6],), "its 3 nodes lie on one line"),
        (([0, 999],), r"contains node 999, must be an index in 0\.\.83"),
        (([0, 3, 3],), "contains a node twice"),
        ((3.5,), "nodes is 3.5, must be the name of a node set"),
        (([[0, 1, 2, 3, 4]],), "its faces have 5 nodes, must be 3"),
    ],
)
def test_nodes_that_cannot_be_tied(args: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        tie(box(), *args)


def test_all_that_is_wrong_at_once() -> None:
    with pytest.raises(InputError) as error:
        box().with_interfaces(
            Interface("a", "left"),
            Interface("b", [0, 20, 40]),
            Interface("a", "nowhere"),
            Interface("c", InBox((5, 5, 5), (6, 6, 6))),
        )
    text = str(error.value)
    assert "'b': node1 is tied to interface 'a' already" in text
    assert "two interfaces are named 'a'" in text
    with pytest.raises(InputError, match="'left': has the name of a node set with other nodes"):
        box().with_interfaces(Interface("left", "right"))
    assert box().with_interfaces(Interface("left", "left")).ties[0].name == "left"
    assert "no node set 'nowhere'" in text and "the pick contains no node" in text


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"kind": "RBE2"}, "kind is 'RBE2', must be 'rigid'"),
        ({"at": (0, 0)}, r"at has shape \(2,\)"),
        ({"weights": [1, 1]}, "a rigid interface has no weights"),
        ({"kind": "average", "weights": [1, -1]}, "weights must not be negative"),
        ({"name": "node7"}, "reserved for the node of that number"),
        ({"name": ""}, "must be a word"),
    ],
)
def test_impossible_interfaces(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Interface(**{"name": "i", "nodes": "right", **options})


def test_thin_patch_warns() -> None:
    part = box()
    far = (200.0, 0.0, 0.0)
    with pytest.warns(JoustoWarning, match="far from the reference point"):
        tie(part, [0, 3, 6, 1], at=far)
    assert tie(part, "right").conditioning > 0.2


def test_beam_nodes_tie_by_rotations_too() -> None:
    beam = Part.beam(1.0, Rectangle(0.1, 0.1), 2, STEEL)
    found = tie(beam, "end", at=(1.0, 0.3, 0.0))
    # translation of the point beside the end from translation and rotation of the node
    q = found.averaging @ np.array([0, 0, 0, 0, 0, 0.01])
    np.testing.assert_allclose(q, [-0.003, 0, 0, 0, 0, 0.01], atol=1e-15)
    with pytest.raises(InputError, match="its 2 nodes lie on one line"):
        tie(beam, [0, 2], kind="average")
