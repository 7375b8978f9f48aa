"""What Mesh.check() says about meshes that are spoilt on purpose."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.mesh.cells import SOLIDS
from jousto.mesh.inspection import require

from .blocks import block


def only(mesh: jo.Mesh, kind: str) -> jo.mesh.Finding:
    """The finding of a kind; there must be one."""
    found = [finding for finding in mesh.check() if finding.kind == kind]
    assert len(found) == 1, [str(finding) for finding in mesh.check()]
    return found[0]


@pytest.mark.parametrize("kind", SOLIDS)
def test_sound_meshes_pass(kind: str) -> None:
    assert block(kind, (2, 2, 2), (0.2, 0.2, 0.3)).check() == ()


def test_negative_jacobians_are_named() -> None:
    mesh = block("hexahedron", (3, 1, 1), (3.0, 1.0, 1.0))
    nodes = mesh.solids[0].nodes.copy()
    nodes[1] = nodes[1][[4, 5, 6, 7, 0, 1, 2, 3]]
    spoilt = jo.Mesh("bar", mesh.nodes, jo.mesh.Cells("hexahedron", nodes, [70, 80, 90]))
    finding = only(spoilt, "jacobian")
    assert finding.severity == "error"
    assert finding.ids == (80,)
    assert str(finding) == (
        "mesh 'bar': the Jacobian of 1 element of 3 is not positive (element 80): correct their"
        " node order or mesh that region again"
    )
    mirrored = jo.Mesh("mirrored", mesh.nodes * (1, 1, -1), mesh.cells)
    assert "all elements have negative volume" in only(mirrored, "jacobian").message


def test_a_folded_quadratic_element_is_named() -> None:
    mesh = block("tetra10", (1, 1, 1), (1.0, 1.0, 1.0))
    nodes = mesh.nodes.copy()
    # a midside node beyond the quarter point of its edge folds the element there
    edge = mesh.solids[0].nodes[0, [0, 1, 4]]
    nodes[edge[2]] = 0.85 * nodes[edge[0]] + 0.15 * nodes[edge[1]]
    finding = only(jo.Mesh("folded", nodes, mesh.cells), "jacobian")
    assert 1 in finding.ids
    assert "straighten the mid-side nodes" in finding.message
    # at 30 % of the edge it is ugly but not folded
    nodes[edge[2]] = 0.7 * nodes[edge[0]] + 0.3 * nodes[edge[1]]
    assert jo.Mesh("ugly", nodes, mesh.cells).check() == ()


def test_folds_between_sound_corners() -> None:
    # the middle of an edge pushed into the brick: all corners stay sound, the middle folds over
    mesh = block("hexahedron20", (1, 1, 1), (1.0, 1.0, 1.0))
    nodes = mesh.nodes.copy()
    nodes[mesh.solids[0].nodes[0, 8], 1] += 1.2
    spoilt = jo.Mesh("pushed", nodes, mesh.cells)
    assert spoilt.quality().scaled_jacobian[0] > 0.1
    assert only(spoilt, "jacobian").ids == (1,)


def test_slivers() -> None:
    # four nodes nearly in one plane, round a square: all edges are of good length
    corners = [(0, 0, 0), (1, 0, 0), (0.5, 0.5, 0.02), (0, 1, 0), (1, 1, 0), (0.5, 0.5, -1)]
    cells = [(0, 1, 3, 2), (1, 4, 3, 2), (0, 3, 1, 5), (1, 3, 4, 5)]
    mesh = jo.Mesh("plate", corners, jo.mesh.Cells("tetra", cells))
    finding = only(mesh, "sliver")
    assert finding.severity == "warning"
    assert set(finding.ids) <= {1, 2}
    assert "2 elements nearly flat (element 1, 2), scaled Jacobian down to 0.0" in finding.message
    assert "2 elements below 0.05" in str(mesh.quality())
    assert mesh.quality().worst(1)[0][0] in (1, 2)


def test_collapsed_and_doubled_elements() -> None:
    mesh = block("hexahedron", (2, 1, 1), (2.0, 1.0, 1.0))
    nodes = mesh.solids[0].nodes.copy()
    nodes[1, 6] = nodes[1, 7]
    collapsed = jo.Mesh("c", mesh.nodes, jo.mesh.Cells("hexahedron", nodes))
    assert only(collapsed, "collapsed").ids == (2,)
    twice = jo.Mesh("t", mesh.nodes, jo.mesh.Cells("hexahedron", mesh.solids[0].nodes[[0, 1, 1]]))
    finding = only(twice, "overlap")
    assert finding.severity == "error"
    assert "exported twice" in finding.message


def test_linear_beside_quadratic_elements() -> None:
    mesh = block("hexahedron20", (2, 1, 1), (2.0, 1.0, 1.0))
    nodes = mesh.solids[0].nodes
    mixed = jo.Mesh(
        "mixed",
        mesh.nodes,
        (jo.mesh.Cells("hexahedron20", nodes[:1]), jo.mesh.Cells("hexahedron", nodes[1:, :8])),
    )
    assert only(mixed, "mixed orders").ids == (1, 2)


def test_pieces_and_duplicate_nodes() -> None:
    one = block("tetra", (2, 1, 1), (0.2, 0.1, 0.1))
    nn = len(one.nodes)
    # two boxes end to end, joined in name only
    nodes = np.concatenate([one.nodes, one.nodes + (0.2, 0, 0)])
    cells = np.concatenate([one.solids[0].nodes, one.solids[0].nodes + nn])
    mesh = jo.Mesh("two", nodes, jo.mesh.Cells("tetra", cells), node_sets={"all": range(2 * nn)})
    pieces = only(mesh, "pieces")
    assert pieces.severity == "error"
    assert "has 2 pieces" in pieces.message
    assert "join them with mesh.merged()" in pieces.message
    duplicates = only(mesh, "duplicate nodes")
    assert "4 pairs of coincident nodes" in duplicates.message
    assert len(duplicates.ids) == 8
    joined = mesh.merged()
    assert joined.check() == ()
    assert len(joined.nodes) == 2 * nn - 4
    assert joined.volume == pytest.approx(mesh.volume)
    assert len(joined.set("all")) == len(joined.nodes)

    apart = jo.Mesh("apart", nodes + (nodes[:, :1] > 0.25) * (0.3, 0, 0), mesh.cells)
    far = jo.Mesh(
        "far",
        np.concatenate([one.nodes, one.nodes + (0.5, 0, 0)]),
        jo.mesh.Cells("tetra", cells),
    )
    finding = only(far, "pieces")
    assert "300 mm apart: join them in the geometry, or make each piece a part" in finding.message
    assert apart.name == "apart"
    with pytest.raises(InputError, match="2 pieces"):
        require(far)


def test_shells_points_and_pyramids() -> None:
    mesh = block("hexahedron", (1, 1, 1), (1.0, 1.0, 1.0))
    nodes = np.concatenate([mesh.nodes, [(2, 0, 0), (3, 0, 0), (0.5, 0.5, 2.0)]])
    shell = jo.Mesh("s", nodes, (*mesh.cells, jo.mesh.Cells("line", [(8, 9)], [55])))
    assert only(shell, "free nodes").ids == (9, 10)
    assert only(shell, "unused nodes").ids == (11,)
    with pytest.warns(jo.JoustoWarning) as caught:
        require(shell)
    said = sorted(str(warning.message) for warning in caught)
    assert ["belong to" in sentence for sentence in said] == [True, True]
    top = mesh.box((0, 0, 1), (1, 1, 1))
    pyramid = jo.mesh.Cells("pyramid", [(top[0], top[2], top[3], top[1], 10)], [66])
    mixed = jo.Mesh("p", nodes, (*mesh.cells, pyramid))
    finding = only(mixed, "unsupported")
    assert finding.severity == "error"
    assert "1 pyramid (element 66) cannot be used" in finding.message
    surface = jo.Mesh("shell", mesh.nodes, jo.mesh.Cells("quad", [(0, 1, 2, 3)]))
    (finding,) = surface.check()
    assert "contains no solid elements, only quad" in finding.message
    assert surface.volume == 0.0
    assert str(surface.quality()) == "no solid elements"


def test_empty_sets() -> None:
    mesh = block("hexahedron", (1, 1, 1), (1.0, 1.0, 1.0))
    spoilt = jo.Mesh(
        "e",
        mesh.nodes,
        mesh.cells,
        node_sets={"bore": []},
        element_sets={"pin": []},
        surfaces={"wall": np.zeros((0, 3))},
    )
    assert "empty sets 'bore', 'pin', 'wall'" in only(spoilt, "empty set").message


@pytest.mark.parametrize(
    ("factor", "sentence"),
    [
        (1e3, r"is 374\.2 m across: if the file is in mm or inches: with unit='mm' it is 0\.374 m"),
        (
            1 / 0.0254,
            r"is 14\.73 m across: if the file is in inches, read it with unit='in': it is then",
        ),
        (
            1e-3,
            r"is 0\.0003742 m across: if the file is in m, read it with unit='m': it is then",
        ),
    ],
)
def test_units_that_cannot_be(factor: float, sentence: str) -> None:
    mesh = block("tetra10", (3, 2, 1), (0.3, 0.2, 0.1))
    assert mesh.check() == ()
    read = dataclasses.replace(mesh, source="block.inp")
    finding = only(read.scaled(factor), "size")
    assert finding.severity == "warning"
    with pytest.raises(AssertionError):
        only(mesh.scaled(factor), "sliver")
    assert re.match(sentence, finding.message)
    # arrays of Python have no unit to guess
    assert mesh.scaled(factor).check() == ()


def test_numbers_given_twice() -> None:
    x = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)], dtype=float)
    cells = jo.mesh.Cells("tetra", [(0, 1, 2, 3), (1, 4, 2, 3)], ids=[7, 7])
    mesh = jo.Mesh("pair", x, cells, node_ids=[1, 2, 3, 4, 4])
    found = [f for f in mesh.check() if f.kind == "numbers"]
    assert [f.ids for f in found] == [(7,), (4,)]
    assert all(f.severity == "error" for f in found)
    assert "number 7 belongs to more than one element" in found[0].message
