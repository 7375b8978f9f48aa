"""What joined two points in results files of older versions, which knew no other symbols."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.model.symbol_record import NO_TURN, SymbolPoint, SymbolShape

GROUP = "connections"
KINDS = ("hinge", "slide", "fixed", "rod", "spring", "damper", "actuator", "bushing")
FORCES = ("spring", "damper", "actuator", "bushing")


def read_connections(group: Any) -> tuple[SymbolShape, ...]:
    """Return the connections of their HDF5 group as symbols, which know no axes.

    `names` and `kinds` (k,), the latter places in `KINDS`; `bodies` (k, 2), -1 for the ground, and
    `points` (k, 2, 3) of both ends, m; `modes` (m, 3), displacements of all points in the modes of
    their bodies behind one another, and `ends` (k, 2), where those of each end.
    """
    names, kinds, bodies, points, modes, ends = (
        group[name][()] for name in ("names", "kinds", "bodies", "points", "modes", "ends")
    )
    cuts = np.concatenate([[0], ends.ravel()])
    sides = [
        SymbolPoint(int(body), u0, NO_TURN, modes=modes[first:last].T if last > first else None)
        for body, u0, first, last in zip(
            bodies.ravel(), points.reshape(-1, 3), cuts[:-1], cuts[1:], strict=True
        )
    ]
    return tuple(
        SymbolShape(
            name=name.decode(),
            kind=KINDS[kind],
            group="force" if KINDS[kind] in FORCES else "joint",
            points=(a, b),
            text=f"{KINDS[kind]} '{name.decode()}'",
        )
        for name, kind, a, b in zip(names, kinds, sides[::2], sides[1::2], strict=True)
    )
