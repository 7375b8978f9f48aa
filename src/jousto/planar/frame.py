"""PlanarFrame: beams in a plane with supports, loads and links."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

import numpy as np

from jousto.base.errors import Problems, count, suggest, warn
from jousto.base.object_repr import described
from jousto.planar.assembly import assemble, masters
from jousto.planar.element import PlanarElement
from jousto.planar.elements import find_element
from jousto.planar.items import (
    FunctionLink,
    LinearLink,
    Link,
    Node,
    PlanarBeam,
    PlanarDamping,
    PlanarLoad,
    PlanarMass,
    PlanarMotion,
    PlanarSupport,
    RigidLink,
    Signal,
)
from jousto.planar.system import Array, System

WHERE = "PlanarFrame"
AXES = ("x", "y", "rotation")


@described
@dataclass(frozen=True, eq=False)
class PlanarFrame:
    """Beams that bend and turn by any amount in a plane, with any master-slave coupling.

    Parameters
    ----------
    nodes : mapping of name to (x, y), or (n, 2) array
        Positions, m; the names of the rows of an array are 0, 1, ...
    beams : sequence of PlanarBeam
        Straight elements of two nodes.
    supports : sequence of PlanarSupport
    loads : sequence of PlanarLoad
    links : sequence of RigidLink, LinearLink, FunctionLink
        Links that make nodes slaves of other nodes.
    masses : sequence of PlanarMass
    damping : PlanarDamping
    gravity : (float, float)
        Gravitational acceleration, m/s^2.
    gravity_signal : function, optional
        Factor of the gravity as a function of time, s, in dynamics; None is 1.
    motions : sequence of PlanarMotion
        Prescribed motions of nodes in dynamics.
    element : {"exact", "corotational", "ancf"} or PlanarElement
        Element of the beams that have none of their own: a word for default options, or an
        `ExactElement`, `CorotationalElement` or `AncfElement` with its options.

    Raises
    ------
    InputError
        With all errors: unknown nodes, beams without length, values that are not finite, nodes that
        are slaves of two links.

    Warns
    -----
    JoustoWarning
        If a section is thicker than its beam is long, probably by different units of EI and EA;
        if an element leaves out shear or rotary inertia that a section has; if an element has
        motions without energy.

    Examples
    --------
    A cantilever with an end moment of 2 pi EI / L closes to a circle, exactly, for any number of
    elements:

    >>> import numpy as np
    >>> import jousto as jo
    >>> rod = jo.planar.PlanarSection(EA=1e6, GA=5e5, EI=10.0)
    >>> frame = jo.planar.PlanarFrame(
    ...     [(0, 0), (0.5, 0), (1, 0)],
    ...     [jo.planar.PlanarBeam(0, 1, rod), jo.planar.PlanarBeam(1, 2, rod)],
    ...     supports=[jo.planar.PlanarSupport(0, rotation=True)],
    ...     loads=[jo.planar.PlanarLoad(2, moment=2 * np.pi * 10.0)],
    ... )
    >>> path = jo.planar.load_steps(frame, np.linspace(0, 1, 11))
    >>> bool(abs(path.positions[-1, 2]).max() < 1e-12)
    True
    """

    nodes: Mapping[Node, Sequence[float]] | Any
    beams: Sequence[PlanarBeam]
    supports: Sequence[PlanarSupport] = ()
    loads: Sequence[PlanarLoad] = ()
    links: Sequence[Link] = ()
    masses: Sequence[PlanarMass] = ()
    damping: PlanarDamping = PlanarDamping()
    gravity: tuple[float, float] = (0.0, 0.0)
    gravity_signal: Signal | None = None
    motions: Sequence[PlanarMotion] = ()
    element: str | PlanarElement = "exact"

    def __post_init__(self) -> None:
        problems = Problems()
        kinds: tuple[tuple[str, Any], ...] = (
            ("beams", PlanarBeam),
            ("supports", PlanarSupport),
            ("loads", PlanarLoad),
            ("links", (RigidLink, LinearLink, FunctionLink)),
            ("masses", PlanarMass),
            ("motions", PlanarMotion),
        )
        for name, kind in kinds:
            given = getattr(self, name)
            items = () if isinstance(given, kind) else tuple(given)
            items = (given,) if isinstance(given, kind) else items
            wrong = [item for item in items if not isinstance(item, kind)]
            for item in wrong:
                known = kind.__name__ if isinstance(kind, type) else "a link"
                problems.add(WHERE, f"{name} has {item!r}, must be {known}")
            object.__setattr__(self, name, tuple(i for i in items if isinstance(i, kind)))
        points = self.nodes if isinstance(self.nodes, Mapping) else dict(enumerate(self.nodes))
        named = {}
        for key, value in points.items():
            p = problems.array(f"node {key!r}", "position", value, (2,))
            named[key] = (0.0, 0.0) if p is None else (float(p[0]), float(p[1]))
        object.__setattr__(self, "nodes", named)
        damping: object = self.damping
        if not isinstance(damping, PlanarDamping):
            problems.add(WHERE, f"damping is {damping!r}, must be PlanarDamping(mass, stiffness)")
        problems.array(WHERE, "gravity", self.gravity, (2,))
        if not self.beams:
            problems.add(WHERE, "has no beams; give one or more")
        object.__setattr__(self, "_elements", self._find_elements(problems))
        for place, key in self._mentioned():
            if key not in named:
                problems.add(place, f"no node {key!r}{suggest(key, [str(k) for k in named])}")
        if not problems.found:
            self._check_items(problems)
            self._check_links(problems)
            self._check_motions(problems)
        problems.raise_if_any()
        self._warn_of_elements()

    def _find_elements(self, problems: Problems) -> tuple[PlanarElement, ...]:
        """Return the element of each beam, and report unknown ones and unfit sections."""
        usual = find_element(problems, WHERE, self.element)
        found = []
        for i, beam in enumerate(self.beams):
            where = self.beam_name(i)
            own = beam.element
            kind = usual if own is None else find_element(problems, where, own)
            if kind is not None:
                found.append(kind)
                kind.check(problems, where, beam.section)
        signal: object = self.gravity_signal
        if signal is not None and not callable(signal):
            text = f"gravity_signal is {signal!r}, must be a function of the time in s"
            problems.add(WHERE, text)
        return tuple(found)

    def element_of(self, i: int) -> PlanarElement:
        """Return the element of a beam, with its options."""
        return cast("tuple[PlanarElement, ...]", vars(self)["_elements"])[i]

    def _warn_of_elements(self) -> None:
        """Warn of parts of sections without effect, and of motions without energy."""
        for i, beam in enumerate(self.beams):
            missing = self.element_of(i).left_out(beam.section)
            if missing:
                kind = self.element_of(i).word
                text = f"element '{kind}' leaves out {' and '.join(missing)} of its section"
                warn(self.beam_name(i), f"{text}; PlanarSection.slender has neither")
                break
        for group in self.system.groups:
            loose = group.free_motions()
            if loose:
                text = f"{group.element!r} leaves {count(loose, 'motion')} of a free beam without "
                text += "energy, besides rigid ones; use other points of integration"
                warn(self.beam_name(int(group.members[0])), text)

    def _mentioned(self) -> Iterator[tuple[str, Node]]:
        """Yield the location and the name of every reference to a node."""
        for i, beam in enumerate(self.beams):
            yield self.beam_name(i), beam.a
            yield self.beam_name(i), beam.b
        for name in ("supports", "loads", "masses", "motions"):
            for i, item in enumerate(getattr(self, name)):
                yield f"{name}[{i}]", item.node
        for i, link in enumerate(self.links):
            for key in (*masters(link), *link.nodes):
                yield f"links[{i}]", key

    def beam_name(self, i: int) -> str:
        """Return the name of an element in messages."""
        beam = self.beams[i]
        return f"beam '{beam.name}'" if beam.name else f"beams[{i}] ({beam.a!r} to {beam.b!r})"

    def _check_items(self, problems: Problems) -> None:
        for i, beam in enumerate(self.beams):
            where, bad = self.beam_name(i), False
            for name in ("offset_a", "offset_b"):
                bad |= problems.array(where, name, getattr(beam, name), (2,)) is None
            if bad:
                continue
            a, b = self.ends(i)
            length = math.dist(a, b)
            if length <= 1e-12 * max(1.0, *np.abs((*a, *b))):
                text = f"both ends are at ({a[0]:g}, {a[1]:g}) m; give it a length or remove it"
                problems.add(where, text)
                continue
            radius = math.sqrt(beam.section.EI / beam.section.EA)
            if radius > length:
                warn(
                    where,
                    f"its radius of gyration sqrt(EI/EA) is {radius:.3g} m and its length "
                    f"{length:.3g} m; are EI in N m^2, EA in N and positions in m?",
                )
        for i, load in enumerate(self.loads):
            problems.array(f"loads[{i}]", "force", load.force, (2,))
            problems.number(f"loads[{i}]", "moment", load.moment, "N m")
            signal: object = load.signal
            if signal is not None and not callable(signal):
                text = f"signal is {signal!r}, must be a function of the time in s"
                problems.add(f"loads[{i}]", text)
        for i, mass in enumerate(self.masses):
            for name, unit in (("mass", "kg"), ("inertia", "kg m^2")):
                value, wanted = getattr(mass, name), "zero or a positive number"
                problems.number(f"masses[{i}]", name, value, unit, wanted, lambda x: x >= 0.0)

    def _check_motions(self, problems: Problems) -> None:
        """Report motions that are no functions, of supported nodes, and of slaves."""
        held = {(s.node, c) for s in self.supports for c in AXES if getattr(s, c)}
        slaves = {key: i for i, link in enumerate(self.links) for key in link.nodes}
        for i, motion in enumerate(self.motions):
            where = f"motions[{i}]"
            given = [c for c in AXES if getattr(motion, c) is not None]
            if not given:
                problems.add(where, "moves nothing; give x, y or rotation")
            if motion.node in slaves:
                text = f"node {motion.node!r} is a slave of links[{slaves[motion.node]}]"
                problems.add(where, f"{text}; move its master instead")
            for c in given:
                if (motion.node, c) in held:
                    text = f"{c} of node {motion.node!r} is supported or moved twice"
                    problems.add(where, f"{text}; keep one of both")
                held.add((motion.node, c))
                _check_motion(problems, where, c, getattr(motion, c))

    def _check_links(self, problems: Problems) -> None:
        owner: dict[Node, int] = {}
        for i, link in enumerate(self.links):
            for key in link.nodes:
                if key in owner:
                    text = f"node {key!r} is already a slave of links[{owner[key]}]"
                    problems.add(f"links[{i}]", f"{text}; a node has one master")
                owner[key] = i
        for i, link in enumerate(self.links):
            for key in masters(link):
                if key in owner:
                    text = f"master {key!r} is itself a slave of links[{owner[key]}]"
                    problems.add(f"links[{i}]", f"{text}; link to that one's master")
            if isinstance(link, LinearLink):
                shape = 3 * len(link.nodes), 3 * len(link.masters)
                problems.array(f"links[{i}]", "T", link.T, shape)
                if link.u0 is not None:
                    problems.array(f"links[{i}]", "u0", link.u0, shape[:1])
            if isinstance(link, FunctionLink):
                size = 3 * len(link.masters) + len(link.coordinates)
                try:
                    found = np.shape(link.function(np.zeros(size)))
                except Exception as error:
                    text = f"its function fails at zero displacements: {error}"
                    problems.add(f"links[{i}]", text)
                else:
                    if found != (3 * len(link.nodes),):
                        text = f"its function returns shape {found}, must be"
                        problems.add(f"links[{i}]", f"{text} ({3 * len(link.nodes)},)")
        for i, support in enumerate(self.supports):
            if support.node not in owner:
                continue
            carrier = self.links[owner[support.node]]
            hinge = isinstance(carrier, RigidLink) and not carrier.rotation
            if support.x or support.y or not hinge:
                text = f"node {support.node!r} is a slave of links[{owner[support.node]}]"
                problems.add(f"supports[{i}]", f"{text}; support its master instead")

    def ends(self, i: int) -> tuple[Array, Array]:
        """Return both ends of an element's axis in the unloaded frame, m."""
        beam = self.beams[i]
        a = np.add(self.nodes[beam.a], beam.offset_a)
        b = np.add(self.nodes[beam.b], beam.offset_b)
        return np.asarray(a, dtype=float), np.asarray(b, dtype=float)

    @cached_property
    def system(self) -> System:
        """Equations of motion, with residuals and tangents."""
        return assemble(self)


def _check_motion(problems: Problems, where: str, axis: str, function: object) -> None:
    """Report a motion that does not return value, rate and second rate at t = 0."""
    wanted = "must be a function of the time in s that returns value, rate and second rate"
    if not callable(function):
        problems.add(where, f"{axis} is {function!r}, {wanted}")
        return
    try:
        found = np.asarray(function(0.0), dtype=float)
    except Exception as error:
        problems.add(where, f"{axis} fails at t = 0: {error}; it {wanted}")
        return
    if found.shape != (3,) or not np.isfinite(found).all():
        problems.add(where, f"{axis} returns {found!r} at t = 0; it {wanted}")
