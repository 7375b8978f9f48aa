"""Beam element with 2 nodes and 12 degrees of freedom in space, for all elements at once.

Local axes: x from end a to end b, z towards the orientation vector, y = z cross x. Degrees of
freedom of an element: ``[ux uy uz rx ry rz]`` at end a, then at end b. All matrices are in closed
form.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arrays import Array, skew, transposed
from jousto.base.complexstep import norm
from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Field, field
from jousto.base.numbers import OptionalPositive
from jousto.base.object_repr import described

# largest number of elements of a member or beam, a hundred times a reasonable number
MOST_ELEMENTS = 100_000


def check_elements(problems: Problems, where: str, value: Any) -> bool:
    """Return whether a number of elements is a whole number in the allowed range; report others."""
    try:
        good = not isinstance(value, bool) and value == int(value) and value >= 1
    except (TypeError, ValueError, OverflowError):
        good = False
    if not good:
        problems.add(where, f"elements is {value!r}, must be a whole number from 1", "elements")
    elif value > MOST_ELEMENTS:
        problems.add(where, f"elements is {value}, must be at most {MOST_ELEMENTS}", "elements")
        return False
    return good


class Elements(Field[int, int]):
    """Field of a number of elements; see `check_elements`."""

    form = "count"
    noun = "int"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the number, or report what is wrong."""
        return int(value) if check_elements(problems, where, value) else None


class Timoshenko(Declared, section="theories", tag="timoshenko", by_value=True):
    """Beam theory with shear deformation.

    Raises
    ------
    InputError
        If a coefficient is not a positive number.

    Examples
    --------
    >>> Timoshenko(ky=0.85, kz=0.85)
    Timoshenko(ky=0.85, kz=0.85)
    """

    ky: OptionalPositive = field(
        "Shear coefficient along y of all sections; None for the coefficient of each section",
        label="shear coefficient ky",
        default=None,
    )
    kz: OptionalPositive = field(
        "Shear coefficient along z; see ky", label="shear coefficient kz", default=None
    )


class EulerBernoulli(Declared, section="theories", tag="euler-bernoulli", by_value=True):
    """Slender-beam theory: sections stay normal to the axis, without shear deformation.

    Examples
    --------
    >>> EulerBernoulli()
    EulerBernoulli()
    """


Theory = EulerBernoulli | Timoshenko


@described
@dataclass(frozen=True, eq=False)
class BeamElements:
    """Elements of a frame as arrays; its builder checks the data.

    Attributes
    ----------
    origin : (ne, 3) ndarray
        Position of the flexible end a in m, part frame.
    axes : (ne, 3, 3) ndarray
        Columns are the local x, y and z axes, resolved in the part frame.
    length : (ne,) ndarray
        Flexible length in m.
    offsets : (ne, 2, 3) ndarray
        Rigid arms from the nodes to the flexible ends a and b in m, part frame.
    EA, GJ, EIy, EIz : (ne,) ndarray
        Axial stiffness in N; torsional and bending stiffness in N m^2.
    phi : (ne, 2) ndarray
        Shear parameters 12 E Iz / (G ky A L^2) for bending in the local xy plane and
        12 E Iy / (G kz A L^2) for the xz plane; zero in Euler-Bernoulli theory.
    """

    origin: Array
    axes: Array
    length: Array
    offsets: Array
    EA: Array
    GJ: Array
    EIy: Array
    EIz: Array
    phi: Array

    def __len__(self) -> int:
        return len(self.length)

    @property
    def kind(self) -> Any:
        """Scalar type of the arrays."""
        return np.result_type(*vars(self).values())


def local_axes(direction: Array, orientation: Array) -> Array:
    """Return the local axes of members; NaN for a member parallel to its orientation vector.

    Parameters
    ----------
    direction : (ne, 3) ndarray
        From end a to end b, part frame, any length.
    orientation : (ne, 3) ndarray
        Vector near the local z axis; z is its component normal to the member, part frame.

    Returns
    -------
    (ne, 3, 3) ndarray
        Columns are the local x, y, z axes.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        x = direction / norm(direction, axis=1)[:, None]
        y = np.cross(orientation / norm(orientation, axis=1)[:, None], x)
        sine = norm(y, axis=1)[:, None]
        y = y / np.where(sine > 1e-6, sine, np.nan)
    return np.stack([x, y, np.cross(x, y)], axis=-1)


def default_orientation(direction: Array) -> Array:
    """Return the default orientation vectors (ne, 3) of members.

    The vector is (0, 0, 1), or (1, 0, 0) for members parallel to z.
    """
    up = np.tile([0.0, 0.0, 1.0], (len(direction), 1))
    across = np.linalg.norm(direction[:, :2], axis=1)
    up[across <= 1e-6 * np.linalg.norm(direction, axis=1)] = [1.0, 0.0, 0.0]
    return up


def stiffness(beams: BeamElements) -> Array:
    """Return the element stiffness matrices in local axes, (ne, 12, 12).

    Przemieniecki, *Theory of Matrix Structural Analysis* (1968), chapter 5, with the shear
    parameters ``phi``; exact for a prismatic member loaded at its ends.
    """
    L = beams.length
    k = np.zeros((len(beams), 12, 12), beams.kind)

    def pair(i: int, j: int, value: Array) -> None:
        k[:, i, j] += value
        if i != j:
            k[:, j, i] += value

    # axial force and torsion
    for i, s in ((0, beams.EA / L), (3, beams.GJ / L)):
        pair(i, i, s)
        pair(i + 6, i + 6, s)
        pair(i, i + 6, -s)

    # bending; in the xz plane ry = -dw/dx, so the coupling terms change sign
    for v, r, EI, phi, sign in (
        (1, 5, beams.EIz, beams.phi[:, 0], 1.0),
        (2, 4, beams.EIy, beams.phi[:, 1], -1.0),
    ):
        c = EI / (L**3 * (1.0 + phi))
        pair(v, v, 12.0 * c)
        pair(v + 6, v + 6, 12.0 * c)
        pair(v, v + 6, -12.0 * c)
        for i, value in ((v, 6.0 * c * L), (v + 6, -6.0 * c * L)):
            pair(i, r, sign * value)
            pair(i, r + 6, sign * value)
        pair(r, r, (4.0 + phi) * c * L**2)
        pair(r + 6, r + 6, (4.0 + phi) * c * L**2)
        pair(r, r + 6, (2.0 - phi) * c * L**2)
    return k


def shape_functions(beams: BeamElements, xi: float) -> Array:
    """Return the shape functions of section translation and rotation at x = xi L.

    They are linear in stretch and twist; in bending they are the cubic and quadratic polynomials
    that solve the static Timoshenko equations without load between the ends: Friedman and Kosmatka,
    *Computers & Structures* 47 (1993) 473-481. For ``phi = 0`` they are the Hermite
    polynomials and the rotation is the slope.

    With these functions the frequencies of refined Euler-Bernoulli beams converge with the fourth
    order. The frequencies of Timoshenko beams converge with the second order once the element
    length is about the section height, because the shear force is constant within an element.

    Parameters
    ----------
    beams : BeamElements
    xi : float
        Position along the element, 0 at end a and 1 at end b.

    Returns
    -------
    (ne, 6, 12) ndarray
        ``[ux uy uz rx ry rz]`` of the section, local axes, from the element's end displacements,
        local axes.
    """
    L = beams.length
    N = np.zeros((len(beams), 6, 12), beams.kind)
    for i in (0, 3):
        N[:, i, i] = 1.0 - xi
        N[:, i, i + 6] = xi
    for v, r, phi, sign in ((1, 5, beams.phi[:, 0], 1.0), (2, 4, beams.phi[:, 1], -1.0)):
        f = 1.0 / (1.0 + phi)
        # deflection from the end deflections and end rotations
        N[:, v, v] = f * (1.0 - 3.0 * xi**2 + 2.0 * xi**3 + phi * (1.0 - xi))
        N[:, v, v + 6] = f * (3.0 * xi**2 - 2.0 * xi**3 + phi * xi)
        N[:, v, r] = sign * f * L * (xi - 2.0 * xi**2 + xi**3 + 0.5 * phi * (xi - xi**2))
        N[:, v, r + 6] = sign * f * L * (xi**3 - xi**2 - 0.5 * phi * (xi - xi**2))
        # rotation of the section
        N[:, r, v] = sign * f * 6.0 * (xi**2 - xi) / L
        N[:, r, v + 6] = -N[:, r, v]
        N[:, r, r] = f * (1.0 - 4.0 * xi + 3.0 * xi**2 + phi * (1.0 - xi))
        N[:, r, r + 6] = f * (3.0 * xi**2 - 2.0 * xi + phi * xi)
    return N


def slopes(beams: BeamElements, xi: float) -> Array:
    """Return the derivatives along the element of deflection and twist at x = xi L.

    Parameters
    ----------
    beams : BeamElements
    xi : float
        Position along the element, 0 at end a and 1 at end b.

    Returns
    -------
    (ne, 3, 12) ndarray
        ``[dv/dx dw/dx drx/dx]``, local axes, from the element's end displacements, local axes.
    """
    L = beams.length
    N = np.zeros((len(beams), 3, 12), beams.kind)
    for row, v, r, phi, sign in ((0, 1, 5, beams.phi[:, 0], 1.0), (1, 2, 4, beams.phi[:, 1], -1.0)):
        f = 1.0 / (1.0 + phi)
        N[:, row, v] = f * (6.0 * (xi**2 - xi) - phi) / L
        N[:, row, v + 6] = -N[:, row, v]
        N[:, row, r] = sign * f * (1.0 - 4.0 * xi + 3.0 * xi**2 + phi * (0.5 - xi))
        N[:, row, r + 6] = sign * f * (3.0 * xi**2 - 2.0 * xi - phi * (0.5 - xi))
    N[:, 2, 3], N[:, 2, 9] = -1.0 / L, 1.0 / L
    return N


def end_displacements(beams: BeamElements) -> Array:
    """Return the matrices (ne, 12, 12) from nodal displacements to local end displacements.

    ``u_end = u_node + r_node cross offset`` in the part frame, then resolved in local axes.
    """
    B = np.zeros((len(beams), 12, 12), beams.kind)
    to_local = transposed(beams.axes)
    for end in (0, 1):
        u, r = slice(6 * end, 6 * end + 3), slice(6 * end + 3, 6 * end + 6)
        B[:, u, u] = to_local
        B[:, u, r] = -to_local @ skew(beams.offsets[:, end])
        B[:, r, r] = to_local
    return B
