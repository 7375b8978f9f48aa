"""Linear elastic, orthotropic material, and the elasticity matrix of materials."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Field, Label, field
from jousto.base.numbers import Number, Positive
from jousto.base.rotations import Rotate, parse_orientation, rotation_matrix
from jousto.materials.material import Material


class Axes(Field[Any, Array]):
    """Field of three directions of a material: the columns of a matrix, or an orientation."""

    form = "orientation"
    noun = "(3, 3) array_like or orientation"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return an orthonormal right-handed matrix (3, 3), or report what is wrong."""
        if isinstance(value, Rotate) or np.shape(value) == (4,):
            e = parse_orientation(problems, where, self.label, value)
            return None if e is None else rotation_matrix(e)
        given = np.eye(3) if value is None else value
        axes = problems.array(where, self.label, given, (3, 3))
        if axes is None:
            return None
        if np.abs(axes.T @ axes - np.eye(3)).max() > 1e-6:
            problems.add(
                where, "the columns must be unit vectors normal to each other", "axes", named=False
            )
        elif np.linalg.det(axes) < 0.0:
            problems.add(
                where,
                "the columns must be right-handed; change the sign of one",
                "axes",
                named=False,
            )
        return axes


class Orthotropic(Declared, section="materials", tag="orthotropic", kw_only=True):
    """Linear elastic material with three planes of symmetry: composites, wood, printed parts.

    Strains along the material axes: ``e1 = s1/E1 - nu12 s2/E1 - nu13 s3/E1``, ``e2 = -nu12 s1/E1 +
    s2/E2 - nu23 s3/E2``, ``e3 = -nu13 s1/E1 - nu23 s2/E2 + s3/E3``, ``g12 = s12/G12`` and so on:
    ``nu12`` is the ratio of the contraction along 2 to the extension along 1, under tension along
    1.

    Raises
    ------
    InputError
        If a value is out of range, the axes are not orthonormal and right-handed, or the compliance
        matrix is not positive definite.

    Examples
    --------
    >>> spruce = Orthotropic(E1=11e9, E2=0.9e9, E3=0.5e9, nu12=0.37, nu13=0.42, nu23=0.47,
    ...                      G12=0.75e9, G13=0.72e9, G23=0.04e9, rho=450.0, name="spruce")
    >>> elasticity(spruce).shape
    (6, 6)
    """

    kind = "material"
    E1: Positive = field("Young's modulus along the material axis 1", unit="Pa")
    E2: Positive = field("Young's modulus along the material axis 2", unit="Pa")
    E3: Positive = field("Young's modulus along the material axis 3", unit="Pa")
    nu12: Number = field("Poisson's ratio, contraction along 2 under tension along 1")
    nu13: Number = field("Poisson's ratio, contraction along 3 under tension along 1")
    nu23: Number = field("Poisson's ratio, contraction along 3 under tension along 2")
    G12: Positive = field("Shear modulus in the plane of the axes 1 and 2", unit="Pa")
    G13: Positive = field("Shear modulus in the plane of the axes 1 and 3", unit="Pa")
    G23: Positive = field("Shear modulus in the plane of the axes 2 and 3", unit="Pa")
    rho: Number = field(
        "Density", unit="kg/m^3", least=0, label="density rho", wanted="zero or positive"
    )
    axes: Axes = field(
        "Columns are the material axes 1, 2, 3, resolved in the part frame; None for the axes "
        "of the part",
        default=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    )
    name: Label = field("Name, for messages", default="")

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a compliance matrix that is not positive definite."""
        lowest = float(np.linalg.eigvalsh(self._scaled_compliance()).min())
        if lowest <= 1e-12:
            problems.add(
                where,
                "Poisson's ratios are too large for the moduli, the compliance is not positive "
                "definite: |nu12| must be below sqrt(E1/E2), |nu13| below sqrt(E1/E3), |nu23| "
                "below sqrt(E2/E3), and all three together smaller still; nu_ij is the "
                "contraction along j under tension along i (perhaps nu_ji was given)",
            )

    def _scaled_compliance(self) -> Array:
        E = np.sqrt([self.E1, self.E2, self.E3])
        S = np.eye(3)
        for i, j, nu in ((0, 1, self.nu12), (0, 2, self.nu13), (1, 2, self.nu23)):
            S[i, j] = S[j, i] = -nu / E[i] ** 2 * E[i] * E[j]
        return S


def elasticity(material: Material | Orthotropic) -> Array:
    """Return the elasticity matrix C (6, 6) in Pa, part axes.

    ``[s11 s22 s33 s12 s23 s13] = C [e11 e22 e33 g12 g23 g13]`` with engineering shear strains g.
    """
    C = np.zeros((6, 6))
    if isinstance(material, Material):
        nu, E = material.nu, material.E
        lam = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
        C[:3, :3] = lam
        C[range(3), range(3)] += 2.0 * material.G
        C[range(3, 6), range(3, 6)] = material.G
        return C
    root = np.sqrt([material.E1, material.E2, material.E3])
    C[:3, :3] = root[:, None] * np.linalg.inv(material._scaled_compliance()) * root
    C[range(3, 6), range(3, 6)] = material.G12, material.G23, material.G13
    R = np.asarray(material.axes)
    if np.array_equal(R, np.eye(3)):
        return C
    T = strain_rotation(R)
    return np.asarray(T.T @ C @ T)


def strain_rotation(R: Array) -> Array:
    """Return T (6, 6), which converts strains in part axes to strains in the axes R (columns).

    Shear strains are engineering strains. Stresses in part axes are ``T^T`` times those in the axes
    R.
    """
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
    T = np.zeros((6, 6))
    for column, (i, j) in enumerate(pairs):
        e = np.zeros((3, 3))
        e[i, j] += 0.5
        e[j, i] += 0.5
        turned = R.T @ e @ R
        for row, (a, b) in enumerate(pairs):
            T[row, column] = turned[a, b] if a == b else 2.0 * turned[a, b]
    return T
