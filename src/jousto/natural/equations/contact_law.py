"""Law of a point of contact, with kinematics of its own: signed distances in the frame of a."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from jousto.base.arrays import Array, crossed
from jousto.mechanism.contacts.laws import POWER
from jousto.mechanism.contacts.shapes import (
    Bore,
    Capsule,
    Cuboid,
    Cylinder,
    HalfSpace,
    HollowSphere,
    Sphere,
    Torus,
)
from jousto.mechanism.forces.base import Push
from jousto.natural.equations.coordinates import Scalars
from jousto.natural.equations.frames import Frames
from jousto.natural.equations.instant import Action, Instant, Law, moment

Distance = Callable[[Array, Array], tuple[float, Array]]
"""Distance of a place from the surface of a shape of some sizes, and its outward normal."""


def _of_plane(size: Array, x: Array) -> tuple[float, Array]:
    return float(x[2]), np.array([0.0, 0.0, 1.0])


def _of_point(x: Array, radius: float, sign: float = 1.0) -> tuple[float, Array]:
    far = float(np.linalg.norm(x))
    return sign * (far - radius), sign * x / far


def _of_sphere(size: Array, x: Array) -> tuple[float, Array]:
    return _of_point(x, size[0])


def _of_hollow_sphere(size: Array, x: Array) -> tuple[float, Array]:
    return _of_point(x, size[0], -1.0)


def _of_bore(size: Array, x: Array) -> tuple[float, Array]:
    return _of_point(x * (1.0, 1.0, 0.0), size[0], -1.0)


def _of_capsule(size: Array, x: Array) -> tuple[float, Array]:
    return _of_point(x - (0.0, 0.0, np.clip(x[2], -size[1], size[1])), size[0])


def _of_torus(size: Array, x: Array) -> tuple[float, Array]:
    flat = x * (1.0, 1.0, 0.0)
    return _of_point(x - size[0] * flat / np.linalg.norm(flat), size[1])


def _of_box(size: Array, x: Array) -> tuple[float, Array]:
    beyond = np.abs(x) - size
    if np.any(beyond > 0.0):
        return _of_point(np.sign(x) * np.maximum(beyond, 0.0), 0.0)
    k = int(np.argmax(beyond))  # inside: over the nearest face
    return float(beyond[k]), np.sign(x[k]) * np.eye(3)[k]


def _of_cylinder(size: Array, x: Array) -> tuple[float, Array]:
    """Distance of a rectangle in the plane through the axis and the place."""
    flat = x * (1.0, 1.0, 0.0)
    far = float(np.linalg.norm(flat))
    out = flat / far if far > 0.0 else np.array([1.0, 0.0, 0.0])
    gap, n = _of_box(np.array([size[0], 1.0, size[1]]), np.array([far, 0.0, x[2]]))
    return gap, n[0] * out + (0.0, 0.0, n[2])


DISTANCES: dict[int, Distance] = {
    HalfSpace.code: _of_plane,
    Sphere.code: _of_sphere,
    HollowSphere.code: _of_hollow_sphere,
    Capsule.code: _of_capsule,
    Cuboid.code: _of_box,
    Cylinder.code: _of_cylinder,
    Bore.code: _of_bore,
    Torus.code: _of_torus,
}
"""Distances by the number of the shape that is touched."""


def left_out(push: Push) -> str:
    """Return what of a contact the moving frame does not have, with the remedy; "" if all."""
    x = {key: np.asarray(value, dtype=float) for key, value in push.data.items()}
    if x["damping"] > 0.0:
        return (
            "the loss of its law depends on the speed at the touch, which the moving frame does "
            "not keep; take restitution=1, SpringDamper or Impact to compare the motion"
        )
    if x["shear"] > 0.0:
        return (
            "its friction has a bristle, which the moving frame does not integrate; take "
            "friction=Regularised(...) or no friction to compare the motion"
        )
    if x["rolling"] > 0.0 or x["drilling"] > 0.0:
        return "the moving frame has no resistance to rolling and drilling"
    if x["resolve"] == 1.0:
        return "the moving frame has no impulses; take resolve='cut'"
    if x["curve"] != POWER:
        return "the moving frame knows powers of the depth only, not lines and tables"
    if int(x["shape"]) not in DISTANCES or x["ring"] > 0.0 or np.any(x["axes"]):
        return (
            "the moving frame has no points that wander on rims and ellipsoids; take spheres or "
            "points at the places that touch"
        )
    return ""


def contact(push: Push, frames: Frames, scalars: Scalars) -> Law:
    """Return the law of a sphere or point of b on a shape of a.

    ``N = max(0, K d^n + c step(d / d1) d')`` along the normal and ``-mu(|v|) N v / |v|`` along the
    slip, at the middle of the overlap; it acts wherever the shapes overlap.
    """
    assert push.a is not None
    assert push.b is not None
    ends = np.array([frames.place(push.a), frames.place(push.b)])
    x = {key: np.asarray(value, dtype=float) for key, value in push.data.items()}
    distance, radius = DISTANCES[int(x["shape"])], float(x["radius"])
    K, n, c, full = (float(x[key]) for key in ("stiffness", "exponent", "viscous", "full"))

    def damper(depth: float) -> tuple[float, float]:
        """Return the damping at a depth and its slope."""
        s = min(depth / full, 1.0) if full > 0.0 else 1.0
        slope = 6.0 * s * (1.0 - s) / full if full > 0.0 else 0.0
        return c * s * s * (3.0 - 2.0 * s), c * slope

    def apply(now: Instant, out: Action) -> None:
        a, b = now.y[ends]
        axes = a[1:]
        centre = b[0] + x["centre"] @ b[1:]
        gap, normal = distance(x["size"], axes @ (centre - a[0]))
        depth = radius - gap
        if not depth > 0.0:
            out.felt.append(np.zeros(6))
            return
        # the common point, and the velocity of b on a there
        u = normal @ axes
        point = centre - (radius - 0.5 * depth) * u
        (va, wa), (vb, wb) = (_velocity(y, dy) for y, dy in zip((a, b), now.dy[ends], strict=True))
        v = vb + np.cross(wb, point - b[0]) - va - np.cross(wa, point - a[0])
        rate = -float(u @ v)
        slip = v + rate * u
        # forces
        elastic = K * depth**n
        damping, steep = damper(depth)
        N = elastic + damping * rate
        acts = N > 0.0
        g = _friction(x, float(slip @ slip)) if acts else 0.0
        F = max(N, 0.0) * (u - g * slip)
        arms = point - a[0], point - b[0]
        for k, sign in enumerate((-1.0, 1.0)):
            out.loads[ends[k]] += _load(sign * F, arms[k], now.y[ends[k]])
        out.felt.append(np.concatenate([F, np.cross(arms[1], F)]))
        out.stored += elastic * depth / (n + 1.0)
        out.damping += (max(N, 0.0) - elastic) * rate
        out.rubbed -= float(F @ slip)
        # stiffness along the normal, damping along it and across
        if not acts:
            return
        across = np.linalg.svd(u[None])[2][1:]
        ways = np.vstack([u, across])
        blocks = [
            [_load(sign * e, arms[k], now.y[ends[k]]) for k, sign in enumerate((-1.0, 1.0))]
            for e in ways
        ]
        pulled = now.pose.pulled(np.array(blocks), np.broadcast_to(ends, (3, 2)))
        stiff = np.diag([n * K * depth ** (n - 1.0) + steep * rate, 0.0, 0.0])
        out.slopes.append(
            (
                (np.broadcast_to(frames.body[ends], (3, 2)), pulled),
                stiff,
                np.diag([damping, g * N, g * N]),
            )
        )

    return apply


def _velocity(y: Array, dy: Array) -> tuple[Array, Array]:
    """Return the velocity of the point of a marker and its angular velocity."""
    return dy[0], 0.5 * crossed(y[1:], dy[1:]).sum(axis=0)


def _load(F: Array, arm: Array, y: Array) -> Array:
    """Return the forces (4, 3) on point and axes of a marker of a force beside its point."""
    out = moment(y, np.cross(arm, F))
    out[0] = F
    return out


def _friction(x: dict[str, Array], square: float) -> float:
    """Return ``mu(|v|) / |v|`` of the smooth law from the square of the slip velocity."""
    velocity, top, kinetic = (float(x[k]) for k in ("velocity", "mu_static", "mu_kinetic"))
    if not velocity > 0.0:
        return 0.0
    w = float(np.sqrt(square)) / velocity
    if w < 1.0:
        return top * (15.0 - 10.0 * w**2 + 3.0 * w**4) / (8.0 * velocity)
    s = min(w - 1.0, 1.0)
    mu = top + (kinetic - top) * s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
    return mu / (w * velocity)
