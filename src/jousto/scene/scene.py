"""Scene: bodies, symbols and motion of a run, a model, a part or modes, in double precision."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array, Index
from jousto.base.object_repr import described
from jousto.base.voigt import STRESS_COMPONENTS
from jousto.simulation.results.solution import Solution

MEASURES = ("von-mises", "signed-von-mises", "principal-max", "principal-min", *STRESS_COMPONENTS)
WORLD = (1.0, 0.0, 0.0, 0.0)


@described
@dataclass(frozen=True, eq=False)
class Rings:
    """Beam as rings: its section swept along the deformed axis.

    Between the ends of an element the rotation of the section is interpolated evenly, the axis is a
    cubic tangent to the end axes, and the resultants are linear.

    Attributes
    ----------
    places : (ne + 1,) int array
        Columns of ``[R e]`` of the nodes in a row.
    ends : (ne, 2, 7) array
        Pose ``[x y z e0 e1 e2 e3]`` of both ends of each element in the frames of their nodes.
    element, share : (nring,) arrays
        The element of each ring, and the position on it: 0 at its first end, 1 at its second.
    vertex_ring : (nv,) int array
        The ring of each vertex.
    yz : (nv, 2) array
        Position of each vertex in the section, m.
    forces : int
        First column of the resultants ``[N Qy Qz Mx My Mz]`` at both ends of each element; -1 if
        the stress is not known.
    corner : (nv,) int array
        The row of `rows` of each vertex.
    rows : (ncorner, 6, 6) array
        Stress ``[s11 s22 s33 s12 s23 s13]`` for unit resultants, 1/m2 and 1/m3.
    least : float
        Smallest thickness of a section in a picture, relative to the extent of the motion.
    """

    places: Index
    ends: Array
    element: Index
    share: Array
    vertex_ring: Index
    yz: Array
    forces: int
    corner: Index
    rows: Array
    least: float


@described
@dataclass(frozen=True, eq=False)
class Sections:
    """Vertices of a modal frame by sections along its elements.

    Attributes
    ----------
    element, share : (nring,) arrays
        The element of each section, and the position on it: 0 at its first end, 1 at its second.
    vertex_ring : (nv,) int array
        The section of each vertex.
    yz : (nv, 2) array
        Position of each vertex in its section, m.
    """

    element: Index
    share: Array
    vertex_ring: Index
    yz: Array


@described
@dataclass(frozen=True, eq=False)
class Body:
    """A body of a scene: ``x = R + A(e) (x0 + sum_j phi_j p_j)``.

    Attributes
    ----------
    name : str
    kind : str
        "solid", "frame", "beam", "rigid", "ground", "mesh", or "contact" for shapes that touch.
    place : int
        Column of ``[R e p]`` in a row; -1 if the body is fixed in the world.
    modes : int
        Number n of its modes.
    positions : (nv, 3) array
        Undeformed vertices in the frame of the body, m.
    triangles, lines, edges : int arrays (nt, 3), (nl, 2), (nd, 2), or None
        Surface, counterclockwise seen from outside; lines; edges that are drawn over the surface.
    shapes : (n, nv, 3) array or None
        Displacement of the vertices in each mode, kg^-0.5.
    stress : (n, nv, 6) array or None
        Stress ``[s11 s22 s33 s12 s23 s13]`` of each mode, Pa kg^-0.5 m^-1: in the axes of the body
        for solids, of the section for frames.
    static : (nv, 6) array or None
        Stress that does not change, Pa.
    known : (nv,) bool array or None
        Mask of vertices with known stress; None: everywhere or nowhere.
    nodes : (nv,) int array or None
        Numbers of the nodes of the model, from 1.
    damage : (nv,) array or None
        Damage at the vertices; nan where it is not known.
    life : (nv,) array or None
        Life at the vertices, s; inf for infinite life, nan where it is not known.
    mass : float or None
        kg.
    about : str
        Facts in one line.
    rings : Rings or None
        Rings of exact beams, which have neither shapes nor stress.
    sections : Sections or None
        Sections of modal frames.
    """

    name: str
    kind: str
    place: int
    modes: int
    positions: Array
    triangles: Index | None = None
    lines: Index | None = None
    edges: Index | None = None
    shapes: Array | None = None
    stress: Array | None = None
    static: Array | None = None
    known: NDArray[np.bool_] | None = None
    nodes: Index | None = None
    damage: Array | None = None
    life: Array | None = None
    mass: float | None = None
    about: str = ""
    rings: Rings | None = None
    sections: Sections | None = None


@described
@dataclass(frozen=True, eq=False)
class Side:
    """Point of a body: ``r = R + A(e) (u + phi p)``.

    Attributes
    ----------
    place : int
        Column of ``[R e p]`` of the body in a row; -1 for a point of the world.
    n : int
        Number of modes of the body.
    u : (3,) array
        Undeformed position in the frame of the body, m.
    phi : (3, n) array or None
        Displacement of the point in each mode.
    frame : (4,) array
        Euler parameters of the marker in the frame of the body, scalar first.
    """

    place: int
    n: int
    u: Array
    phi: Array | None = None
    frame: Array = field(default_factory=lambda: np.array(WORLD))


@described
@dataclass(frozen=True, eq=False)
class Symbol:
    """Symbol of a joint, a force, a sensor or a support.

    Attributes
    ----------
    name, kind : str
    group : str
        "joint", "force", "sensor" or "ground".
    sides : tuple of Side
        Points that the symbol connects; for a path all its points.
    axis : (3,) array or None
        Direction in the frame of the body of the first side, or in the world if `fixed`.
    size : float or None
        m.
    sensor : str or None
        Name of the sensor of the symbol.
    text : str
        Description in one line.
    fixed : bool
        Whether the axis keeps its direction in the world.
    cylinder : dict or None
        Sizes of a hydraulic cylinder, and names of the sensors of its pressures.
    """

    name: str
    kind: str
    group: str
    sides: tuple[Side, ...]
    axis: Array | None = None
    size: float | None = None
    sensor: str | None = None
    text: str = ""
    fixed: bool = False
    cylinder: dict[str, Any] | None = None


@described
@dataclass(frozen=True, eq=False)
class Mark:
    """Named point."""

    name: str
    side: Side


@described
@dataclass(frozen=True, eq=False)
class Sensor:
    """Sensor with its place.

    Attributes
    ----------
    name, unit, description : str
    units, components : tuples of str
        Unit and name of each component.
    side : Side or None
        Place of the sensor.
    arrow : str or None
        "force", "moment", "velocity" or "acceleration" if it is a vector in world axes.
    columns : tuple of int or None
        The components of that vector.
    floors : tuple of float
        Magnitude of each component below which a reading is rounding error.
    """

    name: str
    unit: str
    units: tuple[str, ...]
    components: tuple[str, ...]
    description: str
    side: Side | None = None
    arrow: str | None = None
    columns: tuple[int, ...] | None = None
    floors: tuple[float, ...] = ()


@described
@dataclass(frozen=True, eq=False)
class Mode:
    """Mode: ``row(t) = still + a (real cos wt - imag sin wt)``.

    Attributes
    ----------
    label : str
    frequency : float
        Hz.
    damping : float or None
        Damping ratio.
    real, imag : (nr,) arrays
        Change of the row; imag is None if all points move in phase.
    amplitude : float
        Factor that scales the largest displacement to a tenth of the size.
    note : str
    """

    label: str
    frequency: float
    damping: float | None
    real: Array
    imag: Array | None
    amplitude: float
    note: str = ""


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of a run: rows, read in slices on demand.

    Attributes
    ----------
    times : (nt,) array
        Stored instants, s.
    rows : function
        ``rows(slice)`` returns the rows (k, nr) of these instants, and reads only them.
    """

    times: Array
    rows: Callable[[slice], Array]

    def __repr__(self) -> str:
        return f"<Motion: {len(self.times)} instants>"


@dataclass(frozen=True)
class Happened:
    """Event of a run: time, s, and name."""

    time: float
    name: str


@dataclass(frozen=True, eq=False)
class Scene:
    """Bodies, symbols and motion of a run, a model, a part or modes.

    A row is one instant: the positions q of the engine, ``[R e p]`` body after body, then the
    resultants of exact beams.

    Attributes
    ----------
    what : str
        "run", "model", "part" or "modes".
    name, title : str
    still : (nr,) array
        The row of the first instant.
    bodies, symbols, markers, sensors, modes, events : tuples
    motion : Motion or None
        Motion of the scene.
    box : (2, 3) array
        Opposite corners around everything over the motion, world, m.
    up : (3,) array
        Upwards: against gravity.
    gravity : (3,) array or None
        m/s2.
    measures : tuple of str
        Quantities available as colours.
    limits : dict
        Smallest and largest value of each measure over the run, as far as known.
    run : Solution or None
        The results.
    touches : float or None
        Largest normal force of the contacts of the run, N, 0 if not known; None without contacts.
    """

    what: str
    name: str
    title: str
    still: Array
    bodies: tuple[Body, ...]
    box: Array
    symbols: tuple[Symbol, ...] = ()
    markers: tuple[Mark, ...] = ()
    sensors: tuple[Sensor, ...] = ()
    modes: tuple[Mode, ...] = ()
    events: tuple[Happened, ...] = ()
    motion: Motion | None = None
    up: Array = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    gravity: Array | None = None
    measures: tuple[str, ...] = ()
    limits: dict[str, Any] = field(default_factory=dict)
    run: Solution | None = None
    touches: float | None = None

    def __repr__(self) -> str:
        return f"<Scene {self.name!r}: {len(self.bodies)} bodies, {len(self.symbols)} symbols>"
