"""Checks of measured signals and of the noise given for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.linalg as la

from jousto.base.arrays import Array
from jousto.base.errors import LARGE_STRAIN, Problems, count, strain_remedy

LARGEST = LARGE_STRAIN
"""Strain beyond which no elastic part goes, m/m, the same for every door of the package."""


def read_strain(
    problems: Problems, where: str, e: Any, names: Sequence[str], strains: int | None = None
) -> Array | None:
    """Return strains (nt, ng), with nan for silent gauges, or note what is wrong.

    Parameters
    ----------
    problems, where
        Where to note.
    e : array_like
        Strains, m/m, one channel a column.
    names : sequence of str
        The channels.
    strains : int, optional
        How many of the first channels are strains; all of them if not given.
    """
    if (
        isinstance(e, np.ndarray)
        and e.dtype == np.float64
        and e.shape == (len(names),)
        and bool((np.abs(e[:strains]) <= LARGEST).all())
        and bool(np.isfinite(e).all())
    ):
        return e[None]  # the usual sample of a stream
    try:
        strain = np.atleast_2d(np.array(e, dtype=np.float64))
    except (TypeError, ValueError):
        problems.add(where, "e is not an array of numbers, one row an instant")
        return None
    ng = len(names)
    if strain.ndim != 2 or strain.shape[1] != ng:
        turned = strain.ndim == 2 and strain.shape[0] == ng and strain.shape[1] != ng
        problems.add(
            where,
            f"e has shape {strain.shape}, must be (instants, {ng}): one column for each of "
            f"{', '.join(names[:6])}{', ...' if ng > 6 else ''}"
            + ("; it looks transposed, give e.T" if turned else ""),
        )
        return None
    endless = np.argwhere(np.isinf(strain))
    if len(endless):
        row, column = endless[0]
        problems.add(
            where,
            f"channel '{names[column]}' is infinite at row {row}; give nan where nothing was "
            "measured",
        )
        return None
    part = strain[:, : ng if strains is None else strains]
    size = np.nanmax(np.abs(part), axis=0, initial=0.0) if part.size else np.zeros(0)
    size = np.nan_to_num(size)
    if len(size) and size.max() > LARGEST:
        worst = int(size.argmax())
        problems.add(
            where,
            f"strain of '{names[worst]}' reaches {size[worst]:.4g} m/m, "
            f"{100 * size[worst]:.4g} %, which no elastic part can have; it looks like "
            f"{strain_remedy(float(size[worst]))}",
        )
        return None
    return strain


def read_time(problems: Problems, where: str, time: Any, strain: Array | None) -> Array | None:
    """Return the instants, 0, 1, 2 .. if none are given, or note what is wrong."""
    nt = 0 if strain is None else len(strain)
    if time is None:
        return np.arange(nt, dtype=np.float64)
    t = problems.array(where, "time", np.atleast_1d(np.asarray(time)), (None,))
    if t is None or strain is None:
        return t
    if len(t) != nt:
        problems.add(where, f"{count(len(t), 'time')} for {count(nt, 'row')} of strain")
        return None
    back = np.flatnonzero(np.diff(t) <= 0.0)
    if len(back):
        k = int(back[0])
        problems.add(
            where,
            f"time runs backwards or stands still: {t[k]:.9g} s is followed by {t[k + 1]:.9g} s "
            f"(row {k + 1}, {count(len(back), 'place')} in all); sort the record",
        )
        return None
    return t


def read_noise(
    problems: Problems, where: str, key: str, value: Any, size: int, unit: str, largest: float
) -> Array | None:
    """Return a covariance matrix from standard deviations or a matrix, or note what is wrong."""
    try:
        given = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        problems.add(where, f"{key} is {value!r}, must be standard deviations in {unit}")
        return None
    if given.ndim < 2:
        if given.ndim == 1 and given.shape != (size,):
            problems.add(where, f"{key} has {len(given)} values, must be 1 or {size}")
            return None
        bad = given[~(np.isfinite(given) & (given > 0.0))]
        if bad.size:
            problems.add(
                where,
                f"{key} is {bad.flat[0]:g} {unit}, must be positive: a gauge without noise would "
                "make all others and the model worthless"
                if key == "noise"
                else f"{key} is {bad.flat[0]:g} {unit}, must be positive",
            )
            return None
        if given.max() > largest:
            problems.add(
                where,
                f"{key} is {given.max():g} {unit}; standard deviations are in {unit}, a good gauge "
                "has 1e-6",
            )
            return None
        return np.diag(np.broadcast_to(given**2, (size,)))
    if given.shape != (size, size) or not np.isfinite(given).all():
        problems.add(where, f"{key} has shape {given.shape}, must be finite of ({size}, {size})")
        return None
    if not np.allclose(given, given.T, rtol=1e-8, atol=1e-12 * np.abs(given).max(initial=0.0)):
        problems.add(where, f"{key} is a covariance matrix, but not symmetric")
        return None
    even = 0.5 * (given + given.T)
    least = la.eigvalsh(even)[0]
    floor = 0.0 if key == "noise" else -1e-10 * np.abs(even).max(initial=0.0)
    if least < floor or (key == "noise" and least <= 0.0):
        problems.add(where, f"{key} is no covariance: its least eigenvalue is {least:.3g}")
        return None
    return np.asarray(even)
