"""Checks of a beam body, and the geometry of its nodes and sections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array, read_only
from jousto.base.errors import InputError, Problems, suggest
from jousto.base.numbers import number
from jousto.base.rotations import (
    parse_direction,
)
from jousto.mechanism.beams.frames import section_frames, tangents
from jousto.mechanism.beams.stiffness import BeamSection, as_beam_section
from jousto.parts.frames.element import check_elements

SHARES = {"lumped": 0.0, "corrected": 0.0, "consistent": 1.0}
MOST_TWIST = 3.0  # rad, largest twist of an element
# largest offset of a mass centre, relative to the radius of gyration, that counts as on the axis
CENTRED = 1e-6
COARSE = 1.0  # rad, bend of an unstressed element above which the mesh is coarse
# ratio of the width of a section and the length of the beam above which a warning is given
WIDE = 5.0


def checked_nodes(problems: Problems, where: str, points: ArrayLike, elements: Any) -> Array | None:
    """Return the nodes (n + 1, 3), or report wrong ones."""
    given = problems.array(where, "points", points, (None, 3))
    whole = elements is None or check_elements(problems, where, elements)
    if given is None:
        return None
    if len(given) < 2:
        problems.add(where, f"points has {len(given)} point, must have two ends at least", "points")
        return None
    if not check_apart(problems, where, "points", given) or not whole:
        return None
    if len(given) > 2:
        if elements is not None and elements != len(given) - 1:
            problems.add(
                where,
                f"elements is {elements}, but {len(given)} points make {len(given) - 1} elements; "
                "leave elements out, or give the two ends of a straight beam",
                "elements",
            )
            return None
        return given
    if elements is None:
        problems.add(
            where,
            "elements is missing; give the number of elements between the two ends",
            "elements",
        )
        return None
    xi = np.linspace(0.0, 1.0, int(elements) + 1)[:, None]
    return read_only((1 - xi) * given[0] + xi * given[1])


def check_apart(problems: Problems, where: str, name: str, points: Array) -> bool:
    """Return whether neighbouring points differ, or report those that coincide."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    for i in np.flatnonzero(steps <= 1e-9 * max(extent, 1e-300)):
        problems.add(
            where, f"{name}[{i}] and {name}[{i + 1}] coincide; leave one out", name, int(i)
        )
        return False
    return True


def outlined(sections: tuple[BeamSection, ...]) -> list[BeamSection]:
    """Return the different sections whose outline is known, which are those of one material."""
    return [x for x in {id(x): x for x in sections}.values() if x.elasticity is not None]


def checked_sections(
    problems: Problems, where: str, section: Any, material: Any, nodes: Array | None
) -> tuple[BeamSection, ...]:
    """Return the section of every element, or report what is wrong."""
    several = isinstance(section, list | tuple)
    made: dict[int, BeamSection] = {}
    for item in section if several else (section,):
        try:
            if id(item) not in made:
                made[id(item)] = as_beam_section(item, material)
        except InputError as error:
            problems.found.extend(p.inside(where, named=True) for p in error.problems)
            return ()
    n = 0 if nodes is None else len(nodes) - 1
    if several:
        if nodes is not None and len(section) != n:
            problems.add(
                where,
                f"{len(section)} sections for {n} elements; give one section, or one per element",
                "section",
                named=False,
            )
        return tuple(made[id(item)] for item in section)
    return (made[id(section)],) * n


def inertia_share(problems: Problems, where: str, mass: Any) -> float:
    """Return the share of consistent inertia (0 to 1), or report a wrong one."""
    if isinstance(mass, str):
        if mass not in SHARES:
            problems.add(
                where,
                f"mass is {mass!r}{suggest(mass, SHARES)}, or a number from 0 (lumped) to 1",
                "mass",
            )
        return SHARES.get(mass, 0.0)
    share = number(problems, where, "mass", mass)
    if share is not None and not 0.0 <= share <= 1.0:
        problems.add(where, f"mass is {share:g}, must be from 0 (lumped) to 1 (consistent)", "mass")
    return share or 0.0


def along_nodes(
    problems: Problems, where: str, name: str, value: ArrayLike, n: int, one: tuple[int, ...]
) -> Array | None:
    """Return values (n + 1, ...) at all nodes, from one value or from one value per node."""
    try:
        shape = np.shape(value)
    except ValueError:
        shape = (-1,)
    if shape != one:
        return problems.array(where, name, value, (n + 1, *one))
    found = problems.array(where, name, value, one)
    if found is None:
        return None
    if not one:  # a single value is the value at the end, and the function is linear along the beam
        return read_only(np.linspace(0.0, float(found), n + 1))
    return read_only(np.tile(found, (n + 1, 1)))


def check_twist(problems: Problems, where: str, turns: Array) -> None:
    """Report an element twisted by more than MOST_TWIST: whole turns cannot be represented."""
    steps = np.abs(np.diff(turns))
    worst = int(np.argmax(steps))
    if steps[worst] < MOST_TWIST:
        return
    degrees = "; twist is in rad: were degrees meant?" if np.abs(turns).max() > 2 * np.pi else ""
    needed = int(np.ceil(len(steps) * steps[worst]))
    problems.add(
        where,
        f"twist turns element {worst} by {steps[worst]:.3g} rad, but the frames of its ends "
        f"represent less than half a turn; use {needed} elements, a radian each{degrees}",
        "twist",
    )


def check_share(problems: Problems, where: str, sections: Sequence[BeamSection]) -> None:
    """Report consistent inertia of sections whose mass centre is off the axis."""
    off = [i for i, s in enumerate(sections) if float(np.hypot(*s.center)) > CENTRED * _radius(s)]
    if off:
        y, z = sections[off[0]].center
        problems.add(
            where,
            f"the mass centre of element {off[0]} is {1e3 * y:.4g} mm, {1e3 * z:.4g} mm off the "
            f"axis, which consistent inertia does not allow; use 'corrected' or 'lumped', or put "
            f"the axis through the mass centre and use offset=",
            "mass",
            named=False,
        )


def _radius(section: BeamSection) -> float:
    """Return the smallest radius of gyration of a section, m."""
    return float(np.sqrt(np.linalg.eigvalsh(section.inertia)[0] / section.mass))


def inner_nodes(
    problems: Problems, where: str, name: str, value: Any, allowed: range
) -> tuple[int, ...]:
    """Return the numbers of inner nodes, or report those that do not exist."""
    items = tuple(value) if isinstance(value, Sequence | np.ndarray) else (value,)
    good = tuple(
        int(i) for i in items if isinstance(i, int | np.integer) and not isinstance(i, bool)
    )
    bad = [i for i in items if i not in good] + [i for i in good if i not in allowed]
    if bad:
        span = f"{allowed.start} to {allowed.stop - 1}" if len(allowed) else "none"
        problems.add(
            where, f"{bad[0]!r} is not an inner node; inner nodes are {span}", name, named=False
        )
    return good


def named_nodes(problems: Problems, where: str, markers: Any, n: int) -> dict[str, int]:
    """Return the named nodes, or report what is wrong."""
    if markers is None:
        return {}
    if not isinstance(markers, Mapping):
        problems.add(
            where, f"markers is {markers!r}, must be a mapping of names to nodes", "markers"
        )
        return {}
    named: dict[str, int] = {}
    for point, place in markers.items():
        if point in ("start", "end") or str(point).removeprefix("node").isdecimal():
            problems.add(
                where,
                f"marker {point!r}: a node has this name already; choose another one",
                "markers",
                point,
            )
        elif not isinstance(place, int | np.integer) or not 0 <= place <= n:
            problems.add(
                where, f"marker {point!r}: no node {place!r}; nodes are 0 to {n}", "markers", point
            )
        else:
            named[str(point)] = int(place)
    return named


def checked_up(problems: Problems, where: str, up: ArrayLike | None, nodes: Array) -> Array | None:
    """Return the direction (3,) or directions (n + 1, 3) near the z axes of the sections."""
    if up is None:
        chord = nodes[1] - nodes[0]
        across = float(np.linalg.norm(chord[:2]))
        return np.array(
            [1.0, 0.0, 0.0] if across <= 1e-6 * float(np.linalg.norm(chord)) else [0.0, 0.0, 1.0]
        )
    if np.ndim(up) == 2:
        return problems.array(where, "up", up, (len(nodes), 3))
    return parse_direction(problems, where, "up", up)


def placed_shape(
    problems: Problems,
    where: str,
    nodes: Array,
    up: Array,
    twist: Array,
    corners: tuple[int, ...],
    offsets: Array,
) -> tuple[Array, Array, Array]:
    """Return frames of nodes (n + 1, 3, 3), frames of ends (n, 2, 3, 3) and ends (n, 2, 3)."""
    along = tangents(nodes, corners)
    for i in np.flatnonzero(np.einsum("ij,ij->i", along[:-1, 1], along[1:, 0]) < -1 + 1e-9):
        problems.add(
            where,
            f"points[{i + 1}]: the beam reverses its direction there; leave the point out "
            f"or move it",
            "points",
            int(i + 1),
        )
        return nodes, along, along
    ends = section_frames(along, up, twist)
    if not np.all(np.isfinite(ends)):
        problems.add(
            where,
            "up is parallel to the beam, so that it defines no orientation of the sections; give a "
            "direction across it, up=(x, y, z)",
            "up",
        )
    frames = np.concatenate([ends[:, 0], ends[-1:, 1]])
    arm = np.concatenate([np.zeros((len(nodes), 1)), offsets], axis=1)
    at = nodes + np.einsum("nij,nj->ni", frames, arm)
    return frames, ends, np.stack([at[:-1], at[1:]], axis=1)
