"""Model: a mechanism as flat arrays, the complete input of the engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.object_repr import described
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.forces.law import EngineLaw, law_of
from jousto.model.elimination_order import Elimination
from jousto.model.symbol_record import SymbolShape

if TYPE_CHECKING:
    from jousto.mechanism.foreign.fmu import Fmu
    from jousto.mechanism.sensors.damage_rule import MeterRule
    from jousto.model.beam_record import BeamShape
    from jousto.model.frame_record import FrameShape
    from jousto.model.mode_loads import ModeLoad
    from jousto.reduction.fields.stress import StressModes


@described
@dataclass(frozen=True, eq=False)
class BodyModel:
    """Rigid (n = 0) or modal body.

    The displacement field is u = u0 + Phi p in the floating frame. With
    ``N_j(p) = int u phi_j^T dm`` the engine uses ``D_j = tr(N_j) E - sym(N_j)`` (half of
    dJ/dp_j) and ``B_j = int u x phi_j dm`` (I4 + I5 p). Symmetric tensors are stored as
    xx yy zz yz xz xy.

    Attributes
    ----------
    name : str
        Name of the body.
    iq, iv : int
        Offsets of [R e p] in q and [R' w p'] in v.
    mass, S0, J0 : arrays (1,), (3,), (6,)
        I1 kg, I2 kg m, I7 kg m2.
    I3, B0, D0 : arrays (3, n), (3, n), (6, n)
        ``int phi dm``, I4, and D_j at p = 0.
    ED, EB : arrays (6, n, n), (3, n, n)
        ``dD_j/dp_k`` and ``dB_j/dp_k``, index order component, j, k.
    K, D : arrays (n,)
        omega^2 in rad2/s2 and 2 zeta omega in 1/s.
    stiffening : bool
        Whether the field includes second order in p.
    alpha : float
        Mass-proportional damping, forces -alpha M v, in 1/s; for bodies without modes only.
    """

    name: str
    iq: int
    iv: int
    mass: Array
    S0: Array
    J0: Array
    I3: Array
    B0: Array
    D0: Array
    ED: Array
    EB: Array
    K: Array
    D: Array
    stiffening: bool = False
    alpha: float = 0.0

    @property
    def n(self) -> int:
        """Number of modal coordinates."""
        return len(self.K)


@described
@dataclass(frozen=True, eq=False)
class BeamModel:
    """A geometrically exact beam element between two bodies without modes.

    Attributes
    ----------
    name : str
        Name of the element.
    body : str
        Name of its beam.
    a, b : int
        Bodies at its ends.
    data : array (80,)
        Length, ends, section stiffness, unstressed strains, damping and inertia as in jousto.h.
    """

    name: str
    body: str
    a: int
    b: int
    data: Array


@described
@dataclass(frozen=True, eq=False)
class MarkerModel:
    """Frame on body `body` (-1: ground); mode shapes (3, n), or None if rigid.

    `turns` is True if its orientation is needed in every evaluation and not for sensors only; `chi`
    (6, n, n) is its second-order translation and rotation, with stiffening. `site` is the declared
    marker with its part; None for a marker added by the program.
    """

    body: int
    turns: bool
    u0: Array
    A0: Array
    Phi: Array | None
    Psi: Array | None
    chi: Array | None = None
    site: Marker | None = None


@dataclass(frozen=True)
class CoordinateModel:
    """A scalar function of markers a and b: "axes", "along", "distance", "angle", or of a disc."""

    name: str
    kind: str
    a: int
    b: int
    axis_a: int = 2
    axis_b: int = 2
    radius: float = 0.0
    cone: float = 0.0
    head: float = 0.0


@dataclass(frozen=True, eq=False)
class LineModel:
    """Constraint row: sum of factor times coordinate - offset - signal = 0.

    Attributes
    ----------
    coordinates : tuple of int
        One or two coordinates.
    factors : tuple of float
        Their factors.
    offset : float
        Constant.
    signal : int
        Signal of time, -1 for none.
    """

    coordinates: tuple[int, ...]
    factors: tuple[float, ...]
    offset: float = 0.0
    signal: int = -1


@dataclass(frozen=True)
class JointModel:
    """Constraint rows: coincidence and perpendicular axes of the first two sides, then lines.

    Attributes
    ----------
    name : str
        Name of the joint, coupling, drive or friction.
    sides : tuple of int
        Markers: a and b, or the two pairs of coupled coordinates.
    coincident : bool
        Whether the origins of sides 0 and 1 coincide (three rows).
    perpendicular : tuple of (int, int)
        Axes of side 0 and side 1 that stay perpendicular (a row each).
    lines : tuple of LineModel
        Further rows.
    row : int
        Offset of its rows among the multipliers.
    lock : int
        Index among the optional joints, those of `SwitchedModel` first; -1 for permanent rows.
    used : bool
        Whether a drive, a force, a sensor or an event needs a coordinate of the joint.
    release : int
        Index of the event that removes its rows, -1 for none.
    """

    name: str
    sides: tuple[int, ...]
    coincident: bool
    perpendicular: tuple[tuple[int, int], ...]
    row: int
    lines: tuple[LineModel, ...] = ()
    lock: int = -1
    used: bool = False
    release: int = -1

    @property
    def rows(self) -> int:
        """Number of constraint rows."""
        return 3 * self.coincident + len(self.perpendicular) + len(self.lines)


POSITIONS = {"fixed": 0, "hinge": 1, "slide": 1, "ball": 4, "free": 7, "body": 7}
RATES = {"fixed": 0, "hinge": 1, "slide": 1, "ball": 3, "free": 6, "body": 6}


@dataclass(frozen=True)
class LinkModel:
    """Link of a tree in joint coordinates, as in jousto.h; kinds "fixed", "hinge", "slide" ...

    Attributes
    ----------
    modes : int
        Number of modal coordinates of a link of the kind "body".
    coordinates : tuple of int
        Coordinates of the model equal to its position, with opposite sign if `reversed`.
    """

    kind: str
    parent: int
    body: int
    outer: int = -1
    inner: int = -1
    crossed: int = 0
    joint: int = -1
    reversed: int = 0
    x: int = 0
    u: int = 0
    drive: int = -1
    driven: int = -1
    lock: int = -1
    modes: int = 0
    coordinates: tuple[int, ...] = ()

    @property
    def positions(self) -> int:
        """Number of position coordinates."""
        return POSITIONS[self.kind] + self.modes

    @property
    def rates(self) -> int:
        """Number of velocity coordinates."""
        return RATES[self.kind] + self.modes


@described
@dataclass(frozen=True, eq=False)
class SignalModel:
    """Function of time; kind and data as in jousto.h.

    `count` is the number of times of a table, the index of an input or the event of a switch.
    """

    kind: str
    data: Array
    count: int = 0
    degree: int = 0
    children: tuple[int, int] = (-1, -1)
    name: str = ""


@described
@dataclass(frozen=True, eq=False)
class ForceModel:
    """Force element; its kind is one of jousto.h: "load", "along", "modal load".

    `other` is a second coordinate along which it acts, -1 for none; `release` is the event that
    removes it, -1 for none; `state` is the first of its first-order
    states; `element` is the kind of the declared force, such as "servo". `touches`, `coupled`,
    `dense`, `slots`, `shapes`, `sizes`, `surfaces`, `restitutions` and `slowest_each` of a set of
    contacts are as in `Packed`; `openings`, `pressure`, `thickness`, `restitution` and `slowest`
    are as in `Push`.
    """

    name: str
    kind: str
    data: Array
    a: int = -1
    b: int = -1
    coordinate: int = -1
    other: int = -1
    body: int = -1
    follow: bool = False
    active: bool = False
    signal: int = -1
    reference: int = -1
    spring: int = -1
    damper: int = -1
    function: Any = None
    release: int = -1
    state: int = -1
    state_names: tuple[str, ...] = ()
    openings: tuple[str, ...] = ()
    element: str = ""
    touches: tuple[int, ...] = ()
    coupled: tuple[tuple[int, ...], ...] = ()
    dense: int = 0
    slots: int = 0
    shapes: tuple[str, ...] = ()
    pressure: float = 0.0
    thickness: float = 0.0
    restitution: float = 0.0
    slowest: float = 0.0
    sizes: tuple[float, ...] = ()
    surfaces: tuple[int, ...] = ()
    restitutions: tuple[tuple[float, ...], ...] = ()
    slowest_each: tuple[tuple[float, ...], ...] = ()

    @property
    def points(self) -> int:
        """Largest number of points at which it lets bodies touch."""
        if not self.law.yields:
            return 0
        return sum(name.startswith("approach") for name in self.state_names)

    @property
    def law(self) -> EngineLaw:
        """Declared law of the force."""
        return law_of(self.kind)

    @property
    def states(self) -> int:
        """Number of first-order states."""
        return len(self.state_names)

    @property
    def coordinates(self) -> tuple[int, ...]:
        """Coordinates along which it acts."""
        return tuple(place for place in (self.coordinate, self.other) if place >= 0)


@described
@dataclass(frozen=True, eq=False)
class FrictionModel:
    """Friction of a joint along one or two coordinates; data as in jousto.h.

    `lock` is the optional joint that is active while they stick, -1 with the regularised law;
    `contact` the force whose normal force it has, and `joint` is then the lock; -1: of a joint.
    """

    name: str
    joint: int
    coordinate: int
    sticks: bool
    lock: int
    data: Array
    other: int = -1
    contact: int = -1


@described
@dataclass(frozen=True, eq=False)
class SwitchedModel:
    """Row that holds a coordinate at times, by its optional joint; data as in jousto.h.

    `begin` and `end` are events, -1 for none; a stop has none.
    """

    name: str
    joint: int
    begin: int
    end: int
    data: Array


@dataclass(frozen=True)
class EventModel:
    """Event at a threshold of the sensor value with index `output`.

    With `others` it is the size of several values: bit k is that with index ``output + 1 + k``.
    """

    name: str
    output: int
    others: int
    threshold: float
    direction: int
    stop: bool


@described
@dataclass(frozen=True, eq=False)
class SensorModel:
    """Sensor: kind and object as in jousto.h; `count` values from `offset`."""

    name: str
    kind: str
    object: int
    offset: int
    count: int
    unit: str
    resolved_in: str
    description: str
    components: tuple[str, ...]
    rows: Array | None = None
    other: int = -1
    frame: int = -1


@dataclass(frozen=True)
class MeterModel:
    """Damage meter of the sensor value with index `output`, times `factor`."""

    rule: MeterRule
    output: int
    factor: float


@dataclass(frozen=True, eq=False)
class FmuModel:
    """Functional mock-up unit with the sensors and inputs that exchange its values.

    Attributes
    ----------
    fmu : Fmu
        Declared unit.
    measured : dict
        Inputs of the unit and indices of their sensor values.
    given : dict
        Inputs of the unit with constant values.
    set : dict
        Outputs of the unit and the model's inputs that they set.
    """

    fmu: Fmu
    measured: dict[str, int]
    given: dict[str, float]
    set: dict[str, str]


@described
@dataclass(frozen=True, eq=False)
class Shape:
    """Drawing of a body: nodes (nn, 3) m, elements, modes (nn, 3, n).

    Flexible bodies may also have the stress of each mode at sites, and beam elements.
    """

    kind: str
    nodes: Array
    elements: NDArray[np.int64]
    modes: Array
    stress: StressModes | None = None
    frame: FrameShape | None = None


@dataclass(frozen=True, eq=False)
class Model:
    """Mechanism as flat arrays, ready to run.

    Attributes
    ----------
    name : str
        Name of the mechanism.
    gravity : (3,) array
        m/s2, world.
    bodies, markers, joints, signals, forces, sensors, coordinates, frictions, events : tuples
        The objects, referring to one another by index; the first `active` markers belong to
        joints and forces; joints has couplings, drives and sticking friction too.
    elimination : Elimination
        Block pattern of the constraint matrix.
    q0, v0 : arrays (nq,), (nv,)
        Consistent initial state: [R e p] and [R' w_local p'] body after body.
    shapes : tuple of Shape
        Drawing of each body.
    size : float
        Size of the mechanism, m; constraints are closed to 1e-12 times this size.
    meters : tuple
        Damage meters, sensor after sensor.
    redundant : bool
        Whether rows are redundant; the multipliers are then those of least norm.
    beam_shapes : tuple of BeamShape
        Data of each beam in results: elements, nodes and stress of its sections.
    beams : tuple of BeamModel
        Elements of geometrically exact beams between bodies.
    mode_loads : tuple of ModeLoad
        Loads on modal bodies outside of interfaces, for the load check of the certificate.
    symbols : sequence of SymbolShape
        Positions of joints, forces, sensors and named points, for drawing.
    fmus : tuple of FmuModel
        Models of other programs, which `simulate` runs together with the model.
    tree : tuple of LinkModel
        Links of a rigid tree in joint coordinates, after the bodies that remain in maximal
        coordinates; empty without joint coordinates.
    tree_of : tuple
        Bodies, markers, joints and coordinates for which the links were computed.
    start : str
        Initial state of runs that get none: "initial", "rest" or "vibration-free".
    """

    name: str
    gravity: Array
    bodies: tuple[BodyModel, ...]
    markers: tuple[MarkerModel, ...]
    active: int
    joints: tuple[JointModel, ...]
    signals: tuple[SignalModel, ...]
    forces: tuple[ForceModel, ...]
    sensors: tuple[SensorModel, ...]
    elimination: Elimination
    q0: Array
    v0: Array
    shapes: tuple[Shape, ...] = ()
    size: float = 1.0
    coordinates: tuple[CoordinateModel, ...] = ()
    frictions: tuple[FrictionModel, ...] = ()
    switched: tuple[SwitchedModel, ...] = ()
    events: tuple[EventModel, ...] = ()
    redundant: bool = False
    meters: tuple[MeterModel, ...] = ()
    beam_shapes: tuple[BeamShape, ...] = ()
    beams: tuple[BeamModel, ...] = ()
    mode_loads: tuple[ModeLoad, ...] = ()
    symbols: Sequence[SymbolShape] = ()
    fmus: tuple[FmuModel, ...] = ()
    tree: tuple[LinkModel, ...] = ()
    tree_of: tuple[Any, ...] = ()
    start: str = "initial"

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields, without values that follow from them."""
        return {name: vars(self)[name] for name in self.__dataclass_fields__}

    @cached_property
    def nq(self) -> int:
        """Number of position coordinates."""
        return sum(7 + body.n for body in self.bodies)

    @cached_property
    def nv(self) -> int:
        """Number of velocity coordinates."""
        return sum(6 + body.n for body in self.bodies)

    @property
    def parts_of_tree(self) -> tuple[Any, ...]:
        """Objects on which the links of a tree depend."""
        parts = self.bodies, self.markers, self.joints, self.coordinates, self.frictions
        return *parts, self.elimination

    @cached_property
    def links(self) -> tuple[LinkModel, ...]:
        """Links of the tree; empty if the model has changed since they were computed."""
        same = all(a is b for a, b in zip(self.tree_of, self.parts_of_tree, strict=False))
        return () if self.beams or not same else self.tree

    @property
    def mixed(self) -> bool:
        """Whether the model has joint coordinates and rows of joints at the same time."""
        return bool(self.links) and self.links[0].kind == "body"

    def with_records(self, **changes: Any) -> Model:
        """Return this model with other objects of the same structure.

        As `replace`, but the numbers of coordinates and rows are not counted again.
        """
        made = object.__new__(Model)
        vars(made).update(vars(self) | changes)
        vars(made).pop("links", None)
        return made

    def keeping_tree(self, of: Model) -> Model:
        """Return this model with the links of another model, if that has any.

        For changes without effect on links, such as added objects that act on no joint of the tree.
        """
        return replace(self, tree_of=self.parts_of_tree) if of.links else self

    @cached_property
    def nx(self) -> int:
        """Number of joint coordinates of a tree."""
        return sum(link.positions for link in self.links)

    @cached_property
    def nu(self) -> int:
        """Number of joint velocities of a tree."""
        return sum(link.rates for link in self.links)

    @cached_property
    def touches(self) -> bool:
        """Whether any of its forces are contacts."""
        return any(force.points for force in self.forces)

    @cached_property
    def nstate(self) -> int:
        """Number of first-order states of forces."""
        return sum(force.states for force in self.forces)

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the first-order states, ``force.state``."""
        return tuple(f"{force.name}.{name}" for force in self.forces for name in force.state_names)

    @cached_property
    def nrow(self) -> int:
        """Number of constraint rows."""
        return sum(joint.rows for joint in self.joints)

    @cached_property
    def permanent(self) -> int:
        """Number of permanent constraint rows; those of stops, locks and friction follow."""
        return sum(joint.rows for joint in self.joints if joint.lock < 0)

    @cached_property
    def inputs(self) -> tuple[str, ...]:
        """Names of the external inputs, in the engine's order."""
        signals = [signal for signal in self.signals if signal.kind == "input"]
        return tuple(signal.name for signal in sorted(signals, key=lambda signal: signal.count))

    @property
    def breaks(self) -> Array:
        """Times at which a signal of a force or a drive jumps or has a kink, s, ascending."""
        used = {line.signal for joint in self.joints for line in joint.lines}
        used |= {signal for force in self.forces for signal in (force.signal, force.reference)}
        times: list[Array] = []
        for place in range(len(self.signals) - 1, -1, -1):  # terms come before their sums
            if place not in used:
                continue
            signal = self.signals[place]
            used.update(signal.children)
            if signal.kind in ("table", "pieces"):
                times.append(signal.data[: signal.count])
            elif signal.kind == "step":
                times.append(signal.data[:1])
        return np.unique(np.concatenate([np.zeros(0), *times]))

    @cached_property
    def nout(self) -> int:
        """Number of sensor values."""
        return sum(sensor.count for sensor in self.sensors)

    def __repr__(self) -> str:
        return (
            f"<Model {self.name!r}: {len(self.bodies)} bodies, {self.nv} velocity coordinates, "
            f"{self.nrow} constraint rows>"
        )


def structure_of(model: Model) -> Model:
    """Return a model that differs from this one in numbers at the most, for caches."""
    found: Model = vars(model).get("structure", model)
    return found
