"""Symbols of a scene from joints, forces, sensors and named points in results."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jousto.base.arrays import Array
from jousto.base.rotations import euler_parameters
from jousto.model.symbol_record import SymbolPoint, SymbolShape
from jousto.scene.scene import Mark, Side, Symbol
from jousto.simulation.results.records import BodyShape


def drawn_symbols(
    found: Sequence[SymbolShape], bodies: Sequence[BodyShape]
) -> tuple[tuple[Symbol, ...], tuple[Mark, ...]]:
    """Return the symbols of joints, forces and sensors, and the named points."""
    symbols: list[Symbol] = []
    marks: list[Mark] = []
    for one in found:
        sides = tuple(side_of(point, bodies) for point in one.points)
        if one.group == "marker":
            marks.append(Mark(one.name, sides[0]))
            continue
        symbols.append(
            Symbol(
                name=one.name,
                kind=one.kind,
                group=one.group,
                sides=sides,
                axis=one.axis,
                sensor=one.sensor or None,
                text=one.text,
                fixed=one.fixed,
            )
        )
    return tuple(symbols), tuple(marks)


def side_of(point: SymbolPoint, bodies: Sequence[BodyShape]) -> Side:
    """Return a point of a body as scene point, with the body's column in a row."""
    frame = euler_parameters(point.axes)
    if point.body < 0:
        return Side(-1, 0, np.asarray(point.u0), None, frame)
    shape = bodies[point.body]
    phi = point.modes
    if phi is None and point.node >= 0 and shape.n:
        phi = np.asarray(shape.modes[point.node])
    return Side(shape.q_offset, shape.n, np.asarray(point.u0), phi, frame)


def ground_symbols(symbols: Sequence[Symbol]) -> tuple[Symbol, ...]:
    """Return a support symbol for every ground point that a joint or force connects to a body."""
    points = [
        side.u
        for one in symbols
        if one.group in ("joint", "force") and any(side.place >= 0 for side in one.sides)
        for side in one.sides
        if side.place < 0
    ]
    found = np.unique(np.round(np.array(points).reshape(-1, 3), 12), axis=0)
    return tuple(
        Symbol("ground", "ground", "ground", (Side(-1, 0, point),), text="fixed to the world")
        for point in found
    )


def attached_points(symbols: Sequence[Symbol]) -> dict[int, Array]:
    """Return the points (k, 3) of each body at which joints and forces attach, m, by column."""
    found: dict[int, list[Array]] = {}
    for one in symbols:
        if one.group in ("joint", "force"):
            for side in one.sides:
                if side.place >= 0:
                    found.setdefault(side.place, []).append(side.u)
    return {place: np.array(points) for place, points in found.items()}
