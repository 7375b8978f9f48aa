"""Model: a mechanism as flat arrays, everything the engine needs and nothing else."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jousto.engine.ordering import Elimination

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BodyModel:
    """A rigid (n = 0) or modal body.

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

    @property
    def n(self) -> int:
        """Number of modal coordinates."""
        return len(self.K)


@dataclass(frozen=True, eq=False)
class MarkerModel:
    """A frame on body `body` (-1: ground); mode shapes (3, n) or None where rigid.

    `turns` tells that its orientation matters in every evaluation, not only for sensors.
    """

    body: int
    turns: bool
    u0: Array
    A0: Array
    Phi: Array | None
    Psi: Array | None


@dataclass(frozen=True)
class JointModel:
    """Constraint rows between markers a and b: coincidence, then perpendicular axis pairs."""

    name: str
    a: int
    b: int
    coincident: bool
    perpendicular: tuple[tuple[int, int], ...]
    row: int

    @property
    def rows(self) -> int:
        """Number of constraint rows."""
        return 3 * self.coincident + len(self.perpendicular)


@dataclass(frozen=True, eq=False)
class SignalModel:
    """A factor of time; kind and data as in jousto.h."""

    kind: str
    data: Array


@dataclass(frozen=True, eq=False)
class ForceModel:
    """Force and torque at a marker."""

    name: str
    marker: int
    follow: bool
    signal: int
    force: Array
    torque: Array


@dataclass(frozen=True, eq=False)
class SensorModel:
    """A measurement: kind and object as in jousto.h; count values from offset."""

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


@dataclass(frozen=True, eq=False)
class Shape:
    """What a body looks like, for pictures: nodes (nn, 3) m, elements, modes (nn, 3, n)."""

    kind: str
    nodes: Array
    elements: NDArray[np.int64]
    modes: Array


@dataclass(frozen=True, eq=False)
class Model:
    """A mechanism ready to run.

    Attributes
    ----------
    name : str
        Name of the mechanism.
    gravity : (3,) array
        m/s2, world.
    bodies, markers, joints, signals, forces, sensors : tuples
        The objects, referring to one another by index; the first `active` markers belong to
        joints and forces.
    elimination : Elimination
        Block pattern of the constraint matrix.
    q0, v0 : arrays (nq,), (nv,)
        Consistent initial state: [R e p] and [R' w_local p'] body after body.
    shapes : tuple of Shape
        One for each body.
    size : float
        Size of the mechanism, m; constraints are closed to 1e-12 of it.
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

    @property
    def nq(self) -> int:
        """Number of position coordinates."""
        return sum(7 + body.n for body in self.bodies)

    @property
    def nv(self) -> int:
        """Number of velocity coordinates."""
        return sum(6 + body.n for body in self.bodies)

    @property
    def nrow(self) -> int:
        """Number of constraint rows."""
        return sum(joint.rows for joint in self.joints)

    @property
    def nout(self) -> int:
        """Number of sensor values."""
        return sum(sensor.count for sensor in self.sensors)

    def __repr__(self) -> str:
        return (
            f"<Model {self.name!r}: {len(self.bodies)} bodies, {self.nv} velocity coordinates, "
            f"{self.nrow} constraint rows>"
        )
