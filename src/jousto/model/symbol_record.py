"""SymbolShape: positions of joints, forces, sensors and named points, for drawing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.base.object_repr import described

GROUPS = ("joint", "force", "sensor", "marker")


@described
@dataclass(frozen=True, eq=False)
class SymbolPoint:
    """Point of a symbol: a frame on a body.

    Attributes
    ----------
    body : int
        Index of the body, -1 for the ground.
    u0 : (3,) array
        Undeformed position in the frame of the body (in the world for the ground), m.
    axes : (3, 3) array
        Columns are its axes in the frame of the body.
    node : int
        Node of the body with which the point moves; -1 for none.
    modes : (3, n) array or None
        Displacement in each mode, for a point without a node.
    """

    body: int
    u0: Array
    axes: Array
    node: int = -1
    modes: Array | None = None


@described
@dataclass(frozen=True, eq=False)
class SymbolShape:
    """Symbol of a joint, coupling, force, friction, sensor or named point.

    Attributes
    ----------
    name : str
    kind : str
        Kind in model files, or a more specific one: "motor", "damper".
    group : str
        One of `GROUPS`.
    points : tuple of SymbolPoint
        Connected points, or its position.
    axis : (3,) array or None
        Direction, in the frame of the body of the first point, or in the world if `fixed`.
    fixed : bool
        Whether the axis keeps its direction in the world.
    text : str
        Description in one line.
    sensor : str
        Name of the sensor; empty for other symbols.
    """

    name: str
    kind: str
    group: str
    points: tuple[SymbolPoint, ...]
    axis: Array | None = None
    fixed: bool = False
    text: str = ""
    sensor: str = ""


NO_TURN = np.eye(3)
