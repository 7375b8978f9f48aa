"""Markers: named frames on bodies that joints, forces and sensors use."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from jousto.base.arrays import Array, read_only
from jousto.base.complexstep import floats
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.fields import Field
from jousto.base.rotations import exp_rotation, parse_orientation, rotation_matrix

if TYPE_CHECKING:
    from jousto.reduction.interpolated_points import Followed as Followed
    from jousto.reduction.reduced import ReducedPart


NO_TURN = read_only(np.eye(3))


class Placed(Protocol):
    """Protocol of the body of a marker: its name and the initial state of its frame."""

    @property
    def name(self) -> str:
        """Name of the body."""

    @property
    def position(self) -> Array:
        """Initial world position (3,) of the body frame, m."""

    @property
    def orientation(self) -> Array:
        """Initial Euler parameters (4,) of the body frame."""

    @property
    def modal_coordinates(self) -> Array:
        """Initial modal coordinates (n,)."""


@dataclass(frozen=True, eq=False)
class Marker:
    """Frame fixed to a point of a body; create it with ``body["point"]`` or ``body.at(...)``.

    On a flexible body the marker sits on a node, or follows the nodes around a point. It moves with
    the translation and rotation mode shapes there: ``r = R + A (u0 + Phi p)`` and ``A_marker = A
    exp((Psi p)~) A_0``.

    Parameters
    ----------
    body : Body The body that the marker is fixed to.
    point : str
        Name of the point on the body.
    position_local : (3,) array
        Undeformed position u0 in the body frame, m.
    node : int or None
        Index of the node of a flexible body.
    axes : (3, 3) array
        A_0, whose columns are the marker's axes in the (undeformed) body frame.
    followed : Followed or None
        The nodes whose motion is interpolated if the point of a flexible body is no node.
    """

    body: Placed
    point: str
    position_local: Array
    node: int | None
    axes: Array
    followed: Followed | None = None

    def __repr__(self) -> str:
        return f"<Marker {self.label!r}>"

    @property
    def label(self) -> str:
        """Name for messages, such as ``body.point``."""
        # a node of a beam is named as a point of the beam
        return f"{getattr(self.body, 'beam', self.body.name)}.{self.point}"

    def turned(self, axes: Any) -> Marker:
        """Return the marker at the same point with other axes.

        Parameters
        ----------
        axes : Rotate, (4,) or (3, 3) array_like, scipy Rotation
            New orientation A_0 of the marker relative to the undeformed body frame.

        Raises
        ------
        InputError
            If `axes` is not an orientation.
        """
        return replace(self, axes=marker_axes(self.label, axes))

    @property
    def site(self) -> object:
        """Place of the marker on its body: a node, an interpolated point, or None (body frame)."""
        return self.node if self.followed is None else tuple(self.position_local.tolist())

    @property
    def Phi(self) -> Array:
        """Translation mode shapes (3, n) at the marker, body frame; n = 0 on rigid bodies."""
        reduced = getattr(self.body, "reduced", None)
        if reduced is None or self.site is None:
            return np.zeros((3, 0))
        if self.followed is not None:
            return floats(self.followed.motion(reduced)[:3])
        return floats(reduced.modes[self.node])

    @property
    def Psi(self) -> Array:
        """Rotation mode shapes (3, n) at the marker, body frame.

        Zero if the part has no rotations.
        """
        reduced = getattr(self.body, "reduced", None)
        if reduced is None or self.site is None:
            return np.zeros((3, 0))
        if self.followed is not None:
            return floats(self.followed.motion(reduced)[3:])
        turn = reduced.rotation(self.node)
        if turn is None:
            return np.zeros((3, reduced.modes.shape[2]))
        return floats(turn)

    @property
    def chi(self) -> Array | None:
        """Second-order translation and rotation (6, n, n), see `Stiffening`.

        None if the part has none.
        """
        reduced = getattr(self.body, "reduced", None)
        if reduced is None or self.site is None or reduced.stiffening is None:
            return None
        return self.second_order(reduced)

    def second_order(self, reduced: ReducedPart) -> Array:
        """Return the second-order displacement (6, n, n) at the marker in a part."""
        if self.followed is not None:
            return floats(self.followed.second_order(reduced))
        field = reduced.stiffening
        assert field is not None and self.node is not None
        return np.concatenate([field.translations[self.node], field.rotations[self.node]])

    @property
    def displaced_local(self) -> Array:
        """Position (3,) in the body frame at the initial state, ``u0 + Phi p``, m."""
        Phi = self.Phi
        if not Phi.size:
            return self.position_local
        return np.asarray(self.position_local + Phi @ self.body.modal_coordinates)

    @property
    def r(self) -> Array:
        """World position (3,) at the initial state, ``R + A (u0 + Phi p)``, m."""
        return read_only(world_positions([self])[0])

    @property
    def carrier(self) -> Array:
        """Initial axes (3, 3) of the body at the marker, before A_0: ``A exp((Psi p)~)``."""
        A, Psi = rotation_matrix(self.body.orientation), self.Psi
        return np.asarray(A @ exp_rotation(Psi @ self.body.modal_coordinates)) if Psi.size else A

    @property
    def A(self) -> Array:
        """World axes (3, 3) at the initial state, ``A exp((Psi p)~) A_0``."""
        return read_only(self.carrier @ self.axes)


def world_positions(markers: Sequence[Marker]) -> Array:
    """Return the world positions (n, 3) of markers at the initial state, m, see `Marker.r`."""
    bodies = [marker.body for marker in markers]
    R = floats([body.position for body in bodies]).reshape(-1, 3)
    A = rotation_matrix(floats([body.orientation for body in bodies]).reshape(-1, 4))
    u = floats([marker.displaced_local for marker in markers]).reshape(-1, 3)
    return np.asarray(R + (A @ u[..., None])[..., 0])


def carriers(markers: Sequence[Marker]) -> Array:
    """Return the initial frames (n, 3, 3) of `Marker.carrier` for several markers."""
    A = rotation_matrix(floats([marker.body.orientation for marker in markers]).reshape(-1, 4))
    for i, marker in enumerate(markers):
        if hasattr(marker.body, "reduced"):
            A[i] = marker.carrier
    return A


def marker_axes(label: str, axes: Any) -> Array:
    """Return A_0 (3, 3) of an orientation given by the user; exactly the unit matrix for None."""
    if axes is None:
        return NO_TURN
    problems = Problems()
    e = parse_orientation(problems, f"marker {label}", "axes", axes)
    problems.raise_if_any()
    assert e is not None
    return read_only(rotation_matrix(e))


def as_marker(where: str, name: str, value: Any) -> Marker:
    """Return `value` if it is a marker; else raise an error that shows how to create one."""
    if isinstance(value, Marker):
        return value
    if hasattr(value, "name") and hasattr(value, "orientation"):
        hint = f"is the body {value.name!r}; name a point of it, {value.name}[...]"
    else:
        hint = f'is {value!r}, must be a marker such as body["point"] or ground["origin"]'
    raise InputError(Problem(where, f"{name} {hint}", path=(name,)))


class MarkerField(Field[Marker, Marker]):
    """Field of a marker; a model file contains ``arm.tip`` or a mapping."""

    form = "marker"
    noun = "Marker"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the marker, or report a value of another type."""
        check_marker(problems, where, self.name, value)
        return value


class MarkersField(Field["Iterable[Marker]", "tuple[Marker, ...]"]):
    """Field of several markers, in order; a model file contains a list of them."""

    form = "markers"
    noun = "sequence of Marker"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the markers as a tuple, or report values of other types."""
        markers = tuple(value) if isinstance(value, Iterable) else (value,)
        for i, one in enumerate(markers):
            check_marker(problems, where, f"{self.name}[{i}]", one)
        return markers


class OptionalMarker(Field["Marker | None", "Marker | None"]):
    """Field of a marker, or None."""

    form = "marker"
    noun = "Marker"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the marker or None, or report that the value is neither."""
        check_marker(problems, where, self.name, value)
        return value


def check_marker(problems: Problems, where: str, name: str, value: Any) -> None:
    """Report a problem unless `value` is a marker."""
    try:
        as_marker(where, name, value)
    except InputError as error:
        problems.found.extend(error.problems)
