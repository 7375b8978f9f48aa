"""Items of a planar frame: beams, supports, motions, loads, masses and links."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.materials.damping import ProportionalDamping
from jousto.planar.element import PlanarElement
from jousto.planar.section import PlanarSection

Node = Hashable
Signal = Callable[[float], float]
Prescribed = Callable[[float], tuple[float, float, float]]


@dataclass(frozen=True)
class PlanarBeam:
    """Beam element between two nodes.

    Parameters
    ----------
    a, b : node
        Names of nodes.
    section : PlanarSection
    offset_a, offset_b : (float, float)
        Vector from the node to the end of the beam axis in the unloaded frame, m, in axes of the
        frame. The end is rigidly connected to the node (eqs. 20 to 25).
    name : str
        Name in messages and results.
    element : {"exact", "corotational", "ancf"} or PlanarElement, optional
        Element of this beam; the default is that of the frame.
    """

    a: Node
    b: Node
    section: PlanarSection
    offset_a: tuple[float, float] = (0.0, 0.0)
    offset_b: tuple[float, float] = (0.0, 0.0)
    name: str = ""
    element: str | PlanarElement | None = None


@dataclass(frozen=True)
class PlanarSupport:
    """Support of a node.

    Parameters
    ----------
    node : node
    x, y, rotation : bool
        Fixed displacements: by default a pin; ``rotation=True`` for a clamp.
    """

    node: Node
    x: bool = True
    y: bool = True
    rotation: bool = False


@dataclass(frozen=True)
class PlanarMotion:
    """Prescribed motion of a node in dynamics.

    Parameters
    ----------
    node : node
    x, y, rotation : function, optional
        Displacement (m, rad) as a function of time, s, that returns its value, rate and second
        rate. None leaves it free.

    Examples
    --------
    A hub that turns by ``0.5 w t^2``:

    >>> hub = PlanarMotion(0, rotation=lambda t: (0.5 * 3.0 * t**2, 3.0 * t, 3.0))
    """

    node: Node
    x: Prescribed | None = None
    y: Prescribed | None = None
    rotation: Prescribed | None = None


@dataclass(frozen=True)
class PlanarLoad:
    """Force and moment at a node.

    Parameters
    ----------
    node : node
    force : (float, float)
        Force, N, in axes of the frame, or of the rotated node if `follow`.
    moment : float
        Moment, N m, positive counterclockwise.
    signal : function, optional
        Factor as a function of time, s, in dynamics; None is 1. Statics use load factors.
    follow : bool
        Whether the force rotates with its node (follower load).
    """

    node: Node
    force: tuple[float, float] = (0.0, 0.0)
    moment: float = 0.0
    signal: Signal | None = None
    follow: bool = False


@dataclass(frozen=True)
class PlanarMass:
    """Rigid mass at a node.

    Parameters
    ----------
    node : node
    mass : float
        Mass, kg.
    inertia : float
        Inertia about the node, kg m^2.
    """

    node: Node
    mass: float
    inertia: float = 0.0


@dataclass(frozen=True)
class RigidLink:
    """Nodes connected to a master node by rigid arms.

    Parameters
    ----------
    master : node
    nodes : tuple of nodes
        Slave nodes, whose displacements are eliminated.
    rotation : bool
        Whether the slaves rotate with the master; False for hinges.
    """

    master: Node
    nodes: tuple[Node, ...]
    rotation: bool = True


@dataclass(frozen=True, eq=False)
class LinearLink:
    """Linear relation of displacements of nodes to those of masters, ``u = T q + u0``.

    Parameters
    ----------
    nodes, masters : tuple of nodes
        Each with x, y, rotation, in this order.
    T : (3 nodes, 3 masters) array
    u0 : (3 nodes,) array, optional
        Constant displacements, m and rad.
    """

    nodes: tuple[Node, ...]
    masters: tuple[Node, ...]
    T: Any
    u0: Any = None


@dataclass(frozen=True, eq=False)
class FunctionLink:
    """Displacements of nodes as a function of master displacements and further coordinates.

    Parameters
    ----------
    nodes, masters : tuple of nodes
        Each with x, y, rotation, in this order.
    function : function
        Function of ``[x, y, rotation of the masters ..., further coordinates ...]`` that returns
        the displacements of the nodes (3 nodes,), written with NumPy; derivatives are exact.
    coordinates : tuple of str
        Names of further coordinates, such as the displacement of a slider; initial value zero.

    Examples
    --------
    A slider on the line from node ``p`` to node ``q``, with the rotation of ``p``:

    >>> import numpy as np
    >>> def slide(u):
    ...     share = 0.5 + u[6]  # begins halfway
    ...     x = (1 - share) * u[0] + share * u[3] + u[6] * 2.0  # 2 m from p to q, along x
    ...     return np.array([x, (1 - share) * u[1] + share * u[4], u[2]])
    >>> link = FunctionLink(("slider",), ("p", "q"), slide, coordinates=("share",))
    """

    nodes: tuple[Node, ...]
    masters: tuple[Node, ...]
    function: Callable[[Any], Any]
    coordinates: tuple[str, ...] = ()


Link = RigidLink | LinearLink | FunctionLink


class PlanarDamping(ProportionalDamping):
    """Proportional damping of the frame; the mass-proportional part includes all masses."""


def vector(x: Any) -> np.ndarray[Any, Any]:
    """Return an array-like value as an array of floats."""
    return np.array(x, dtype=float)
