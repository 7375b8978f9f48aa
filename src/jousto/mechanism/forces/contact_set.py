"""Contacts between many bodies, found at run time."""

from __future__ import annotations

from collections import Counter
from functools import cached_property, partial
from math import inf
from typing import Any, ClassVar

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import Problems, count, suggest
from jousto.base.fields import Choice, Flag, Items, field
from jousto.base.numbers import DefaultNumber, Number, OptionalWhole
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.contacts.collision import (
    DRILLING,
    ROLLING,
    Apart,
    CollisionShape,
    OptionalContactLaw,
    Surface,
    SurfacePair,
)
from jousto.mechanism.contacts.friction import default_static
from jousto.mechanism.contacts.laws import TABLE, ContactLaw
from jousto.mechanism.contacts.meetings import Meetings, check_kinds, meetings
from jousto.mechanism.contacts.pair_tables import (
    LAW_ROW,
    PairLaw,
    coupled_bodies,
    excluded_keys,
    group_table,
    joined_bodies,
    law_row,
    polytope_numbers,
    shape_rows,
    touching_table,
)
from jousto.mechanism.contacts.pairing import POINTS
from jousto.mechanism.forces.base import ForceElement, Packed, Push
from jousto.mechanism.forces.contact import (
    RESOLVE,
    RESOLVES,
    SHEAR,
    STATES,
    TURN,
    check_restitution,
    judged_from,
    point_states,
    refuse_turn,
)
from jousto.mechanism.forces.friction import SMOOTH, SmoothField
from jousto.mechanism.forces.law import EngineLaw

SLOT = {"touched": "1", "tip": "1"}
"""Shape that is touched + 1, tip or other shape + 1, both 0 if the slot is free; then the states
of a contact."""
LEAST_SLOTS = 16
"""Smallest number of slots where `most` is not given."""
SLOTS_EACH = 2
"""Slots for each tip of a shape where `most` is not given."""
IMPLICIT = 150
"""Largest number of bodies that touch one another with an implicit method."""
LISTED = 12
"""Largest number of excluded pairs that `facts` lists."""
SHOWN = 3
"""Largest number of names in a message."""

EngineLaw(
    "contact set",
    constants=("shapes", "tips", "surfaces", "groups", "excluded", "slots", "pairs", "resolve"),
    between=True,
    fast={"contacts": ()},
).declared()
EngineLaw(
    "contact slot",
    constants=("set", "number"),
    states=SLOT | point_states(POINTS) | TURN,
    between=True,
    fast={"contacts": ()},
    yields=True,
).declared()


class Contacts(ForceElement, tag="contacts"):
    """Shapes on any bodies touch one another wherever they meet, with the law of `Contact`.

    Which pairs touch is found during the run; the work grows with the number of shapes, not with
    its square. Shapes of one body never touch, nor do those of bodies with a joint between them
    unless ``joined`` is set; the ground, and what is fixed to it, touches every body. `Apart`
    excludes further pairs.

    A pair that comes near takes one of ``most`` slots; if all are in use, the run ends with an
    error. Whether shapes may have touched within a step is decided by their largest possible
    motion, not by where they are at its ends, so that no body flies through another one.

    Two surfaces touch by the law of Hertz, see `Surface`; shapes without a surface by ``law``.
    ``laws`` shows what each pair became. Edges and corners have the stiffness of the largest
    sphere in their shape. Resistance to rolling and drilling acts where a sphere or the tip of a
    shape touches; faces resist by the forces at their corners.

    Examples
    --------
    >>> from jousto import RigidBody, ground
    >>> from jousto.mechanism import CollisionShape, Contacts, HalfSpace, PowerLaw, Sphere
    >>> floor = CollisionShape("floor", ground["origin"], HalfSpace())
    >>> balls = [
    ...     RigidBody.sphere(f"ball{i}", radius=0.1, mass=1.0, position=(0, 0, 0.3 * i + 0.2))
    ...     for i in range(3)
    ... ]
    >>> shapes = [CollisionShape(ball.name, ball["origin"], Sphere(0.1)) for ball in balls]
    >>> Contacts("contacts", [floor, *shapes], law=PowerLaw(1e7, restitution=0.7))
    <contacts 'contacts': 4 shapes>
    """

    kind = "contacts"
    unmeasured: ClassVar[str] = (
        "has many forces; take a ContactForceSensor of two of its shapes or groups, or a "
        "BodyLoadSensor of the applied forces on a body"
    )
    shapes: Items[CollisionShape] = field("Shapes that touch one another")
    law: OptionalContactLaw = field(
        "Law of the normal force where a shape has no surface", default=None, kw_only=True
    )
    mu_kinetic: Number = field(
        "Coefficient of friction while it slips, where a shape has no surface",
        unit="1",
        least=0,
        default=0.0,
        kw_only=True,
    )
    mu_static: DefaultNumber = field(
        "Coefficient of friction up to which it sticks, where a shape has no surface; None: "
        "mu_kinetic",
        unit="1",
        least=0,
        default=None,
        kw_only=True,
    )
    pairs: Items[SurfacePair] = field(
        "Laws and friction of pairs of surfaces", default=(), kw_only=True
    )
    apart: Items[Apart] = field(
        "Pairs of shapes or groups that never touch", default=(), kw_only=True
    )
    joined: Flag = field(
        "Whether bodies with a joint between them touch", default=False, kw_only=True
    )
    overlap: Choice = field(
        "What to do if shapes overlap at the start: refuse them, start as they are, or move their "
        "bodies apart by the least displacement",
        words=("refuse", "start", "apart"),
        default="refuse",
        kw_only=True,
    )
    most: OptionalWhole = field(
        "Largest number of pairs that are near at a time; None: 2 for each sphere or corner, 16 "
        "at least",
        least=1,
        default=None,
        kw_only=True,
    )
    shear: Number = field(
        "Stiffness of the bristle of friction over that of the normal force, 2 (1 - nu) / (2 - nu)",
        unit="1",
        above=0,
        default=SHEAR,
        kw_only=True,
    )

    friction: SmoothField = field(SMOOTH, default=None, kw_only=True)
    rolling: Number = field(
        f"{ROLLING}; where a shape has no surface", unit="m", least=0, default=0.0, kw_only=True
    )
    drilling: Number = field(
        f"{DRILLING}; where a shape has no surface", unit="m", least=0, default=0.0, kw_only=True
    )
    resolve: Choice = field(RESOLVES, words=RESOLVE, default="cut", kw_only=True)

    def __post_init__(self) -> None:
        default_static(self)
        super().__post_init__()

    def __repr__(self) -> str:
        return f"<contacts {self.name!r}: {count(len(self.shapes), 'shape')}>"

    # -- checks ------------------------------------------------------------------------------

    def consistent(self, problems: Problems, where: str) -> None:
        """Report names that are unknown or used twice, and pairs without a law."""
        if len(self.shapes) < 2:
            problems.add(where, "needs two shapes at least", "shapes")
            return
        self._check_names(problems, where)
        if problems.found:
            return
        self._check_laws(problems, where)
        check_kinds(problems, where, self.shapes, self.apart)

    def _check_names(self, problems: Problems, where: str) -> None:
        seen: set[str] = set()
        for one in self.shapes:
            if one.name in seen:
                problems.add(where, f"two shapes have the name {one.name!r}", "shapes")
            seen.add(one.name)
        surfaces: dict[str, Surface] = {}
        for surface in self._given_surfaces:
            if surfaces.setdefault(surface.name, surface) != surface:
                problems.add(
                    where, f"two different surfaces have the name {surface.name!r}", "shapes"
                )
        for pair in self.pairs:
            for name in (pair.a, pair.b):
                if name not in surfaces:
                    problems.add(where, f"no surface {name!r}{suggest(name, surfaces)}", "pairs")
        known = dict.fromkeys([*self.groups, *seen])
        for excluded in self.apart:
            for name in (excluded.a, excluded.b):
                if name not in known:
                    problems.add(
                        where, f"no shape or group {name!r}{suggest(name, known)}", "apart"
                    )

    def _check_laws(self, problems: Problems, where: str) -> None:
        law: Any = self.law
        bare = [one.name for one in self.shapes if one.surface is None or one.surface.E is None]
        if bare and law is None:
            problems.add(
                where,
                f"{_some(bare)} without a surface with E; give each one, or the set a law",
                "law",
            )
        for (a, b), pair in self.laws.items() if not problems.found else ():
            if pair.law.curve == TABLE:
                problems.add(
                    where,
                    "a set of contacts has no TableLaw; give a PowerLaw, or a Contact for each "
                    "pair",
                    "law",
                )
            if self.resolve == "impulse":
                check_restitution(problems, where, pair.law)
                for word, length in zip(("rolling", "drilling"), pair.lengths, strict=True):
                    if length:
                        refuse_turn(problems, where, word)
            kinetic, static = pair.friction
            if static < kinetic:
                named = f"{a or 'no surface'} and {b or 'no surface'}"
                problems.add(
                    where, f"{named}: mu_static {static:g} is below mu_kinetic {kinetic:g}"
                )

    # -- tables ------------------------------------------------------------------------------

    @property
    def _given_surfaces(self) -> list[Surface]:
        return [one.surface for one in self.shapes if one.surface is not None]

    @cached_property
    def groups(self) -> dict[str, int]:
        """Groups of the shapes by name, numbered."""
        names = dict.fromkeys(one.group for one in self.shapes)
        return {name: i for i, name in enumerate(names)}

    @cached_property
    def surfaces(self) -> dict[str, Surface | None]:
        """Surfaces of the shapes by name; None under "" for shapes without one."""
        found: dict[str, Surface | None] = {}
        for one in self.shapes:
            found.setdefault("" if one.surface is None else one.surface.name, one.surface)
        return found

    @cached_property
    def laws(self) -> dict[tuple[str, str], PairLaw]:
        """Law of each pair of surfaces by their names; "" stands for shapes without a surface."""
        names = list(self.surfaces)
        return {(a, b): self._law_between(a, b) for i, a in enumerate(names) for b in names[i:]}

    def _law_between(self, a: str, b: str) -> PairLaw:
        one, other = self.surfaces[a], self.surfaces[b]
        if one is None or other is None:
            usual = (self.rolling, self.drilling)
            return PairLaw(self.law, (self.mu_kinetic, self.mu_static), usual)
        law: ContactLaw = one.law_with(other) or self.law
        friction, lengths = one.friction_with(other), one.lengths_with(other)
        for pair in self.pairs:
            if pair.applies(a, b):
                law, friction = pair.law_or(law), pair.friction_or(friction)
                lengths = pair.lengths_or(lengths)
        return PairLaw(law, friction, lengths)

    @cached_property
    def _meetings(self) -> Meetings:
        return meetings([one.shape for one in self.shapes])

    @property
    def slots(self) -> int:
        """Largest number of spheres, corners and ends that are near a shape at a time."""
        tips, others = self._meetings.tips, len(self.shapes) - 1
        return self._most(SLOTS_EACH * tips, tips * others)

    @property
    def convex(self) -> int:
        """Largest number of pairs of polytopes that are near at a time."""
        n = sum(self._meetings.convex)
        return self._most(self._meetings.near, n * (n - 1) // 2)

    def _most(self, usual: int, all_of_them: int) -> int:
        if usual and self.most is not None:
            return self.most
        return min(all_of_them, max(LEAST_SLOTS, usual))

    @property
    def facts(self) -> list[tuple[str, str]]:
        """Lines on who can touch whom, by groups, and on the law of each pair of surfaces."""
        shapes = count(len(self.shapes), "shape")
        joints = "touch too" if self.joined else "do not touch"
        rows = [
            (
                f"contacts {self.name}",
                f"{shapes}, up to {self.slots + self.convex} pairs at a time; bodies with a joint "
                f"{joints}",
            )
        ]
        sizes = Counter(one.group for one in self.shapes)
        meets, names = group_table(self.groups, self.apart), list(self.groups)
        for i, name in enumerate(names):
            others = [other for j, other in enumerate(names) if meets[i, j]]
            text = ", ".join(f"{other} ({sizes[other]})" for other in others) or "nothing"
            rows.append((f"group {name} ({sizes[name]}) touches", text))
        single = [one for one in self.apart if not {one.a, one.b} <= self.groups.keys()]
        if single:
            shown = ", ".join(f"{one.a} - {one.b}" for one in single[:LISTED])
            rows.append(("never touch", shown + (", ..." if len(single) > LISTED else "")))
        for (a, b), pair in self.laws.items():
            rows.append((f"{a or 'no surface'} on {b or 'no surface'}", str(pair)))
        return rows

    @property
    def markers(self) -> tuple[Marker, ...]:
        """Markers of the shapes."""
        return tuple(one.marker for one in self.shapes)

    @property
    def turning(self) -> tuple[tuple[str, Marker], ...]:
        """Markers whose orientation matters, each with the name of the shape."""
        return tuple((one.name, one.marker) for one in self.shapes)

    @property
    def drawn_at(self) -> tuple[Marker, ...]:
        """Markers of the shapes."""
        return self.markers

    @property
    def touching_shapes(self) -> tuple[tuple[Marker, Any], ...]:
        """All shapes."""
        return tuple((one.marker, one.shape) for one in self.shapes)

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The set, and its slots."""
        numbers = partial(_slot_numbers, self)
        turn = TURN if any(any(pair.lengths) for pair in self.laws.values()) else {}
        slot = Push("contact slot", {}, states=tuple(SLOT | STATES | turn), numbers=numbers)
        states = tuple(SLOT | point_states(self._meetings.points))
        pair = Push("contact slot", {}, states=states, numbers=numbers)
        whole = Push("contact set", {}, numbers=self._numbers)
        return (whole, *[slot] * self.slots, *[pair] * self.convex)

    def _numbers(self, builder: Any) -> Packed:
        """Return the numbers of the set: sizes, then its tables as in the engine."""
        places = [builder.marker(marker, True) for marker in self.markers]
        body_of = [builder.markers[place].body for place in places]
        names = list(self.surfaces)
        index = {name: i for i, name in enumerate(names)}
        kinds = [index["" if x.surface is None else x.surface.name] for x in self.shapes]
        shapes = [one.shape for one in self.shapes]
        polytopes, starts = polytope_numbers(shapes, self._meetings.convex)
        groups = [self.groups[one.group] for one in self.shapes]
        rows, tips = shape_rows(self.shapes, places, starts, kinds, groups)
        laws = np.zeros((len(names), len(names), LAW_ROW))
        velocity = 0.0 if self.friction is None else self.friction.velocity
        for (a, b), pair in self.laws.items():
            numbers = law_row(pair, self.shear, velocity, strikes=self.resolve == "impulse")
            laws[index[a], index[b]] = laws[index[b], index[a]] = numbers
        meets = group_table(self.groups, self.apart)
        joined = [] if self.joined else joined_bodies(builder.joined_bodies())
        apart = excluded_keys(self.shapes, self.groups, self.apart, joined, body_of)
        sizes = (len(rows), len(tips), len(names), len(meets), len(apart), self.slots, self.convex)
        how = RESOLVE.index(self.resolve)
        touching = touching_table(shapes)
        parts: list[Array] = [
            np.array((*sizes, how), dtype=float),
            rows,
            tips,
            laws,
            touching,
            meets,
            apart,
            polytopes,
        ]
        coupled = coupled_bodies(rows, meets, body_of)
        return Packed(
            np.concatenate([np.ravel(part) for part in parts]),
            touches=tuple(places),
            coupled=tuple(tuple(sorted(some)) for some in coupled if len(some) <= IMPLICIT),
            dense=max((len(some) for some in coupled if len(some) > IMPLICIT), default=0),
            slots=self.slots + self.convex,
            shapes=tuple(one.name for one in self.shapes),
            sizes=tuple(x if x < inf else 0.0 for x in (one.size for one in self.shapes)),
            surfaces=tuple(kinds),
            restitution=tuple(
                tuple(self._law_between(a, b).law.asked for b in names) for a in names
            ),
            slowest=tuple(
                tuple(judged_from(self._law_between(a, b).law, self.resolve) for b in names)
                for a in names
            ),
        )


def _slot_numbers(contacts: Contacts, builder: Any) -> Packed:
    """Return the numbers of a slot: the forces of its set and of itself."""
    place = builder.force_places[id(contacts)]
    return Packed(np.array([place, len(builder.forces)], dtype=float))


def _some(names: list[str]) -> str:
    """Return the first of several names of shapes, and how many there are."""
    shown = ", ".join(repr(name) for name in names[:SHOWN])
    more = len(names) - SHOWN
    return f"{shown} and {count(more, 'other shape')} are" if more > 0 else f"{shown}: shapes"
