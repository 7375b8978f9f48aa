"""PlanarFrame: beams in a plane with supports, loads and links."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from jousto.base.errors import Problems, suggest, warn
from jousto.base.object_repr import described
from jousto.planar.element import mass_matrix, shape_matrix
from jousto.planar.elimination import (
    ArmCoupling,
    BlockCoupling,
    ChainCoupling,
    Elimination,
    FunctionCoupling,
    LinearCoupling,
    PlanarCoupling,
)
from jousto.planar.items import (
    FunctionLink,
    LinearLink,
    Link,
    Node,
    PlanarBeam,
    PlanarDamping,
    PlanarLoad,
    PlanarMass,
    PlanarSupport,
    RigidLink,
    vector,
)
from jousto.planar.system import Array, System

WHERE = "PlanarFrame"


@described
@dataclass(frozen=True, eq=False)
class PlanarFrame:
    """Geometrically exact beams in a plane (Reissner), with any master-slave coupling.

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

    Raises
    ------
    InputError
        With all errors: unknown nodes, beams without length, values that are not finite, nodes that
        are slaves of two links.

    Warns
    -----
    JoustoWarning
        If a section is thicker than its beam is long, probably by different units of EI and EA.

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

    def __post_init__(self) -> None:
        problems = Problems()
        kinds: tuple[tuple[str, Any], ...] = (
            ("beams", PlanarBeam),
            ("supports", PlanarSupport),
            ("loads", PlanarLoad),
            ("links", (RigidLink, LinearLink, FunctionLink)),
            ("masses", PlanarMass),
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
        for place, key in self._mentioned():
            if key not in named:
                problems.add(place, f"no node {key!r}{suggest(key, [str(k) for k in named])}")
        if not problems.found:
            self._check_items(problems)
            self._check_links(problems)
        problems.raise_if_any()

    def _mentioned(self) -> Iterator[tuple[str, Node]]:
        """Yield the location and the name of every reference to a node."""
        for i, beam in enumerate(self.beams):
            yield self.beam_name(i), beam.a
            yield self.beam_name(i), beam.b
        for name in ("supports", "loads", "masses"):
            for i, item in enumerate(getattr(self, name)):
                yield f"{name}[{i}]", item.node
        for i, link in enumerate(self.links):
            for key in (*_masters(link), *link.nodes):
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

    def _check_links(self, problems: Problems) -> None:
        owner: dict[Node, int] = {}
        for i, link in enumerate(self.links):
            for key in link.nodes:
                if key in owner:
                    text = f"node {key!r} is already a slave of links[{owner[key]}]"
                    problems.add(f"links[{i}]", f"{text}; a node has one master")
                owner[key] = i
        for i, link in enumerate(self.links):
            for key in _masters(link):
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


def _masters(link: Link) -> tuple[Node, ...]:
    return (link.master,) if isinstance(link, RigidLink) else tuple(link.masters)


def assemble(frame: PlanarFrame) -> System:
    """Return the equations of a frame."""
    names = list(frame.nodes)
    place = {key: i for i, key in enumerate(names)}
    count = len(names)
    where = np.array([frame.nodes[key] for key in names])

    # displacements u: nodes, then the different ends of offset beams
    ends: dict[tuple[int, float, float], int] = {}
    dofs = np.zeros((len(frame.beams), 6), dtype=int)
    for e, beam in enumerate(frame.beams):
        for k, (key, offset) in enumerate(((beam.a, beam.offset_a), (beam.b, beam.offset_b))):
            X, Y = float(offset[0]), float(offset[1])
            index = place[key]
            if X or Y:
                index = ends.setdefault((index, X, Y), count + len(ends))
            dofs[e, 3 * k : 3 * k + 3] = 3 * index + np.arange(3)
    size = 3 * (count + len(ends))

    coupling, unknowns = _links(frame, place, where)
    if ends:
        master = np.array([k[0] for k in ends])
        arms = np.array([k[1:] for k in ends])
        # nodes are ends with arms of length zero
        every = np.concatenate([np.arange(count), master])
        offsets: PlanarCoupling = ArmCoupling(
            count, every, np.concatenate([np.zeros((count, 2)), arms])
        )
        coupling = offsets if coupling is None else ChainCoupling(offsets, coupling)
    if coupling is None:
        coupling = LinearCoupling(np.eye(3 * count))

    # elements
    a = np.array([frame.ends(e)[0] for e in range(len(frame.beams))])
    b = np.array([frame.ends(e)[1] for e in range(len(frame.beams))])
    d = b - a
    length = np.hypot(d[:, 0], d[:, 1])
    sections = [beam.section for beam in frame.beams]
    z0 = np.zeros((len(a), 4))
    z0[:, :2] = d / length[:, None]
    z0[:, 2] = np.arctan2(d[:, 1], d[:, 0])
    M = mass_matrix(
        length * [s.mass for s in sections], length * [s.rotary for s in sections], dofs, size
    )
    for item in frame.masses:
        k = 3 * place[item.node]
        M[range(k, k + 3), range(k, k + 3)] += (item.mass, item.mass, item.inertia)
    g = np.zeros(size)
    g[0::3], g[1::3] = frame.gravity

    held = set()
    label = [f"{'xyr'[c]} of node {names[i]!r}" for i in range(count) for c in range(3)]
    column = {name: i for i, name in enumerate(unknowns)}
    for support in frame.supports:
        for c, hold in enumerate((support.x, support.y, support.rotation)):
            if hold:
                held.add(column[label[3 * place[support.node] + c]])
    return System(
        elimination=Elimination(coupling),
        free=np.array([i for i in range(len(unknowns)) if i not in held], dtype=int),
        names=tuple(unknowns),
        T=shape_matrix(length, dofs, size),
        z0=z0.ravel(),
        length=length,
        D=np.array([(s.EA, s.GA, s.EI) for s in sections]),
        M=M,
        loads=tuple((load, 3 * place[load.node]) for load in frame.loads),
        weight=M @ g,
        alpha=frame.damping.mass,
        beta=frame.damping.stiffness,
        count=count,
    )


def _links(
    frame: PlanarFrame, place: dict[Any, int], where: Array
) -> tuple[PlanarCoupling | None, list[str]]:
    """Return the coupling from unknowns to displacements of nodes, and the unknowns' names."""
    names = list(frame.nodes)
    label = [f"{'xyr'[c]} of node {key!r}" for key in names for c in range(3)]
    if not frame.links:
        return None, label
    slaves: set[int] = set()
    for link in frame.links:
        width = 2 if isinstance(link, RigidLink) and not link.rotation else 3
        slaves |= {3 * place[key] + c for key in link.nodes for c in range(width)}
    kept = [i for i in range(len(label)) if i not in slaves]
    column = {i: k for k, i in enumerate(kept)}
    unknowns = [label[i] for i in kept]
    blocks: list[tuple[Array, Array, PlanarCoupling]] = []
    identity = np.eye(len(kept))
    blocks.append((np.array(kept), np.arange(len(kept)), LinearCoupling(identity)))
    for i, link in enumerate(frame.links):
        masters = (link.master,) if isinstance(link, RigidLink) else link.masters
        columns = [column[3 * place[key] + c] for key in masters for c in range(3)]
        width = 2 if isinstance(link, RigidLink) and not link.rotation else 3
        rows = np.array([3 * place[key] + c for key in link.nodes for c in range(width)])
        part: PlanarCoupling
        if isinstance(link, RigidLink):
            arms = np.array([where[place[k]] - where[place[link.master]] for k in link.nodes])
            part = ArmCoupling(1, np.zeros(len(arms), dtype=int), arms, link.rotation)
        elif isinstance(link, LinearLink):
            part = LinearCoupling(vector(link.T), 0.0 if link.u0 is None else vector(link.u0))
        else:
            own = [f"{name} of links[{i}]" for name in link.coordinates]
            columns += [len(unknowns) + k for k in range(len(own))]
            unknowns += own
            part = FunctionCoupling(link.function, len(rows), len(columns))
        blocks.append((rows, np.array(columns), part))
    assert all(isinstance(x, (RigidLink, LinearLink, FunctionLink)) for x in frame.links)
    return BlockCoupling((len(label), len(unknowns)), blocks), unknowns
