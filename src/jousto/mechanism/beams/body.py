"""Beam bodies: chains of nodes and geometrically exact elements."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array, read_only
from jousto.base.declare import Declared
from jousto.base.errors import InputError, Problem, Problems, suggest, warn
from jousto.base.fields import AnyField, Field, field, kept
from jousto.base.frozen import Frozen
from jousto.base.numbers import Number, OptionalValues, number, set_fields
from jousto.base.rotations import (
    euler_parameters,
    parse_direction,
    rotation_matrix,
)
from jousto.mechanism.beams.frames import arc_lengths, section_frames, strains, tangents
from jousto.mechanism.beams.limits import highest_frequencies
from jousto.mechanism.beams.stiffness import BeamSection, as_beam_section, tension_factor
from jousto.mechanism.bodies.body import RigidBody
from jousto.mechanism.bodies.marker import Marker, marker_axes
from jousto.mechanism.bodies.posed import ZERO3, Posed
from jousto.parts.frames.members import check_elements

SHARES = {"lumped": 0.0, "corrected": 0.0, "consistent": 1.0}
MOST_TWIST = 3.0  # rad of an element
CENTRED = 1e-6  # radii of gyration that a mass centre may be off the axis
ROTARY = 1.2  # of the inertia that a first moment needs at least
COARSE = 1.0  # rad that an unstressed element may turn
WIDE = 5.0  # lengths of a beam that its section may be wide
SLOW = 1.0  # s of stiffness damping: 1 Hz is far beyond critical


class BeamDamping(Declared, by_value=True):
    """Damping of a beam proportional to its mass and to its stiffness.

    A vibration of angular frequency w has the damping ratio ``mass/(2 w) + stiffness w/2``.

    Raises
    ------
    InputError
        If a value is negative or not finite.
    """

    mass: Number = field(
        "Forces ``-mass M v``: resists all motion through the world, rigid motion too. M is the "
        "mass matrix of the beam, whichever it is: lumped, corrected or shared",
        unit="1/s",
        least=0,
        wanted="zero or positive",
        default=0.0,
    )
    stiffness: Number = field(
        "Resultants ``s = C (e + stiffness e')``: resists straining alone",
        unit="s",
        least=0,
        wanted="zero or positive",
        default=0.0,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Warn of a stiffness that lets nothing vibrate."""
        if self.stiffness > SLOW:
            warn(
                where,
                f"stiffness is {self.stiffness:g} s: a vibration of 1 Hz has the damping ratio "
                f"{math.pi * self.stiffness:.3g}, and nothing vibrates any more; it is in s",
            )


class BeamNode(RigidBody):
    """A node of a beam: a rigid body with the mass of its half elements.

    Made by `BeamBody`; its frame is that of the section there.

    Parameters
    ----------
    beam : str
        Name of the beam.
    place : int
        Number of the node from 0.
    **fields
        Those of `RigidBody`, and the damping of its momenta, proportional to its mass, 1/s.
    """

    beam: str
    place: int
    damping: float

    def __init__(self, beam: str, place: int, **fields: Any) -> None:
        set_fields(
            self,
            name=f"{beam}.node{place + 1}",
            beam=beam,
            place=place,
            markers=Frozen({}),
            **fields,
        )

    def __repr__(self) -> str:
        return f"<BeamNode {self.name!r}: {self.mass:g} kg>"


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
        "smooth curve unless `corners` says otherwise",
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
        nodes = _nodes(problems, where, self.points, elements)
        sections = _sections(problems, where, self.section, self.material, nodes)
        if mass is None:
            mass = "corrected" if self.bending else "lumped"
        share = _share(problems, where, mass)
        if self.straight and reference is not None:
            problems.add(where, "straight and reference both tell the unstressed shape; give one")
        if nodes is None:
            return
        n = len(nodes) - 1
        turns = _along(problems, where, "twist", self.twist, n, ())
        arms = _along(problems, where, "offset", self.offset, n, (2,))
        if turns is not None:
            _check_twist(problems, where, turns)
        if share:
            _check_share(problems, where, sections)
        kinks = _places(problems, where, "corners", self.corners, range(1, n))
        named = _markers(problems, where, self.markers, n)
        z = _up(problems, where, self.up, nodes)
        if reference is not None:
            reference = problems.array(where, "reference", reference, (n + 1, 3))
            if reference is not None:
                _apart(problems, where, "reference", reference)
        if problems.found:
            return
        assert turns is not None and arms is not None and z is not None
        frames, ends, r = _shape(problems, where, nodes, z, turns, kinks, arms)
        if problems.found:
            return
        lengths = arc_lengths(r, ends)
        if self.straight:
            e0 = np.zeros((n, 6))
            e0[:, 3] = np.diff(turns) / lengths
        elif reference is not None:
            _, ends0, r0 = _shape(problems, where, reference, z, turns, kinks, arms)
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
        data = _element_data(self)
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
        width = max(
            (float(np.ptp(x.outline, axis=0).max()) for x in _outlined(sections)), default=0
        )
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
        return tuple(_node_bodies(self))


# -- helpers of the constructor -------------------------------------------------------------


def _nodes(problems: Problems, where: str, points: ArrayLike, elements: Any) -> Array | None:
    """Return the nodes (n + 1, 3), or note why there are none."""
    given = problems.array(where, "points", points, (None, 3))
    whole = elements is None or check_elements(problems, where, elements)
    if given is None:
        return None
    if len(given) < 2:
        problems.add(where, f"points has {len(given)} point, must have two ends at least")
        return None
    if not _apart(problems, where, "points", given) or not whole:
        return None
    if len(given) > 2:
        if elements is not None and elements != len(given) - 1:
            problems.add(
                where,
                f"elements is {elements}, but {len(given)} points make {len(given) - 1} elements; "
                "leave elements out, or give the two ends of a straight beam",
            )
            return None
        return given
    if elements is None:
        problems.add(where, "elements is missing: how many between the two ends of the beam?")
        return None
    xi = np.linspace(0.0, 1.0, int(elements) + 1)[:, None]
    return read_only((1 - xi) * given[0] + xi * given[1])


def _apart(problems: Problems, where: str, name: str, points: Array) -> bool:
    """Return whether neighbours differ, or note which do not."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    for i in np.flatnonzero(steps <= 1e-9 * max(extent, 1e-300)):
        problems.add(where, f"{name}[{i}] and {name}[{i + 1}] are at one place; leave one out")
        return False
    return True


def _outlined(sections: tuple[BeamSection, ...]) -> list[BeamSection]:
    """Return the different sections whose outline is known: those of one material."""
    return [x for x in {id(x): x for x in sections}.values() if x.elasticity is not None]


def _sections(
    problems: Problems, where: str, section: Any, material: Any, nodes: Array | None
) -> tuple[BeamSection, ...]:
    """Return the section of every element, or note what is wrong."""
    several = isinstance(section, list | tuple)
    made: dict[int, BeamSection] = {}
    for item in section if several else (section,):
        try:
            if id(item) not in made:
                made[id(item)] = as_beam_section(item, material)
        except InputError as error:
            problems.found.extend(Problem(where, str(p)) for p in error.problems)
            return ()
    n = 0 if nodes is None else len(nodes) - 1
    if several:
        if nodes is not None and len(section) != n:
            problems.add(where, f"section: {len(section)} sections for {n} elements; one each")
        return tuple(made[id(item)] for item in section)
    return (made[id(section)],) * n


def _share(problems: Problems, where: str, mass: Any) -> float:
    """Return the share of consistent inertia, or note what is wrong."""
    if isinstance(mass, str):
        if mass not in SHARES:
            problems.add(
                where, f"mass is {mass!r}{suggest(mass, SHARES)}, or a number from 0 (lumped) to 1"
            )
        return SHARES.get(mass, 0.0)
    share = number(problems, where, "mass", mass)
    if share is not None and not 0.0 <= share <= 1.0:
        problems.add(where, f"mass is {share:g}, must be from 0 (lumped) to 1 (consistent)")
    return share or 0.0


def _along(
    problems: Problems, where: str, name: str, value: ArrayLike, n: int, one: tuple[int, ...]
) -> Array | None:
    """Return values at all nodes (n + 1, ...) of one for all (or of the end) or of each."""
    try:
        shape = np.shape(value)
    except ValueError:
        shape = (-1,)
    if shape != one:
        return problems.array(where, name, value, (n + 1, *one))
    found = problems.array(where, name, value, one)
    if found is None:
        return None
    if not one:  # grows along the beam
        return read_only(np.linspace(0.0, float(found), n + 1))
    return read_only(np.tile(found, (n + 1, 1)))


def _check_twist(problems: Problems, where: str, turns: Array) -> None:
    """Refuse a twist that the ends of an element do not show: whole turns would be lost."""
    steps = np.abs(np.diff(turns))
    worst = int(np.argmax(steps))
    if steps[worst] < MOST_TWIST:
        return
    degrees = "; it is in rad: were degrees meant?" if np.abs(turns).max() > 2 * np.pi else ""
    needed = int(np.ceil(len(steps) * steps[worst]))
    problems.add(
        where,
        f"twist turns element {worst} by {steps[worst]:.3g} rad, of which its ends show less than "
        f"half a turn; take {needed} elements, for a radian each{degrees}",
    )


def _check_share(problems: Problems, where: str, sections: Sequence[BeamSection]) -> None:
    """Refuse consistent inertia of sections whose mass centre is off the axis."""
    off = [i for i, s in enumerate(sections) if float(np.hypot(*s.center)) > CENTRED * _radius(s)]
    if off:
        y, z = sections[off[0]].center
        problems.add(
            where,
            f"mass: the mass centre of element {off[0]} is {1e3 * y:.4g} mm, {1e3 * z:.4g} mm off "
            "the axis, and consistent inertia is that of a centre on it; take 'corrected' or "
            "'lumped', or put the axis through the mass centre and use offset=",
        )


def _radius(section: BeamSection) -> float:
    """Return the smallest radius of gyration of a section, m."""
    return float(np.sqrt(np.linalg.eigvalsh(section.inertia)[0] / section.mass))


def _places(
    problems: Problems, where: str, name: str, value: Any, allowed: range
) -> tuple[int, ...]:
    """Return node numbers, or note those that do not exist."""
    items = tuple(value) if isinstance(value, Sequence | np.ndarray) else (value,)
    good = tuple(
        int(i) for i in items if isinstance(i, int | np.integer) and not isinstance(i, bool)
    )
    bad = [i for i in items if i not in good] + [i for i in good if i not in allowed]
    if bad:
        span = f"{allowed.start} to {allowed.stop - 1}" if len(allowed) else "none"
        problems.add(where, f"{name}: {bad[0]!r} is no inner node; they are {span}")
    return good


def _markers(problems: Problems, where: str, markers: Any, n: int) -> dict[str, int]:
    """Return the named nodes, or note what is wrong."""
    if markers is None:
        return {}
    if not isinstance(markers, Mapping):
        problems.add(where, f"markers is {markers!r}, must be a mapping of names to nodes")
        return {}
    named: dict[str, int] = {}
    for point, place in markers.items():
        if point in ("start", "end") or str(point).removeprefix("node").isdecimal():
            problems.add(where, f"marker {point!r}: the name is taken by a node")
        elif not isinstance(place, int | np.integer) or not 0 <= place <= n:
            problems.add(where, f"marker {point!r}: no node {place!r}; they are 0 to {n}")
        else:
            named[str(point)] = int(place)
    return named


def _up(problems: Problems, where: str, up: ArrayLike | None, nodes: Array) -> Array | None:
    """Return the direction (3,) or directions (n + 1, 3) near the sections' z axes."""
    if up is None:
        chord = nodes[1] - nodes[0]
        across = float(np.linalg.norm(chord[:2]))
        return np.array(
            [1.0, 0.0, 0.0] if across <= 1e-6 * float(np.linalg.norm(chord)) else [0.0, 0.0, 1.0]
        )
    if np.ndim(up) == 2:
        return problems.array(where, "up", up, (len(nodes), 3))
    return parse_direction(problems, where, "up", up)


def _shape(
    problems: Problems,
    where: str,
    nodes: Array,
    up: Array,
    twist: Array,
    corners: tuple[int, ...],
    offsets: Array,
) -> tuple[Array, Array, Array]:
    """Return frames of nodes (n + 1, 3, 3) and ends (n, 2, 3, 3), and the ends (n, 2, 3)."""
    along = tangents(nodes, corners)
    for i in np.flatnonzero(np.einsum("ij,ij->i", along[:-1, 1], along[1:, 0]) < -1 + 1e-9):
        problems.add(where, f"points[{i + 1}]: the beam turns back on itself there")
        return nodes, along, along
    ends = section_frames(along, up, twist)
    if not np.all(np.isfinite(ends)):
        problems.add(
            where,
            "up is parallel to the beam, so that it does not orient its sections; give a "
            "direction across it, up=(x, y, z)",
        )
    frames = np.concatenate([ends[:, 0], ends[-1:, 1]])
    arm = np.concatenate([np.zeros((len(nodes), 1)), offsets], axis=1)
    at = nodes + np.einsum("nij,nj->ni", frames, arm)
    return frames, ends, np.stack([at[:-1], at[1:]], axis=1)


# -- what the engine gets -------------------------------------------------------------------


def _arms(beam: BeamBody) -> tuple[Array, Array]:
    """Return arms u (n, 2, 3) and orientations B (n, 2, 3, 3) of the ends in their nodes."""
    u = np.concatenate([np.zeros((beam.n + 1, 1)), beam.offsets], axis=1)
    frames = np.stack([beam.frames[:-1], beam.frames[1:]], axis=1)
    B = np.swapaxes(frames, 2, 3) @ beam.ends
    same = np.abs(B - np.eye(3)).max(axis=(2, 3)) < 1e-14
    B[same] = np.eye(3)
    return np.stack([u[:-1], u[1:]], axis=1), B


def _element_data(beam: BeamBody) -> dict[str, Array]:
    u, B = _arms(beam)
    made: dict[tuple[int, float], tuple[Array, float]] = {}
    sections = []
    for section, L in zip(beam.sections, beam.lengths, strict=True):
        key = (id(section), float(L) if beam.bending else 0.0)
        if key not in made:
            C = section.with_bending(float(L)) if beam.bending else section.stiffness
            made[key] = C, tension_factor(C)
        C, factor = made[key]
        J = L * section.inertia
        tensor = J[0, 0], J[1, 1], J[2, 2], J[1, 2], J[0, 2], J[0, 1]
        sections.append((C, L * section.mass, tensor, factor, section.polar))
    C, mass, J, limit, polar = (np.array(x, float) for x in zip(*sections, strict=True))
    damping = beam.damping
    return {
        "length": np.array(beam.lengths),
        "u_a": u[:, 0],
        "B_a": B[:, 0],
        "u_b": u[:, 1],
        "B_b": B[:, 1],
        "C": C,
        "e0": np.array(beam.unstressed),
        "beta": np.full(beam.n, damping.stiffness, float),
        "alpha": np.full(beam.n, damping.mass, float),
        "share": np.full(beam.n, beam.share, float),
        "mass": mass,
        "J": J,
        "limit": limit,
        "helical": np.full(beam.n, beam.bending, float),
        "polar": polar,
    }


def _node_bodies(beam: BeamBody) -> list[BeamNode]:
    """Return the node bodies with mass, centre and inertia of their half elements.

    The sum over the nodes is the trapezoidal rule for the kinetic energy ``int f ds`` of
    ``f = rho A v.v / 2``. Corrected, each element of mass m and length h adds
    ``(h^2/12) (f'(0) - f'(h))`` (Euler, Maclaurin) with ``v' = w x t``: the first moment m h/12
    along the axis t towards its inside. At equal elements these cancel but for the ends. A little
    rotary inertia where they do not, of order 3, keeps the mass matrix positive.
    """
    n = beam.n
    u, B = _arms(beam)
    half = 0.5 * beam.lengths * np.array([s.mass for s in beam.sections])
    center = np.array([[0.0, *s.center] for s in beam.sections])
    J = 0.5 * beam.lengths[:, None, None] * np.stack([s.inertia for s in beam.sections])
    mass, first, second = np.zeros(n + 1), np.zeros((n + 1, 3)), np.zeros((n + 1, 3, 3))
    extra = np.zeros((n + 1, 3))
    for end in (0, 1):
        rows = slice(end, n + end)
        x = u[:, end] + np.einsum("nij,nj->ni", B[:, end], center)
        mass[rows] += half
        first[rows] += half[:, None] * x
        turned = B[:, end] @ J @ np.swapaxes(B[:, end], 1, 2)
        second[rows] += turned + half[:, None, None] * _steiner(x)
        if beam.corrected:
            ahead = (1 - 2 * end) * (beam.lengths * half / 6)[:, None] * B[:, end, :, 0]
            extra[rows] += ahead
            second[rows] += 2 * np.einsum("ni,ni->n", x, ahead)[:, None, None] * np.eye(3)
            second[rows] -= x[:, :, None] * ahead[:, None] + ahead[:, :, None] * x[:, None]
    first += extra
    second += ROTARY * _steiner(extra) / mass[:, None, None]
    at = first / mass[:, None]
    inertia = second - mass[:, None, None] * _steiner(at)
    inertia = 0.5 * (inertia + np.swapaxes(inertia, 1, 2))
    A = rotation_matrix(beam.orientation)
    reach = A @ beam.nodes.T
    position = beam.position + reach.T
    velocity = beam.velocity + np.cross(beam.angular_velocity, reach.T)
    frames = A @ beam.frames
    for array in (position, velocity, at, inertia):
        array.setflags(write=False)
    bodies = []
    for i in range(n + 1):
        before = 0.5 * beam.lengths[i - 1] if i > 0 else 0.0
        after = 0.5 * beam.lengths[i] if i < n else 0.0
        arm = np.array([0.0, *beam.offsets[i]])
        outline = np.stack([arm, arm])
        outline[0, 0], outline[1, 0] = -before, after
        bodies.append(
            BeamNode(
                beam.name,
                i,
                mass=float(mass[i]),
                inertia=inertia[i],
                center=at[i],
                position=position[i],
                orientation=read_only(euler_parameters(frames[i])),
                velocity=velocity[i],
                angular_velocity=beam.angular_velocity,
                outline=read_only(outline),
                damping=beam.damping.mass,
            )
        )
    return bodies


def _steiner(x: Array) -> Array:
    """Return ``|x|^2 E - x x^T`` (k, 3, 3) of vectors (k, 3)."""
    square = np.einsum("ni,ni->n", x, x)
    return np.asarray(square[:, None, None] * np.eye(3) - x[:, :, None] * x[:, None, :])
