"""Critical planes: stress on all planes through a point, and the plane of crack initiation.

On a plane of normal n the traction ``t = S n`` has the normal stress ``n . t`` and the shear vector
``t - n (n . t)``, whose path is a closed curve in the plane. The shear amplitude is the radius of
the smallest circle around this curve, which is valid for non-proportional loading too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.errors import InputError, Problem, Problems, warn
from jousto.base.fields import field
from jousto.base.files import Rows, Tabular
from jousto.base.numbers import Number, Positive
from jousto.base.object_repr import described
from jousto.base.ranking import largest, ranking
from jousto.fatigue.multiaxial.enclosing_ball import enclosing_ball, enclosing_circles
from jousto.materials.strength.strain_life import StrainLife
from jousto.recovery.fields.planes import positive_normal

BLOCK_BYTES = 64 << 20  # memory for the stresses on planes evaluated at a time, bytes
COARSE = math.radians(9.0)  # angle between normals of the first search, rad
PLANE_TIE = 1e-7  # relative difference of values on the finest grid (0.01 degrees) that are equal
SENSITIVITY = "in [0, 10]"
VOIGT = ((0, 3, 5), (3, 1, 4), (5, 4, 2))


class Findley(Declared, by_value=True):
    """Findley's criterion: shear amplitude plus k times the largest normal stress.

    ``f = max over planes of (t_a + k s_n,max)`` (W. N. Findley, *J. Eng. Ind.* 81 (1959) 301-306).

    Examples
    --------
    >>> round(Findley.of(torsion=155e6, bending=250e6).k, 3)
    0.247
    """

    k: Number = field(
        "Sensitivity to normal stress; 0.2 to 0.3 for ductile steels",
        least=0,
        most=10,
        wanted=SENSITIVITY,
        default=0.3,
    )

    @classmethod
    def of(cls, torsion: float, bending: float) -> Findley:
        """Return the criterion of a material from its fatigue limits at R = -1, Pa."""
        ratio = 2.0 * _ratio("Findley", torsion, bending) - 1.0
        return cls(ratio / math.sqrt(1.0 - ratio * ratio))

    def value(self, shear: ArrayLike, normal: ArrayLike) -> Array:
        """Return f (Pa) of shear amplitude and largest normal stress of a plane, Pa."""
        return np.maximum(np.asarray(shear) + self.k * np.asarray(normal), 0.0)

    def equivalent(self, value: ArrayLike) -> Array:
        """Return the uniaxial stress amplitude at R = -1 with the same parameter f, Pa.

        The amplitude, for an S-N curve of alternating tension, is ``2 f / (k + sqrt(1 + k^2))``.
        """
        return np.asarray(2.0 * np.asarray(value) / (self.k + math.sqrt(1.0 + self.k**2)))


class FatemiSocie(Declared, by_value=True):
    """Fatemi and Socie's criterion: shear strain amplitude, increased by the normal stress.

    ``max over planes of g_a (1 + k s_n,max / S_y)`` (*Fatigue Fract. Eng. Mater. Struct.* 11 (1988)
    149-165) with elastic strains ``g = t / G``.
    """

    S_y: Positive = field("Yield stress", unit="Pa", label="yield stress S_y")
    E: Positive = field("Young's modulus", unit="Pa", label="Young's modulus E")
    nu: Number = field(
        "Poisson's ratio", above=-1, below=0.5, wanted="above -1 and below 0.5", default=0.3
    )
    k: Number = field(
        "Sensitivity to normal stress; 0.6 to 1 for steels",
        least=0,
        most=10,
        wanted=SENSITIVITY,
        default=1.0,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Warn of a yield stress that is probably in MPa."""
        if self.S_y < 1e5:
            warn("FatemiSocie", f"S_y = {self.S_y:g} Pa is very low; was it given in MPa?")

    @property
    def G(self) -> float:
        """Shear modulus, Pa."""
        return self.E / (2.0 * (1.0 + self.nu))

    def value(self, shear: ArrayLike, normal: ArrayLike) -> Array:
        """Return the parameter of shear stress amplitude and largest normal stress, Pa."""
        opened = np.maximum(1.0 + self.k * np.asarray(normal) / self.S_y, 0.0)
        return np.asarray(np.asarray(shear) / self.G * opened)

    def cycles(self, value: ArrayLike, material: StrainLife) -> Array:
        """Return the life (cycles) of a parameter on the shear strain-life curve of a material.

        ``t_f/G (2N)^b + g_f (2N)^c`` with ``t_f = sf / sqrt(3)`` and ``g_f = sqrt(3) ef``.
        """
        root = math.sqrt(3.0)
        K, n = material.hardening
        shear = StrainLife(
            self.G, material.sf / root, material.b, root * material.ef, material.c, K, n
        )
        return shear.cycles(value)


@dataclass(frozen=True)
class NormalStress:
    """Criterion of brittle materials and welds: the largest normal stress amplitude.

    ``max over planes of s_n,a``; a mean stress correction may follow.
    """

    def value(self, shear: ArrayLike, normal: ArrayLike) -> Array:
        """Return the normal stress amplitude, which the caller passes as `shear`."""
        return np.asarray(shear, dtype=np.float64)

    def equivalent(self, value: ArrayLike) -> Array:
        """Return the uniaxial stress amplitude, Pa, which equals the value."""
        return np.asarray(value, dtype=np.float64)


class DangVan(Declared, by_value=True):
    """Dang Van's criterion: infinite life if ``max_t (t(t) + a s_h(t)) <= b``.

    t is the Tresca shear stress in a grain after shakedown. Its residual stress is the centre of
    the smallest ball around the path of the stress deviator; s_h is the hydrostatic stress (K. Dang
    Van et al., ASTM STP 1020 (1989) 72-102).

    Examples
    --------
    >>> round(DangVan.of(torsion=155e6, bending=250e6).a, 2)
    0.36
    """

    a: Number = field("Sensitivity to hydrostatic stress", least=0, most=10, wanted=SENSITIVITY)
    b: Positive = field("Fatigue limit in torsion at R = -1", unit="Pa", label="fatigue limit b")

    @classmethod
    def of(cls, torsion: float, bending: float) -> DangVan:
        """Return the criterion of a material from its fatigue limits at R = -1, Pa."""
        return cls(3.0 * (_ratio("DangVan", torsion, bending) - 0.5), torsion)


class PlaneCriterion(Protocol):
    """Interface of a criterion on planes."""

    def value(self, shear: ArrayLike, normal: ArrayLike) -> Array:
        """Return the parameter of a plane from shear amplitude and largest normal stress, Pa."""
        ...


def _ratio(where: str, torsion: float, bending: float) -> float:
    problems = Problems()
    problems.positive(where, "fatigue limit in torsion", torsion, "Pa")
    problems.positive(where, "fatigue limit in bending", bending, "Pa")
    problems.raise_if_any()
    if not 0.5 <= torsion / bending < 1.0:
        raise InputError(
            Problem(
                where,
                f"torsion / bending is {torsion / bending:g}; the criterion needs 0.5 (no "
                "influence of the normal stress) to 1 (brittle)",
            )
        )
    return torsion / bending


def normals(step: float = COARSE) -> Array:
    """Return about evenly distributed unit normals (m, 3) on a half-sphere, `step` in rad.

    The normals are sorted by `nearness`, which decides among planes of equal value.
    """
    rings = max(2, round(0.5 * math.pi / step))
    out = [np.array([[0.0, 0.0, 1.0]])]
    for ring in range(1, rings + 1):
        theta = 0.5 * math.pi * ring / rings
        # opposite normals on the equator belong to the same plane, so half of the circle is enough
        turn = math.pi if ring == rings else 2.0 * math.pi
        count = max(3, round(turn * math.sin(theta) / step))
        phi = np.arange(count) * turn / count
        s, c = math.sin(theta), math.cos(theta)
        out.append(np.stack([s * np.cos(phi), s * np.sin(phi), np.full(count, c)], axis=1))
    n = np.concatenate(out)
    return n[sorted(range(len(n)), key=lambda i: nearness(n[i]), reverse=True)]


def nearness(normal: Array) -> tuple[float, ...]:
    """Return a sort key: largest for the normal nearest to the first axis, then the second.

    Among mirrored normals positive components come first. Components are rounded to 1e-3, which is
    above the difference of two normals of one plane on the finest grid.
    """
    n = positive_normal(normal).round(3)
    return (*np.abs(n).tolist(), *n.tolist())


def tangents(n: Array) -> tuple[Array, Array]:
    """Return two unit vectors (m, 3) in each plane."""
    helper = np.where(np.abs(n[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    u = np.cross(helper, n)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    return u, np.cross(n, u)


def plane_rows(n: Array) -> Array:
    """Return rows (m, 3, 6) of the normal stress and the shear along two tangents of planes."""
    u, v = tangents(n)

    def rows(a: Array) -> Array:
        """Return the rows of ``a . S n`` over the Voigt components."""
        return np.stack(
            [
                a[:, 0] * n[:, 0],
                a[:, 1] * n[:, 1],
                a[:, 2] * n[:, 2],
                a[:, 0] * n[:, 1] + a[:, 1] * n[:, 0],
                a[:, 1] * n[:, 2] + a[:, 2] * n[:, 1],
                a[:, 0] * n[:, 2] + a[:, 2] * n[:, 0],
            ],
            axis=1,
        )

    return np.stack([rows(n), rows(u), rows(v)], axis=1)


def on_planes(s: Array, n: Array) -> tuple[Array, Array]:
    """Return normal stress (m, nt) and shear vector (m, nt, 2) of stresses (nt, 6) on planes."""
    rows = plane_rows(n)
    return rows[:, 0] @ s.T, np.stack([rows[:, 1] @ s.T, rows[:, 2] @ s.T], axis=2)


@described
@dataclass(frozen=True, eq=False)
class CriticalPlane:
    """Critical plane through a point.

    Attributes
    ----------
    normal : (3,) array
        Unit normal, axes of the stress; nan where the criterion has no plane (Dang Van).
    value : float
        Value of the criterion, Pa (strain for Fatemi-Socie).
    shear : float
        Shear stress amplitude on the plane, Pa; for `NormalStress` the amplitude of the normal
        stress.
    normal_stress : float
        Largest normal stress on the plane, Pa; for Dang Van the hydrostatic stress.
    index : int
        Sample of the largest normal stress (for Dang Van, of the largest sum).
    """

    normal: Array
    value: float
    shear: float
    normal_stress: float
    index: int


@explained
def critical_plane(stress: ArrayLike, criterion: PlaneCriterion | DangVan) -> CriticalPlane:
    """Return the plane with the largest value of a criterion over a stress history.

    Planes are evaluated every 9 degrees on the half-sphere; the three with the largest values are
    refined to 0.01 degrees. The shear amplitude of a plane is the radius of the smallest circle
    around its shear path, computed exactly. Among planes of equal value to 1e-7, such as the pairs
    of in-phase loads, the normal nearest to the first axis is chosen, then to the second.

    Parameters
    ----------
    stress : (nt, 6) array_like
        ``[s11 s22 s33 s12 s23 s13]``, Pa.
    criterion : Findley, FatemiSocie, NormalStress or DangVan

    Raises
    ------
    InputError
        For a history that is empty, not finite or of another shape.

    Examples
    --------
    >>> t = np.linspace(0, 2 * np.pi, 361)
    >>> s = np.zeros((361, 6))
    >>> s[:, 0] = 100e6 * np.sin(t)  # alternating tension
    >>> found = critical_plane(s, Findley(0.3))
    >>> round(found.value / 1e6, 2), round(float(Findley(0.3).equivalent(found.value)) / 1e6, 2)
    (67.2, 100.0)
    """
    s = _history(stress)
    if isinstance(criterion, DangVan):
        return _dang_van(s, criterion)
    n = normals()
    values = np.concatenate([_values(s, part, criterion)[0] for part in _split(n, len(s))])
    refined: list[tuple[float, Array]] = []
    for start in n[ranking(values)[:3]]:
        # grids around the best normal, each finer than the last
        centre, reach = start, COARSE
        while reach > math.radians(0.01):
            u, v = tangents(centre[None])
            g = reach * np.array(
                [0.0, -0.5, 0.5, -1.0, 1.0]
            )  # the centre comes first, so that it is selected among equal values
            net = centre + g[:, None, None] * u[0] + g[None, :, None] * v[0]
            net = net.reshape(-1, 3) / np.linalg.norm(net.reshape(-1, 3), axis=1, keepdims=True)
            found = _values(s, net, criterion)[0]
            centre = net[largest(found)]
            reach *= 0.5
        refined.append((float(found.max()), centre))
    top = max(value for value, _ in refined)
    equal = [normal for value, normal in refined if value >= top - PLANE_TIE * abs(top)]
    best = positive_normal(max(equal, key=nearness))
    value, shear, normal, index = (x[0] for x in _values(s, best[None], criterion))
    return CriticalPlane(best, float(value), float(shear), float(normal), int(index))


def _values(
    s: Array, n: Array, criterion: PlaneCriterion
) -> tuple[Array, Array, Array, NDArray[np.intp]]:
    sn, t = on_planes(s, n)
    index = np.argmax(sn, axis=1)
    top = np.take_along_axis(sn, index[:, None], axis=1)[:, 0]
    if isinstance(criterion, NormalStress):
        amplitude = 0.5 * (top - sn.min(axis=1))
    else:
        amplitude = enclosing_circles(t)[1]
    return criterion.value(amplitude, top), amplitude, top, index


def _split(n: Array, nt: int) -> list[Array]:
    rows = max(1, BLOCK_BYTES // (48 * max(nt, 1)))
    return [n[i : i + rows] for i in range(0, len(n), rows)]


def _history(stress: ArrayLike) -> Array:
    problems = Problems()
    s = problems.array("critical plane", "stress", stress, (None, 6))
    if s is not None and not len(s):
        problems.add("critical plane", "the stress history is empty")
    problems.raise_if_any()
    assert s is not None
    return s


def _dang_van(s: Array, criterion: DangVan) -> CriticalPlane:
    hydrostatic = s[:, :3].mean(axis=1)
    deviator = s.copy()
    deviator[:, :3] -= hydrostatic[:, None]
    # scaled components, in which the Euclidean norm is sqrt(S : S)
    d = deviator * np.sqrt([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
    centre, _ = enclosing_ball(d)
    grain = deviator - centre / np.sqrt([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
    principal = np.linalg.eigvalsh(grain[:, VOIGT])
    shear = 0.5 * (principal[:, 2] - principal[:, 0])
    total = shear + criterion.a * hydrostatic
    i = int(np.argmax(total))
    return CriticalPlane(
        np.full(3, math.nan), float(total[i]), float(shear[i]), float(hydrostatic[i]), i
    )


@described
@dataclass(frozen=True, eq=False)
class Multiaxial(Tabular):
    """Values of a multiaxial criterion at several sites.

    Attributes
    ----------
    labels : tuple of str
    criterion : object
    planes : tuple of CriticalPlane
        Critical plane of each site.
    """

    labels: tuple[str, ...]
    criterion: PlaneCriterion | DangVan
    planes: tuple[CriticalPlane, ...]

    @property
    def values(self) -> Array:
        """Values of the criterion, Pa (strain for Fatemi-Socie)."""
        return np.array([plane.value for plane in self.planes])

    @property
    def safety(self) -> Array:
        """Factors (ns,) on the load up to the limit of Dang Van's criterion.

        Raises
        ------
        InputError
            For a criterion without a limit; use `plane_damage` with an S-N curve.
        """
        if not isinstance(self.criterion, DangVan):
            raise InputError(
                Problem(
                    type(self.criterion).__name__,
                    "has no limit; compare its equivalent amplitude with an S-N curve, "
                    "or use plane_damage",
                )
            )
        with np.errstate(divide="ignore"):
            return np.where(self.values > 0.0, self.criterion.b / self.values, np.inf)

    def table(self, rows: int = 10) -> str:
        """Return a table of the sites with the largest values."""
        strain = isinstance(self.criterion, FatemiSocie)
        unit, factor = ("um/m", 1e6) if strain else ("MPa", 1e-6)
        width = max(12, *(len(label) for label in self.labels))
        head = [
            f"{self.criterion}",
            f"{'site':>{width}} {'value':>9} {'shear':>9} {'normal':>9}  plane",
            f"{'':>{width}} {unit:>9} {'MPa':>9} {'MPa':>9}",
        ]
        order = ranking(self.values, self.labels)[:rows]
        lines = []
        for i in order:
            p = self.planes[i]
            normal = "" if np.isnan(p.normal[0]) else " ".join(f"{x:6.3f}" for x in p.normal)
            lines.append(
                f"{self.labels[i]:>{width}} {factor * p.value:9.2f} {1e-6 * p.shear:9.2f} "
                f"{1e-6 * p.normal_stress:9.2f}  {normal}"
            )
        return "\n".join(head + lines)

    def _csv(self) -> Rows:
        """Return the table of value and plane of all sites."""
        head = ("site", "value", "shear (Pa)", "normal stress (Pa)", "n1", "n2", "n3", "sample")
        rows = [
            (label, p.value, p.shear, p.normal_stress, *p.normal.tolist(), p.index)
            for label, p in zip(self.labels, self.planes, strict=True)
        ]
        return (*head, f"{self.criterion}"), rows

    def __str__(self) -> str:
        return self.table()


@explained
def multiaxial(
    stress: Any, criterion: PlaneCriterion | DangVan, *, sites: Sequence[str] | str | None = None
) -> Multiaxial:
    """Return the critical planes of a multiaxial criterion at sites of a stress field.

    Parameters
    ----------
    stress : StressField or (ns, nt, 6) array_like
        Field from `stress_field`, or histories of several sites, Pa.
    criterion : Findley, FatemiSocie, NormalStress or DangVan
    sites : sequence of str, optional
        Labels of the sites; None takes all, at about 20 ms per site.

    Raises
    ------
    InputError
        For unknown sites, or histories that are empty or not finite.
    """
    labels, histories = _places(stress, sites)
    planes = tuple(critical_plane(next_, criterion) for next_ in histories)
    return Multiaxial(labels, criterion, planes)


def _places(stress: Any, sites: Sequence[str] | str | None) -> tuple[tuple[str, ...], Any]:
    """Return labels and an iterator over histories (nt, 6)."""
    if hasattr(stress, "history"):
        labels = (
            tuple(stress.labels)
            if sites is None
            else (sites,)
            if isinstance(sites, str)
            else tuple(sites)
        )
        return labels, (np.asarray(stress.history(label)) for label in labels)
    s = np.asarray(stress, dtype=np.float64)
    if s.ndim == 2:
        s = s[None]
    problems = Problems()
    if s.ndim != 3 or s.shape[2] != 6:
        problems.add(
            "multiaxial",
            f"stress has shape {s.shape}, must be (sites, instants, 6) or (instants, 6)",
        )
    elif not len(s):
        problems.add("multiaxial", "stress has no sites; give one or more")
    problems.raise_if_any()
    return tuple(str(i) for i in range(len(s))), iter(s)
