"""Beam bodies: chains of nodes and geometrically exact elements."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array, read_only
from jousto.base.errors import InputError, Problem, Problems, suggest, warn
from jousto.base.fields import AnyField, Field, field, kept
from jousto.base.frozen_dict import Frozen
from jousto.base.numbers import OptionalValues, set_fields
from jousto.materials.damping import ProportionalDamping
from jousto.mechanism.beams.discretisation import BeamNode, element_data, node_bodies
from jousto.mechanism.beams.frames import arc_lengths, strains
from jousto.mechanism.beams.geometry import (
    COARSE,
    WIDE,
    along_nodes,
    check_apart,
    check_share,
    check_twist,
    checked_nodes,
    checked_sections,
    checked_up,
    inertia_share,
    inner_nodes,
    named_nodes,
    outlined,
    placed_shape,
)
from jousto.mechanism.beams.limits import highest_frequencies
from jousto.mechanism.beams.stiffness import BeamSection
from jousto.mechanism.bodies.base import ZERO3, Posed
from jousto.mechanism.bodies.marker import Marker, marker_axes

# s, stiffness damping above which a warning is given: 1 Hz is far beyond critical damping
SLOW = 1.0


class BeamDamping(ProportionalDamping):
    """Damping of a beam proportional to its mass and to its stiffness.

    A vibration of angular frequency w has the damping ratio ``mass/(2 w) + stiffness w/2``.

    Raises
    ------
    InputError
        If a value is negative or not finite.
    """

    def consistent(self, problems: Problems, where: str) -> None:
        """Warn about a stiffness damping so large that no vibration remains."""
        if self.stiffness > SLOW:
            warn(
                where,
                f"stiffness is {self.stiffness:g} s: a vibration of 1 Hz has the damping ratio "
                f"{math.pi * self.stiffness:.3g}, so that no vibration is left; the coefficient is "
                f"in s, check its unit",
                "stiffness",
            )


class Damping(Field["BeamDamping | None", BeamDamping]):
    """Field of the damping of a beam; None for no damping."""

    form = "item"
    noun = "BeamDamping"
    of = BeamDamping
    checks_none = True

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the damping, or report a value of another type."""
        found = BeamDamping() if value is None else value
        if not isinstance(found, BeamDamping):
            wanted = "must be a BeamDamping(mass=, stiffness=)"
            problems.add(where, f"{self.name} is {value!r}, {wanted}")
        return found


class Share(Field["str | float | None", float]):
    """Field of the inertia of the elements; the beam stores the share of consistent inertia."""

    form = "beam inertia"
    noun = '"lumped", "corrected", "consistent" or float'


class Elements(Field["int | None", "dict[str, Array]"]):
    """Field of the number of elements; the beam stores their data instead."""

    form = "count"
    noun = "int"


class BeamBody(Posed, tag="beam"):
    """Geometrically exact beam: large bending, twist, stretch and shear.

    Each element joins two nodes and has one constant strain (Reissner-Simo measures in the frame
    halfway between its ends): ``Gamma = Q_m^T (r_b - r_a)/L - e1``, ``kappa = log(Q_a^T Q_b)/L``
    and resultants ``s = C (e - e0)``. Rigid motions of any size cause no strain. The nodes are
    bodies of the mechanism and carry markers for joints, forces and sensors. The initial velocity
    is that of a rigid motion of the beam.

    Attributes
    ----------
    nodes : (n + 1, 3) array
        Nodes in the body frame, m.
    frames : (n + 1, 3, 3) array
        Section frames of the nodes, columns in the body frame; also the frames of the node bodies.
    ends : (n, 2, 3, 3) array
        Section frames of the ends of the elements; at corners they differ from the frames of the
        nodes.
    lengths : (n,) array
        Unstressed lengths of the elements, m.
    sections : tuple of BeamSection
        Section of each element.
    mass : float
        Mass, kg.
    elements : dict of array
        Data (n, ...) of the elements by name, see ``jo_beam_data`` in jousto.h.

    Raises
    ------
    InputError
        With all problems of the arguments.

    Examples
    --------
    >>> from jousto import Circle, Material
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> cable = BeamBody("cable", [(0, 0, 0), (1, 0, 0)], Circle(0.01), steel, elements=8)
    >>> cable
    <BeamBody 'cable': 8 elements, 1 m, 0.617 kg>
    >>> cable["end"]
    <Marker 'cable.end'>
    """

    together = ("points",)
    nodes: Array = kept()
    frames: Array = kept()
    ends: Array = kept()
    lengths: Array = kept()
    sections: tuple[BeamSection, ...] = kept()
    offsets: Array = kept()
    unstressed: Array = kept()
    share: float = kept()
    corrected: bool = kept()
    points: AnyField = field(
        "Two ends of a straight beam, or all its nodes, in the body frame. Three or more nodes "
        "lie on a curve that is smooth except at `corners`",
        form="shapes",
        noun="(2, 3) or (n + 1, 3) array_like",
        unit="m",
        shapes=((None, 3),),
    )
    section: AnyField = field(
        "Cross section of all elements, or one per element",
        form="beam sections",
        noun="Section, BeamSection or sequence of n of them",
    )
    material: AnyField = field(
        "Material of a `Section`; a `BeamSection` contains its own stiffness and mass",
        form="material",
        noun="Material",
        default=None,
    )
    elements: Elements = field(
        "Number of elements n between two points; not needed with three or more points",
        default=None,
        kw_only=True,
    )
    up: AnyField = field(
        "Direction near the z axis of the first section, body frame; the other sections follow "
        "by the smallest rotations along the curve. Or one direction per node. None for (0, 0, "
        "1), or (1, 0, 0) for beams that begin along z",
        form="shapes",
        noun="(3,) or (n + 1, 3) array_like",
        shapes=((3,), (None, 3)),
        default=None,
        kw_only=True,
    )
    twist: AnyField = field(
        "Additional rotation of the sections about the axis: of the end, increasing linearly "
        "along the beam, or of each node",
        form="shapes",
        noun="float or (n + 1,) array_like",
        unit="rad",
        shapes=((), (None,)),
        default=0.0,
        kw_only=True,
    )
    corners: AnyField = field(
        "Nodes (from 0) at which the axis has a corner: two elements are welded there at an angle",
        form="counts",
        noun="sequence of int",
        default=(),
        kw_only=True,
    )
    mass: Share = field(
        'Inertia and weight of the elements. "lumped" (0): half of the mass at each node. '
        '"consistent" (1): linear shape functions; numbers between 0 and 1 mix both (mass '
        "centres on the axis only). All these are of order 2 in the element length. "
        '"corrected": lumped with the Euler-Maclaurin end correction, of order 3 for bending '
        "vibrations of straight beams with `bending`, and with the right deflection of straight"
        ' beams under their weight. None for "corrected" with `bending`, else "lumped"',
        default=None,
        kw_only=True,
    )
    bending: AnyField = field(
        "Higher order in bending: straight beams bent in a plane converge with order 4 instead "
        "of 2, curved and twisted beams with smaller errors. The axis of an element is a helix "
        "between its ends (Sonneville, Cardona and Bruls 2014) instead of its chord, and the "
        "residual bending flexibility is added (see `BeamSection.with_bending`). This makes "
        "elements softer in shear and lowers the tension at which they become unstable",
        form="flag",
        noun="bool",
        default=False,
        kw_only=True,
    )
    damping: Damping = field(
        "Damping proportional to mass and stiffness; None for no damping",
        default=None,
        kw_only=True,
    )
    offset: AnyField = field(
        "Offset (y, z) of the section's reference axis from the line of nodes by rigid arms, in"
        " section axes; one for all nodes or one per node",
        form="shapes",
        noun="(2,) or (n + 1, 2) array_like",
        unit="m",
        shapes=((2,), (None, 2)),
        default=(0.0, 0.0),
        kw_only=True,
    )
    straight: AnyField = field(
        "Whether the beam is straight without stress, so that the given shape is elastically bent",
        form="flag",
        noun="bool",
        default=False,
        kw_only=True,
    )
    reference: OptionalValues = field(
        "Nodes of the unstressed shape; None for the shape given by `points`",
        unit="m",
        shape=(None, 3),
        default=None,
        kw_only=True,
    )
    markers: AnyField = field(
        'Names of nodes (from 0). "start", "end" and "node1"... always exist',
        form="nodes",
        noun="mapping of str to int",
        default=None,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Store nodes, frames and unstressed strains; report inconsistent arguments."""
        mass, elements, reference = vars(self)["mass"], vars(self)["elements"], self.reference
        nodes = checked_nodes(problems, where, self.points, elements)
        sections = checked_sections(problems, where, self.section, self.material, nodes)
        if mass is None:
            mass = "corrected" if self.bending else "lumped"
        share = inertia_share(problems, where, mass)
        if self.straight and reference is not None:
            problems.add(
                where,
                "straight and reference both define the unstressed shape; give only one",
                "straight",
            )
        if nodes is None:
            return
        n = len(nodes) - 1
        turns = along_nodes(problems, where, "twist", self.twist, n, ())
        arms = along_nodes(problems, where, "offset", self.offset, n, (2,))
        if turns is not None:
            check_twist(problems, where, turns)
        if share:
            check_share(problems, where, sections)
        kinks = inner_nodes(problems, where, "corners", self.corners, range(1, n))
        named = named_nodes(problems, where, self.markers, n)
        z = checked_up(problems, where, self.up, nodes)
        if reference is not None:
            reference = problems.array(where, "reference", reference, (n + 1, 3))
            if reference is not None:
                check_apart(problems, where, "reference", reference)
        if problems.found:
            return
        assert turns is not None and arms is not None and z is not None
        frames, ends, r = placed_shape(problems, where, nodes, z, turns, kinks, arms)
        if problems.found:
            return
        lengths = arc_lengths(r, ends)
        if self.straight:
            e0 = np.zeros((n, 6))
            e0[:, 3] = np.diff(turns) / lengths
        elif reference is not None:
            _, ends0, r0 = placed_shape(problems, where, reference, z, turns, kinks, arms)
            if problems.found:
                return
            lengths = arc_lengths(r0, ends0)
            e0 = strains(r0, ends0, lengths, helical=bool(self.bending))
        else:
            e0 = strains(r, ends, lengths, helical=bool(self.bending))
        set_fields(
            self,
            nodes=nodes,
            frames=read_only(frames),
            ends=read_only(ends),
            lengths=read_only(lengths),
            sections=sections,
            offsets=read_only(arms),
            unstressed=read_only(e0),
            share=share,
            corrected=isinstance(mass, str) and mass == "corrected",
            mass=float(sum(s.mass * L for s, L in zip(sections, lengths, strict=True))),
            bending=bool(self.bending),
            markers=Frozen(named),
        )
        data = element_data(self)
        set_fields(self, elements={key: read_only(values) for key, values in data.items()})
        coarsest = float((lengths * np.linalg.norm(e0[:, 3:], axis=1)).max())
        if coarsest > COARSE:
            twisted = float(np.abs(np.diff(turns)).max())
            remedy = (
                f"it is twisted by {np.ptp(turns):.4g} rad; if degrees were meant, convert to "
                f"rad, else give more points"
                if twisted > 0.5 * coarsest
                else "give more points, or corners=[...] where the beam has corners"
            )
            text = (
                f"its unstressed elements bend by up to {coarsest:.3g} rad each, which is "
                f"coarse; {remedy}"
            )
            warn(where, text)
        width = max((float(np.ptp(x.outline, axis=0).max()) for x in outlined(sections)), default=0)
        if width > WIDE * lengths.sum():
            warn(
                where,
                f"its section is {width:.4g} m wide and the beam {lengths.sum():.4g} m long; "
                "are its dimensions in millimetres?",
            )

    __iter__: ClassVar[None] = None

    def __repr__(self) -> str:
        return (
            f"<BeamBody {self.name!r}: {self.n} elements, {self.length:.4g} m, {self.mass:.3g} kg>"
        )

    def __getitem__(self, point: str) -> Marker:
        """Return the marker at "start", "end", "node7" (from 1) or a named node.

        Its axes are those of the section there.

        Raises
        ------
        InputError
            If there is no such node; the message suggests the most similar name.
        """
        return self._marker(self._place(point), str(point), ZERO3, None)

    def node(self, i: int, *, at: ArrayLike = ZERO3, axes: Any = None) -> Marker:
        """Return the marker on a node.

        Parameters
        ----------
        i : int
            Number of the node from 0; -1 is the last one.
        at : (3,) array_like
            Position of the marker relative to the node, in the section axes of the node, m.
        axes : orientation, optional
            Axes of the marker relative to those of the section; None for the section axes.
        """
        number: Any = i
        whole = isinstance(number, int | np.integer) and not isinstance(number, bool)
        if not whole or not -self.n - 1 <= i <= self.n:
            raise InputError(
                Problem(
                    f"beam {self.name!r}",
                    f"no node {i!r}; nodes are 0 to {self.n}, or -1 for the last",
                )
            )
        place = int(i) % (self.n + 1)
        return self._marker(place, f"node{place + 1}", at, axes)

    def at(self, position: ArrayLike, axes: Any = None, name: str | None = None) -> Marker:
        """Raise InputError: the markers of an exact beam sit on its nodes only."""
        raise InputError(
            Problem(
                f"beam {self.name!r}",
                'is an exact beam, whose markers sit on nodes: use body["start"], body["node7"]'
                " or body.node(i, at=(x, y, z))",
            )
        )

    def _place(self, point: str) -> int:
        known = {"start": 0, "end": self.n, **self.markers}
        if point in known:
            return int(known[point])
        digits = str(point).removeprefix("node")
        if digits != point and digits.isdecimal() and 1 <= int(digits) <= self.n + 1:
            return int(digits) - 1
        raise InputError(
            Problem(
                f"beam {self.name!r}",
                f"no point {point!r}{suggest(str(point), known)}; its nodes are 'node1' to "
                f"'node{self.n + 1}'",
            )
        )

    def _marker(self, place: int, name: str, at: ArrayLike, axes: Any) -> Marker:
        problems = Problems()
        position = problems.array(f"beam {self.name!r}", f"place at {name}", at, (3,))
        problems.raise_if_any()
        assert position is not None
        frame = marker_axes(f"{self.name}.{name}", axes)
        return Marker(self.bodies[place], name, position, None, frame)

    @property
    def n(self) -> int:
        """Number of elements."""
        return len(self.lengths)

    @property
    def length(self) -> float:
        """Unstressed length, m."""
        return float(self.lengths.sum())

    @property
    def s(self) -> Array:
        """Arc length (n + 1,) of the nodes along the unstressed axis, m."""
        return np.concatenate([[0.0], np.cumsum(self.lengths)])

    @property
    def highest_frequency(self) -> float:
        """Highest frequency of an element, Hz; explicit methods need steps of 1/(3 f) or less."""
        return float(highest_frequencies(self.elements).max()) / (2 * np.pi)

    @cached_property
    def bodies(self) -> tuple[BeamNode, ...]:
        """Node bodies, each with half of the mass and rotary inertia of its elements."""
        return tuple(node_bodies(self))


# -- helpers of the constructor -------------------------------------------------------------


# -- data for the engine --------------------------------------------------------------------
