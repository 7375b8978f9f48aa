"""Straight members, joined into the arrays of a frame."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jousto.base.arrays import Array, some
from jousto.base.complexstep import norm, scalar
from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import AnyField, Field, Label, Nested, field
from jousto.base.numbers import OptionalValues, Vector
from jousto.materials.library import by_name
from jousto.materials.material import Material
from jousto.parts.form import Dictionary
from jousto.parts.frames.element import Elements, default_orientation
from jousto.parts.frames.frame import BeamOptions, FrameArrays
from jousto.sections.section import Section, is_section

# largest distance of positions that count as one node, relative to the size of the frame
MERGE = 1e-8


class SectionField(Nested[Section, Section]):
    """Field of the cross section of a beam."""

    section = "sections"
    room = "jousto.sections"
    noun = "Section"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the section, or report a value of another type."""
        if not is_section(value):
            problems.add(where, f"{self.name} is {value!r}, must be a Section")
        return value


class MaterialField(Field[Material, Material]):
    """Field of a material; a model file may contain its name in the library."""

    form = "material"
    noun = "Material"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the material, or report a value of another type."""
        if not isinstance(value, Material):
            how = by_name(value)
            problems.add(where, f"{self.name} is {value!r}, must be a Material{how}")
        return value


class Member(Declared):
    """Straight member between two nodes, divided into equal beam elements.

    Raises
    ------
    InputError
        With all problems of the arguments.

    Examples
    --------
    >>> from jousto import Circle
    >>> rod = Member((0, 0, 0), (3, 4, 0), Circle(0.02), Material(2e11, 0.3, 7850.0), elements=2)
    >>> rod.length
    5.0
    """

    kind = "member"
    start: Vector = field("Position of the first end node, part frame", unit="m")
    end: Vector = field("Position of the other end node, part frame", unit="m")
    section: SectionField = field("Cross section")
    material: MaterialField = field("Its material")
    elements: Elements = field("Number of elements", default=1)
    orientation: OptionalValues = field(
        "Vector near the section's z axis, part frame. If not given: (0, 0, 1), and (1, 0, 0) for "
        "members parallel to z",
        shape=(3,),
        default=None,
    )
    start_offset: Vector = field(
        "Rigid arm from the first end node to the flexible member, part frame",
        unit="m",
        default=(0.0, 0.0, 0.0),
    )
    end_offset: Vector = field(
        "Rigid arm from the other end node", unit="m", default=(0.0, 0.0, 0.0)
    )
    name: Label = field(
        "Name of the node sets ``name``, ``name.start`` and ``name.end``", default=""
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a member without length, and an orientation parallel to the member."""
        if self.length == 0.0:
            problems.add(where, f"has zero length, from {self.start} to {self.end} m with offsets")
        elif self.orientation is not None:
            along = (self.end + self.end_offset - self.start - self.start_offset) / self.length
            size = float(np.linalg.norm(self.orientation))
            if float(np.linalg.norm(np.cross(along.real, self.orientation))) <= 1e-6 * size:
                problems.add(
                    where,
                    f"orientation {self.orientation.tolist()} is zero or parallel to the member;"
                    " give a vector across it, near the local z axis",
                    "orientation",
                )

    @property
    def length(self) -> float:
        """Flexible length in m."""
        between = self.end + self.end_offset - self.start - self.start_offset
        return scalar(norm(between))


class FrameMembers(BeamOptions):
    """Straight members, joined where their ends meet a node."""

    members: AnyField = field("The members", form="members", noun="sequence of Member")
    points: Dictionary = field(
        "Names for the nodes at these positions, part frame",
        unit="m",
        form="points",
        noun="mapping of str to (3,) array_like",
        default=None,
        kw_only=True,
    )


def join_members(frame: FrameMembers) -> FrameArrays:
    """Return the arrays of a frame in which members whose ends have one position share a node.

    An end also joins an inner node of another member; inner nodes of two crossing members are not
    joined.

    Raises
    ------
    InputError
        If there are no members, two have one name, or a named point is not at a node.
    """
    where, problems = f"part '{frame.name}'", Problems()
    members, points = frame.members, frame.points or {}
    wrong = [f"members[{i}]" for i, m in enumerate(members) if not isinstance(m, Member)]
    if wrong:
        problems.add(where, f"{some(wrong)} must be Member objects")
    if not members:
        problems.add(where, "has no members")
    problems.raise_if_any()
    names = [m.name for m in members if m.name]
    for double in sorted({n for n in names if names.count(n) > 1}):
        problems.add(where, f"two members are named '{double}'")

    # all positions: ends first, then the inner nodes
    ends = np.array([p for m in members for p in (m.start, m.end)])
    inner = [_inner_nodes(m) for m in members]
    every = np.concatenate([ends, *inner])
    size = float(np.ptp(every.real, axis=0).max())
    owner = np.arange(len(every))
    from scipy.spatial import cKDTree  # slow to import and rarely needed

    for i, j in sorted(cKDTree(every.real).query_pairs(MERGE * size)):
        if i < len(ends):
            owner[j] = min(owner[j], owner[i])

    # number the nodes along the members
    chains = []
    first = len(ends)
    for i, nodes in enumerate(inner):
        between = owner[first : first + len(nodes)]
        chains.append(np.concatenate([owner[[2 * i]], between, owner[[2 * i + 1]]]))
        first += len(nodes)
    order = list(dict.fromkeys(int(x) for chain in chains for x in chain))
    number = np.zeros(len(every), dtype=np.int64)
    number[order] = np.arange(len(order))
    chains = [number[chain] for chain in chains]
    xyz = every[order]

    offsets = []
    for member in members:
        both = (member.start_offset, member.end_offset)
        arms = np.zeros((int(member.elements), 2, 3), np.result_type(*both))
        arms[0, 0], arms[-1, 1] = both
        offsets.append(arms)
    sets: dict[str, tuple[int, ...]] = {}
    for member, chain in zip(members, chains, strict=True):
        if member.name:
            sets[member.name] = tuple(dict.fromkeys(int(i) for i in chain))
            sets[f"{member.name}.start"] = (int(chain[0]),)
            sets[f"{member.name}.end"] = (int(chain[-1]),)
    _name_points(problems, where, points, xyz, sets)
    problems.raise_if_any()
    return FrameArrays(
        nodes=xyz,
        elements=np.concatenate([np.stack([c[:-1], c[1:]], axis=1) for c in chains]),
        sections=[m.section for m in members for _ in range(m.elements)],
        materials=[m.material for m in members for _ in range(m.elements)],
        orientations=np.concatenate([np.tile(_up(m), (m.elements, 1)) for m in members]),
        offsets=np.concatenate(offsets),
        node_sets=sets,
        **{key: getattr(frame, key) for key in BeamOptions.fields},
    )


def _inner_nodes(member: Member) -> Array:
    """Return the inner nodes of a member, between its flexible ends."""
    a, b = member.start + member.start_offset, member.end + member.end_offset
    xi = np.linspace(0.0, 1.0, int(member.elements) + 1)[1:-1, None]
    nodes: Array = (1.0 - xi) * a + xi * b
    return nodes


def _up(member: Member) -> Array:
    """Return the orientation vector of a member."""
    if member.orientation is not None:
        return np.asarray(member.orientation)
    along: Array = member.end + member.end_offset - member.start - member.start_offset
    return np.asarray(default_orientation(along[None])[0])


def _name_points(
    problems: Problems,
    where: str,
    points: Mapping[str, Any],
    xyz: Array,
    sets: dict[str, tuple[int, ...]],
) -> None:
    """Add a one-node set for each named position."""
    from scipy.spatial import cKDTree

    tree, size = cKDTree(xyz.real), float(np.ptp(xyz.real, axis=0).max())
    for name, value in points.items():
        label = f"point '{name}'"
        place = problems.array(where, label, value, (3,))
        if place is None:
            continue
        distance, node = tree.query(place.real)
        if distance > 1e-6 * size:
            problems.add(
                where,
                f"{label} at {place.tolist()} m is not at a node; the nearest is node{node + 1} at"
                f" {xyz[node].tolist()} m",
                label,
            )
        elif name in sets:
            problems.add(where, "this name is used by a member", label, named=False)
        else:
            sets[name] = (int(node),)
