"""Parts: sets, members, and every kind of bad input."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from jousto.base.errors import InputError, JoustoWarning
from jousto.materials.material import Material
from jousto.parts.frames.element import EulerBernoulli, Timoshenko
from jousto.parts.frames.members import Member
from jousto.parts.mass import PointMass
from jousto.parts.part import Part
from jousto.sections.section import Circle, GeneralSection, Rectangle

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
ROD = Circle(0.05)
NODES = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (1.0, 1.0, 1.0)]
ELEMENTS = [(0, 1), (1, 2), (2, 3)]


def test_beam() -> None:
    part = Part.beam(length=2.0, section=ROD, elements=4, material=STEEL)
    assert_array_equal(part.nodes[:, 0], [0.0, 0.5, 1.0, 1.5, 2.0])
    assert part.dofs_per_node == 6 and part.M.shape == part.K.shape == (30, 30)
    assert part.node("start") == part.node("node1") == 0
    assert part.node("end") == part.node("node5") == 4
    with pytest.raises(InputError, match="no node set 'node6'; did you mean"):
        part.node("node6")
    with pytest.raises(ValueError):
        part.nodes[0, 0] = 1.0


def test_beam_equals_frame_and_members() -> None:
    beam = Part.beam(2.0, ROD, 4, STEEL)
    frame = Part.frame(beam.nodes, beam.elements, sections=[ROD] * 4, materials=[STEEL] * 4)
    member = Part.from_members([Member((0, 0, 0), (2, 0, 0), ROD, STEEL, elements=4)])
    for other in (frame, member):
        assert_allclose(other.K.toarray(), beam.K.toarray(), rtol=1e-13)
        assert_allclose(other.M.toarray(), beam.M.toarray(), rtol=1e-13)


def test_user_sets() -> None:
    part = Part.frame(
        NODES, ELEMENTS, sections=ROD, materials=STEEL, node_sets={"foot": 0, "top": [2, 3]}
    )
    assert part.node("foot") == 0
    assert part.node_sets["top"] == (2, 3)
    with pytest.raises(InputError, match="node set 'top' has 2 nodes, one is needed"):
        part.node("top")


def test_members_share_nodes() -> None:
    # a portal with a brace that meets the beam at an inner node; a crossing wire stays apart
    leg = {"section": ROD, "material": STEEL, "elements": 2}
    part = Part.from_members(
        [
            Member((0, 0, 0), (0, 0, 2), **leg, name="left"),
            Member((4, 0, 0), (4, 0, 2 + 1e-10), **leg, name="right"),
            Member((0, 0, 2), (4, 0, 2), ROD, STEEL, elements=4, name="beam"),
            Member((0, 0, 1), (1, 0, 2), ROD, STEEL, name="brace"),
            Member((1, -1, 1), (3, 1, 3), **leg, name="wire"),
            Member((1, -1, 1), (0, 0, 1), ROD, STEEL),
        ],
        points={"corner": (4, 0, 2)},
    )
    # 3 + 3 + 3 inner of the beam + 0 + 3 of the wire, whose middle (2, 0, 2) is an own node
    assert len(part.nodes) == 12
    assert part.node("corner") == part.node("beam.end") == part.node("right.end")
    assert part.node("brace.end") == part.node_sets["beam"][1]
    assert part.node("brace.start") == part.node_sets["left"][1]
    middle = [i for i, x in enumerate(part.nodes) if np.allclose(x, (2, 0, 2))]
    assert len(middle) == 2
    assert len(part.elements) == 2 + 2 + 4 + 1 + 2 + 1


def test_member_offsets_lie_at_its_two_ends() -> None:
    part = Part.from_members(
        [
            Member(
                (0, 0, 0),
                (3, 0, 0),
                ROD,
                STEEL,
                elements=3,
                start_offset=(0.3, 0, 0.2),
                end_offset=(-0.3, 0, 0.2),
            )
        ]
    )
    assert_allclose(part.nodes[[1, 3 - 1]], [(1.1, 0, 0.2), (1.9, 0, 0.2)], rtol=1e-12)
    assert part.mass == pytest.approx(7850 * ROD.A * 2.4, rel=1e-12)
    assert_allclose(part.center, [1.5, 0, 0.2], rtol=1e-12)


def frame(**changes: Any) -> Part:
    given: dict[str, Any] = {
        "nodes": NODES,
        "elements": ELEMENTS,
        "sections": ROD,
        "materials": STEEL,
    }
    return Part.frame(**(given | changes))


def nan_nodes() -> np.ndarray:
    nodes = np.array(NODES)
    nodes[2, 1] = np.nan
    return nodes


BAD: tuple[tuple[Callable[[], object], tuple[str, ...]], ...] = (
    (lambda: frame(nodes=nan_nodes()), ("nodes[2, 1] is nan, must be finite",)),
    (lambda: frame(nodes=[(0, 0), (1, 1)]), ("nodes has shape (2, 2), must be (any, 3)",)),
    (lambda: frame(nodes="four"), ("nodes is not an array of numbers",)),
    (lambda: frame(elements=[(0, 1), (1, 7)]), ("elements[1, 1] is node 7", "0..3")),
    (lambda: frame(elements=[(0, -1)]), ("elements[0, 1] is node -1",)),
    (lambda: frame(elements=[(0, 1.5)]), ("whole numbers",)),
    (lambda: frame(elements=[]), ("elements has shape (0,)",)),
    (lambda: frame(elements=[(0, 1, 2)]), ("elements has shape (1, 3)",)),
    (lambda: frame(elements=[*ELEMENTS, (1, 1)]), ("element 4 (nodes 2 and 2) has zero length",)),
    (lambda: frame(elements=ELEMENTS[:2]), ("node4: not attached to any element",)),
    (
        lambda: frame(elements=[(0, 1), (2, 3)]),
        ("2 pieces that are not connected", "node2 and node3, 1 m apart"),
    ),
    (lambda: frame(sections="circle"), ("section is 'circle', must be a Section",)),
    (lambda: frame(sections=[ROD, ROD]), ("2 sections for 3 elements",)),
    (lambda: frame(sections=[ROD, None, ROD]), ("sections[1] is None",)),
    (lambda: frame(materials=[STEEL, STEEL, "steel"]), ("materials[2] is 'steel'",)),
    (lambda: frame(theory="timoshenko"), ("theory is 'timoshenko'", "Timoshenko()")),
    (
        lambda: frame(sections=GeneralSection(A=1e-3, Iy=1e-6, Iz=1e-6, J=1e-6)),
        ("section of element 1 has no shear coefficients", "EulerBernoulli()"),
    ),
    (
        lambda: frame(orientations=[(0, 0, 1), (0, 1, 0), (1, 0, 0)]),
        ("orientation [0.0, 1.0, 0.0] of element 2 is zero or parallel",),
    ),
    (lambda: frame(orientations=(0, 0, 0)), ("orientation [0.0, 0.0, 0.0] of element 1",)),
    (lambda: frame(orientations=[(0, 0, 1)]), ("orientations has shape (1, 3), must be (3, 3)",)),
    (lambda: frame(offsets=np.zeros((3, 3))), ("offsets has shape (3, 3), must be (3, 2, 3)",)),
    (lambda: frame(node_sets={"foot": [9]}), ("node set 'foot' contains node 9",)),
    (lambda: frame(node_sets={"foot": []}), ("node set 'foot' is empty",)),
    (lambda: frame(node_sets={"foot": [1, 1]}), ("node set 'foot' contains a node twice",)),
    (lambda: frame(node_sets={"foot": "left"}), ("node set 'foot' is 'left'",)),
    (lambda: frame(node_sets={"node2": [2]}), ("node set 'node2': this name is reserved",)),
    (lambda: frame(node_sets={"": [2]}), ("has no usable name",)),
    (lambda: frame(point_masses=[PointMass("tip", 1.0)]), ("point_masses[0]: no node set 'tip'",)),
    (lambda: frame(point_masses=[PointMass(4, 1.0)]), ("point_masses[0]: node 4 is not in 0..3",)),
    (lambda: frame(point_masses=[3.0]), ("point_masses[0] is 3.0, must be a PointMass",)),
    (
        lambda: frame(materials=Material(2e11, 0.3, 0.0)),
        ("has no mass: every density is zero",),
    ),
    (lambda: Part.beam(0.0, ROD, 4, STEEL), ("length is 0 m",)),
    (lambda: Part.beam(1.0, ROD, 0, STEEL), ("elements is 0, must be a whole number from 1",)),
    (lambda: Part.beam(1.0, ROD, 2.5, STEEL), ("elements is 2.5",)),  # type: ignore[arg-type]
    (lambda: Timoshenko(ky=-1.0), ("shear coefficient ky is -1",)),
    (lambda: Member((0, 0, 0), (0, 0, 0), ROD, STEEL), ("has zero length",)),
    (
        lambda: Member((0, 0, 0), (1, 0, 0), ROD, STEEL, end_offset=(-1, 0, 0), name="a"),
        ("member 'a'", "zero length"),
    ),
    (lambda: Member((0, 0, 0), (1, 0, np.inf), ROD, STEEL), ("end[2] is inf",)),
    (lambda: Member((0, 0, 0), (1, 0, 0), ROD, STEEL, elements=0), ("elements is 0",)),
    (lambda: Member((0, 0, 0), (1, 0, 0), ROD, STEEL, orientation=(2, 0, 0)), ("parallel",)),
    (
        lambda: Member((0, 0, 0), (1, 0, 0), STEEL, ROD),  # type: ignore[arg-type]
        ("must be a Section", "must be a Material"),
    ),
    (lambda: Part.from_members([]), ("has no members",)),
    (lambda: Part.from_members([ROD]), ("members[0] must be Member objects",)),  # type: ignore[list-item]
    (
        lambda: Part.from_members([Member((0, 0, 0), (1, 0, 0), ROD, STEEL, name="a")] * 2),
        ("two members are named 'a'",),
    ),
    (
        lambda: Part.from_members(
            [Member((0, 0, 0), (1, 0, 0), ROD, STEEL)], points={"tip": (0.9, 0, 0)}
        ),
        ("point 'tip' at [0.9, 0.0, 0.0] m is not at a node", "node2 at [1.0, 0.0, 0.0]"),
    ),
    (
        lambda: Part.from_members(
            [Member((0, 0, 0), (1, 0, 0), ROD, STEEL, name="a")], points={"a": (1, 0, 0)}
        ),
        ("point 'a': this name is used by a member",),
    ),
    (
        lambda: Part.from_members(
            [
                Member((0, 0, 0), (2, 0, 0), ROD, STEEL),
                Member((1, 0, 0), (1, 1, 0), ROD, STEEL),
            ]
        ),
        ("2 pieces that are not connected",),
    ),
)


@pytest.mark.parametrize(("make", "messages"), BAD)
def test_bad_input(make: Callable[[], object], messages: tuple[str, ...]) -> None:
    with pytest.raises(InputError) as caught:
        make()
    for message in messages:
        assert message in str(caught.value)


def test_everything_wrong_is_reported_at_once() -> None:
    with pytest.raises(InputError) as caught:
        frame(
            elements=[(0, 1), (1, 1)],
            sections=[ROD, "I"],
            materials=3.0,
            node_sets={"foot": [9]},
            point_masses=[PointMass("tip", 1.0)],
            theory="EB",
            name="boom",
        )
    text = str(caught.value)
    for message in (
        "theory is 'EB'",
        "sections[1] is 'I'",
        "material is 3.0",
        "element 2 (nodes 2 and 2) has zero length",
        "node set 'foot' contains node 9",
        "no node set 'tip'",
        "node3, node4: not attached",
    ):
        assert message in text
    assert len(caught.value.problems) == 7
    assert {p.where for p in caught.value.problems} == {"part 'boom'"}


def test_section_in_millimetres_is_noticed() -> None:
    with pytest.warns(JoustoWarning, match="larger than the part"):
        Part.beam(2.0, Rectangle(100.0, 100.0), 4, STEEL)


@pytest.mark.parametrize(
    ("length", "height", "sentence"),
    [
        (1000.0, 0.2, "part 'beam': is 1000 m large; if its lengths are in mm, convert them"),
        (300.0, 30.0, "part 'beam': is 300 m large; if its lengths are in mm"),
        (90.0, 30.0, "part 'beam': a section of 30 m; if its sizes are in mm, convert them"),
    ],
)
def test_a_part_in_millimetres_is_noticed(length: float, height: float, sentence: str) -> None:
    with pytest.warns(JoustoWarning) as caught:
        Part.beam(length, Rectangle(height, height), 4, STEEL)
    assert [str(w.message)[: len(sentence)] for w in caught] == [sentence]


def test_a_consistent_system_of_other_units_is_not_taken_for_a_mistake() -> None:
    # mm, t, s: the material alone is told
    with pytest.warns(JoustoWarning) as caught:
        Part.beam(1000.0, Rectangle(20.0, 20.0), 4, Material(E=210e3, nu=0.3, rho=7.85e-9))
    assert all(str(w.message).startswith("material") for w in caught)


def test_all_mass_on_one_line_is_legal() -> None:
    part = Part.beam(1.0, ROD, 2, STEEL, lumped=True, rotary_inertia=False, theory=EulerBernoulli())
    assert part.inertia[0, 0] == pytest.approx(0.0, abs=1e-15)


def test_thousands_of_elements_take_about_a_second() -> None:
    # about 0.3 s of processor time on a slow core; ten times that would be a loop over elements
    start = time.process_time()
    part = Part.beam(10.0, Rectangle(0.1, 0.2), 3000, STEEL)
    part.mass  # noqa: B018
    assert time.process_time() - start < 3.0
    assert part.K.nnz < 60 * part.K.shape[0]
