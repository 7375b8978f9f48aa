"""Data of a beam body for the engine: node bodies and the elements between them."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.arrays import Array, read_only
from jousto.base.frozen_dict import Frozen
from jousto.base.numbers import set_fields
from jousto.base.rotations import (
    euler_parameters,
    rotation_matrix,
)
from jousto.mechanism.beams.stiffness import tension_factor
from jousto.mechanism.bodies.body import RigidBody

ROTARY = 1.2  # ratio of the smallest rotary inertia and the inertia that the first moment requires


class BeamNode(RigidBody):
    """Node of a beam: a rigid body with half of the mass of its elements.

    Created by `BeamBody`; its frame is the section frame at the node.

    Parameters
    ----------
    beam : str
        Name of the beam.
    place : int
        Number of the node from 0.
    **fields
        Fields of `RigidBody`, and the mass-proportional damping of its momenta, 1/s.
    """

    beam: str
    place: int
    damping: float

    def __init__(self, beam: str, place: int, **fields: Any) -> None:
        set_fields(
            self,
            name=f"{beam}.node{place + 1}",
            beam=beam,
            place=place,
            markers=Frozen({}),
            **fields,
        )

    def __repr__(self) -> str:
        return f"<BeamNode {self.name!r}: {self.mass:g} kg>"


def _arms(beam: Any) -> tuple[Array, Array]:
    """Return arms u (n, 2, 3) and orientations B (n, 2, 3, 3) of element ends in node frames."""
    u = np.concatenate([np.zeros((beam.n + 1, 1)), beam.offsets], axis=1)
    frames = np.stack([beam.frames[:-1], beam.frames[1:]], axis=1)
    B = np.swapaxes(frames, 2, 3) @ beam.ends
    same = np.abs(B - np.eye(3)).max(axis=(2, 3)) < 1e-14
    B[same] = np.eye(3)
    return np.stack([u[:-1], u[1:]], axis=1), B


def element_data(beam: Any) -> dict[str, Array]:
    """Return the data of all elements of a `BeamBody`, by name in the engine."""
    u, B = _arms(beam)
    made: dict[tuple[int, float], tuple[Array, float]] = {}
    sections = []
    for section, L in zip(beam.sections, beam.lengths, strict=True):
        key = (id(section), float(L) if beam.bending else 0.0)
        if key not in made:
            C = section.with_bending(float(L)) if beam.bending else section.stiffness
            made[key] = C, tension_factor(C)
        C, factor = made[key]
        J = L * section.inertia
        tensor = J[0, 0], J[1, 1], J[2, 2], J[1, 2], J[0, 2], J[0, 1]
        sections.append((C, L * section.mass, tensor, factor, section.polar))
    C, mass, J, limit, polar = (np.array(x, float) for x in zip(*sections, strict=True))
    damping = beam.damping
    return {
        "length": np.array(beam.lengths),
        "u_a": u[:, 0],
        "B_a": B[:, 0],
        "u_b": u[:, 1],
        "B_b": B[:, 1],
        "C": C,
        "e0": np.array(beam.unstressed),
        "beta": np.full(beam.n, damping.stiffness, float),
        "alpha": np.full(beam.n, damping.mass, float),
        "share": np.full(beam.n, beam.share, float),
        "mass": mass,
        "J": J,
        "limit": limit,
        "helical": np.full(beam.n, beam.bending, float),
        "polar": polar,
    }


def node_bodies(beam: Any) -> list[BeamNode]:
    """Return the node bodies with mass, centre and inertia of half of their elements.

    The sum over the nodes is the trapezoidal rule for the kinetic energy ``int f ds`` of
    ``f = rho A v.v / 2``. The "corrected" inertia adds ``(h^2/12) (f'(0) - f'(h))``
    (Euler-Maclaurin) with ``v' = w x t`` for each element of mass m and length h: a first moment m
    h/12 along the axis t, towards the middle of the element. Between equal elements these first
    moments cancel, so that only the ends have one. There a rotary inertia of order h^3 is added to
    keep the mass matrix positive definite.
    """
    n = beam.n
    u, B = _arms(beam)
    half = 0.5 * beam.lengths * np.array([s.mass for s in beam.sections])
    center = np.array([[0.0, *s.center] for s in beam.sections])
    J = 0.5 * beam.lengths[:, None, None] * np.stack([s.inertia for s in beam.sections])
    mass, first, second = np.zeros(n + 1), np.zeros((n + 1, 3)), np.zeros((n + 1, 3, 3))
    extra = np.zeros((n + 1, 3))
    for end in (0, 1):
        rows = slice(end, n + end)
        x = u[:, end] + np.einsum("nij,nj->ni", B[:, end], center)
        mass[rows] += half
        first[rows] += half[:, None] * x
        turned = B[:, end] @ J @ np.swapaxes(B[:, end], 1, 2)
        second[rows] += turned + half[:, None, None] * _steiner(x)
        if beam.corrected:
            ahead = (1 - 2 * end) * (beam.lengths * half / 6)[:, None] * B[:, end, :, 0]
            extra[rows] += ahead
            second[rows] += 2 * np.einsum("ni,ni->n", x, ahead)[:, None, None] * np.eye(3)
            second[rows] -= x[:, :, None] * ahead[:, None] + ahead[:, :, None] * x[:, None]
    first += extra
    second += ROTARY * _steiner(extra) / mass[:, None, None]
    at = first / mass[:, None]
    inertia = second - mass[:, None, None] * _steiner(at)
    inertia = 0.5 * (inertia + np.swapaxes(inertia, 1, 2))
    A = rotation_matrix(beam.orientation)
    reach = A @ beam.nodes.T
    position = beam.position + reach.T
    velocity = beam.velocity + np.cross(beam.angular_velocity, reach.T)
    frames = A @ beam.frames
    for array in (position, velocity, at, inertia):
        array.setflags(write=False)
    bodies = []
    for i in range(n + 1):
        before = 0.5 * beam.lengths[i - 1] if i > 0 else 0.0
        after = 0.5 * beam.lengths[i] if i < n else 0.0
        arm = np.array([0.0, *beam.offsets[i]])
        outline = np.stack([arm, arm])
        outline[0, 0], outline[1, 0] = -before, after
        bodies.append(
            BeamNode(
                beam.name,
                i,
                mass=float(mass[i]),
                inertia=inertia[i],
                center=at[i],
                position=position[i],
                orientation=read_only(euler_parameters(frames[i])),
                velocity=velocity[i],
                angular_velocity=beam.angular_velocity,
                outline=read_only(outline),
                damping=beam.damping.mass,
            )
        )
    return bodies


def _steiner(x: Array) -> Array:
    """Return ``|x|^2 E - x x^T`` (k, 3, 3) of vectors (k, 3)."""
    square = np.einsum("ni,ni->n", x, x)
    return np.asarray(square[:, None, None] * np.eye(3) - x[:, :, None] * x[:, None, :])
