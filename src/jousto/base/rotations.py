"""Orientations: forms accepted from users, Euler parameters and rotation matrices.

Euler parameters e are scalar first with unit norm: ``e0 = cos(phi/2)``,
``e1..3 = n sin(phi/2)`` for a rotation by phi about the unit axis n.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Never

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array, crossed, read_only, skew
from jousto.base.complexstep import arctan2, floats, norm, stepped
from jousto.base.errors import Problems
from jousto.base.fields import Field
from jousto.base.numbers import number, set_fields

UNIT_TOLERANCE = 1e-6

PARALLEL = 1e-12  # largest sine of the angle between parallel vectors

# smallest allowed value of the largest component of a direction
SHORTEST = 1e-150


def rotation_matrix(e: ArrayLike) -> Array:
    """Return the matrix A (..., 3, 3) from local to world axes for Euler parameters e (..., 4).

    Rantalainen 2007, eq. 3.5.

    Examples
    --------
    >>> rotation_matrix([0.5**0.5, 0, 0, 0.5**0.5]).round(12) @ [1, 0, 0]  # 90 deg about z
    array([0., 1., 0.])
    """
    e = floats(e)
    # Python numbers need a tenth of the time of NumPy
    e0, e1, e2, e3 = e.tolist() if e.ndim == 1 else np.moveaxis(e, -1, 0)
    A = np.array(
        [
            [1 - 2 * (e2 * e2 + e3 * e3), 2 * (e1 * e2 - e0 * e3), 2 * (e1 * e3 + e0 * e2)],
            [2 * (e1 * e2 + e0 * e3), 1 - 2 * (e1 * e1 + e3 * e3), 2 * (e2 * e3 - e0 * e1)],
            [2 * (e1 * e3 - e0 * e2), 2 * (e2 * e3 + e0 * e1), 1 - 2 * (e1 * e1 + e2 * e2)],
        ]
    )
    return A if e.ndim == 1 else np.moveaxis(A, (0, 1), (-2, -1))


def euler_parameters(A: ArrayLike) -> Array:
    """Return the unit Euler parameters (4,) of a rotation matrix, with e0 >= 0.

    Shepperd's method divides by the largest of the four components, so that every rotation is well
    conditioned. The sign is chosen such that e0 is not negative.
    """
    A = floats(A)
    trace = np.trace(A)
    squares = np.array([trace, A[0, 0], A[1, 1], A[2, 2]])
    k = int(np.argmax(squares))
    if k == 0:
        e = np.array([1 + trace, A[2, 1] - A[1, 2], A[0, 2] - A[2, 0], A[1, 0] - A[0, 1]])
    else:
        i = k - 1
        j, m = (i + 1) % 3, (i + 2) % 3
        e = np.empty(4, A.dtype)
        e[0] = A[m, j] - A[j, m]
        e[1 + i] = 1 + 2 * A[i, i] - trace
        e[1 + j] = A[j, i] + A[i, j]
        e[1 + m] = A[m, i] + A[i, m]
    e /= norm(e)
    return -e if e[0] < 0.0 else e


def euler_parameters_of(A: ArrayLike) -> Array:
    """Return the unit Euler parameters (n, 4) of rotation matrices (n, 3, 3), with e0 >= 0.

    Row k of the matrix ``4 e e^T``, whose entries are sums of entries of A, is a multiple of e;
    k is the largest component (Shepperd).
    """
    A = floats(A)
    trace = np.trace(A, axis1=1, axis2=2)
    Q = np.empty((len(A), 4, 4))
    Q[:, 0, 0] = 1 + trace
    for i in range(3):
        j, m = (i + 1) % 3, (i + 2) % 3
        Q[:, 0, i + 1] = Q[:, i + 1, 0] = A[:, m, j] - A[:, j, m]
        Q[:, i + 1, i + 1] = 1 + 2 * A[:, i, i] - trace
        Q[:, i + 1, j + 1] = Q[:, j + 1, i + 1] = A[:, i, j] + A[:, j, i]
    largest = np.argmax(np.diagonal(Q, axis1=1, axis2=2), axis=1)
    e = np.take_along_axis(Q, largest[:, None, None], axis=1)[:, 0]
    e /= np.linalg.norm(e, axis=1, keepdims=True)
    return np.asarray(np.where(e[:, :1] < 0.0, -e, e))


def exp_rotation(theta: ArrayLike) -> Array:
    """Return exp(theta~), the rotation by ``|theta|`` rad about theta (Rodrigues).

    Examples
    --------
    >>> exp_rotation([0, 0, np.pi / 2]).round(12) @ [1, 0, 0]
    array([0., 1., 0.])
    """
    theta = floats(theta)
    angle = norm(theta)
    W = skew(theta)
    # sinc keeps both coefficients exact for small angles
    a = np.sinc(angle / np.pi)
    b = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    return np.asarray(np.eye(3) + a * W + b * (W @ W))


def unit_vector(direction: ArrayLike) -> Array:
    """Return a vector (3,) scaled to length 1, even if its square over- or underflows.

    Examples
    --------
    >>> unit_vector([0, 3e200, 4e200]).round(12)
    array([0. , 0.6, 0.8])
    """
    d = floats(direction)
    d = d / np.abs(d).max()
    return np.asarray(d / norm(d))


def parse_direction(problems: Problems, where: str, name: str, value: Any) -> Array | None:
    """Return a nonzero vector (3,), or report a zero one."""
    direction = problems.array(where, name, value, (3,))
    if direction is not None and max(map(abs, direction.tolist())) < SHORTEST:
        found = ", ".join(f"{x:g}" for x in direction)
        problems.add(where, f"{name} is ({found}), must have a direction", name)
        return None
    return direction


class Direction(Field["ArrayLike | None", "Array | None"]):
    """Field of a nonzero vector (3,), or None."""

    form = "direction"
    noun = "(3,) array_like"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a read-only nonzero vector, or report what is wrong."""
        return parse_direction(problems, where, self.name, value)


def turn_onto(A: ArrayLike, axis: ArrayLike) -> Array:
    """Return the frame A (3, 3) after the smallest rotation that aligns its z axis with `axis`."""
    A = floats(A)
    h = unit_vector(axis)
    z = A[:, 2]
    cross = crossed(z, h)
    sine, cosine = norm(cross), z @ h
    if sine < PARALLEL:
        if stepped(cross):
            return np.asarray(
                exp_rotation(cross * np.sign(cosine.real)) @ turn_onto(A.real, h.real)
            )
        # parallel: nothing to do; opposite: half a turn about x
        return A.copy() if cosine > 0 else np.asarray(A @ np.diag([1.0, -1.0, -1.0]))
    if cosine.real > -0.5:
        return np.asarray(least_turn(cross, cosine) @ A)
    return np.asarray(exp_rotation(cross / sine * arctan2(sine, cosine)) @ A)


def turn_each_onto(A: Array, axes: Array) -> Array:
    """Return the result of `turn_onto` for frames A (n, 3, 3) and axes (n, 3)."""
    h = axes / np.abs(axes).max(axis=1, keepdims=True)
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    cross, cosine = crossed(A[:, :, 2], h), (A[:, :, 2] * h).sum(axis=1)
    apart = np.linalg.norm(cross, axis=1) >= PARALLEL
    near = apart & (cosine > -0.5)
    out = A.copy()
    out[near] = least_turn(cross[near], cosine[near]) @ A[near]
    for i in np.flatnonzero(~near & (apart | (cosine < 0.0))):
        out[i] = turn_onto(A[i], axes[i])
    return out


def least_turn(cross: Array, cosine: Array) -> Array:
    """Return the smallest rotations (..., 3, 3) from unit vectors z to unit vectors h.

    ``cosine E + c~ + c c^T / (1 + cosine)`` with ``c = z x h`` (..., 3) and ``cosine = z . h``
    """
    c, size = cross, np.asarray(cosine)[..., None, None]
    return np.asarray(size * np.eye(3) + skew(c) + c[..., :, None] * c[..., None, :] / (1.0 + size))


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Rotate:
    """Rotation about an axis; the unit of the angle is its keyword. See also `Rotate.euler`.

    Parameters
    ----------
    axis : (3,) array_like
        Direction of the axis, any length above zero.
    degrees, radians : float
        Angle, right-handed about the axis; one of the two.

    Raises
    ------
    InputError
        If the axis is zero, a value is not a finite number, or the angle has no keyword.

    Examples
    --------
    >>> Rotate((0, 0, 1), degrees=90).matrix.round(12) @ [1, 0, 0]
    array([0., 1., 0.])
    >>> Rotate((0, 0, 1), radians=0.5)
    Rotate((0, 0, 1), radians=0.5)
    """

    axis: Array
    radians: float

    def __init__(
        self,
        axis: ArrayLike,
        *unnamed: Never,
        degrees: float | None = None,
        radians: float | None = None,
    ) -> None:
        problems = Problems()
        one_unit(problems, "Rotate", "the angle", unnamed, degrees, radians)
        angle = None
        if degrees is not None:
            given = number(problems, "Rotate", "degrees", degrees)
            angle = None if given is None else given * (np.pi / 180.0)
        elif radians is not None:
            angle = number(problems, "Rotate", "radians", radians)
        direction = parse_direction(problems, "Rotate", "axis", axis)
        problems.raise_if_any()
        set_fields(self, axis=direction, radians=angle)

    @classmethod
    def euler(
        cls,
        convention: str,
        *unnamed: Never,
        degrees: ArrayLike | None = None,
        radians: ArrayLike | None = None,
    ) -> Rotate:
        """Return the rotation by three angles about axes, in the order of the convention.

        Parameters
        ----------
        convention : str
            Axes of the rotations. Capitals are axes of the rotated body (intrinsic):
            ``"ZXZ"`` is ``A = Az(a) Ax(b) Az(c)``. Small letters are axes of the world (extrinsic):
            ``"zxz"`` is ``A = Az(c) Ax(b) Az(a)``, as in scipy's ``Rotation``.
        degrees, radians : (3,) array_like
            The angles a, b, c; one of the two.

        Raises
        ------
        InputError
            If the convention is unknown, or the angles are not three finite numbers with a unit.

        Examples
        --------
        >>> Rotate.euler("ZYX", degrees=(90, 0, 90)).matrix.round(12) @ [0, 1, 0]  # yaw, then roll
        array([0., 0., 1.])
        """
        problems = Problems()
        axes = parse_convention(problems, "Rotate.euler", convention)
        one_unit(problems, "Rotate.euler", "the angles", unnamed, degrees, radians)
        name = "radians" if degrees is None else "degrees"
        given = radians if degrees is None else degrees
        found = None if given is None else problems.array("Rotate.euler", name, given, (3,))
        problems.raise_if_any()
        assert axes is not None
        assert found is not None
        angles = found if degrees is None else np.radians(found)
        turns = [exp_rotation(x * np.eye(3)[i]) for x, i in zip(angles, axes, strict=True)]
        e = euler_parameters(np.linalg.multi_dot(turns if convention.isupper() else turns[::-1]))
        sine = float(np.linalg.norm(e[1:]))
        axis = e[1:] if sine > 0.0 else np.array([0.0, 0.0, 1.0])
        return cls(axis, radians=2.0 * float(np.arctan2(sine, e[0])))

    def __repr__(self) -> str:
        axis = ", ".join(f"{x:g}" for x in self.axis)
        return f"Rotate(({axis}), radians={self.radians:g})"

    @property
    def degrees(self) -> float:
        """Angle, degrees."""
        return float(np.degrees(self.radians))

    @property
    def euler_parameters(self) -> Array:
        """Euler parameters (4,), scalar first."""
        half = self.radians / 2
        return np.concatenate([[np.cos(half)], unit_vector(self.axis) * np.sin(half)])

    @property
    def matrix(self) -> Array:
        """Rotation matrix (3, 3)."""
        return rotation_matrix(self.euler_parameters)


def one_unit(
    problems: Problems, where: str, what: str, unnamed: tuple[Any, ...], *given: Any
) -> None:
    """Report a problem unless an angle is given exactly once, in degrees or in radians."""
    if unnamed:
        it = repr(unnamed[0])
        needs = "needs the name of its" if what == "the angle" else "need the name of their"
        problems.add(where, f"{what} {it} {needs} unit: degrees={it} or radians={it}")
    elif sum(x is not None for x in given) != 1:
        problems.add(where, f"give {what} as degrees=... or radians=..., one of the two")


def parse_convention(problems: Problems, where: str, value: Any) -> tuple[int, ...] | None:
    """Return the axes 0, 1, 2 of a convention of Euler angles, or report a wrong one."""
    if isinstance(value, str) and is_convention(value):
        return tuple("XYZ".index(x) for x in value.upper())
    likely = value.upper().translate(str.maketrans("123", "XYZ")) if isinstance(value, str) else ""
    hint = f"; did you mean {likely!r}?" if is_convention(likely) else ""
    problems.add(
        where,
        f"convention is {value!r}, must be three axes, neighbours different: capitals such as "
        "'ZXZ' for the axes of the rotated body (intrinsic), small letters such as 'zxz' for "
        f"those of the world (extrinsic){hint}",
        "convention",
    )
    return None


def is_convention(text: str) -> bool:
    """Return whether a text is three axes X, Y, Z of one case, neighbours different."""
    one_case = len(text) == 3 and (set(text) <= set("XYZ") or set(text) <= set("xyz"))
    return one_case and text[0] != text[1] != text[2]


def parse_orientation(problems: Problems, where: str, name: str, value: Any) -> Array | None:
    """Return the Euler parameters (4,) of an orientation given in any accepted form.

    Parameters
    ----------
    problems : Problems
        Collected problems.
    where, name : str
        Object and argument for the message.
    value : None, Rotate, (4,) or (3, 3) array_like, scipy Rotation
        None is no rotation; four numbers are Euler parameters, scalar first; columns of a (3, 3)
        matrix are the rotated axes.

    Returns
    -------
    (4,) read-only array or None if there was a problem
    """
    if value is None:
        return read_only([1.0, 0.0, 0.0, 0.0])
    if isinstance(value, Rotate):
        return read_only(value.euler_parameters)
    if hasattr(value, "as_matrix"):
        value = value.as_matrix()
    try:
        array = floats(value)
    except (TypeError, ValueError, OverflowError):
        array = np.empty(0)
    if array.shape not in ((4,), (3, 3)):
        found = f"has shape {array.shape}" if array.size else f"is {value!r}"
        problems.add(
            where,
            f"{name} {found}; must be four Euler parameters (scalar first), a (3, 3) rotation "
            "matrix, a scipy Rotation, Rotate(axis, degrees=...) or "
            'Rotate.euler("ZXZ", degrees=...)',
            name,
        )
        return None
    if not np.all(np.isfinite(array)):
        problems.add(where, f"{name} is {array.tolist()}, must be finite", name)
        return None
    if array.shape == (4,):
        length = norm(array)
        if abs(length - 1) > UNIT_TOLERANCE:
            problems.add(
                where,
                f"{name} {array.tolist()} has length {length:g}; Euler parameters (scalar first) "
                "must have length 1",
                name,
            )
            return None
        return read_only(array / length)
    error = float(np.abs(array.T @ array - np.eye(3)).max())
    if error > UNIT_TOLERANCE:
        problems.add(
            where,
            f"{name} is not a rotation matrix: its columns are not orthonormal "
            f"(largest error of A^T A is {error:.1e})",
            name,
        )
        return None
    if np.linalg.det(array) < 0:
        problems.add(
            where, f"{name} is a reflection (determinant -1), must be a right-handed rotation", name
        )
        return None
    return read_only(euler_parameters(array))
