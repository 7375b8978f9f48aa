"""Mesh: sets, picks, outer faces, volumes."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.mesh.cells import KINDS, SOLIDS, faces, mirrored
from jousto.mesh.reference import places

from .blocks import block


@pytest.mark.parametrize("kind", SOLIDS)
def test_outer_surface_closes_and_holds_the_volume(kind: str) -> None:
    mesh = block(kind, (3, 2, 2), (0.3, 0.2, 0.1))
    p = mesh.nodes[mesh.triangles]
    area = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]) / 2.0
    # Gauss: the normals of a closed surface add up to zero, x . n / 3 to the volume
    np.testing.assert_allclose(area.sum(axis=0), 0.0, atol=1e-15)
    assert np.sum(p.mean(axis=1) * area) / 3.0 == pytest.approx(0.3 * 0.2 * 0.1, rel=1e-12)
    assert mesh.volume == pytest.approx(0.3 * 0.2 * 0.1, rel=1e-12)
    assert np.linalg.norm(area, axis=1).sum() == pytest.approx(0.22, rel=1e-12)
    # every face belongs to the element that is said to own it
    solid = np.concatenate([c.nodes for c in mesh.solids])
    for block_of_faces in mesh.faces:
        for nodes, owner, side in zip(
            block_of_faces.nodes, block_of_faces.owners, block_of_faces.sides, strict=True
        ):
            assert tuple(solid[owner][list(faces(kind)[side])]) == tuple(nodes)


@pytest.mark.parametrize("kind", ["tetra10", "hexahedron20", "wedge15"])
def test_volume_of_curved_cells(kind: str) -> None:
    # a plate bent to a quarter ring: midside nodes on the arcs, volume by Pappus' rule
    mesh = block(kind, (8, 2, 2), (np.pi / 2, 0.2, 0.1))
    angle, r, z = mesh.nodes[:, 0], 1.0 + mesh.nodes[:, 1], mesh.nodes[:, 2]
    bent = jo.Mesh("ring", np.stack([r * np.cos(angle), r * np.sin(angle), -z], axis=1), mesh.cells)
    # parabolas through three points of an arc of 11.25 degrees miss it by some 1e-6
    assert bent.volume == pytest.approx(np.pi / 2 * 1.1 * 0.2 * 0.1, rel=1e-5)


def test_quality_of_ideal_and_known_cells() -> None:
    s = 1.0 / np.sqrt(2.0)
    regular = [(1, 0, -s), (-1, 0, -s), (0, 1, s), (0, -1, s)]
    mesh = jo.Mesh("regular", regular, jo.mesh.Cells("tetra", [(0, 2, 1, 3)]))
    assert mesh.volume > 0.0
    assert mesh.quality().scaled_jacobian == pytest.approx([1.0])
    assert mesh.quality().aspect == pytest.approx([1.0])
    # the corner of a cube: three right angles at one corner, 45, 45, 60 degrees at the others;
    # there sqrt(2) det / (1 sqrt(2) sqrt(2)) = 1 / sqrt(2)
    corner = jo.Mesh("corner", places("tetra"), jo.mesh.Cells("tetra", [(0, 1, 2, 3)]))
    assert corner.quality().scaled_jacobian == pytest.approx([1.0 / np.sqrt(2.0)])
    # a cube sheared by 45 degrees: every corner has an angle of 45 or 135 degrees
    cube = block("hexahedron", (1, 1, 1), (1.0, 1.0, 1.0))
    sheared = jo.Mesh("sheared", cube.nodes + cube.nodes[:, [1, 1, 1]] * (1, 0, 0), cube.cells)
    assert sheared.quality().scaled_jacobian == pytest.approx([np.sin(np.pi / 4)])
    assert sheared.quality().aspect == pytest.approx([np.sqrt(2.0)])
    assert sheared.quality().jacobian_ratio == pytest.approx([1.0])


@pytest.mark.parametrize("kind", SOLIDS)
def test_mirrored_order_turns_a_cell(kind: str) -> None:
    mesh = block(kind, (1, 1, 1), (1.0, 1.0, 1.0))
    turned = jo.mesh.Cells(kind, mesh.cells[0].nodes[:, mirrored(kind)])
    assert jo.Mesh("turned", mesh.nodes * (1, 1, -1), turned).volume == pytest.approx(1.0)
    assert np.all(jo.Mesh("m", mesh.nodes * (1, 1, -1), turned).quality().scaled_jacobian > 0.1)


def test_sets_of_elements_and_faces_are_node_sets() -> None:
    mesh = block("hexahedron", (4, 1, 1), (4.0, 1.0, 1.0))
    end = next(f.nodes[f.sides == 5] for f in mesh.faces)[:1]
    named = jo.Mesh(
        "bar",
        mesh.nodes,
        mesh.cells,
        element_sets={"right": [3, 2]},
        surfaces={"left": end},
        node_sets={"corner": [7, 0]},
    )
    np.testing.assert_array_equal(named.set("right"), mesh.box((2, 0, 0), (4, 1, 1)))
    np.testing.assert_array_equal(named.set("left"), mesh.box((0, 0, 0), (0, 1, 1)))
    np.testing.assert_array_equal(named.set("corner"), [0, 7])
    with pytest.raises(InputError, match="no set 'rihgt'; did you mean 'right'"):
        named.set("rihgt")
    with pytest.raises(ValueError, match="read-only"):
        named.set("right")[0] = 1
    assert "20 nodes, 4 hexahedron, 4000 x 1000 x 1000 mm" in str(named)


def test_picks() -> None:
    mesh = block("hexahedron", (4, 4, 4), (0.4, 0.4, 0.4))
    middle = (0.2, 0.2, 0.2)
    assert len(mesh.box((0.1, 0.1, 0.1), (0.3, 0.3, 0.3))) == 27
    assert len(mesh.box((0.1, 0.1, 0.1), (0.3, 0.3, 0.3), surface=True)) == 0
    assert len(mesh.box((-np.inf, -np.inf, 0.0), (np.inf, np.inf, 0.0))) == 25
    assert len(mesh.sphere(middle, 0.1)) == 7
    assert len(mesh.cylinder(middle, (0, 0, 2), 0.1)) == 25
    assert len(mesh.cylinder(middle, (0, 0, 2), 0.1, 0.2)) == 15
    assert len(mesh.cylinder(middle, (0, 0, 2), 0.1, surface=True)) == 10
    assert len(mesh.plane((0, 0.1, 0), (0, -3, 0))) == 25
    np.testing.assert_array_equal(mesh.normal_to((1, 0, 0)), mesh.plane((0.4, 0, 0), (1, 0, 0)))
    near = mesh.nearest((0.41, 0.4, 0.4), 2)
    away = np.linalg.norm(mesh.nodes[near] - 0.4, axis=1)
    np.testing.assert_allclose(np.sort(away), [0.0, 0.1], atol=1e-12)
    named = mesh.with_set("pin", near)
    np.testing.assert_array_equal(named.set("pin"), np.sort(near))
    np.testing.assert_allclose(mesh.scaled(2.0).nodes, 2.0 * mesh.nodes)


def test_a_new_set_takes_the_place_of_a_surface_and_an_element_set() -> None:
    mesh = block("hexahedron", (2, 1, 1), (0.2, 0.1, 0.1))
    left = next(f.nodes[f.sides == 5] for f in mesh.faces)[:1]
    named = jo.Mesh(
        "bar",
        mesh.nodes,
        mesh.cells,
        element_sets={"half": [0]},
        surfaces={"end": left},
    )
    right = mesh.box((0.2, 0, 0), (0.2, 1, 1))
    other = named.with_set("end", right).with_set("half", right)
    assert not other.surfaces and not other.element_sets
    assert set(named.with_set("more", right).surfaces) == {"end"}
    # pressure on that name acts there, and nowhere else
    part = jo.Part.solid(other, jo.material("S355"))
    force = part.load(jo.parts.Pressure("end", 1.0)).reshape(-1, 3)
    np.testing.assert_array_equal(np.flatnonzero(np.abs(force).sum(axis=1)), right)
    np.testing.assert_allclose(force.sum(axis=0), [-0.01, 0.0, 0.0], atol=1e-15)


def test_wrong_picks_are_told() -> None:
    mesh = block("tetra", (1, 1, 1), (1.0, 1.0, 1.0))
    with pytest.raises(InputError, match="axis is zero") as caught:
        mesh.cylinder((0, 0, 0), (0, 0, 0), -1.0)
    assert len(caught.value.problems) == 2
    with pytest.raises(InputError, match="normal is zero"):
        mesh.plane((0, 0, 0), (0, 0, 0))
    with pytest.raises(InputError, match="angle is 0 degrees"):
        mesh.normal_to((0, 0, 1), 0.0)
    with pytest.raises(InputError, match="factor is -1"):
        mesh.scaled(-1.0)


def test_wrong_arrays_are_told_together() -> None:
    with pytest.raises(InputError) as caught:
        jo.Mesh(
            "bad",
            np.zeros((4, 3)),
            (jo.mesh.Cells("tetra", [(0, 1, 2, 4)]),),
            node_ids=[1, 2],
            node_sets={"a": [9]},
            surfaces={"s": [(0, 1)]},
        )
    text = str(caught.value)
    assert "tetra element 0 has node index 4, must be in 0..3" in text
    assert "node_ids has shape (2,)" in text
    assert "node set 'a' contains 9" in text
    assert "surface 's' has shape (1, 2)" in text
    with pytest.raises(InputError, match="unknown kind; known: tetra, tetra10"):
        jo.mesh.Cells("tet", [(0, 1, 2, 3)])
    with pytest.raises(InputError, match=r"must be \(any, 10\)"):
        jo.mesh.Cells("tetra10", [(0, 1, 2, 3)])
    assert set(SOLIDS) < set(KINDS)


def test_dropping_what_solids_do_not_use() -> None:
    mesh = block("tetra10", (2, 1, 1), (2.0, 1.0, 1.0))
    more = jo.Mesh(
        "more",
        np.concatenate([np.full((2, 3), 9.0), mesh.nodes]),
        (
            jo.mesh.Cells("line", [(0, 1)]),
            jo.mesh.Cells("tetra10", mesh.cells[0].nodes + 2, mesh.cells[0].ids),
        ),
        np.arange(100, 102 + len(mesh.nodes)),
        node_sets={"centre": [0, 5]},
        surfaces={"all": np.concatenate([f.nodes for f in mesh.faces]) + 2},
    )
    assert {finding.kind for finding in more.check()} == {"free nodes"}
    less = more.solid()
    np.testing.assert_allclose(less.nodes, mesh.nodes)
    np.testing.assert_array_equal(less.cells[0].nodes, mesh.cells[0].nodes)
    np.testing.assert_array_equal(less.node_ids, np.arange(102, 102 + len(mesh.nodes)))
    np.testing.assert_array_equal(less.set("centre"), [3])
    assert len(less.surfaces["all"]) == len(more.surfaces["all"])
    assert less.check() == ()
