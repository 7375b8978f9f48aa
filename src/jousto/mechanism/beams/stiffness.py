"""Sections of geometrically exact beams: stiffness (6, 6) and inertia per length.

Section axes: x along the beam, y to the left and z up when looking along x. Strains are
``e = [Gamma_x, Gamma_y, Gamma_z, kappa_x, kappa_y, kappa_z]`` of the reference axis, resultants
``s = [N, Qy, Qz, Mx, My, Mz]``, both resolved in section axes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array, read_only
from jousto.base.declare import Declared, maker
from jousto.base.errors import Problems, warn
from jousto.base.fields import AnyField, Field, Items, field
from jousto.base.numbers import DefaultValues, Number, OptionalValues, Values, set_fields
from jousto.materials.library import by_name
from jousto.materials.material import Material
from jousto.mechanism.bodies.base import Inertia, Mass
from jousto.sections.points import StressPoint, section_outline, stress_points
from jousto.sections.section import is_section

# m/s, speed of axial waves that no solid exceeds
FASTEST_WAVE = 5e4
# relative tolerance of the polar moments of a flat section with proportional mass and stiffness
MOMENTS, ALIKE = 0.01, 0.01
# ratio of polar to (EIy + EIz)/EA (or its inverse) above which polar is probably another quantity
POLAR = 10.0
# smallest eigenvalue of a stiffness scaled to unit diagonal
SINGULAR = 1e-13


class Stiffness(Field[ArrayLike, Array]):
    """Field of a symmetric, positive definite matrix (6, 6), or its diagonal (6,)."""

    form = "shapes"
    noun = "(6, 6) or (6,) array_like"
    shapes = ((6,), (6, 6))

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the matrix (6, 6), or report what is wrong."""
        return _stiffness(problems, where, value)


class OffsetSection(Declared, section="beam sections", tag="offset"):
    """Section of one material with offsets of centroid and shear centre from the reference axis.

    With the strains at the centroid and at the shear centre, ``Gamma_x + z_c kappa_y - y_c
    kappa_z`` and ``Gamma_y - z_s kappa_x, Gamma_z + y_s kappa_x``, the stiffness is
    ``C = T^T diag(EA, ky GA, kz GA, GJ, EIy, EIz) T``.

    Raises
    ------
    InputError
        Without shear coefficients or density.

    Examples
    --------
    >>> from jousto import Material, Rectangle
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> offset = BeamSection.of(Rectangle(0.02, 0.01), steel, centroid=(0.0, 0.1))
    >>> bool(np.isclose(offset.stiffness[0, 4], 210e9 * 2e-4 * 0.1))
    True
    """

    together = ("section", "material")
    section: AnyField = field(
        "Section constants about the centroid and principal axes, which are the section axes",
        form="section",
        noun="Section",
    )
    material: AnyField = field(
        "Material; its density must not be zero", form="material", noun="Material"
    )
    centroid: Values = field(
        "Position (y, z) of the centroid relative to the reference axis; also the mass centre",
        unit="m",
        shape=(2,),
        default=(0.0, 0.0),
        kw_only=True,
    )
    shear_center: OptionalValues = field(
        "Position (y, z) of the shear centre relative to the reference axis; None for the centroid",
        unit="m",
        shape=(2,),
        default=None,
        kw_only=True,
    )
    fibres: AnyField = field(
        "Whether the stretch of the fibres by twist is included, ``polar = (Iy + Iz)/A + |s - "
        "c|^2``",
        form="flag",
        noun="bool",
        default=True,
        kw_only=True,
    )

    def heading(self, problems: Problems) -> str:
        """Return the prefix of messages."""
        return f"section {type(self.section).__name__}"

    def consistent(self, problems: Problems, where: str) -> None:
        """Report wrong sections and materials, and their missing values."""
        section, material = self.section, self.material
        if not is_section(section):
            problems.add(
                where,
                f"is {section!r}, must be a section such as Rectangle, Tube or GeneralSection, or "
                "a BeamSection",
            )
        if not isinstance(material, Material):
            problems.add(
                where,
                f"material is {material!r}, must be a Material{by_name(material)}",
                "material",
            )
        if problems.found:
            return
        for name in ("ky", "kz"):
            if getattr(section, name) is None:
                problems.add(
                    where,
                    f"{name} is missing: an exact beam has shear; give the shear coefficients, "
                    "GeneralSection(..., ky=5/6, kz=5/6)",
                    name,
                )
        if material.rho == 0.0:
            problems.add(where, "rho is 0: an exact beam needs mass; give the density", "material")

    @property
    def made(self) -> BeamSection:
        """Stiffness and inertia of the section."""
        section, material, c = self.section, self.material, self.centroid
        s = c if self.shear_center is None else self.shear_center
        E, G, rho = material.E, material.G, material.rho
        A, Iy, Iz = section.A, section.Iy, section.Iz
        D = np.diag([E * A, section.ky * G * A, section.kz * G * A, G * section.J, E * Iy, E * Iz])
        T = shifted_strains(c, s)
        return BeamSection(
            T.T @ D @ T,
            rho * A,
            (rho * (Iy + Iz), rho * Iy, rho * Iz),
            center=c,
            points=stress_points(section, (c[0], c[1]), (s[0], s[1])),
            outline=section_outline(section, (c[0], c[1])),
            elasticity=(E, material.nu),
            polar=float((Iy + Iz) / A + (c - s) @ (c - s)) if self.fibres else 0.0,
        )


class BeamSection(Declared, section="beam sections", tag="stiffness"):
    """Stiffness and inertia of a beam section, also of composite or offset sections.

    ``s = C e``: resultants ``[N, Qy, Qz, Mx, My, Mz]`` from the strains of the reference axis
    ``[Gamma_x, Gamma_y, Gamma_z, kappa_x, kappa_y, kappa_z]``, both in section axes.

    Raises
    ------
    InputError
        If the stiffness is not symmetric or not positive definite, the mass is not positive, or the
        inertia is unphysical.

    Warns
    -----
    JoustoWarning
        If the inertia about x differs from the sum of the other two, or `polar` from the value of
        the stiffness: by more than 1 % where mass and stiffness have the same distribution, by a
        factor of ten in other sections.

    Examples
    --------
    >>> section = BeamSection((2.8e7, 1e7, 1e7, 2e4, 1.4e4, 1.4e4), 1.2, (1.2e-3, 6e-4, 6e-4))
    >>> section
    <BeamSection: 1.2 kg/m, EA 2.8e+07 N>
    """

    stiffness: Stiffness = field(
        "C, symmetric and positive definite, in N, N m and N m2; six numbers are the diagonal "
        "``EA, GAy, GAz, GJ, EIy, EIz``"
    )
    mass: Mass = field("Mass per length", unit="kg/m")
    inertia: Inertia = field(
        "Rotary inertia per length about the mass centre, section axes: three moments or a 3 x 3 "
        "tensor. A homogeneous section has ``rho (Iy + Iz), rho Iy, rho Iz``; in any flat section "
        "the first is the sum of the other two, not rho times the torsion constant",
        unit="kg m",
    )
    center: Values = field(
        "Position (y, z) of the mass centre relative to the reference axis",
        unit="m",
        shape=(2,),
        default=(0.0, 0.0),
        kw_only=True,
    )
    points: Items[StressPoint] = field(
        "Points of the section where stress is recovered, with the stress per unit resultant",
        default=(),
        kw_only=True,
    )
    outline: DefaultValues = field(
        "Outline (y, z) of the section for drawings, counterclockwise seen against x; None for a "
        "rectangle of the same rotary inertia",
        unit="m",
        shape=(None, 2),
        default=None,
        kw_only=True,
    )
    elasticity: AnyField = field(
        "Young's modulus, Pa, and Poisson's ratio, for strain gauges; None without gauges",
        form="elasticity",
        noun="(float, float)",
        default=None,
        kw_only=True,
    )
    polar: Number = field(
        "``(Iy + Iz)/A`` about the shear centre. A twist kappa stretches the fibres by ``polar "
        "kappa^2 / 2`` on average, so that a tension N raises the torsional stiffness to ``GJ + N "
        "polar`` (Wagner 1929, Biot 1939). 0 leaves this effect out",
        unit="m2",
        least=0,
        wanted="zero or positive",
        default=0.0,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Create an outline if there is none; warn about values in other units."""
        if vars(self)["outline"] is None:
            y, z = np.sqrt(3.0 * np.diag(self.inertia)[[2, 1]] / self.mass)
            edge = self.center + np.array([[-y, -z], [y, -z], [y, z], [-y, z]])
            set_fields(self, outline=read_only(edge))
        _warn_units(where, self.stiffness, self.mass)
        _warn_moments(where, self)

    def __repr__(self) -> str:
        return f"<BeamSection: {self.mass:g} kg/m, EA {self.stiffness[0, 0]:g} N>"

    of = staticmethod(maker("BeamSection.of", OffsetSection))

    def with_bending(self, length: float) -> Array:
        """Return the stiffness (6, 6) of an element with the residual bending flexibility.

        A shear force Q bends an element of length L between its middle and its ends, which the
        constant strain of the element does not represent. MacNeal's correction (*Computers &
        Structures* 8 (1978) 175-183) adds this flexibility to that of shear, ``F_QQ += L^2/12 P^T
        F_MM P``, with ``P Q = (0, Qz, -Qy)`` the slope of the moments: under end loads the element
        then deflects like a cubic beam element.
        """
        F = np.linalg.inv(self.stiffness)
        P = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
        F[:3, :3] += length**2 / 12 * P.T @ F[3:, 3:] @ P
        C = np.linalg.inv(F)
        return np.asarray((C + C.T) / 2)


def as_beam_section(section: Any, material: Any) -> BeamSection:
    """Return a BeamSection from the section and material given by a user; raises InputError."""
    if isinstance(section, BeamSection):
        if material is not None:
            problems = Problems()
            problems.add(
                "section",
                "a BeamSection contains its stiffness and mass, leave material out",
                "material",
                named=False,
            )
            problems.raise_if_any()
        return section
    return BeamSection.of(section, material)


def shifted_strains(centroid: ArrayLike, shear_center: ArrayLike) -> Array:
    """Return T (6, 6), which converts strains of the reference axis to those at the two centres."""
    (yc, zc), (ys, zs) = np.asarray(centroid), np.asarray(shear_center)
    T = np.eye(6)
    T[0, 4], T[0, 5] = zc, -yc
    T[1, 3], T[2, 3] = -zs, ys
    return T


def tension_factor(C: Array) -> float:
    """Return ``1/GA - 1/EA``, 1/N: the linear law is unstable if tension times it exceeds 1.

    GA is the shear stiffness of the weaker direction; the result is 0 if shear is stiffer than
    extension. A straight beam under tension becomes unstable in shear at ``N > GA/(1 - GA/EA)``.
    """
    F = np.linalg.inv(C)
    return max(0.0, float(np.linalg.eigvalsh(F[1:3, 1:3])[-1] - F[0, 0]))


def _stiffness(problems: Problems, where: str, stiffness: ArrayLike) -> Array | None:
    """Return the checked stiffness (6, 6), or report what is wrong."""
    try:
        shape = np.shape(stiffness)
    except ValueError:
        shape = ()
    given = problems.array(where, "stiffness", stiffness, (6,) if shape == (6,) else (6, 6))
    if given is None:
        return None
    C = np.diag(given) if shape == (6,) else given
    names = ("N", "Qy", "Qz", "Mx", "My", "Mz")
    diagonal = np.diag(C)
    for i in np.flatnonzero(diagonal <= 0):
        problems.add(
            where, f"stiffness of {names[i]} is {diagonal[i]:g}, must be positive", "stiffness"
        )
    if np.any(diagonal <= 0):
        return None
    scaled = C / np.sqrt(np.outer(diagonal, diagonal))
    if np.abs(scaled - scaled.T).max() > 1e-9:
        i, j = np.unravel_index(int(np.argmax(np.abs(scaled - scaled.T))), (6, 6))
        problems.add(
            where,
            f"stiffness is not symmetric: element ({i + 1},{j + 1}) is {C[i, j]:g}, "
            f"({j + 1},{i + 1}) is {C[j, i]:g}",
            "stiffness",
        )
        return None
    values, vectors = np.linalg.eigh((scaled + scaled.T) / 2)
    if values[0] <= SINGULAR:
        worst = np.argsort(-np.abs(vectors[:, 0]))[:2]
        problems.add(
            where,
            f"stiffness is not positive definite (smallest eigenvalue {values[0]:.3g} with a "
            f"diagonal of ones, in {names[worst[0]]} and {names[worst[1]]}); check the signs and "
            "sizes of its coupling terms",
            "stiffness",
        )
        return None
    return read_only((C + C.T) / 2)


def _warn_units(where: str, C: Array, mass: float) -> None:
    """Warn if axial waves in the beam would be faster than in any solid."""
    speed = float(np.sqrt(C[0, 0] / mass))
    if speed > FASTEST_WAVE:
        warn(
            where,
            f"EA = {C[0, 0]:g} N and {mass:g} kg/m mean axial waves of {speed:.3g} m/s, faster "
            f"than in any solid; use SI units, N and kg/m",
            "EA",
        )


def _warn_moments(where: str, section: BeamSection) -> None:
    """Warn if the polar moments are not the sums of the moments about y and z."""
    Jx, Jy, Jz = np.diag(section.inertia)
    if abs(Jx - Jy - Jz) > MOMENTS * (Jy + Jz):
        warn(
            where,
            f"inertia about x is {Jx:.4g} kg m, those about y and z together {Jy + Jz:.4g}: in a "
            f"flat section it is their sum; give rho (Iy + Iz), not rho times the torsion "
            "constant, all about the mass centre",
            "inertia",
        )
    if not section.polar:
        return
    across, expected = _gyration(section.stiffness)
    around = np.linalg.eigvalsh(section.inertia[1:, 1:]) / section.mass
    alike = np.allclose(around, across, rtol=ALIKE)
    ratio = section.polar / expected
    if (abs(ratio - 1.0) > MOMENTS) if alike else not 1.0 / POLAR < ratio < POLAR:
        warn(
            where,
            f"polar is {section.polar:.4g} m2, but the stiffness means {expected:.4g} m2: polar "
            f"is (Iy + Iz)/A about the shear centre, not Iy + Iz and not the torsion constant",
            "polar",
        )


def _gyration(C: Array) -> tuple[Array, float]:
    """Return the squared radii of gyration of a stiffness, m2, and the sum for polar inertia.

    The squared radii are ``(EI)/EA`` of bending without axial force, about the centroid, ascending;
    the sum includes the squared distance from centroid to shear centre.
    """
    bending = C[4:, 4:] - np.outer(C[4:, 0], C[0, 4:]) / C[0, 0]
    squares = np.linalg.eigvalsh(bending) / C[0, 0]
    centroid = np.array([-C[0, 5], C[0, 4]]) / C[0, 0]
    # shear centre, through which shear forces cause no twist: Gamma_s = Gamma + kappa_x x s
    twist = np.linalg.solve(C[1:3, 1:3], C[1:3, 3])
    centre = np.array([twist[1], -twist[0]])
    return squares, float(squares.sum() + (centroid - centre) @ (centroid - centre))
