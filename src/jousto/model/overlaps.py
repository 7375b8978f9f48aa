"""Shapes that overlap at the start: depth, energy that the law holds there, and speed it gives."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf, sqrt

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, count, warn
from jousto.base.rounding import STANDARD_GRAVITY
from jousto.mechanism.forces.contact_set import Contacts
from jousto.mechanism.mechanism import Mechanism
from jousto.model.contact_points import ContactPoint, contact_sources, points_of
from jousto.model.model import BodyModel, Model
from jousto.model.native.native import Engine

TOUCHING = 1e-6
"""Depth over the size of the smaller shape up to which shapes only touch."""
DEEP = 0.05
"""Depth over the size of the smaller shape above which the law is too soft, or the start wrong."""
TOO_DEEP = 1.0 / 3.0
"""Depth over the size of the smaller shape above which no run starts, unless it is at rest."""
THROWN = 0.5
"""Acceleration of the bodies apart over that by the contact alone, above which they are thrown."""
CANCELLED = 1e-3
"""Sum of the forces of a pair over that of their sizes, below which they cancel each other."""
SHOWN = 5
"""Largest number of pairs that a message lists."""
Key = tuple[str, str, str]
"""Contact, and the bodies or shapes a and b of a pair."""


@dataclass(frozen=True)
class Overlap:
    """Two shapes that overlap at the start.

    Attributes
    ----------
    contact : str
        Name of the contact or of the set.
    first, second : str
        Bodies of a contact, or shapes of a set.
    depth, size : float
        Depth of the overlap, and size of the smaller shape, m; infinite if it is not known.
    energy : float
        Energy that the law holds at this depth, J.
    speed, height : float
        Largest speed, m/s, that it gives the lighter body, and the height to which that rises, m.
    balanced : bool
        Whether other forces hold the bodies against the contact, as at rest.
    """

    contact: str
    first: str
    second: str
    depth: float
    size: float
    energy: float
    speed: float
    height: float
    balanced: bool

    def __str__(self) -> str:
        return f"{self.first!r} and {self.second!r} by {self.depth:.3g} m"

    @property
    def share(self) -> float:
        """Depth over the size of the smaller shape."""
        return self.depth / self.size

    @property
    def thrown(self) -> bool:
        """Whether the start throws the bodies: deep or high beside their size, and not at rest."""
        far = self.share > DEEP or self.height > self.size
        return far and not self.balanced

    @property
    def text(self) -> str:
        """Depth, energy, and what that does."""
        part = f" ({100 * self.share:.2g} % of the smaller shape)" if self.share else ""
        energy = f", where the law holds {self.energy:.3g} J"
        if not self.balanced and self.speed:
            energy += f": up to {self.speed:.3g} m/s, {self.height:.3g} m high"
        return f"{self.depth:.3g} m{part}{energy}"


def overlaps(model: Model) -> list[Overlap]:
    """Return the shapes that overlap at the start of a model, the deepest first."""
    if not model.touches:
        return []
    engine = Engine(model, implicit=False)
    found = _by_pair(points_of(engine))
    if not found:
        return []
    about = _pairs(model, found)
    made = [
        _overlap(model, engine, points, *about[key])
        for key, points in found.items()
        if _depth(points) > TOUCHING * min(about[key][1], model.size)
    ]
    return sorted(made, key=lambda one: -one.depth)


def _by_pair(points: Iterable[ContactPoint]) -> dict[Key, list[ContactPoint]]:
    """Return the points of each pair of contact, a and b."""
    found: dict[Key, list[ContactPoint]] = {}
    for point in points:
        found.setdefault((point.contact, point.a, point.b), []).append(point)
    return found


def _depth(points: list[ContactPoint]) -> float:
    """Return the largest depth of some points, m."""
    return max(-one.gap for one in points)


def _pairs(model: Model, keys: Iterable[Key]) -> dict[Key, tuple[tuple[str, str], float]]:
    """Return bodies, and the size of the smaller shape, m, of the pairs of contact, a and b."""
    sources = contact_sources(model)
    found = {
        (name, a, b): ((a, b), size or inf) for _, name, _, a, b, size, *_ in sources["contacts"]
    }
    sets = {
        name: dict(zip(shapes, zip(bodies, sizes, strict=True), strict=True))
        for _, _, name, shapes, bodies, sizes, *_ in sources["sets"]
    }
    for name, a, b in keys:
        if name in sets:
            (first, one), (second, other) = sets[name][a], sets[name][b]
            found[name, a, b] = (first, second), min(one or inf, other or inf)
    return found


def _overlap(
    model: Model,
    engine: Engine,
    points: list[ContactPoint],
    bodies: tuple[str, str],
    size: float,
) -> Overlap:
    """Return the overlap of two bodies at some points."""
    named = {body.name: body for body in model.bodies}
    some = [named.get(name) for name in bodies]
    inverse = [0.0 if one is None else 1.0 / float(np.real(one.mass[0])) for one in some]
    energy = sum(one.stored for one in points)
    # free bodies of inverse masses w part with sqrt(2 E sum(w)), the lighter one has its share
    speed = max(inverse) * sqrt(2.0 * energy / sum(inverse)) if sum(inverse) else 0.0
    g = float(np.linalg.norm(np.real(model.gravity))) or STANDARD_GRAVITY
    first = points[0]
    push = np.sum([one.force * one.normal for one in points], axis=0)
    total = float(np.linalg.norm(push))
    # forces that cancel each other, as of shapes in one place, are no rest
    balanced = total > CANCELLED * sum(one.force for one in points) and not (
        _acceleration(engine, some, push / total) > THROWN * sum(inverse) * total
    )
    return Overlap(
        *(first.contact, first.a, first.b),
        depth=_depth(points),
        size=size,
        energy=energy,
        speed=speed,
        height=speed**2 / (2.0 * g),
        balanced=balanced,
    )


def _acceleration(engine: Engine, bodies: list[BodyModel | None], normal: Array) -> float:
    """Return the acceleration of the second body along a normal less that of the first one, m/s2.

    Infinite where the joints do not determine it.
    """
    try:
        a = np.real(engine.accelerations()[0])
    except InputError:
        return inf
    along = [0.0 if one is None else float(a[one.iv : one.iv + 3] @ normal) for one in bodies]
    return along[1] - along[0]


def refuse_overlaps(mechanism: Mechanism, model: Model) -> None:
    """Raise InputError with the shapes that overlap at the start of sets that refuse this.

    Warn of other shapes that overlap so deep that the start throws them.
    """
    found = overlaps(model)
    strict = [
        force.name
        for force in mechanism.forces
        if isinstance(force, Contacts) and force.overlap != "start"
    ]
    problems = Problems()
    for name in strict:
        mine = [one for one in found if one.contact == name]
        if not mine:
            continue
        listed = ", ".join(map(str, mine[:SHOWN])) + (", ..." if len(mine) > SHOWN else "")
        problems.add(
            f"contacts {name!r}",
            f"{count(len(mine), 'pair')} of shapes overlap at the start: {listed}; move the bodies "
            'apart, or overlap="apart" does, exclude the pairs with Apart, or start as they are, '
            'overlap="start"',
            "overlap",
        )
    problems.raise_if_any()
    thrown = [one for one in found if one.thrown]
    if thrown:
        worst = max(thrown, key=lambda one: one.energy)
        more = f"; so do {count(len(thrown) - 1, 'other pair')}" if len(thrown) > 1 else ""
        warn(
            f"contact {worst.contact!r}",
            f"{worst.first!r} and {worst.second!r} overlap at the start by {worst.text}{more}; "
            "move the bodies apart, or start from jo.equilibrium",
        )


def refuse_deep(engine: Engine) -> None:
    """Raise InputError if a run would start with shapes too deep in each other, and not at rest."""
    if not engine.model.touches:
        return
    found = _by_pair(points_of(engine))
    about = _pairs(engine.model, found) if found else {}
    deep = [key for key in found if _depth(found[key]) > TOO_DEEP * about[key][1]]
    made = [_overlap(engine.model, engine, found[key], *about[key]) for key in deep]
    thrown = sorted((one for one in made if one.thrown), key=lambda one: -one.share)
    if not thrown:
        return
    shown = "; ".join(f"{one.first!r} and {one.second!r} by {one.text}" for one in thrown[:SHOWN])
    more = "; ..." if len(thrown) > SHOWN else ""
    raise InputError(
        Problem(
            f"contact {thrown[0].contact!r}",
            "shapes overlap at the start by more than a third of their size, where force and "
            f"normal mean nothing: {shown}{more}; move the bodies apart, or exclude the pair",
        )
    )


def overlap_facts(mechanism: Mechanism, model: Model) -> list[tuple[str, str]]:
    """Return a line on the shapes that overlap at the start for each set of contacts."""
    found = overlaps(model)
    rows = []
    for force in mechanism.forces:
        if isinstance(force, Contacts):
            mine = [one for one in found if one.contact == force.name]
            listed = ", ".join(map(str, mine[:SHOWN])) + (", ..." if len(mine) > SHOWN else "")
            rows.append((f"overlaps of {force.name}", listed or "none"))
    return rows


def apart_sets(mechanism: Mechanism) -> set[str]:
    """Return the names of the sets of contacts that move bodies apart."""
    return {
        force.name
        for force in mechanism.forces
        if isinstance(force, Contacts) and force.overlap == "apart"
    }
