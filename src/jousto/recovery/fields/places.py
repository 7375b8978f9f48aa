"""Sites of a stress field by label, set or node, and checks of its data."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from jousto.base.arrays import Array, Index
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.reduction.fields.stress import StressModes

Sites = str | int | Iterable[Any] | slice | None
ROTATION = 1e-6
"""Largest deviation of ``A^T A`` of a rotation matrix from I."""


def refuse_no_rotations(problems: Problems, where: str, A: Array, time: Array) -> None:
    """Add a problem if a matrix of A (nt, 3, 3) is not a rotation, ``A^T A = I``, ``det A = 1``."""
    away = np.abs(np.swapaxes(A, 1, 2) @ A - np.eye(3)).max(axis=(1, 2), initial=0.0)
    mirrored = np.linalg.det(A) < 0.0
    bad = np.flatnonzero((away > ROTATION) | mirrored)
    if len(bad):
        k = int(bad[0])
        found = (
            "A^T A differs from I by " + f"{away[k]:.3g}" if away[k] > ROTATION else "det A is -1"
        )
        problems.add(
            where,
            f"A is not a rotation at {time[k]:g} s, index {k}: {found} ({len(bad)} of {len(A)} "
            "matrices); give orthonormal matrices from body to world with determinant 1",
        )


def refuse_gaps(where: str, p: Array, time: Array) -> None:
    """Raise InputError if coordinates are not finite, with the first such instant."""
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
    """Return the indices (k,) of sites of stress modes; see `StressField.indices`.

    Raises
    ------
    InputError
        With all sites that do not exist.
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
                message = f"sites is a boolean array of {len(items)} entries, must have {ns}"
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
                problems.add(where, f"no stress site at node {item} (nodes are numbered from 0)")
            found.extend(at)
        else:
            problems.add(where, f"site is {item!r}, must be a label, a node set or a node number")
    if not items:
        problems.add(where, "sites is empty; None takes all sites")
    problems.raise_if_any()
    return np.array(list(dict.fromkeys(found)), dtype=np.intp)
