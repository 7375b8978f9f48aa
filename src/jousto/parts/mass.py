"""Mass of a part as points, from which its mass matrix and all its inertia integrals follow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from jousto.base.arrays import Array, Ints, Sparse, as_csr, node_dofs, read_only, scatter, skew
from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Field, field
from jousto.base.numbers import Number
from jousto.base.object_repr import described


class NodeField(Field["int | str", "int | str"]):
    """Field of a node or of the name of a set; the part converts it to indices."""

    form = "text"
    noun = "int or str"


class Tensor(Field[ArrayLike | None, Array]):
    """Field of moments of inertia or of an inertia tensor; None for no inertia."""

    form = "inertia"
    noun = "(3,) or (3, 3) array_like"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the inertia tensor (3, 3), or report that it is unphysical."""
        J = np.zeros(3) if value is None else value
        J = problems.array(where, "inertia", J, (3,) if np.ndim(J) == 1 else (3, 3))
        if J is None:
            return None
        J = np.diag(J) if J.ndim == 1 else J
        scale = np.abs(J).max()
        if np.abs(J - J.T).max() > 1e-9 * scale:
            problems.add(where, "inertia is not symmetric", "inertia")
        elif np.linalg.eigvalsh(second_moment(J.real)).min() < -1e-9 * scale:
            moments = ", ".join(f"{x:.6g}" for x in np.linalg.eigvalsh(J))
            problems.add(
                where,
                f"principal moments of inertia are {moments} kg m^2; they must not be negative, "
                f"and none may exceed the sum of the other two",
            )
        return read_only(J)


class Arm(Field[ArrayLike | None, Array]):
    """Field of a vector (3,); None for zero."""

    form = "vector"
    noun = "(3,) array_like"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a read-only array, or report what is wrong."""
        return problems.array(where, self.name, np.zeros(3) if value is None else value, (3,))


class PointMass(Declared):
    """Rigid mass fixed to a node.

    Raises
    ------
    InputError
        If a value is not finite, the mass is negative, or the inertia is unphysical (not symmetric,
        or a moment above the sum of the other two).

    Examples
    --------
    >>> PointMass("end", 2.5, inertia=(0.1, 0.2, 0.2)).mass
    2.5
    """

    node: NodeField = field(
        'Node index (from 0), or the name of a node set such as ``"node1"`` or ``"end"``'
    )
    mass: Number = field("Mass", unit="kg", least=0, wanted="zero or positive")
    inertia: Tensor = field(
        "Inertia about the centre of the mass, part axes: three moments or a 3 x 3 tensor",
        unit="kg m^2",
        default=(0.0, 0.0, 0.0),
    )
    offset: Arm = field(
        "Vector from the node to the centre of the mass, part frame",
        unit="m",
        default=(0.0, 0.0, 0.0),
    )

    def heading(self, problems: Problems) -> str:
        """Return the prefix of messages."""
        return f"point mass at node {self.node!r}"


def second_moment(J: Array) -> Array:
    """Return second moments G = int s s^T dm for inertia tensors J = tr(G) E - G, (..., 3, 3)."""
    half_trace = 0.5 * np.trace(J, axis1=-2, axis2=-1)
    G: Array = half_trace[..., None, None] * np.eye(3) - J
    return G


def inertia_tensor(G: Array) -> Array:
    """Return inertia tensors J = tr(G) E - G for second moments G = int s s^T dm, (..., 3, 3)."""
    J: Array = np.trace(G, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) - G
    return J


@described
@dataclass(frozen=True, eq=False)
class MassPoints:
    """Mass of a part as k points that translate and rotate with the nodes.

    The particles of point i lie at ``position_i + s`` and move, for nodal displacements d, by
    ``N_i d + (N_rot_i d) cross s``, where ``int s dm = 0`` and ``int s s^T dm = second_moment_i``.

    Parameters
    ----------
    mass : (k,) ndarray
        Masses in kg.
    position : (k, 3) ndarray
        Undeformed positions of the points' centres in m, part frame.
    second_moment : (k, 3, 3) ndarray
        ``int s s^T dm`` about each point's own centre in kg m^2, part axes.
    N : (3 k, ndof) sparse array
        Translations of the centres from nodal displacements, part axes.
    N_rot : (3 k, ndof) sparse array
        Rotation vectors of the points from nodal displacements, part axes.
    arm : (k, 3) ndarray, optional
        Rigid arm from the node of the point to its centre in m, part frame; zero if not given. N
        contains its first-order effect.
    """

    mass: Array
    position: Array
    second_moment: Array
    N: Sparse
    N_rot: Sparse
    arm: Array | None = None

    def __post_init__(self) -> None:
        if self.arm is None:
            object.__setattr__(self, "arm", np.zeros((len(self.mass), 3)))
        for name in ("mass", "position", "second_moment", "arm"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        object.__setattr__(self, "N", as_csr(self.N))
        object.__setattr__(self, "N_rot", as_csr(self.N_rot))

    def __len__(self) -> int:
        return len(self.mass)

    @property
    def inertia(self) -> Array:
        """Inertia tensors of the points about their own centres in kg m^2, (k, 3, 3)."""
        return inertia_tensor(self.second_moment)

    def matrix(self) -> Sparse:
        """Return the mass matrix ``N^T diag(m) N + N_rot^T blkdiag(J) N_rot``, (ndof, ndof)."""
        m = np.repeat(self.mass, 3)
        i = np.arange(len(m))
        D: Sparse = sp.csr_array((m, (i, i)), shape=(len(m), len(m)))
        M = self.N.T @ (D @ self.N)
        turning = np.flatnonzero(np.any(self.second_moment != 0.0, axis=(1, 2)))
        if len(turning):
            rows = node_dofs(np.arange(len(turning))[:, None], 3)
            size = 3 * len(turning)
            J = scatter(self.inertia[turning], rows, rows, (size, size))
            N_rot = self.N_rot[node_dofs(turning[:, None], 3).ravel()]
            M = M + N_rot.T @ (J @ N_rot)
        return as_csr((M + M.T) * 0.5)


def rigid_points(node: Ints, mass: Array, offset: Array, moment: Array, nodes: Array) -> MassPoints:
    """Return one mass point per node from masses that are fixed to nodes.

    Parameters
    ----------
    node : (m,) ndarray
        Node index of each mass.
    mass : (m,) ndarray
        Masses in kg.
    offset : (m, 3) ndarray
        From the node to the centre of each mass in m, part frame.
    moment : (m, 3, 3) ndarray
        Second moments about the centres of the masses in kg m^2, part axes.
    nodes : (nn, 3) ndarray
        Node positions in m; every node has six degrees of freedom.

    Returns
    -------
    MassPoints
        One point for each node that carries mass or rotary inertia, in node order.
    """
    nn = len(nodes)
    kind = np.result_type(mass, offset, moment)
    m = np.zeros(nn, kind)
    np.add.at(m, node, mass)
    first = np.zeros((nn, 3), kind)
    np.add.at(first, node, mass[:, None] * offset)
    c = first / np.where(m > 0.0, m, 1.0)[:, None]

    # parallel-axis terms about the common centre
    arm = offset - c[node]
    G = np.zeros((nn, 3, 3), kind)
    np.add.at(G, node, moment + mass[:, None, None] * arm[:, :, None] * arm[:, None, :])

    used = np.flatnonzero((m > 0.0) | np.any(G != 0.0, axis=(1, 2)))
    rows = node_dofs(np.arange(len(used))[:, None], 3)
    columns = node_dofs(used[:, None], 6)
    E = np.broadcast_to(np.eye(3), (len(used), 3, 3))
    shape = (3 * len(used), 6 * nn)
    return MassPoints(
        mass=m[used],
        position=nodes[used] + c[used],
        second_moment=G[used],
        N=scatter(np.concatenate([E, -skew(c[used])], axis=2), rows, columns, shape),
        N_rot=scatter(E, rows, columns[:, 3:], shape),
        arm=c[used],
    )


def joined(parts: Sequence[MassPoints]) -> MassPoints:
    """Return the mass points of several descriptions with the same degrees of freedom."""
    if len(parts) == 1:
        return parts[0]
    return MassPoints(
        mass=np.concatenate([p.mass for p in parts]),
        position=np.concatenate([p.position for p in parts]),
        second_moment=np.concatenate([p.second_moment for p in parts]),
        N=as_csr(sp.vstack([p.N for p in parts], format="csr")),
        N_rot=as_csr(sp.vstack([p.N_rot for p in parts], format="csr")),
        arm=np.concatenate([np.asarray(p.arm) for p in parts]),
    )
