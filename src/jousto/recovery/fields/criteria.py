"""Criteria: scalar measures of stress and strain tensors, with their names."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.voigt import PAIRS, STRAIN_COMPONENTS, STRESS_COMPONENTS
from jousto.model.native import recover

INVARIANTS = (
    "von-mises",
    "signed-von-mises",
    "principal-1",
    "principal-2",
    "principal-3",
    "signed-principal",
    "max-shear",
)
"""Criteria that do not depend on axes, for stress and strain."""

TENSOR_SHEARS = ("e12", "e23", "e13")
"""Names of tensor shear strains, half of the engineering shear strains."""

SUM_ROUNDING = 1e-7
"""Sum of the extreme principal values over their difference, below which the sum is zero, as in
stress_recovery.c: in pure shear they are opposite, and round-off would determine the sign."""


@dataclass(frozen=True)
class Plane:
    """Criterion: the normal stress ``n^T S n`` (or normal strain) of a plane.

    Parameters
    ----------
    normal : (3,) array_like
        Normal of the plane, in the axes of the field; any length.

    Raises
    ------
    InputError
        If the normal is not three finite numbers, or zero.

    Examples
    --------
    >>> round(float(evaluate([100.0, 0, 0, 30.0, 0, 0], Plane((1, 1, 0)))), 6)
    80.0
    """

    normal: tuple[float, float, float]

    def __init__(self, normal: ArrayLike) -> None:
        problems = Problems()
        n = problems.array("Plane", "normal", normal, (3,))
        if n is not None and not np.any(n):
            problems.add("Plane", "normal is (0, 0, 0), must not be zero")
        problems.raise_if_any()
        assert n is not None
        x, y, z = (n / np.linalg.norm(n)).tolist()
        object.__setattr__(self, "normal", (x, y, z))

    def __str__(self) -> str:
        return "normal:" + ",".join(f"{x:.6g}" for x in self.normal)


Criterion = str | Plane


def criteria(strain: bool = False) -> tuple[str, ...]:
    """Return the names of all criteria of stress, or of strain.

    Examples
    --------
    >>> criteria()[:3]
    ('von-mises', 'signed-von-mises', 'principal-1')
    """
    if strain:
        return (*INVARIANTS, *STRAIN_COMPONENTS, *TENSOR_SHEARS)
    return (*INVARIANTS, *STRESS_COMPONENTS)


def check_criterion(criterion: Any, strain: bool = False, where: str = "criterion") -> Criterion:
    """Return the criterion if it is valid.

    Raises
    ------
    InputError
        If there is no such criterion; the message contains the nearest name.
    """
    if isinstance(criterion, Plane):
        return criterion
    known = criteria(strain)
    if isinstance(criterion, str) and criterion in known:
        return criterion
    kind = "strain" if strain else "stress"
    if isinstance(criterion, str) and criterion in criteria(not strain):
        message = f"{criterion!r} is not a criterion of {kind}; make the field with strain="
        raise InputError(Problem(where, message + str(not strain)))
    hint = suggest(criterion, known) if isinstance(criterion, str) else ""
    message = f"{criterion!r} is not a criterion of {kind}{hint}"
    raise InputError(Problem(where, f"{message}; there are {', '.join(known)} and Plane(normal)"))


def weights(criterion: Criterion, strain: bool = False) -> Array | None:
    """Return weights w (6,) of a linear criterion ``w . s``, Voigt order; None if nonlinear."""
    if isinstance(criterion, Plane):
        n, shear = criterion.normal, 1.0 if strain else 2.0
        return np.array([n[i] * n[j] * (1.0 if i == j else shear) for i, j in PAIRS])
    for names, factor in (
        (STRESS_COMPONENTS, 1.0),
        (STRAIN_COMPONENTS, 1.0),
        ((*STRAIN_COMPONENTS[:3], *TENSOR_SHEARS), 0.5),
    ):
        if criterion in names:
            out = np.zeros(6)
            out[names.index(criterion)] = factor
            return out
    return None


def tensor(s: ArrayLike, strain: bool = False) -> Array:
    """Return tensors (..., 3, 3) of stresses or strains (..., 6) in Voigt order."""
    voigt = np.asarray(s, dtype=np.float64)
    if strain:
        voigt = voigt * np.array([1.0, 1.0, 1.0, 0.5, 0.5, 0.5])
    return voigt[..., [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]


def voigt(tensors: ArrayLike, strain: bool = False) -> Array:
    """Return stresses or strains (..., 6) in Voigt order of symmetric tensors (..., 3, 3)."""
    T = np.asarray(tensors, dtype=np.float64)
    out = T[..., [0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
    return np.asarray(out * np.array([1, 1, 1, 2, 2, 2])) if strain else out


def rotate_tensors(s: ArrayLike, A: ArrayLike, strain: bool = False) -> Array:
    """Return stresses or strains (..., 6) in rotated axes, ``A S A^T`` with A (..., 3, 3)."""
    T, R = tensor(s, strain), np.asarray(A, dtype=np.float64)
    return voigt(R @ T @ np.swapaxes(R, -1, -2), strain)


def von_mises(s: ArrayLike, strain: bool = False) -> Array:
    """Return the equivalent stress (...,) of stresses (..., 6) in Voigt order.

    ``sqrt(((s11-s22)^2 + (s22-s33)^2 + (s33-s11)^2) / 2 + 3 (s12^2 + s23^2 + s13^2))``; for strains
    ``sqrt(2/3 e':e')`` with the deviator e', which equals the axial strain of isochoric uniaxial
    flow.

    Examples
    --------
    >>> von_mises([[100.0, 0, 0, 0, 0, 0], [0, 0, 0, 100.0, 0, 0], [5, 5, 5, 0, 0, 0]]).round(2)
    array([100.  , 173.21,   0.  ])
    """
    s11, s22, s33, s12, s23, s13 = np.moveaxis(np.asarray(s, dtype=np.float64), -1, 0)
    direct = (s11 - s22) ** 2 + (s22 - s33) ** 2 + (s33 - s11) ** 2
    shear = s12**2 + s23**2 + s13**2
    if strain:
        return np.asarray(np.sqrt(2.0 / 9.0 * direct + shear / 3.0))
    return np.asarray(np.sqrt(0.5 * direct + 3.0 * shear))


def principal_values(s: ArrayLike, strain: bool = False) -> Array:
    """Return the principal stresses or strains (..., 3) in descending order.

    Examples
    --------
    >>> principal_values([0.0, 0, 0, 100.0, 0, 0]).round(9)
    array([ 100.,    0., -100.])
    """
    return recover.principal_values(_tensor_rows(s, strain))


def principal(s: ArrayLike, strain: bool = False) -> tuple[Array, Array]:
    """Return principal values (..., 3), descending, and directions (..., 3, 3) in columns.

    In closed form: the value furthest from the others is the root ``2 q cos(theta)`` of the
    deviator D with ``cos 3 theta = det D / (2 q^3)``; the other two, which may be equal, follow
    from the plane normal to its direction, so that they have full accuracy.

    Examples
    --------
    >>> values, directions = principal([30.0, 70.0, 0, 0, 0, 0])
    >>> values.round(9), abs(directions[:, 0]).round(9)
    (array([70., 30.,  0.]), array([0., 1., 0.]))
    """
    return recover.principal(_tensor_rows(s, strain))


def _tensor_rows(s: ArrayLike, strain: bool) -> Array:
    rows = np.asarray(s, dtype=np.float64)
    return rows * np.array([1.0, 1.0, 1.0, 0.5, 0.5, 0.5]) if strain else rows


def evaluate(s: ArrayLike, criterion: Criterion = "von-mises", strain: bool = False) -> Array:
    """Return the criterion (...,) of stresses or strains (..., 6) in Voigt order.

    Parameters
    ----------
    s : (..., 6) array_like
        ``[s11 s22 s33 s12 s23 s13]``, or ``[e11 e22 e33 g12 g23 g13]`` with engineering shears.
    criterion : str or Plane
        "s11" .. "s13" ("e11" .. "g13"; "e12" is half of "g12"), "von-mises", "signed-von-mises"
        (with the sign of the principal value of largest magnitude), "principal-1" >= "principal-2"
        >= "principal-3", "signed-principal" (that of largest magnitude), "max-shear" (half the
        difference of the principal stresses; for strains the difference), or a `Plane`. The sign is
        positive if two principal values have the largest magnitude, as in pure shear.
    strain : bool
        Whether `s` are strains.

    Raises
    ------
    InputError
        If there is no such criterion.

    Examples
    --------
    >>> float(evaluate([-50.0, 0, 0, 0, 0, 0], "signed-von-mises"))
    -50.0
    """
    check_criterion(criterion, strain)
    values = np.asarray(s, dtype=np.float64)
    w = weights(criterion, strain)
    if w is not None:
        return np.asarray(values @ w)
    if criterion == "von-mises":
        return von_mises(values, strain)
    p = principal_values(values, strain)
    if criterion in ("principal-1", "principal-2", "principal-3"):
        return np.asarray(p[..., int(str(criterion)[-1]) - 1])
    if criterion == "max-shear":
        return np.asarray((1.0 if strain else 0.5) * (p[..., 0] - p[..., 2]))
    positive = p[..., 0] + p[..., 2] >= -SUM_ROUNDING * (p[..., 0] - p[..., 2])
    if criterion == "signed-principal":
        return np.where(positive, p[..., 0], p[..., 2])
    return np.where(positive, 1.0, -1.0) * von_mises(values, strain)
