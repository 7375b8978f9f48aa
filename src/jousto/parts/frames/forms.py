"""Beams as input of a part: a straight beam, a frame from arrays, a frame from members."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.fields import Label, field
from jousto.base.numbers import OptionalValues, Positive
from jousto.parts.frames.element import Elements
from jousto.parts.frames.frame import BeamOptions, Frame, FrameArrays, assemble, check_frame
from jousto.parts.frames.members import FrameMembers, MaterialField, SectionField, join_members
from jousto.parts.frames.outlines import outlines_of


def frame_fields(frame: Frame) -> dict[str, Any]:
    """Return the fields of a part from a checked frame."""
    K, M, points, stress, second_order = assemble(frame)
    return {
        "name": frame.name,
        "nodes": frame.nodes,
        "elements": frame.elements,
        "dofs_per_node": 6,
        "M": M,
        "K": K,
        "node_sets": frame.node_sets,
        "mass_points": points,
        "stress": stress,
        "second_order": second_order,
        "outlines": outlines_of(frame.sections),
    }


class ArrayFrame(FrameArrays, tag="frame"):
    """Frame of beams in space given by arrays.

    Raises
    ------
    InputError
        With all problems of the arguments.

    Examples
    --------
    >>> from jousto import Material, Member, Part, Rectangle, Tube
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> part = Part.frame([[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 1], [1, 2]],
    ...                   sections=Tube(0.05, 0.002), materials=steel)
    >>> f"{part.mass:.4f} kg"
    '4.7351 kg'
    """

    def assembled(self) -> dict[str, Any]:
        """Return the fields of the part that is built from the arrays."""
        return frame_fields(check_frame(self))


class MemberFrame(FrameMembers, tag="members"):
    """Frame of straight members, joined where their ends meet a node.

    A member named "leg" creates the node sets "leg" (all its nodes), "leg.start" and "leg.end".

    Raises
    ------
    InputError
        With all problems of the arguments.

    Examples
    --------
    >>> from jousto import Material, Member, Part, Rectangle, Tube
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> tube = Tube(0.05, 0.002)
    >>> part = Part.from_members(
    ...     [Member((0, 0, 0), (1, 0, 0), tube, steel, elements=4, name="boom"),
    ...      Member((1, 0, 0), (1, 0, 1), tube, steel, elements=3)],
    ...     points={"tip": (1, 0, 1)})
    >>> len(part.nodes), part.node("tip"), part.node_sets["boom.end"]
    (8, 7, (4,))
    """

    def assembled(self) -> dict[str, Any]:
        """Return the fields of the part that is built from the members."""
        return frame_fields(check_frame(join_members(self)))


class StraightBeam(BeamOptions, tag="beam"):
    """Straight beam along +x from the origin, with the node sets "start" and "end".

    Raises
    ------
    InputError
        With all problems of the arguments.

    Examples
    --------
    >>> from jousto import Material, Member, Part, Rectangle, Tube
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> part = Part.beam(2.0, Rectangle(0.1, 0.1), 4, steel, lumped=True)
    >>> part.mass_points.mass
    array([19.625, 39.25 , 39.25 , 39.25 , 19.625])
    """

    length: Positive = field("Its length", unit="m")
    section: SectionField = field(
        "Cross section; its y axis is the y axis of the part unless ``orientation`` rotates it"
    )
    elements: Elements = field("Number of elements of equal length")
    material: MaterialField = field("Its material")
    orientation: OptionalValues = field(
        "Vector near the section's z axis, part frame; (0, 0, 1) if not given",
        shape=(3,),
        default=None,
        kw_only=True,
    )
    name: Label = field("Name of the part", file=False, default="beam", kw_only=True)

    def assembled(self) -> dict[str, Any]:
        """Return the fields of the part that is built from the beam."""
        n = self.elements
        nodes = np.zeros((n + 1, 3), np.result_type(self.length))
        nodes[:, 0] = (
            np.linspace(0.0, 1.0, n + 1) * self.length
            if np.iscomplexobj(nodes)
            else np.linspace(0.0, self.length, n + 1)
        )
        frame = FrameArrays(
            nodes,
            np.stack([np.arange(n), np.arange(1, n + 1)], axis=1),
            sections=self.section,
            materials=self.material,
            orientations=self.orientation,
            node_sets={"start": (0,), "end": (n,)},
            **{key: getattr(self, key) for key in BeamOptions.fields},
        )
        return frame_fields(check_frame(frame))
