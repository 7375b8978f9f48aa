"""Symbols of a scene from joints, forces, sensors and named points in results."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jousto.base.arrays import Array
from jousto.base.rotations import euler_parameters
from jousto.model.symbol_record import SymbolPoint, SymbolShape
from jousto.scene.scene import Body, Mark, Side, Symbol
from jousto.simulation.results.records import BodyShape

LISTED = 8
"""Largest number of shapes that are listed for a body."""


def drawn_symbols(
    found: Sequence[SymbolShape], bodies: Sequence[BodyShape]
) -> tuple[tuple[Symbol, ...], tuple[Mark, ...]]:
    """Return the symbols of joints, forces and sensors, and the named points."""
    symbols: list[Symbol] = []
    marks: list[Mark] = []
    for one in found:
        if one.group == "shape":
            continue
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
                cylinder=None if one.cylinder is None else one.cylinder._asdict(),
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


def contact_bodies(found: Sequence[SymbolShape], bodies: Sequence[BodyShape]) -> tuple[Body, ...]:
    """Return the shapes that touch, as one surface for each body that has some."""
    of_body: dict[int, list[SymbolShape]] = {}
    for one in found:
        if one.group == "shape" and one.triangles is not None and len(one.triangles):
            of_body.setdefault(one.points[0].body, []).append(one)
    return tuple(_surface(place, some, bodies) for place, some in sorted(of_body.items()))


def _surface(place: int, some: Sequence[SymbolShape], bodies: Sequence[BodyShape]) -> Body:
    """Return the shapes of a body as a scene body; they move with the points of their markers."""
    owner = None if place < 0 else bodies[place]
    vertices, moves = [], []
    for one in some:
        assert one.triangles is not None
        side = side_of(one.points[0], bodies)
        corners = one.triangles.reshape(-1, 3) @ np.asarray(one.points[0].axes).T + side.u
        vertices.append(corners)
        phi = np.zeros((3, side.n)) if side.phi is None else side.phi
        moves.append(np.repeat(phi.T[:, None, :], len(corners), axis=1))
    positions = np.concatenate(vertices)
    n = 0 if owner is None else owner.n
    return Body(
        name=f"contact shapes of {'the ground' if owner is None else owner.name}",
        kind="contact",
        place=-1 if owner is None else owner.q_offset,
        modes=n,
        positions=positions,
        triangles=np.arange(len(positions)).reshape(-1, 3),
        shapes=np.concatenate(moves, axis=1) if n else None,
        about=", ".join(one.kind for one in some[:LISTED]) + (", ..." if some[LISTED:] else ""),
    )
