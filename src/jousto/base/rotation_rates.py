"""Conversion between angular velocity and the rates of rotation parameters."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.complexstep import floats
from jousto.base.errors import Problems
from jousto.base.rotations import UNIT_TOLERANCE, parse_convention

POLE = 1e-6  # distance from the pole of Euler angles, rad, below which rates are refused


def velocity_matrix(e: ArrayLike, convention: str | None = None) -> Array:
    """Return G of ``w' = G e'``, which converts rates of rotation parameters to angular velocity.

    w' is resolved in the rotated frame, ``dA/dt = A skew(w')``; in the world it is ``A w'``.

    * Euler parameters: ``G = 2 [-e1 e0 e3 -e2; -e2 -e3 e0 e1; -e3 e2 -e1 e0]`` (Shabana, *Dynamics
      of Multibody Systems*, section 2.5), for rates that keep the length of e at 1.
    * Euler angles a, b, c about the axes i, j, k of the rotated body, ``A = Ai(a) Aj(b) Ak(c)``:
      ``G = [Ak^T Aj^T i, Ak^T j, k]``.

    Parameters
    ----------
    e : (..., 4) or (..., 3) array_like
        Euler parameters, scalar first, of length 1; or three angles, rad.
    convention : str, optional
        Convention of the angles as in `Rotate.euler`, such as ``"ZXZ"`` (axes of the rotated body)
        or ``"zxz"`` (axes of the world); None for Euler parameters.

    Returns
    -------
    (..., 3, 4) or (..., 3, 3) array

    Raises
    ------
    InputError
        If the shape does not fit, a value is not finite, Euler parameters do not have length 1, or
        the convention is unknown.

    Examples
    --------
    A yaw of 2 rad/s, pitched up by 90 degrees, is a roll:

    >>> G = velocity_matrix((0.3, -np.pi / 2, 0.0), "ZYX")
    >>> (G @ [2.0, 0.0, 0.0]).round(12)
    array([2., 0., 0.])
    """
    values, axes = _parse("velocity_matrix", e, convention)
    return _of_parameters(values) if axes is None else _of_angles(values, axes)


def rate_matrix(e: ArrayLike, convention: str | None = None) -> Array:
    """Return H of ``e' = H w'``, which converts angular velocity to rates of rotation parameters.

    The inverse of `velocity_matrix`: ``G H = 1``. For Euler parameters ``H = G^T / 4``; these rates
    keep the length of e. Euler angles have a pole where two of their axes are parallel, so that no
    rates give a rotation about the normal of the axes: ``b = 0`` or 180 degrees of conventions such
    as ZXZ, ``b = +-90`` degrees of conventions such as ZYX.

    Parameters
    ----------
    e : (..., 4) or (..., 3) array_like
        Euler parameters, scalar first, of length 1; or three angles, rad.
    convention : str, optional
        Convention of the angles as in `Rotate.euler`; None for Euler parameters.

    Returns
    -------
    (..., 4, 3) or (..., 3, 3) array

    Raises
    ------
    InputError
        As `velocity_matrix`; also within 1e-6 rad of the pole, where rates lose six digits or more.

    Examples
    --------
    >>> rate_matrix((0.0, 0.0, 0.0), "ZYX") @ [1.0, 0.0, 0.0]
    array([0., 0., 1.])
    """
    values, axes = _parse("rate_matrix", e, convention)
    if axes is None:
        return rates_of_parameters(values)
    assert convention is not None
    _refuse_pole(np.real(values[..., 1]), convention)
    return np.asarray(np.linalg.inv(_of_angles(values, axes)))


def rates_of_parameters(e: Array) -> Array:
    """Return H (..., 4, 3) for Euler parameters (..., 4), without checking them."""
    return np.asarray(np.swapaxes(_of_parameters(e), -1, -2) / 4.0)


def _of_parameters(e: Array) -> Array:
    e0, e1, e2, e3 = np.moveaxis(e, -1, 0)
    G = 2.0 * np.array([[-e1, e0, e3, -e2], [-e2, -e3, e0, e1], [-e3, e2, -e1, e0]])
    return np.asarray(np.moveaxis(G, (0, 1), (-2, -1)))


def _of_angles(angles: Array, axes: tuple[int, int, int, bool]) -> Array:
    *order, extrinsic = axes
    # extrinsic rotations are intrinsic ones in reverse order
    a = angles[..., ::-1] if extrinsic else angles
    i, j, k = order[::-1] if extrinsic else order
    Aj, Ak = _turn(j, a[..., 1]), _turn(k, a[..., 2])
    # rows of the matrices: (Ak^T Aj^T i)^T = i^T Aj Ak
    columns = [
        (Aj @ Ak)[..., i, :],
        Ak[..., j, :],
        np.broadcast_to(np.eye(3)[k], angles.shape),
    ]
    return np.stack(columns[::-1] if extrinsic else columns, axis=-1)


def _turn(axis: int, angle: Any) -> Array:
    """Return the rotations (..., 3, 3) by angles (...) about a coordinate axis."""
    c, s = np.cos(angle), np.sin(angle)
    A = np.zeros((*np.shape(angle), 3, 3), np.result_type(c))
    j, k = (axis + 1) % 3, (axis + 2) % 3
    A[..., axis, axis] = 1.0
    A[..., j, j] = A[..., k, k] = c
    A[..., k, j], A[..., j, k] = s, -s
    return A


def _parse(
    where: str, e: ArrayLike, convention: str | None
) -> tuple[Array, tuple[int, int, int, bool] | None]:
    """Return checked parameters, the axes of Euler angles, and whether angles are extrinsic."""
    problems = Problems()
    axes = None if convention is None else parse_convention(problems, where, convention)
    count = 4 if convention is None else 3
    try:
        values = floats(e)
    except (TypeError, ValueError, OverflowError):
        values = np.zeros(0)
    if values.ndim < 1 or values.shape[-1] != count:
        found = f"has shape {values.shape}" if values.size else f"is {e!r}"
        hint = ""
        if convention is None and values.ndim and values.shape[-1] == 3:
            hint = "; three angles need their convention, such as 'ZXZ'"
        what = "four Euler parameters, scalar first" if convention is None else "three angles, rad"
        problems.add(where, f"e {found}, must be {what}{hint}", "e")
    elif not np.isfinite(values).all():
        problems.add(where, "e has values that are not finite", "e")
    elif convention is None:
        length = np.sqrt((np.real(values) ** 2).sum(axis=-1))
        worst = float(np.ravel(length)[np.abs(length - 1.0).argmax()]) if length.size else 1.0
        if abs(worst - 1.0) > UNIT_TOLERANCE:
            problems.add(where, f"e has length {worst:g}; Euler parameters must have length 1", "e")
    problems.raise_if_any()
    if axes is None:
        return values, None
    assert convention is not None
    i, j, k = axes
    return values, (i, j, k, convention.islower())


def _refuse_pole(b: Array, convention: str) -> None:
    """Raise InputError where the middle angle is within `POLE` of its pole."""
    first = 0.0 if convention[0] == convention[2] else np.pi / 2
    distance = np.abs(np.remainder(b - first + np.pi / 2, np.pi) - np.pi / 2)
    if not distance.size or distance.min() > POLE:
        return
    worst = float(np.ravel(b)[distance.argmin()])
    pole = first + np.pi * round((worst - first) / np.pi)
    problems = Problems()
    problems.add(
        "rate_matrix",
        f"the middle angle of {convention!r} is {np.degrees(worst):.9g} deg, within {POLE:g} rad "
        f"of the pole at {np.degrees(pole):g} deg, where rates are not determined; take Euler "
        "parameters, which have none",
        "e",
    )
    problems.raise_if_any()
