"""SymbolShape: positions of joints, forces, sensors and named points, for drawing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, overload

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import count
from jousto.base.object_repr import described

GROUPS = ("joint", "force", "sensor", "marker", "shape")


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


class CylinderShape(NamedTuple):
    """Sizes of a hydraulic cylinder, and the sensors of the pressures of its chambers.

    Attributes
    ----------
    bore, rod : float
        Diameters of the piston and of the rod, m.
    closed, stroke : float
        Distance of its points with the rod fully in, and the stroke, m.
    pressures : tuple of str
        Names of the sensors of the pressure on the piston side and on the rod side, Pa; empty for
        a chamber without one.
    """

    bore: float
    rod: float
    closed: float
    stroke: float
    pressures: tuple[str, str]


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
    triangles : (nt, 3, 3) array or None
        Surface of a shape that touches, in the frame of its point, m.
    cylinder : CylinderShape or None
        Sizes of a hydraulic cylinder.
    """

    name: str
    kind: str
    group: str
    points: tuple[SymbolPoint, ...]
    axis: Array | None = None
    fixed: bool = False
    text: str = ""
    sensor: str = ""
    triangles: Array | None = None
    cylinder: CylinderShape | None = None


NO_TURN = np.eye(3)


class Symbols(Sequence[SymbolShape]):
    """Symbols of a mechanism, created at first use, since few models are drawn.

    Parameters
    ----------
    name : str
        Name of the mechanism.
    make : callable
        Returns the symbols.
    """

    def __init__(self, name: str, make: Callable[[], tuple[SymbolShape, ...]]) -> None:
        self._name, self._make = name, make

    @cached_property
    def _made(self) -> tuple[SymbolShape, ...]:
        return self._make()

    @overload
    def __getitem__(self, place: int) -> SymbolShape: ...
    @overload
    def __getitem__(self, place: slice) -> Sequence[SymbolShape]: ...
    def __getitem__(self, place: int | slice) -> SymbolShape | Sequence[SymbolShape]:
        return self._made[place]

    def __len__(self) -> int:
        return len(self._made)

    def __repr__(self) -> str:
        return f"<Symbols {self._name!r}: {count(len(self), 'symbol')}>"

    def __reduce__(self) -> Any:
        # pickle the symbols, not the maker: bodies have other ids in another process
        return tuple, (self._made,)
