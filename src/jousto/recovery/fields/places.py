"""Places of a stress field by label, set or node, and what its data cannot be."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from jousto.base.arrays import Array, Index
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.reduction.fields.stress import StressModes

Sites = str | int | Iterable[Any] | slice | None
ROTATION = 1e-6
"""What ``A^T A`` of a rotation may differ from I by."""


def refuse_no_rotations(problems: Problems, where: str, A: Array, time: Array) -> None:
    """Add a problem if a matrix of A (nt, 3, 3) is not a rotation, ``A^T A = I``, ``det A = 1``."""
    away = np.abs(np.swapaxes(A, 1, 2) @ A - np.eye(3)).max(axis=(1, 2), initial=0.0)
    mirrored = np.linalg.det(A) < 0.0
    bad = np.flatnonzero((away > ROTATION) | mirrored)
    if len(bad):
        k = int(bad[0])
        found = (
            "A^T A differs from I by " + f"{away[k]:.3g}" if away[k] > ROTATION else "it mirrors"
        )
        problems.add(
            where,
            f"A is no rotation at {time[k]:g} s, instant {k}: {found}; {len(bad)} of {len(A)} are "
            "none; give orthonormal matrices from body to world with determinant 1",
        )


def refuse_gaps(where: str, p: Array, time: Array) -> None:
    """Raise InputError if coordinates are not numbers, with the first such instant."""
    bad = ~np.isfinite(p).all(axis=1) if np.ndim(p) == 2 else np.zeros(0, dtype=bool)
    if not bad.any() or np.shape(time) != bad.shape:
        return
    k = int(np.argmax(bad))
    mode = int(np.argmax(~np.isfinite(p[k])))
    raise InputError(
        Problem(
            where,
            f"coordinate {mode + 1} is {p[k, mode]} at {time[k]:g} s, instant {k}, the first of "
            f"{int(bad.sum())} without numbers; end the field before it, end=, or fill the gap",
        )
    )


def site_indices(
    modes: StressModes, sites: Sites, where: str, known: dict[str, int] | None = None
) -> Index:
    """Return the places (k,) of stress modes by index; see `StressField.indices`.

    Raises
    ------
    InputError
        If there is no such place; all that are missing are named.
    """
    ns = len(modes.labels)
    if sites is None:
        return np.arange(ns)
    if isinstance(sites, slice):
        return np.arange(ns)[sites]
    problems = Problems()
    items: list[Any]
    if isinstance(sites, str | int | np.integer):
        items = [sites]
    else:
        items = sites.tolist() if isinstance(sites, np.ndarray) else list(sites)
        if items and all(isinstance(item, bool | np.bool_) for item in items):
            if len(items) != ns:
                message = f"a boolean choice of sites has {len(items)} entries, there are {ns}"
                raise InputError(Problem(where, message))
            return np.flatnonzero(items)
    labels = known or {label: i for i, label in enumerate(modes.labels)}
    found: list[int] = []
    for item in items:
        if isinstance(item, str):
            if item in labels:
                found.append(labels[item])
            elif item in modes.sets:
                found.extend(modes.sets[item].tolist())
            else:
                names = [*labels, *modes.sets]
                problems.add(where, f"no stress site or set '{item}'{suggest(item, names)}")
        elif isinstance(item, int | np.integer) and not isinstance(item, bool):
            at = () if modes.nodes is None else np.flatnonzero(modes.nodes == item).tolist()
            if not len(at):
                problems.add(where, f"no stress is known at node {item} (nodes count from 0)")
            found.extend(at)
        else:
            problems.add(where, f"site {item!r} is neither a label, a set nor a node number")
    if not items:
        problems.add(where, "sites is empty; None takes all of them")
    problems.raise_if_any()
    return np.array(list(dict.fromkeys(found)), dtype=np.intp)
