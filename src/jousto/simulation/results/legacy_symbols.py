"""Connections of two points, the only symbols in results files of older versions."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.model.symbol_record import NO_TURN, SymbolPoint, SymbolShape

GROUP = "connections"
KINDS = ("hinge", "slide", "fixed", "rod", "spring", "damper", "actuator", "bushing")
FORCES = ("spring", "damper", "actuator", "bushing")


def read_connections(group: Any) -> tuple[SymbolShape, ...]:
    """Return symbols without axes from an HDF5 group of connections.

    Its datasets: `names` (k,); `kinds` (k,), indices into `KINDS`; `bodies` (k, 2), the bodies of
    both ends, -1 for the ground; `points` (k, 2, 3), their positions, m; `modes` (m, 3), the mode
    shapes of all points one after the other; `ends` (k, 2), the last row of each point in `modes`.
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
