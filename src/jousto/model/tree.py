"""Tree: mechanisms that can run in joint coordinates, and their links in the engine's order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import accumulate
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.rotations import rotation_matrix
from jousto.mechanism.items_by_kind import CORES, word_problem
from jousto.model.loop_joints import cut_joints, drawback, spanning
from jousto.model.model import JointModel, LinkModel, Model
from jousto.model.subtrees import bearers, carried_bodies, is_link, with_ports

PORTS = 4
"""Smallest number of carried bodies for "auto" to select joint coordinates beside flexible ones.

The reaction of a subtree on its carrier costs about as much as the rows of one body: 2 carried
bodies are 1.1 times faster, 5 and 9 bodies 1.5 and 2 times (benchmarks/ports.py).
"""

JOINT = "joint coordinates"
BODIES = "positions of the bodies"
PARALLEL = {(0, 2), (1, 2)}
NO_TURN = {(0, 2), (1, 2), (0, 1)}
# links by three criteria: whether the origins coincide, whether x and y are fixed in the axes of a,
# and the pairs of perpendicular axes
LINKS = {
    (True, False, frozenset(PARALLEL)): "hinge",
    (True, False, frozenset(NO_TURN)): "fixed",
    (True, False, frozenset({(2, 2)})): "universal",
    (True, False, frozenset[tuple[int, int]]()): "ball",
    (False, True, frozenset(NO_TURN)): "slide",
    (False, True, frozenset(PARALLEL)): "cylindrical",
}
ALIGNED = 0.5  # smallest cosine between axes of a and b that a joint keeps parallel
JUMP = 1e-9  # largest jump of values and rates of a signal that counts as continuous, relative
KINDS = "revolute, prismatic, cylindrical, universal, spherical and fixed"
# axes of the two angles of a universal joint in columns: (z, x, y) and (y, x, -z)
Z_FIRST = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
Y_FIRST_BACK = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


class _Unfit(Exception):
    """Error of a mechanism that cannot run in joint coordinates, with the reason."""


def with_core(model: Model, core: str) -> Model:
    """Return the model with its solver core: "auto", "joint" or "maximal".

    Raises
    ------
    InputError
        If joint coordinates are requested but impossible.
    """
    if problem := word_problem("core", core, CORES):
        raise InputError(Problem(f"mechanism {model.name!r}", problem))
    if core == "maximal":
        return replace(model, tree=()) if model.tree else model
    try:
        made = _treed(model)
        return model if core == "auto" and _drawback(made) else made
    except _Unfit as reason:
        if core == "joint":
            where = f"mechanism {model.name!r}"
            remedy = "use core='maximal', or leave core out"
            raise InputError(
                Problem(where, f"cannot run in joint coordinates: {reason}; {remedy}")
            ) from None
        return model


def core_of(model: Model) -> str:
    """Return the core of a model, and why it is not joint coordinates if so."""
    if model.mixed:
        carried, where = _carried(model), ", ".join(bearers(model))
        kept = len(model.bodies) - carried
        bodies = "1 body" if kept == 1 else f"{kept} bodies"
        return f"positions of {bodies}, {JOINT} for {carried} more on {where}"
    if model.links:
        rows = sum(model.joints[k].rows for k in cut_joints(model, model.links))
        loops = f", {rows} row{'s' * (rows > 1)} beside it" if rows else ""
        return f"{JOINT} ({model.nu} of a tree{loops})"
    try:
        reason = _drawback(_treed(model))
    except _Unfit as unfit:
        reason = str(unfit)
    return BODIES + (f": {reason}" if reason else ", as requested")


def _drawback(made: Model) -> str:
    """Return why joint coordinates are not faster; empty if they are faster."""
    if not made.mixed:
        return drawback(made)
    count = _carried(made)
    return f"joint coordinates for {count} of them save little" if count < PORTS else ""


def _carried(model: Model) -> int:
    """Return the number of bodies with joint coordinates in a model that has both kinds."""
    return len(model.bodies) - sum(link.kind == "body" for link in model.links)


def _treed(model: Model) -> Model:
    """Return the model with its links; _Unfit if it has none."""
    if any(body.n for body in model.bodies):
        return with_ports(model, _Tree(model).ports())
    return replace(model, tree=_Tree(model).links(), tree_of=model.parts_of_tree)


@dataclass(eq=False)
class _Tree:
    model: Model
    made: list[LinkModel] = field(default_factory=list)
    of_body: dict[int, int] = field(default_factory=dict)
    drives: dict[int, int] = field(default_factory=dict)  # joint of the drive, by coordinate
    kinds: dict[str, str] = field(
        default_factory=dict
    )  # kinds of the joints that can be links, by name

    def links(self) -> tuple[LinkModel, ...]:
        """Return the links, parents first; _Unfit if there are none."""
        self._check_items()
        joints = self._joints()
        near = self._near(joints)
        self._grow(-1, near)
        heavy = sorted(range(len(self.model.bodies)), key=lambda i: -self._mass(i))
        for body in heavy:
            if body not in self.of_body:
                self._add(None, "free", {"kind": "free", "parent": -1, "body": body})
                self.of_body[body] = len(self.made) - 1
                self._grow(body, near)
        rest = cut_joints(self.model, self.made)
        if self.model.switched and rest:
            row, joint = self.model.switched[0].name, self.model.joints[rest[0]].name
            raise _Unfit(f"stop or lock '{row}' is beside '{joint}', which is not a link of a tree")
        if self.model.frictions and rest:
            friction, joint = self.model.frictions[0].name, self.model.joints[rest[0]].name
            raise _Unfit(
                f"friction '{friction}' is beside '{joint}', which is not a link of a tree"
            )
        self._note_locks()
        return tuple(self.made)

    def ports(self) -> tuple[LinkModel, ...]:
        """Return the links of rigid subtrees, after the other bodies; _Unfit if there are none."""
        m = self.model
        if m.beams:
            raise _Unfit(f"'{m.beams[0].body}' is an exact beam")
        soft = next(body.name for body in m.bodies if body.n)
        if m.frictions:
            friction = m.frictions[0].name
            raise _Unfit(f"body '{soft}' is flexible, and '{friction}' is friction")
        if m.switched:
            row = m.switched[0].name
            raise _Unfit(f"body '{soft}' is flexible, and '{row}' is a rigid stop or a lock")
        if hubs := m.elimination.hubs:
            hub = m.bodies[hubs[0]].name
            raise _Unfit(f"body '{soft}' is flexible, and '{hub}' has very many joints")
        alone = [k for k, joint in enumerate(m.joints) if joint.release < 0 and joint.lock < 0]
        known = {k for k in alone if is_link(m.joints[k]) and self._known(k)}
        drives = {k for k in alone if not is_link(m.joints[k]) and self._drives(m.joints[k])}
        while carried := carried_bodies(m, known, drives):
            links = self._on_bodies(carried, drives)
            taken = {link.drive for link in links}
            strange = {k for k in drives - taken if set(self._ends(k)) & carried.keys()}
            if not strange:
                return links
            drives -= strange
        raise _Unfit(
            f"body '{soft}' is flexible, and no rigid body is connected to another rigid body only"
        )

    def _on_bodies(self, carried: dict[int, int], drives: set[int]) -> tuple[LinkModel, ...]:
        joints = self.model.joints
        self.drives = {}
        for k in sorted(drives):
            self.drives.setdefault(joints[k].lines[0].coordinates[0], k)
        kept = [i for i in range(len(self.model.bodies)) if i not in carried]
        self.made, self.of_body = [], {body: i for i, body in enumerate(kept)}
        for body in kept:
            fields = {"kind": "body", "parent": -1, "body": body}
            self._add(None, "body", {**fields, "modes": self.model.bodies[body].n})
        near = self._near(sorted(carried.values()))
        for body in [-1, *kept]:
            self._grow(body, near)
        return tuple(self.made)

    def _near(self, joints: Sequence[int]) -> dict[int, list[int]]:
        """Return the joints on each body, those of motors behind gear springs last.

        A motor is eliminated before the joint of its spring, so that it follows that joint
        (`jo_link_coupling` of the engine).
        """
        model, near = self.model, dict[int, list[int]]()
        shafts = {model.coordinates[f.other] for f in model.forces if f.other >= 0}
        sides = {frozenset((shaft.a, shaft.b)) for shaft in shafts}
        for k in sorted(joints, key=lambda k: frozenset(model.joints[k].sides[:2]) in sides):
            for body in self._ends(k):
                near.setdefault(body, []).append(k)
        return near

    def _note_locks(self) -> None:
        """Store for each link the friction, stop or lock that can lock it."""
        users: dict[int, list[int]] = {}  # links by their coordinates
        for i, link in enumerate(self.made):
            for coordinate in link.coordinates:
                users.setdefault(coordinate, []).append(i)
        for friction in self.model.frictions:
            if not friction.sticks:
                continue
            lock = self.model.joints[friction.lock].lock
            for place in {friction.coordinate, friction.other}:
                for i in users.get(place, ()):
                    self.made[i] = replace(self.made[i], lock=lock)
        for row in self.model.switched:
            joint = self.model.joints[row.joint]
            links = users.get(joint.lines[0].coordinates[0], ())
            if not links:
                raise _Unfit(f"'{row.name}' limits no coordinate of a link")
            for i in links:
                if self.made[i].lock >= 0 or self.made[i].drive >= 0:
                    raise _Unfit(f"'{row.name}' is not alone on its coordinate")
                self.made[i] = replace(self.made[i], lock=joint.lock)

    def _mass(self, body: int) -> float:
        return float(np.real(self.model.bodies[body].mass[0]))

    def _check_items(self) -> None:
        m = self.model
        if m.beams:
            raise _Unfit(f"'{m.beams[0].body}' is an exact beam")
        for body in m.bodies:
            if body.n:
                raise _Unfit(f"body '{body.name}' is flexible")
        if not m.bodies:
            raise _Unfit("it has no bodies")
        for friction in m.frictions:
            if friction.contact >= 0:
                raise _Unfit(f"rows of '{friction.name}' hold points that touch")
        for joint in m.joints:
            if joint.release >= 0:
                event = m.events[joint.release].name
                raise _Unfit(f"event '{event}' releases '{joint.name}'")

    def _ends(self, joint: int) -> tuple[int, int]:
        return self._bodies[joint]

    @cached_property
    def _bodies(self) -> list[tuple[int, int]]:
        """The two bodies of each joint."""
        of = [marker.body for marker in self.model.markers]
        return [(of[joint.sides[0]], of[joint.sides[1]]) for joint in self.model.joints]

    def _joints(self) -> list[int]:
        """Return the joints that become links; store the drives of coordinates.

        Of the joints of a loop, the one with the fewest rows is left out; its rows, and those of
        couplings, remain, see loop_joints.py.
        """
        joints = self.model.joints
        known: list[int] = []
        for k, joint in enumerate(joints):
            if joint.coincident or joint.perpendicular:
                if self._known(k):
                    known.append(k)
            elif joint.lock < 0 and self._drives(joint):
                self.drives.setdefault(joint.lines[0].coordinates[0], k)
        kept = spanning([(*self._ends(k), joints[k].rows) for k in known])
        return [known[i] for i in kept]

    def _known(self, place: int) -> bool:
        try:
            self.kinds[self.model.joints[place].name] = self._kind(place)
        except _Unfit:
            return False
        return True

    def _drives(self, joint: JointModel) -> bool:
        """Return whether a drive prescribes one coordinate, with a continuous speed."""
        line = joint.lines[0]
        single = len(joint.lines) == 1 and len(line.coordinates) == 1
        return single and line.signal >= 0 and self._smooth(line.signal)

    def _smooth(self, place: int) -> bool:
        """Return whether the value and the rate of a signal are continuous."""
        signal = self.model.signals[place]
        if signal.kind in ("sum", "product"):
            return all(self._smooth(child) for child in signal.children)
        if signal.kind == "pieces":
            return _smooth_pieces(np.real(signal.data), signal.count, signal.degree)
        return signal.kind in ("constant", "harmonic", "speed")

    def _grow(self, start: int, near: dict[int, list[int]]) -> None:
        """Add all bodies connected to a body, or to the ground, branch by branch."""
        waiting = [(k, start) for k in reversed(near.get(start, []))]
        while waiting:
            k, parent = waiting.pop()
            a, b = self._ends(k)
            body = b if a == parent else a
            if body in self.of_body or body < 0:
                continue  # the joint towards the parent
            self._hang(k, parent, body, body == a)
            waiting += [(j, body) for j in reversed(near[body]) if j != k]

    def _hang(self, k: int, parent: int, body: int, reversed_: bool) -> None:
        joint = self.model.joints[k]
        kind = self.kinds[joint.name]
        outer, inner = joint.sides[::-1] if reversed_ else joint.sides
        above = self.of_body[parent] if parent >= 0 else -1
        if above >= 0 and self.made[above].kind == "fixed":
            # children of a fixed body are attached to the parent of that body
            above = self.made[above].parent
        link = {"kind": kind, "parent": above, "body": body, "outer": outer, "inner": inner}
        link |= {"joint": k, "reversed": int(reversed_)}
        if kind in ("cylindrical", "universal"):
            first = "slide" if kind == "cylindrical" else "hinge"
            crossed = int(kind == "universal")
            self._add(joint, kind, link | {"kind": first, "body": -1, "inner": -1, "joint": -1})
            above = len(self.made) - 1
            link |= {"kind": "hinge", "parent": above, "outer": -1, "crossed": crossed}
        self._add(joint, kind, link)
        self.of_body[body] = len(self.made) - 1

    def _add(self, joint: JointModel | None, whole: str, link: dict[str, Any]) -> None:
        """Append a link with given fields, and add its indices and its own coordinates.

        `whole` is the kind of the joint; a link may be its first or its second half.
        """
        if self.made:
            last = self.made[-1]
            link |= {"x": last.x + last.positions, "u": last.u + last.rates}
        if joint is not None:
            link["coordinates"] = self._own(link, joint, whole)
        for coordinate in link.get("coordinates", ()):
            if coordinate in self.drives and "drive" not in link:
                drive = self.drives.pop(coordinate)
                link |= {"drive": drive, "driven": self.first_line[drive]}
        self.made.append(LinkModel(**link))

    def _own(self, link: dict[str, Any], joint: JointModel, kind: str) -> tuple[int, ...]:
        """Return the coordinates that equal the position of a link, up to the sign."""
        a, b = joint.sides[:2]
        pairs = {"hinge": ("angle", a, b), "slide": ("along", a, b)}
        found = []
        for i in self.between.get(self._pair(a, b), ()):
            c = self.model.coordinates[i]
            if kind == "universal":
                mine = not link["reversed"] and c.kind == "angle" and self._crossed(link, joint, i)
            else:
                mine = (c.kind, c.a, c.b) == pairs.get(link["kind"]) and (
                    c.kind == "angle" or c.axis_a == 2
                )
            if mine:
                found.append(i)
        return tuple(found)

    @cached_property
    def first_line(self) -> list[int]:
        """Index of the first line of each joint among the lines of all joints."""
        return [0, *accumulate(len(joint.lines) for joint in self.model.joints)]

    @cached_property
    def between(self) -> dict[tuple[int, int], list[int]]:
        """Coordinates, grouped by their two bodies."""
        found: dict[tuple[int, int], list[int]] = {}
        for i, c in enumerate(self.model.coordinates):
            found.setdefault(self._pair(c.a, c.b), []).append(i)
        return found

    def _pair(self, a: int, b: int) -> tuple[int, int]:
        one, other = self.model.markers[a].body, self.model.markers[b].body
        return (one, other) if one <= other else (other, one)

    def _crossed(self, link: dict[str, Any], joint: JointModel, place: int) -> bool:
        """Return whether an angle is that of the first or the second hinge of a universal joint."""
        a, b = joint.sides[:2]
        c = self.model.coordinates[place]
        if link["body"] < 0:
            return c.a == a and self._turned(c.b, b, Z_FIRST)
        return self._turned(c.a, b, Y_FIRST_BACK) and self._turned(c.b, a, Z_FIRST)

    def _turned(self, place: int, origin: int, axes: Array) -> bool:
        """Return whether a marker is another marker with reordered axes."""
        one, other = self.model.markers[place], self.model.markers[origin]
        return (
            one.body == other.body
            and np.array_equal(one.u0, other.u0)
            and float(np.abs(one.A0 - other.A0 @ axes).max()) < 1e-14
        )

    def _kind(self, place: int) -> str:
        """Return the links that represent a joint, as kinds; _Unfit if there are none."""
        joint = self.model.joints[place]
        rows, sliding = set(joint.perpendicular), self._slides(joint)
        kind = LINKS.get((joint.coincident, sliding, frozenset(rows)))
        if kind is None or (joint.coincident and joint.lines):
            raise _Unfit(f"joint '{joint.name}' is none of the kinds {KINDS}")
        if kind in ("ball", "universal"):
            return kind
        axes = (2,) if rows == PARALLEL else (0, 1, 2)
        if any(self.cosines[place][i] < ALIGNED for i in axes):
            raise _Unfit(f"the axes of joint '{joint.name}' point in opposite directions")
        return kind

    def _slides(self, joint: JointModel) -> bool:
        """Return whether the lines of a joint fix x and y of b in the axes of a."""
        held = set()
        for line in joint.lines:
            c = self.model.coordinates[line.coordinates[0]]
            plain = len(line.coordinates) == 1 and line.factors[0] == 1.0 and line.offset == 0.0
            if plain and line.signal < 0 and c.kind == "along" and (c.a, c.b) == joint.sides[:2]:
                held.add(c.axis_a)
        return held == {0, 1} and len(joint.lines) == 2

    @cached_property
    def cosines(self) -> list[list[float]]:
        """Cosines between the axes x, y, z of sides 0 and 1 of each joint at the start."""
        m = self.model
        first = np.array([body.iq + 3 for body in m.bodies])
        A = rotation_matrix(np.real(m.q0)[first[:, None] + np.arange(4)])
        A = np.concatenate([A, np.eye(3)[None]])  # the index of the ground is -1
        sides = np.array([joint.sides[:2] for joint in m.joints], dtype=np.intp)
        markers = [m.markers[i] for i in sides.ravel()]
        local = np.real([marker.A0 for marker in markers])
        axes = (A[[marker.body for marker in markers]] @ local).reshape(-1, 2, 3, 3)
        found: list[list[float]] = (axes[:, 0] * axes[:, 1]).sum(axis=1).tolist()
        return found


def _smooth_pieces(data: Array, count: int, degree: int) -> bool:
    """Return whether polynomial pieces join continuously, with zero rate at both ends."""
    t, c = data[:count], data[count:].reshape(-1, degree + 1)
    width = np.diff(t)[:, None]
    powers = width ** np.arange(degree + 1)
    order = np.arange(degree + 1)
    end = (c * powers).sum(axis=1)
    terms = c[:, 1:] * order[1:] * powers[:, :-1]
    rate = terms.sum(axis=1)
    begin = c[:, 1] if degree else np.zeros(len(c))
    jumps = np.abs(end[:-1] - c[1:, 0])
    kinks = np.abs(np.concatenate([[begin[0]], begin[1:] - rate[:-1], [rate[-1]]]))
    sizes = float(np.abs(c[:, 0]).max()) or 1.0, float(np.abs(terms).max(initial=0.0)) or 1.0
    return bool(jumps.max(initial=0.0) <= JUMP * sizes[0] and kinks.max() <= JUMP * sizes[1])
