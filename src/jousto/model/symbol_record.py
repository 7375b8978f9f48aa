"""SymbolShape: where joints, forces, sensors and named points of a mechanism are, for pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.base.object_repr import described

GROUPS = ("joint", "force", "sensor", "marker")


@described
@dataclass(frozen=True, eq=False)
class SymbolPoint:
    """A frame on a body.

    Attributes
    ----------
    body : int
        Number of the body, -1 for the ground.
    u0 : (3,) array
        Undeformed position in the frame of the body, of the ground in the world, m.
    axes : (3, 3) array
        Columns are its axes in the frame of the body.
    node : int
        Node of the body that it moves with; -1 for none.
    modes : (3, n) array or None
        Its displacement in each mode, where it moves with no node.
    """

    body: int
    u0: Array
    axes: Array
    node: int = -1
    modes: Array | None = None


@described
@dataclass(frozen=True, eq=False)
class SymbolShape:
    """What is drawn for a joint, coupling, force, friction or sensor; or a named point.

    Attributes
    ----------
    name : str
    kind : str
        The word of its class in model files, or a finer one: "motor", "damper".
    group : str
        One of `GROUPS`.
    points : tuple of SymbolPoint
        What it joins, or where it is.
    axis : (3,) array or None
        Its direction, in the frame of the body of the first point, or in the world if `fixed`.
    fixed : bool
        Whether the axis keeps its direction in the world.
    text : str
        One line about it.
    sensor : str
        Name of the sensor; empty for what is none.
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
