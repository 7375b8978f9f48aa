"""Fronts of work-precision diagrams: the time of a program for an error, and its method."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Point = dict[str, Any]
DECADES = tuple(float(f"1e{k}") for k in range(-1, -12, -1))  # m, above what rounding leaves
LIKE = 1.1  # errors within this factor are alike


def front(points: Iterable[Point], program: str, method: str | None = None) -> Array:
    """Points (n, 2), error and time, that no other of the program beats; the error falls."""
    own = sorted(
        (p["error"], p["seconds"])
        for p in points
        if p["program"] == program and p["error"] and method in (None, p["method"])
    )
    best: list[tuple[float, float]] = []
    for error, seconds in own:  # from the smallest error on
        if not best or seconds < best[-1][1]:
            best.append((error, seconds))
    return np.array(best[::-1]).reshape(-1, 2)


def time_at(curve: Array, error: float) -> float:
    """Time at an error on a front, interpolated in logarithms; nan outside."""
    if not len(curve) or not curve[-1, 0] <= error <= curve[0, 0]:
        return float("nan")
    x, y = np.log(curve[::-1, 0]), np.log(curve[::-1, 1])
    return float(np.exp(np.interp(np.log(error), x, y)))


def programs(points: Iterable[Point]) -> list[str]:
    return list(dict.fromkeys(point["program"] for point in points))


def methods(points: Iterable[Point], program: str) -> list[str]:
    return list(dict.fromkeys(p["method"] for p in points if p["program"] == program))


def levels(points: list[Point]) -> list[float]:
    """Errors at which jousto and another program are compared, m; falling.

    All decades that both have; of a program without one, the middle of what both have.
    """
    own, found = front(points, "jousto"), set()
    for name in programs(points):
        other = front(points, name)
        if name == "jousto" or not len(own) or not len(other):
            continue
        low, high = max(own[-1, 0], other[-1, 0]), min(own[0, 0], other[0, 0])
        both = {error for error in DECADES if low <= error <= high}
        middle = float(f"{np.sqrt(low * high):.0e}")
        found |= both or ({middle} if low <= middle <= high else set())
    return sorted(found, reverse=True)


def fastest(points: list[Point], program: str, error: float) -> str:
    """Method of a program with the least time at an error; "" if the front joins two of them."""
    times = {m: time_at(front(points, program, m), error) for m in methods(points, program)}
    known = {m: t for m, t in times.items() if np.isfinite(t)}
    return min(known, key=lambda m: known[m]) if known else ""


def at_step(points: list[Point], program: str, method: str, step: float) -> Point | None:
    """Fastest point of a method at a step; of several tolerances those that keep the error.

    The error kept is that of the tightest tolerance, up to a factor `LIKE`.
    """
    own = [
        p
        for p in points
        if (p["program"], p["method"], p["setting"].get("step")) == (program, method, step)
        and p["error"] is not None
    ]
    if not own:
        return None
    tight = min(own, key=lambda p: p["setting"].get("tolerance", 0.0))
    keep = [p for p in own if p["error"] <= LIKE * tight["error"]]
    return min(keep, key=lambda p: p["seconds"])
