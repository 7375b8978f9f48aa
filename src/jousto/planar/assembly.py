"""Assembly: the equations of a planar frame in arrays, from its items.

The displacements u are those of the nodes, of the other ends of offset beams, and the own ones of
the elements. The unknowns q are displacements of nodes, coordinates of links, and stretches.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from jousto.planar.element import Array, Beams, ElementGroup, Motion, PlanarElement
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
    PlanarMotion,
    PlanarSupport,
    Prescribed,
    RigidLink,
    Signal,
    vector,
)
from jousto.planar.system import System

STRAIGHT = 1e-9  # sine of the angle up to which two beams are collinear


class Declaration(Protocol):
    """What a frame declares; `PlanarFrame` checks and documents it."""

    @property
    def nodes(self) -> Any:
        """Positions by the names of nodes, m."""

    @property
    def beams(self) -> Sequence[PlanarBeam]:
        """Beams."""

    @property
    def supports(self) -> Sequence[PlanarSupport]:
        """Supports."""

    @property
    def motions(self) -> Sequence[PlanarMotion]:
        """Prescribed motions."""

    @property
    def loads(self) -> Sequence[PlanarLoad]:
        """Loads."""

    @property
    def links(self) -> Sequence[Link]:
        """Links."""

    @property
    def masses(self) -> Sequence[PlanarMass]:
        """Masses."""

    @property
    def damping(self) -> PlanarDamping:
        """Damping."""

    @property
    def gravity(self) -> tuple[float, float]:
        """Gravitational acceleration, m/s^2."""

    @property
    def gravity_signal(self) -> Signal | None:
        """Factor of gravity over time."""

    def element_of(self, i: int) -> PlanarElement:
        """Return the element of a beam."""

    def beam_name(self, i: int) -> str:
        """Return the name of a beam in messages."""

    def ends(self, i: int) -> tuple[Array, Array]:
        """Return both ends of a beam in the unloaded frame, m."""


class Ends(NamedTuple):
    """Ends of the beams: nodes, then the different ends of offset beams.

    Attributes
    ----------
    of_beams : (ne, 2) array of int
        Index of both ends of each beam.
    arms : tuple of (node, X, Y)
        Master node and arm, m, of each end of an offset beam.
    nodes : int
        Number of nodes.
    """

    of_beams: Array
    arms: tuple[tuple[int, float, float], ...]
    nodes: int

    @property
    def total(self) -> int:
        """Number of nodes and ends of offset beams."""
        return self.nodes + len(self.arms)

    @property
    def dofs(self) -> Array:
        """Indices of x, y, rotation of both ends of each beam, (ne, 6)."""
        return (3 * self.of_beams[:, :, None] + np.arange(3)).reshape(-1, 6)


def masters(link: Link) -> tuple[Node, ...]:
    """Return the master nodes of a link."""
    return (link.master,) if isinstance(link, RigidLink) else tuple(link.masters)


def assemble(frame: Declaration) -> System:
    """Return the equations of a frame."""
    place = {key: i for i, key in enumerate(frame.nodes)}
    ends = _ends(frame, place)
    chords = np.array([np.subtract(*frame.ends(e)[::-1]) for e in range(len(frame.beams))])
    coupling, unknowns = _nodes_coupling(frame, place, ends)
    stretches, names = shared_stretches(frame, ends, chords)
    made = _groups(frame, ends, chords, stretches, len(names))
    first = 3 * ends.total
    coupling = _with_own(coupling, len(names), first, made.size, made.couplings)
    M = _mass(frame, place, made)
    g = np.zeros(made.size)
    g[0:first:3], g[1:first:3] = frame.gravity
    held, moved = _held(frame, place, unknowns)
    unknowns = [*unknowns, *names]
    sections = [beam.section for beam in frame.beams]
    limited = [frame.element_of(e).shear_limit for e in range(len(sections))]
    return System(
        elimination=Elimination(coupling),
        free=np.array([i for i in range(len(unknowns)) if i not in held], dtype=int),
        moved=moved,
        names=tuple(unknowns),
        groups=tuple(made.groups),
        length=np.hypot(chords[:, 0], chords[:, 1]),
        D=np.array([(s.EA, s.GA, s.EI) for s in sections]),
        limits=np.where(limited, [s.limit for s in sections], np.inf),
        M=M,
        loads=tuple((load, 3 * place[load.node]) for load in frame.loads),
        weight=M @ g,
        gravity_signal=frame.gravity_signal,
        alpha=frame.damping.mass,
        beta=frame.damping.stiffness,
        count=ends.nodes,
    )


class _Made(NamedTuple):
    """Groups of beams with their masses and couplings, and the number of all displacements."""

    groups: list[ElementGroup]
    masses: list[Array]
    couplings: list[tuple[Array, PlanarCoupling]]
    size: int


def _groups(frame: Declaration, ends: Ends, chords: Array, stretches: Array, count: int) -> _Made:
    """Return the beams of each element; own displacements come behind those of the ends."""
    first = size = 3 * ends.total
    groups: list[ElementGroup] = []
    masses: list[Array] = []
    couplings: list[tuple[Array, PlanarCoupling]] = []
    for kind, members in _kinds(frame).items():
        beams = Beams.of(chords[members], [frame.beams[e].section for e in members])
        own = size + np.arange(kind.own * len(members))
        dofs = np.concatenate([ends.dofs[members], own.reshape(len(members), -1)], axis=1)
        groups.append(ElementGroup(kind, members, dofs, *kind.points(beams)))
        masses.append(kind.masses(beams))
        at = np.where(stretches[members] < 0, -1, first + stretches[members])
        part = kind.own_coupling(beams, Motion(ends.dofs[members], at, first + count))
        if part is not None:
            couplings.append((own, part))
        size += len(own)
    return _Made(groups, masses, couplings, size)


def _held(
    frame: Declaration, place: dict[Any, int], unknowns: list[str]
) -> tuple[set[int], tuple[tuple[int, Prescribed], ...]]:
    """Return the supported and moved unknowns, and the moved ones with their motions."""
    column = {name: i for i, name in enumerate(unknowns)}
    label = _labels(frame)

    def at(node: Node, c: int) -> int:
        return column[label[3 * place[node] + c]]

    held = {
        at(s.node, c)
        for s in frame.supports
        for c, hold in enumerate((s.x, s.y, s.rotation))
        if hold
    }
    moved = tuple(
        (at(m.node, c), motion)
        for m in frame.motions
        for c, motion in enumerate((m.x, m.y, m.rotation))
        if motion is not None
    )
    return held | {k for k, _ in moved}, moved


def _kinds(frame: Declaration) -> dict[PlanarElement, Array]:
    """Return the beams of each element with equal options."""
    found: dict[PlanarElement, list[int]] = {}
    for e in range(len(frame.beams)):
        found.setdefault(frame.element_of(e), []).append(e)
    return {kind: np.array(members) for kind, members in found.items()}


def _ends(frame: Declaration, place: dict[Any, int]) -> Ends:
    count = len(frame.nodes)
    arms: dict[tuple[int, float, float], int] = {}
    of_beams = np.zeros((len(frame.beams), 2), dtype=int)
    for e, beam in enumerate(frame.beams):
        for k, (key, offset) in enumerate(((beam.a, beam.offset_a), (beam.b, beam.offset_b))):
            X, Y = float(offset[0]), float(offset[1])
            index = place[key]
            if X or Y:
                index = arms.setdefault((index, X, Y), count + len(arms))
            of_beams[e, k] = index
    return Ends(of_beams, tuple(arms), count)


def shared_stretches(frame: Declaration, ends: Ends, chords: Array) -> tuple[Array, list[str]]:
    """Return the number of the stretch of both ends of each beam (ne, 2), -1 without, and names.

    Two beams share it where the axial force is continuous: they are collinear, have one section and
    one element, and nothing else acts on their node: no beam, load, mass, support, link or arm.
    """
    wanted = np.array([frame.element_of(e).stretches for e in range(len(frame.beams))])
    place = {key: i for i, key in enumerate(frame.nodes)}
    acting: list[PlanarSupport | PlanarMotion | PlanarMass]
    acting = [*frame.supports, *frame.motions, *frame.masses]
    loaded = {place[x.node] for x in acting}
    loaded |= {place[x.node] for x in frame.loads if any(x.force)}
    loaded |= {place[key] for link in frame.links for key in (*masters(link), *link.nodes)}
    loaded |= {node for node, *_ in ends.arms}
    at: dict[int, list[tuple[int, int]]] = {}
    for e, pair in enumerate(ends.of_beams):
        for k in range(2):
            at.setdefault(int(pair[k]), []).append((e, k))
    number = np.full((len(frame.beams), 2), -1)
    names: list[str] = []
    nodes = list(frame.nodes)
    for end, items in at.items():
        own = [item for item in items if wanted[item[0]]]
        join = len(items) == len(own) == 2 and end not in loaded and end < ends.nodes
        join = join and _continues(frame, own, chords)
        for i, (e, k) in enumerate(own):
            if not (join and i):
                node = nodes[end] if end < ends.nodes else nodes[ends.arms[end - ends.nodes][0]]
                names.append(f"stretch of {frame.beam_name(e)} at node {node!r}")
            number[e, k] = len(names) - 1
    return number, names


def _continues(frame: Declaration, pair: list[tuple[int, int]], chords: Array) -> bool:
    """Return whether the second beam continues the first one, with its section and element."""
    (e, i), (f, k) = pair
    # directions away from the common node
    a, b = (1 - 2 * i) * chords[e], (1 - 2 * k) * chords[f]
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    straight = abs(a[0] * b[1] - a[1] * b[0]) < STRAIGHT * size and a @ b < 0.0
    same = frame.beams[e].section == frame.beams[f].section
    return bool(straight and same and frame.element_of(e) == frame.element_of(f))


def _nodes_coupling(
    frame: Declaration, place: dict[Any, int], ends: Ends
) -> tuple[PlanarCoupling | None, list[str]]:
    """Return the coupling from unknowns to displacements of ends, and the unknowns' names.

    None stands for equal displacements and unknowns.
    """
    where = np.array([frame.nodes[key] for key in frame.nodes])
    coupling, unknowns = _links(frame, place, where)
    if ends.arms:
        master = np.array([k[0] for k in ends.arms])
        arms = np.array([k[1:] for k in ends.arms])
        # nodes are ends with arms of length zero
        every = np.concatenate([np.arange(ends.nodes), master])
        lengths = np.concatenate([np.zeros((ends.nodes, 2)), arms])
        offsets = ArmCoupling(ends.nodes, every, lengths)
        return (offsets if coupling is None else ChainCoupling(offsets, coupling)), unknowns
    return coupling, unknowns


def _with_own(
    coupling: PlanarCoupling | None,
    stretches: int,
    size: int,
    slaves: int,
    parts: Sequence[tuple[Array, PlanarCoupling]],
) -> PlanarCoupling:
    """Return the coupling with the own displacements of elements, and stretches as unknowns."""
    if not parts:
        return coupling or LinearCoupling(np.eye(size))
    every = np.arange(size + stretches)
    same = LinearCoupling(np.eye(size))
    own = [(rows, every, part) for rows, part in parts]
    outer = BlockCoupling((slaves, len(every)), [(every[:size], every[:size], same), *own])
    if coupling is None:
        return outer
    if not stretches:
        return ChainCoupling(outer, coupling)
    n, more = coupling.shape[1], LinearCoupling(np.eye(stretches))
    blocks = [(every[:size], np.arange(n), coupling), (every[size:], n + every[:stretches], more)]
    return ChainCoupling(outer, BlockCoupling((size + stretches, n + stretches), blocks))


def _mass(frame: Declaration, place: dict[Any, int], made: _Made) -> Array:
    """Return the mass matrix of the displacements (size, size)."""
    M = np.zeros((made.size, made.size))
    for group, of_beams in zip(made.groups, made.masses, strict=True):
        np.add.at(M, (group.dofs[:, :, None], group.dofs[:, None, :]), of_beams)
    for item in frame.masses:
        k = 3 * place[item.node]
        M[range(k, k + 3), range(k, k + 3)] += (item.mass, item.mass, item.inertia)
    return M


def _labels(frame: Declaration) -> list[str]:
    return [f"{'xyr'[c]} of node {key!r}" for key in frame.nodes for c in range(3)]


def _links(
    frame: Declaration, place: dict[Any, int], where: Array
) -> tuple[PlanarCoupling | None, list[str]]:
    """Return the coupling from unknowns to displacements of nodes, and the unknowns' names."""
    label = _labels(frame)
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
        columns = [column[3 * place[key] + c] for key in masters(link) for c in range(3)]
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
