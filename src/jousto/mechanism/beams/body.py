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

SLOW = 1.0  # s of stiffness damping: 1 Hz is far beyond critical


class BeamDamping(ProportionalDamping):
    """Damping of a beam proportional to its mass and to its stiffness.

    A vibration of angular frequency w has the damping ratio ``mass/(2 w) + stiffness w/2``.

    Raises
    ------
    InputError
        If a value is negative or not finite.
    """

    def consistent(self, problems: Problems, where: str) -> None:
        """Warn of a stiffness that lets nothing vibrate."""
        if self.stiffness > SLOW:
            warn(
                where,
                f"stiffness is {self.stiffness:g} s: a vibration of 1 Hz has the damping ratio "
                f"{math.pi * self.stiffness:.3g}, and nothing vibrates any more; it is in s",
                "stiffness",
            )


class Damping(Field["BeamDamping | None", BeamDamping]):
    """Damping of a beam; None for none."""

    form = "item"
    noun = "BeamDamping"
    of = BeamDamping
    checks_none = True

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the damping."""
        found = BeamDamping() if value is None else value
        if not isinstance(found, BeamDamping):
            wanted = "must be a BeamDamping(mass=, stiffness=)"
            problems.add(where, f"{self.name} is {value!r}, {wanted}")
        return found


class Share(Field["str | float | None", float]):
    """How the elements have their mass; the beam keeps how much it is."""

    form = "beam inertia"
    noun = '"lumped", "corrected", "consistent" or float'


class Elements(Field["int | None", "dict[str, Array]"]):
    """The number of elements; the beam keeps their data."""

    form = "count"
    noun = "int"


class BeamBody(Posed, tag="beam"):
    """A geometrically exact beam: it bends, twists, stretches and shears without any limit.

    Elements of two nodes stand between the nodes, each with one strain (Reissner-Simo measures, the
    relative rotation halved): ``Gamma = Q_m^T (r_b - r_a)/L - e1``, ``kappa = log(Q_a^T Q_b)/L``
    and resultants ``s = C (e - e0)``. Rigid motions strain nothing, whatever their size. The nodes
    are bodies of the mechanism and carry markers for joints, forces and sensors. The initial
    velocity is that of the beam which moves as a rigid body.

    Attributes
    ----------
    nodes : (n + 1, 3) array
        Nodes in the body frame, m.
    frames : (n + 1, 3, 3) array
        Section frames of the nodes, columns in the body frame; those of the node bodies too.
    ends : (n, 2, 3, 3) array
        Section frames of the elements' ends; they differ from those of the nodes at corners.
    lengths : (n,) array
        Unstressed lengths of the elements, m.
    sections : tuple of BeamSection
        One for each element.
    mass : float
        Mass, kg.
    elements : dict of array
        Data (n, ...) of the elements by name, see ``jo_beam_data`` in jousto.h.

    Raises
    ------
    InputError
        With everything that is wrong.

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
        "Ends of a straight beam, or its nodes, in the body frame. Several points are points of a "
        "smooth curve but at `corners`",
        form="shapes",
        noun="(2, 3) or (n + 1, 3) array_like",
        unit="m",
        shapes=((None, 3),),
    )
    section: AnyField = field(
        "Cross section; one for all elements or one each",
        form="beam sections",
        noun="Section, BeamSection or sequence of n of them",
    )
    material: AnyField = field(
        "Of a `Section`; a `BeamSection` has its own",
        form="material",
        noun="Material",
        default=None,
    )
    elements: Elements = field(
        "Number of elements n between two points; three or more points decide it themselves",
        default=None,
        kw_only=True,
    )
    up: AnyField = field(
        "Direction near the z axis of the first section, body frame, from which the others follow "
        "by the smallest rotations along the curve; or one for each node. None for (0, 0, 1), of "
        "beams that begin along z (1, 0, 0)",
        form="shapes",
        noun="(3,) or (n + 1, 3) array_like",
        shapes=((3,), (None, 3)),
        default=None,
        kw_only=True,
    )
    twist: AnyField = field(
        "Turn of the sections about the axis beyond that: of the end, growing along the beam, or "
        "of each node",
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
        "Inertia of the elements and, as mass is pulled where it is, their weight: of their halves "
        "at the nodes (0), of linear shape functions (1) or between (mass centres on the axis "
        "only), all of order 2 in the length of the elements; or that of their halves with the end "
        "correction of Euler and Maclaurin, for which bending vibrations of straight beams with "
        "`bending` are of order 3 and a straight one bends under its weight as it should. None for "
        '"corrected" with `bending`, else "lumped"',
        default=None,
        kw_only=True,
    )
    bending: AnyField = field(
        "Straight beams bent in a plane converge with fourth order instead of second, curved and "
        "twisted ones with smaller errors: the axis of an element is a screw line between its ends "
        "(Sonneville, Cardona and Bruls 2014) instead of its chord, and the residual bending "
        "flexibility is added (see `BeamSection.with_bending`). Elements become softer in shear, "
        "which lowers the tension that they bear",
        form="flag",
        noun="bool",
        default=False,
        kw_only=True,
    )
    damping: Damping = field(
        "Damping proportional to mass and stiffness; None for none", default=None, kw_only=True
    )
    offset: AnyField = field(
        "Section axis (y, z) relative to the line of nodes, or that at each node, section axes: "
        "rigid arms",
        form="shapes",
        noun="(2,) or (n + 1, 2) array_like",
        unit="m",
        shapes=((2,), (None, 2)),
        default=(0.0, 0.0),
        kw_only=True,
    )
    straight: AnyField = field(
        "The unstressed beam is straight: it is placed bent, and springs back",
        form="flag",
        noun="bool",
        default=False,
        kw_only=True,
    )
    reference: OptionalValues = field(
        "Nodes of the unstressed shape; None for that of `points`",
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
        """Keep nodes, frames and unstressed strains; note what does not fit together."""
        mass, elements, reference = vars(self)["mass"], vars(self)["elements"], self.reference
        nodes = checked_nodes(problems, where, self.points, elements)
        sections = checked_sections(problems, where, self.section, self.material, nodes)
        if mass is None:
            mass = "corrected" if self.bending else "lumped"
        share = inertia_share(problems, where, mass)
        if self.straight and reference is not None:
            problems.add(
                where, "straight and reference both tell the unstressed shape; give one", "straight"
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
                f"it is twisted by {np.ptp(turns):.4g} rad; were degrees meant? If not, more points"
                if twisted > 0.5 * coarsest
                else "give more points, or corners=[...] where the beam has corners"
            )
            text = f"its elements turn by up to {coarsest:.3g} rad each, which is coarse; {remedy}"
            warn(where, text)
        width = max((float(np.ptp(x.outline, axis=0).max()) for x in outlined(sections)), default=0)
        if width > WIDE * lengths.sum():
            warn(
                where,
                f"its section is {width:.4g} m wide and the beam {lengths.sum():.4g} m long; were "
                "millimetres meant?",
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
            If there is no such node; names the nearest one.
        """
        return self._marker(self._place(point), str(point), ZERO3, None)

    def node(self, i: int, *, at: ArrayLike = ZERO3, axes: Any = None) -> Marker:
        """Return the marker on a node.

        Parameters
        ----------
        i : int
            Number of the node from 0; -1 is the last one.
        at : (3,) array_like
            Place of the marker from the node, section axes of the node, m.
        axes : orientation, optional
            Its axes relative to those of the section; None for these.
        """
        number: Any = i
        whole = isinstance(number, int | np.integer) and not isinstance(number, bool)
        if not whole or not -self.n - 1 <= i <= self.n:
            raise InputError(
                Problem(f"beam {self.name!r}", f"no node {i!r}; they are 0 to {self.n}, or from -1")
            )
        place = int(i) % (self.n + 1)
        return self._marker(place, f"node{place + 1}", at, axes)

    def at(self, position: ArrayLike, axes: Any = None, name: str | None = None) -> Marker:
        """Raise InputError: the markers of a beam sit on its nodes."""
        raise InputError(
            Problem(
                f"beam {self.name!r}",
                'bends, its markers sit on nodes: use body["start"], body["node7"] or '
                "body.node(i, at=(x, y, z))",
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
        """The nodes as bodies: half of every element's mass and rotary inertia at its ends."""
        return tuple(node_bodies(self))


# -- helpers of the constructor -------------------------------------------------------------


# -- what the engine gets -------------------------------------------------------------------
