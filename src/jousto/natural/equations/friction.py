"""Friction of joints by the regularised law, with the reactions of the joints as normal forces."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.arrays import Array, crossed
from jousto.mechanism.forces.friction import Friction, Regularised
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coordinate import Angle
from jousto.natural.equations.constraints import Rows
from jousto.natural.equations.coordinates import Scalars
from jousto.natural.equations.instant import Action, Instant, Law

NEARBY = 1e-6  # relative increment of the squared speed in a finite difference


def reaction(
    joint: Joint, rows: Rows, scalars: Scalars, y: Array, gradients: Array, lam: Array
) -> Array:
    """Return force and moment (6,) of a joint on its body b, about the origin of marker b, world.

    The reaction follows from the work of ``-Cq^T lam`` on the point and axes of b, where a force f
    on an axis e is the moment ``e x f``.
    """
    mine = rows.of[id(joint)]
    along = -lam[mine] @ rows.F[mine]
    used = np.flatnonzero(along)
    on_b = gradients[used, 1]
    axes = y[scalars.ends[used, 1], 1:]
    turned = crossed(axes, on_b[:, 1:]).sum(axis=1)
    return np.concatenate([along[used] @ on_b[:, 0], along[used] @ turned])


def friction_law(friction: Friction, rows: Rows, scalars: Scalars) -> Law:
    """Return the force law of a friction, ``f = -mu(speed) N s'/speed`` along its coordinates."""
    joint, law = friction.joint, friction.law
    assert isinstance(law, Regularised)
    side = scalars.frames.place(joint.frames[0])
    places = [scalars.coordinate(s) for s in friction.coordinates]
    turns = np.array([isinstance(s, Angle) for s in friction.coordinates])
    arms = np.where(turns, friction.radius or 0.0, 1.0)
    top, kinetic, velocity = friction.mu_static, friction.mu_kinetic, law.velocity

    def press(now: Instant) -> tuple[float, float]:
        """Return the normal force, N, and the friction moment per mu of a collar, N m."""
        y = reaction(joint, rows, scalars, now.y, now.gradients, now.lam)
        F, M = (now.y[side, 1:] @ x for x in (y[:3], y[3:]))
        N = friction.preload + float(np.hypot(F[0], F[1]))
        if friction.bearing_length:
            N += float(np.hypot(M[0], M[1])) / friction.bearing_length
        if not friction.collar_radius:
            return N, 0.0
        if turns[0]:
            return N, friction.collar_radius * float(abs(F[2]))
        return N + float(abs(M[2])) / friction.collar_radius, 0.0

    def over_speed(square: float) -> float:
        """Return mu(speed) / speed from the squared speed."""
        w = np.sqrt(square) / velocity
        if w < 1.0:
            return float(top * (15.0 - 10.0 * w**2 + 3.0 * w**4) / (8.0 * velocity))
        x = min(w - 1.0, 1.0)
        mu = top + (kinetic - top) * x**3 * (10.0 - 15.0 * x + 6.0 * x * x)
        return float(mu / np.sqrt(square))

    def apply(now: Instant, out: Action) -> None:
        at = np.array([scalars.number(place) for place in places])
        rate = now.rate[at]
        N, collar = press(now)
        s = arms * rate
        square = float(s @ s)
        g = over_speed(square)
        weight = N * arms + collar * turns
        f = -g * s * weight
        near = NEARBY * (square + velocity**2)
        rise = (over_speed(square + near) - g) / near
        slope: Any = weight[:, None] * arms * (g * np.eye(len(s)) + 2.0 * rise * np.outer(s, s))
        out.along[at] += f
        out.felt.append(f)
        out.rubbed -= float(f @ rate)
        out.slopes.append((at, np.zeros_like(slope), slope))

    return apply
