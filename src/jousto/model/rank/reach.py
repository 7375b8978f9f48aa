"""Loads on flexible bodies that their modes cannot represent, and how wrong stress is by it."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import warn
from jousto.base.rotations import rotation_matrix
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.forces.loads import Torque
from jousto.mechanism.forces.springs import ModalLoad
from jousto.mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from jousto.parts.part import Part
    from jousto.reduction.reach import Reach
    from jousto.reduction.reduced import ReducedPart

STRESS, EXAMINED = 0.1, 0.02  # error of stress that is told by compile, by doctor and check
LARGE = 5000  # degrees of freedom of a full model above which compile leaves that to doctor
SAG = 1e-5  # of the length of a body: mean sag under its weight that modes may leave out
REMEDY = (
    "give its reduction more modes, residuals=[the load] (inertia_relief=True for weight), or an "
    "interface where the load acts"
)


# what was asked of the modes of a part before: work of a load in the full part and in the modes
_ASKED: WeakKeyDictionary[Part, dict[Any, tuple[float, float] | None]] = WeakKeyDictionary()
MOST_ASKED = 1000


def warn_loads(mechanism: Mechanism) -> None:
    """Warn of loads that the modes of a body of a small part represent badly; for `compile`."""
    for where, sentence in unheld_loads(mechanism, STRESS, LARGE):
        warn(where, sentence)


def unheld_loads(
    mechanism: Mechanism, least_error: float = EXAMINED, largest: float = np.inf
) -> list[tuple[str, str]]:
    """Return what modes leave out of loads on their bodies: where, and a sentence with a remedy.

    Asked of what acts between the interfaces: load patterns, forces and torques at nodes that are
    no interface, and the weight of bodies with interfaces where it makes them sag. The modes find
    the best displacements that they can, so that the error of their stress in the energy norm is
    ``|s - s_r| / |s| = sqrt(1 - W_r / W)`` with the static work of the full model and theirs.
    Parts from files do not know their full model, which is solved here.

    Parameters
    ----------
    mechanism : Mechanism
    least_error : float
        Error of stress from which a load is told.
    largest : float
        Most degrees of freedom of a part that is asked.
    """
    found: list[tuple[str, str]] = []
    if not any(isinstance(body, FlexibleBody) for body in mechanism.bodies):
        return found
    from jousto.reduction.modes.rigid import length_scale
    from jousto.reduction.reach import Reach

    known: dict[int, Reach] = {}
    told: set[tuple[int, str]] = set()

    def look(
        body: FlexibleBody, where: str, place: str, pattern: Array, least: float = 0.0
    ) -> None:
        reduced = body.reduced
        if reduced.source is None or (id(reduced), place) in told:
            return
        if reduced.source.K.shape[0] > largest:
            return
        told.add((id(reduced), place))
        # loads of one shape do work with the square of their size
        size = float(np.abs(pattern).max(initial=0.0)) if pattern.shape == (3,) else 1.0
        pattern = pattern / size if size > 0.0 else pattern
        asked = _ASKED.setdefault(reduced.source, {})
        load = (_digest(reduced), pattern.shape, pattern.tobytes())
        if load not in asked:
            if id(reduced) not in known:
                known[id(reduced)] = Reach(reduced)
            reach = known[id(reduced)]
            work = reach.work(_on_part(reach, pattern))
            if len(asked) >= MOST_ASKED:
                asked.clear()
            asked[load] = None if work is None else (float(work[0].sum()), float(work[1].sum()))
        if (work_found := asked[load]) is None:
            return
        whole, held = work_found[0] * size**2, work_found[1] * size**2
        if whole - held > max(least_error**2 * whole, least):
            share = (whole - held) / whole
            sentence = (
                f"the {reduced.n} modes of body '{body.name}' leave out {_percent(share)} % of the "
                f"static work of {place}: it bends too little, and its stress is wrong by "
                f"{_percent(share**0.5)} % (energy norm); {REMEDY}"
            )
            found.append((where, sentence))

    for force in mechanism.forces:
        for body, place, pattern in _loads(force):
            look(body, f"{type(force).__name__} '{force.name}'", place, pattern)
    if not mechanism.gravity.any():
        return found
    for moving in mechanism.bodies:
        if isinstance(moving, FlexibleBody) and moving.reduced.interfaces:
            g = rotation_matrix(moving.orientation).T @ mechanism.gravity
            weight = moving.reduced.invariants.mass * float(np.linalg.norm(g))
            least = SAG * length_scale(moving.reduced.nodes) * weight
            look(moving, f"body '{moving.name}'", "its weight", g, least)
    return found


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g}" if share < 0.1 else f"{100.0 * share:.0f}"


def _loads(force: object) -> Iterator[tuple[FlexibleBody, str, Array]]:
    """Yield body, place and load: forces (nodes, 3), or [node, 0 or 3 if it is a moment].

    Of a point between nodes: these, and six loads on each of them for three unit loads, (k, 7, 3).
    """
    if isinstance(force, ModalLoad):
        yield force.body, f"pattern '{force.name}'", force.pattern
        return
    for name in ("marker", "a", "b"):
        marker = getattr(force, name, None)
        if not isinstance(marker, Marker) or not isinstance(marker.body, FlexibleBody):
            continue
        reduced, node = marker.body.reduced, marker.node
        first = 3 * isinstance(force, Torque)
        if marker.followed is not None:
            nodes, weights = marker.followed.nodes, marker.followed.weights
            number = np.broadcast_to(nodes[:, None, None], (len(nodes), 1, 3))
            unit = weights[first : first + 3].transpose(1, 2, 0)
            yield marker.body, f"a load at {marker.point}", np.concatenate([number, unit], axis=1)
            continue
        if node is None or any(node in reduced.node_sets[i] for i in reduced.interfaces):
            continue
        yield (
            marker.body,
            f"a load at node{node + 1}",
            np.array([node, first]),
        )


def _digest(reduced: ReducedPart) -> bytes:
    """Return what tells the modes of a part from others of the same part."""
    found = hashlib.blake2b(repr(reduced.interfaces).encode(), digest_size=20)
    for array in (reduced.frequencies, reduced.modes):
        found.update(np.ascontiguousarray(array).data)
    return found.digest()


def _on_part(reach: Reach, load: Array) -> Array:
    """Return loads (ndof, m): a pattern, weight (3,), or unit forces or moments on a node (2,)."""
    if load.ndim == 3:
        return reach.spread(load[:, 0, 0].astype(np.intp), load[:, 1:])
    if load.ndim == 2:
        return reach.nodal(load)[:, None]
    if len(load) == 3:
        return reach.weight(load)[:, None]
    return reach.unit(int(load[0]), int(load[1]))
