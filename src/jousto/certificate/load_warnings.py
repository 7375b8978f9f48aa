"""Warnings about loads that the modes of flexible bodies do not represent, with stress errors."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import warn
from jousto.model.mode_loads import ModeLoad
from jousto.model.model import Model

if TYPE_CHECKING:
    from jousto.certificate.load_coverage import Reach
    from jousto.parts.part import Part
    from jousto.reduction.reduced import ReducedPart

RUN_ERROR, EXAMINED_ERROR = 0.1, 0.02
"""Stress errors above which a run or an equilibrium warns, and doctor and `jousto check`."""
RUN_SIZE = 5000
"""Number of degrees of freedom above which only doctor solves a part, not a run."""
# smallest mean sag under its own weight that the modes do not contain / length of the body
SAG = 1e-5
REMEDY = (
    "give its reduction more modes, residuals=[the load] (inertia_relief=True for weight), or an "
    "interface where the load acts"
)

# hash of a reduction, which each run of a model needs
_DIGESTS: WeakKeyDictionary[ReducedPart, bytes] = WeakKeyDictionary()
# static work of unit loads in a part and in its modes, by a hash of modes and load
_WORK: WeakKeyDictionary[Part, dict[Any, tuple[float, float] | None]] = WeakKeyDictionary()
MOST_KEPT = 1000


def warn_loads(model: Model) -> None:
    """Warn about loads that the modes of small parts represent badly."""
    for where, sentence in unheld_loads(model, RUN_ERROR, RUN_SIZE):
        warn(where, sentence)


def unheld_loads(
    model: Model, least_error: float = EXAMINED_ERROR, largest: float = np.inf
) -> list[tuple[str, str]]:
    """Return loads outside of the modes: place, and a message with a remedy.

    The check covers loads between the interfaces: load patterns, forces and torques at nodes that
    are no interface, and the weight of bodies with interfaces. The modes approximate the
    displacement as well as they can, so that the error of the stress in the energy norm is ``|s -
    s_r| / |s| = sqrt(1 - W_r / W)``, with the static work W of the full model and W_r of the modes.
    Parts from files are not checked, since they contain no full model.

    Parameters
    ----------
    model : Model
        Result of `compile`; a copy from another process has no such loads.
    least_error : float
        Smallest stress error of the returned loads.
    largest : float
        Largest number of degrees of freedom of a part that is solved.
    """
    if not model.mode_loads:
        return []
    from jousto.reduction.modes.rigid import length_scale

    found: list[tuple[str, str]] = []
    solved: dict[int, Reach] = {}
    judged: set[tuple[int, str]] = set()
    for load in model.mode_loads:
        reduced, key = load.reduced, (id(load.reduced), load.place)
        assert reduced.source is not None
        if key in judged or reduced.source.K.shape[0] > largest:
            continue
        judged.add(key)
        if (work := _work(load, solved)) is None:
            continue
        full, kept = work
        sagging = SAG * length_scale(reduced.nodes) * load.weight
        if full - kept > max(least_error**2 * full, sagging):
            share = (full - kept) / full
            sentence = (
                f"the {reduced.n} modes of body '{load.body}' leave out {_percent(share)} % of the "
                f"static work of {load.place}: its deformation is too small, and the error of its "
                f"stress is "
                f"{_percent(share**0.5)} % (energy norm); {REMEDY}"
            )
            found.append((load.where, sentence))
    return found


def _work(load: ModeLoad, solved: dict[int, Reach]) -> tuple[float, float] | None:
    """Return the static work of a load in the full part and in the modes, J, None if unknown.

    Work is quadratic in a load, so that weights in one direction share a solution.
    """
    from jousto.certificate.load_coverage import Reach

    reduced, pattern = load.reduced, load.pattern
    assert reduced.source is not None
    size = float(np.abs(pattern).max(initial=0.0)) if load.weight else 1.0
    pattern = pattern / size if size > 0.0 else pattern
    kept = _WORK.setdefault(reduced.source, {})
    key = (_digest(reduced), pattern.shape, pattern.tobytes())
    if key not in kept:
        if id(reduced) not in solved:
            solved[id(reduced)] = Reach(reduced)
        reach = solved[id(reduced)]
        work = reach.work(_on_part(reach, pattern))
        if len(kept) >= MOST_KEPT:
            kept.clear()
        kept[key] = None if work is None else (float(work[0].sum()), float(work[1].sum()))
    unit = kept[key]
    return None if unit is None else (unit[0] * size**2, unit[1] * size**2)


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g}" if share < 0.1 else f"{100.0 * share:.0f}"


def _digest(reduced: ReducedPart) -> bytes:
    """Return a hash that differs between reductions of one part."""
    if reduced not in _DIGESTS:
        found = hashlib.blake2b(repr(reduced.interfaces).encode(), digest_size=20)
        for array in (reduced.frequencies, reduced.modes):
            found.update(np.ascontiguousarray(array).data)
        _DIGESTS[reduced] = found.digest()
    return _DIGESTS[reduced]


def _on_part(reach: Reach, load: Array) -> Array:
    """Return a `ModeLoad.pattern` as loads (ndof, m) on the degrees of freedom of the part."""
    if load.ndim == 3:
        return reach.spread(load[:, 0, 0].astype(np.intp), load[:, 1:])
    if load.ndim == 2:
        return reach.nodal(load)[:, None]
    if len(load) == 3:
        return reach.weight(load)[:, None]
    return reach.unit(int(load[0]), int(load[1]))
