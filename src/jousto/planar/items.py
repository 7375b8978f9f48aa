"""What a planar frame is made of: sections, beams, supports, loads, masses and links."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, Positive
from jousto.materials.damping import ProportionalDamping
from jousto.materials.material import Material
from jousto.sections.section import Section

Node = Hashable
Signal = Callable[[float], float]
NOT_NEGATIVE = "zero or a positive number"


class PlanarSection(Declared, by_value=True):
    """Stiffness and mass of a beam in its plane: ``[N, Q, M] = [EA eps, GA gam, EI kap]``.

    Raises
    ------
    InputError
        With all values that are not positive (mass and rotary: not negative).

    Examples
    --------
    >>> PlanarSection(EA=2.8e7, GA=1e7, EI=1.4e4, mass=1.2, rotary=6e-4).limit
    15555555.6
    """

    EA: Positive = field("Axial stiffness", unit="N")
    GA: Positive = field("Shear stiffness with its shear coefficient", unit="N")
    EI: Positive = field("Bending stiffness", unit="N m^2")
    mass: Number = field("Mass of a length", unit="kg/m", least=0, wanted=NOT_NEGATIVE, default=0.0)
    rotary: Number = field(
        "Inertia of a length, rho I", unit="kg m", least=0, wanted=NOT_NEGATIVE, default=0.0
    )

    @classmethod
    def of(cls, section: Section, material: Material, *, GA: float | None = None) -> PlanarSection:
        """Return the stiffness of a section that bends about its z axis.

        Parameters
        ----------
        section : Section
            `Rectangle`, `Circle` and others; y lies in the plane.
        material : Material
        GA : float, optional
            N; by default the shear area ``ky A`` times G.

        Raises
        ------
        InputError
            If the section has no shear coefficient and no GA is given.
        """
        if GA is None:
            problems = Problems()
            if section.ky is None:
                text = "has no shear coefficient ky; give PlanarSection.of(..., GA=) in N"
                problems.add(type(section).__name__, text)
            problems.raise_if_any()
            GA = (section.ky or 0.0) * section.A * material.G
        rho = material.rho
        return cls(
            EA=material.E * section.A,
            GA=GA,
            EI=material.E * section.Iz,
            mass=rho * section.A,
            rotary=rho * section.Iz,
        )

    @property
    def limit(self) -> float:
        """Largest stable axial force, N: ``GA / (1 - GA / EA)``, infinite for GA >= EA.

        Beyond it a stretched beam gains energy by turning its cross sections out of the stretch:
        the tension-shear instability of the linear law, which no material has.
        """
        return math.inf if self.GA >= self.EA else self.GA / (1.0 - self.GA / self.EA)


@dataclass(frozen=True)
class PlanarBeam:
    """One element between two nodes; a beam of many elements is several of them.

    Parameters
    ----------
    a, b : node
        Names of nodes.
    section : PlanarSection
    offset_a, offset_b : (float, float)
        From the node to the end of the axis in the unloaded frame, x and y of the frame in m: the
        end turns with its node (eqs. 20 to 25).
    name : str
        Shown in messages and results.
    """

    a: Node
    b: Node
    section: PlanarSection
    offset_a: tuple[float, float] = (0.0, 0.0)
    offset_b: tuple[float, float] = (0.0, 0.0)
    name: str = ""


@dataclass(frozen=True)
class PlanarSupport:
    """A node whose displacements are held.

    Parameters
    ----------
    node : node
    x, y, rotation : bool
        What is held: a pin by default, ``rotation=True`` clamps.
    """

    node: Node
    x: bool = True
    y: bool = True
    rotation: bool = False


@dataclass(frozen=True)
class PlanarLoad:
    """A force and a moment at a node.

    Parameters
    ----------
    node : node
    force : (float, float)
        N, x and y of the frame, or of the turned node if it follows.
    moment : float
        N m, positive counterclockwise.
    signal : function, optional
        Time in s to a factor, in dynamics; 1 without it. Statics have their own load factor.
    follow : bool
        Whether the force turns with its node.
    """

    node: Node
    force: tuple[float, float] = (0.0, 0.0)
    moment: float = 0.0
    signal: Signal | None = None
    follow: bool = False


@dataclass(frozen=True)
class PlanarMass:
    """A rigid mass at a node.

    Parameters
    ----------
    node : node
    mass : float
        kg.
    inertia : float
        kg m^2 about the node.
    """

    node: Node
    mass: float
    inertia: float = 0.0


@dataclass(frozen=True)
class RigidLink:
    """Nodes that are carried by another one as if by rigid arms.

    Parameters
    ----------
    master : node
    nodes : tuple of nodes
        Their displacements are no unknowns any more.
    rotation : bool
        Whether they turn with the master; False makes hinges, which turn freely.
    """

    master: Node
    nodes: tuple[Node, ...]
    rotation: bool = True


@dataclass(frozen=True, eq=False)
class LinearLink:
    """Displacements of nodes that depend linearly on those of others: ``u = T q + u0``.

    Parameters
    ----------
    nodes, masters : tuple of nodes
        Each with x, y, rotation, in this order.
    T : (3 nodes, 3 masters) array
    u0 : (3 nodes,) array, optional
        m, rad.
    """

    nodes: tuple[Node, ...]
    masters: tuple[Node, ...]
    T: Any
    u0: Any = None


@dataclass(frozen=True, eq=False)
class FunctionLink:
    """Displacements of nodes that are any function of those of others and of own coordinates.

    Parameters
    ----------
    nodes, masters : tuple of nodes
        Each with x, y, rotation, in this order.
    function : function
        ``[x, y, rotation of the masters ..., own coordinates ...]`` to the displacements of the
        nodes, (3 nodes,), written with NumPy; derivatives are found exactly.
    coordinates : tuple of str
        Names of own coordinates, such as how far a slider has come; they start at zero.

    Examples
    --------
    A slider on the straight line from ``p`` to ``q``, both nodes of a frame; it turns with ``p``:

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
    """Damping of all beams, also of what is fixed to them: everything that moves has mass."""


def vector(x: Any) -> np.ndarray[Any, Any]:
    """Return floats of anything like an array."""
    return np.array(x, dtype=float)
