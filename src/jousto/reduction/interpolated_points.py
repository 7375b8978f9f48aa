"""Points of a flexible body between its nodes, whose motion is interpolated from the nodes."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from jousto.base.arrays import Array, Ints, skew
from jousto.base.errors import InputError, Problem
from jousto.parts.frames.element import BeamElements, end_displacements, shape_functions
from jousto.parts.frames.second_order import double_turn
from jousto.reduction.modes.rigid import length_scale

if TYPE_CHECKING:
    from jousto.reduction.reduced import ReducedPart

ARM = 0.1
"""Longest rigid arm from the axis of a beam to a point / size of the part."""

AROUND = 40
"""Number of nodes around a point of a solid for the interpolation."""

DEPENDENT = 1e-6
"""Smallest part of a polynomial that is independent of the previous ones; others are left out."""


@dataclass(frozen=True, eq=False)
class Followed:
    """Interpolation of a point from nodes: ``[u; theta] = sum_k W_k [u_k; theta_k]``.

    Attributes
    ----------
    nodes : (k,) int array
        Indices of the nodes, from 0.
    weights : (6, k, 6) array
        Matrices from translation and rotation of the nodes to those of the point, part frame, m and
        rad.
    arm : (3,) array
        Rigid arm from the interpolated position to the point itself, part frame, m.
    """

    nodes: Ints
    weights: Array
    arm: Array

    def motion(self, reduced: ReducedPart) -> Array:
        """Return translation and rotation of the point in each mode (6, n)."""
        turns = (reduced.rotation(int(k)) for k in self.nodes)
        theta = np.array([np.zeros((3, reduced.n)) if turn is None else turn for turn in turns])
        moved = np.concatenate([reduced.modes[self.nodes], theta], axis=1)
        return np.asarray(np.einsum("akb,kbn->an", self.weights, moved))

    def second_order(self, reduced: ReducedPart) -> Array:
        """Return second-order translation and rotation of the point (6, n, n), see `Stiffening`."""
        field = reduced.stiffening
        assert field is not None
        nodal = np.concatenate(
            [field.translations[self.nodes], field.rotations[self.nodes]], axis=1
        )
        chi = np.einsum("akb,kbij->aij", self.weights, nodal)
        if np.any(self.arm):
            chi[:3] += double_turn(self.motion(reduced)[3:], self.arm[None])[0]
        return np.asarray(chi)


def followed(reduced: ReducedPart, point: Array) -> Followed:
    """Return the interpolation of a point of a part from its nodes.

    In beams the point moves with the nearest section: translation and rotation follow from the
    shape functions of the element, with a rigid arm to points off the axis. In other parts a
    polynomial of second degree (or of the terms that the nodes determine, at least the linear ones)
    is fitted to the translations of the surrounding nodes, with weights ``w = (1 - d^2/R^2)^2 /
    d^2`` of the distance d; the value and half of the curl of the polynomial at the point are the
    translation and rotation (Lancaster and Salkauskas, *Math. Comp.* 37, 1981). Rigid motions and
    constant strain are reproduced exactly; therefore a force on the point becomes nodal forces with
    the same resultant and moment.

    Parameters
    ----------
    reduced : ReducedPart
    point : (3,) array
        Part frame, m.

    Raises
    ------
    InputError
        If the point is outside of the part, or its nodes do not determine the rotation.
    """
    if reduced.beams is not None and len(reduced.beams):
        return _of_beam(reduced, reduced.beams, point)
    return _of_solid(reduced, point)


def _refused(reduced: ReducedPart, point: Array, message: str) -> InputError:
    at = ", ".join(f"{x:g}" for x in np.real(point))
    return InputError(Problem(f"reduced part '{reduced.name}'", f"point ({at}) {message}"))


# -- beams ----------------------------------------------------------------------------------


def _of_beam(reduced: ReducedPart, beams: BeamElements, point: Array) -> Followed:
    along = np.einsum("ea,ea->e", point - beams.origin, beams.axes[:, :, 0]) / beams.length
    along = np.where(along.real < 0.0, 0.0, np.where(along.real > 1.0, 1.0, along))
    foot = beams.origin + (along * beams.length)[:, None] * beams.axes[:, :, 0]
    away = np.linalg.norm(np.real(point - foot), axis=1)
    e = int(away.argmin())
    size = length_scale(np.real(reduced.nodes))
    if away[e] > ARM * size:
        message = (
            f"lies {away[e]:.4g} m from the axis of the nearest beam, farther than {ARM:g} of the "
            f"part's size ({size:.4g} m); are its coordinates in metres and in the part's frame?"
        )
        raise _refused(reduced, point, message)
    arm = point - foot[e]
    one = BeamElements(**{f.name: getattr(beams, f.name)[e : e + 1] for f in fields(beams)})
    N = (shape_functions(one, along[e]) @ end_displacements(one))[0]
    axes = beams.axes[e]
    theta = axes @ N[3:]
    weights = np.concatenate([axes @ N[:3] - skew(arm) @ theta, theta])
    return Followed(reduced.elements[e], weights.reshape(6, 2, 6), arm)


# -- solids and matrices --------------------------------------------------------------------


def _of_solid(reduced: ReducedPart, point: Array) -> Followed:
    _check_inside(reduced, point)
    known = np.arange(len(reduced.nodes))
    if reduced.faces and reduced.rotation_nodes is not None:
        # the reference nodes of interfaces do not belong to the solid
        known = np.setdiff1d(known, reduced.rotation_nodes)
    x = np.real(reduced.nodes[known])
    tree, count = cKDTree(x), min(AROUND, len(x))
    while True:
        found, places = tree.query(np.real(point), count)
        distance, near = np.atleast_1d(found), known[np.atleast_1d(places)]
        R = float(distance.max()) or 1.0
        P = _polynomials(reduced.nodes[near] - point, R)
        kept = _independent(P)
        if np.array_equal(kept[:4], [0, 1, 2, 3]):
            break
        if count == len(x):
            message = (
                "cannot be interpolated: the nodes of the part lie in one plane or line and do "
                'not determine its rotation; use a node, body["node7"]'
            )
            raise _refused(reduced, point, message)
        count = min(2 * count, len(x))
    d = np.maximum(distance / R, 1e-6)
    root = (1.0 - np.minimum(d, 1.0 - 1e-6) ** 2) / d
    fit = np.linalg.pinv(root[:, None] * P[:, kept]) * root
    value, slope = fit[0], fit[1:4] / R
    weights = np.zeros((6, len(near), 6), fit.dtype)
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        weights[a, :, a] = value
        weights[3 + a, :, c] = 0.5 * slope[b]
        weights[3 + a, :, b] = -0.5 * slope[c]
    return Followed(near, weights, np.zeros(3))


def _polynomials(r: Array, R: float) -> Array:
    """Return 1, x, y, z and their products at points (k, 3), in units of R, (k, 10)."""
    x, y, z = (r / R).T
    return np.stack([np.ones_like(x), x, y, z, x * x, y * y, z * z, x * y, y * z, z * x], axis=1)


def _independent(P: Array) -> list[int]:
    """Return the columns that are linearly independent of the previous ones."""
    kept: list[int] = []
    Q = np.zeros((len(P), 0))
    for j, column in enumerate(np.real(P).T):
        rest = column - Q @ (Q.T @ column)
        rest -= Q @ (Q.T @ rest)
        size = np.linalg.norm(rest)
        if size > DEPENDENT * np.sqrt(len(P)):
            kept.append(j)
            Q = np.column_stack([Q, rest / size])
    return kept


def _check_inside(reduced: ReducedPart, point: Array) -> None:
    x, at = np.real(reduced.nodes), np.real(point)
    hint = (
        "; check that its coordinates are in m and in the frame of the part A point in a bore "
        "or beside the part needs an Interface, which ties the nodes around it to a node of its"
        " own"
    )
    if not reduced.faces:
        low, high = x.min(axis=0), x.max(axis=0)
        away = float(np.linalg.norm(at - np.clip(at, low, high)))
        if away > 1e-6 * length_scale(x):
            message = f"lies {away:.4g} m outside of the box around the nodes of the part{hint}"
            raise _refused(reduced, point, message)
        return
    corners = np.concatenate([_triangles(face) for face in reduced.faces])
    T = x[corners] - at
    distance = _distances(T)
    nearest = int(distance.argmin())
    longest = float(np.linalg.norm(T[nearest] - np.roll(T[nearest], 1, axis=0), axis=1).max())
    # curved faces are treated as flat here
    if distance[nearest] > 0.25 * longest and _turns(T) < 0.5:
        message = f"lies {distance[nearest]:.4g} m outside of the surface of the part{hint}"
        raise _refused(reduced, point, message)


def _triangles(face: Ints) -> Ints:
    """Return the triangles (nt, 3, 3) between the corners of faces of 3, 4, 6 or 8 nodes."""
    if face.shape[1] in (3, 6):
        return np.asarray(face[:, :3])
    return np.concatenate([face[:, [0, 1, 2]], face[:, [0, 2, 3]]])


def _turns(T: Array) -> float:
    """Return the winding number of a closed surface (nt, 3, 3) about the origin; 1 means inside.

    The winding number is the sum of the solid angles divided by 4 pi: van Oosterom and Strackee,
    *IEEE Trans. Biomed. Eng.* 30 (1983).
    """
    a, b, c = T.transpose(1, 0, 2)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    below = la * lb * lc + sum(
        np.einsum("ij,ij->i", u, v) * w for u, v, w in ((a, b, lc), (b, c, la), (c, a, lb))
    )
    return float(np.arctan2(volume, below).sum() / (2.0 * np.pi))


def _distances(T: Array) -> Array:
    """Return the distances (nt,) of triangles (nt, 3, 3) from the origin."""
    normal = np.cross(T[:, 1] - T[:, 0], T[:, 2] - T[:, 0])
    size = np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None]
    normal = normal / size
    best = np.full(len(T), np.inf)
    over = np.ones(len(T), dtype=bool)
    for i in range(3):
        a, b = T[:, i], T[:, (i + 1) % 3]
        side = b - a
        share = -np.einsum("ij,ij->i", a, side) / np.einsum("ij,ij->i", side, side)
        foot = a + np.clip(share, 0.0, 1.0)[:, None] * side
        best = np.minimum(best, np.linalg.norm(foot, axis=1))
        over &= np.einsum("ij,ij->i", np.cross(side, -a), normal) >= 0.0
    height = np.abs(np.einsum("ij,ij->i", T[:, 0], normal))
    return np.where(over, height, best)
