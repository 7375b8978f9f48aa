"""Laws of forces: forces on the points and axes of markers, and their derivatives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from jousto.base.arrays import Array, crossed, skew
from jousto.mechanism.forces.base import Push
from jousto.natural.equations.bodies import FRAME
from jousto.natural.equations.contact_law import contact
from jousto.natural.equations.coordinates import Scalars
from jousto.natural.equations.frames import Frames, tangent
from jousto.natural.equations.instant import Action, Instant, Law, moment


def factor(signal: Any, t: float) -> float:
    """Return the value of a signal, 1 for none."""
    return 1.0 if signal is None else float(signal(t))


def load(push: Push, frames: Frames, scalars: Scalars) -> Law:
    """Return the law of a force and a torque at a marker."""
    assert push.b is not None
    at = frames.place(push.b)
    F, T = (np.asarray(push.data[key], dtype=float) for key in ("force", "torque"))

    def apply(now: Instant, out: Action) -> None:
        y = now.y[at]
        now_F, now_T = (factor(push.signal, now.t) * x for x in (F, T))
        if push.follow:
            now_F, now_T = now_F @ y[1:], now_T @ y[1:]
        both = moment(y, now_T)
        both[0] = now_F
        out.loads[at] += both
        out.felt.append(np.concatenate([now_F, now_T]))
        if np.any(both):
            out.work += float(np.sum(both * now.dy[at]))

    return apply


def along(push: Push, frames: Frames, scalars: Scalars) -> Law:
    """Return the law of a spring, damper, servo or actuator along a coordinate."""
    assert push.coordinate is not None
    place = scalars.coordinate(push.coordinate)
    k, c, free, preload, limit = (
        float(np.asarray(push.data[key]))
        for key in ("stiffness", "damping", "free", "preload", "limit")
    )

    def apply(now: Instant, out: Action) -> None:
        i = scalars.number(place)
        s, rate = float(now.s[i]), float(now.rate[i])
        goal = [0.0, 0.0]
        if push.reference is not None:
            goal = [float(x) for x in push.reference.jet(np.array(now.t))[:2]]
        f = k * (free + goal[0] - s) + c * (goal[1] - rate) + preload * factor(push.signal, now.t)
        slope, steep, table, damper = -k, -c, 0.0, 0.0
        if push.spring is not None:
            table, rise, _ = (float(x) for x in push.spring.jet(np.array(s)))
            f, slope = f + table, slope + rise
        if push.damper is not None:
            damper, rise, _ = (float(x) for x in push.damper.jet(np.array(rate)))
            f, steep = f + damper, steep + rise
        if limit > 0.0 and abs(f) >= limit:
            f, slope, steep = float(np.copysign(limit, f)), 0.0, 0.0
        out.along[i] += f
        out.felt.append(np.array([f]))
        out.slopes.append((np.array([i]), np.array([[-slope]]), np.array([[-steep]])))
        if push.active:
            out.work += f * rate
        else:
            out.stored += 0.5 * k * (s - free) ** 2 - preload * (s - free)
            out.damping += rate * (c * rate - damper)
            out.work += rate * table

    return apply


def gear_spring(push: Push, frames: Frames, scalars: Scalars) -> Law:
    """Return the law of a spring and damper between two coordinates with a gear ratio."""
    assert push.coordinate is not None and push.other is not None
    places = [scalars.coordinate(s) for s in (push.coordinate, push.other)]
    k, c, ratio, free = (
        float(np.asarray(push.data[key])) for key in ("stiffness", "damping", "ratio", "free")
    )
    shares = np.array([1.0, -1.0 / ratio])

    def apply(now: Instant, out: Action) -> None:
        at = np.array([scalars.number(place) for place in places])
        e, rate = float(shares @ now.s[at]) - free, float(shares @ now.rate[at])
        table = rise = 0.0
        if push.spring is not None:
            table, rise, _ = (float(x) for x in push.spring.jet(np.array(e)))
        force = shares * (table - k * e - c * rate)
        out.along[at] += force
        out.felt.append(force)
        both = np.outer(shares, shares)
        out.slopes.append((at, (k - rise) * both, c * both))
        out.stored += 0.5 * k * e * e
        out.damping += c * rate * rate
        out.work += rate * table

    return apply


def stop(push: Push, frames: Frames, scalars: Scalars) -> Law:
    """Return the law of a stop at the limits of a coordinate."""
    assert push.coordinate is not None
    place = scalars.coordinate(push.coordinate)
    k, low, high, loss, speed = (
        float(np.asarray(push.data[key]))
        for key in ("stiffness", "lower", "upper", "loss", "speed")
    )

    def apply(now: Instant, out: Action) -> None:
        i = scalars.number(place)
        s, rate = float(now.s[i]), float(now.rate[i])
        side, d = (1.0, s - high) if s > high else (-1.0, max(0.0, low - s))
        x = float(np.clip(side * rate / speed, -1.0, 1.0))
        share = loss * 0.5 * x * (3.0 - x * x)
        f = -side * k * d
        out.along[i] += f * (1.0 + share)
        out.felt.append(np.array([f * (1.0 + share)]))
        slope = k * (1.0 + share) if d > 0.0 else 0.0
        steep = k * d * 1.5 * loss * (1.0 - x * x) / speed
        out.slopes.append((np.array([i]), np.array([[slope]]), np.array([[steep]])))
        out.stored += 0.5 * k * d * d
        out.damping -= f * share * rate

    return apply


def relative(a: Array, b: Array) -> tuple[Array, Array, Array]:
    """Return ``[d, theta]`` (6,) of b relative to a, resolved in a, and its gradients (6, 4, 3).

    ``exp(theta~) = A_a^T A_b``; a small rotation ``delta`` of b relative to a, resolved in a,
    changes theta by ``T(theta)^-1 delta`` with the T of ``exp(theta~)' = (T theta')~ exp(theta~)``.
    """
    d = b[0] - a[0]
    theta = Rotation.from_matrix(a[1:] @ b[1:].T).as_rotvec()
    ga, gb = np.zeros((6, 4, 3)), np.zeros((6, 4, 3))
    for k in range(3):
        ga[k, 0], ga[k, 1 + k], gb[k, 0] = -a[1 + k], d, a[1 + k]
    # rows of back: world axes about which a rotation changes theta_k
    back = np.linalg.inv(tangent(theta)) @ a[1:]
    for k in range(3):
        ga[3 + k, 1:] = -0.5 * crossed(back[k], a[1:])
        gb[3 + k, 1:] = 0.5 * crossed(back[k], b[1:])
    return np.concatenate([a[1:] @ d, theta]), ga, gb


def bushing(push: Push, frames: Frames, scalars: Scalars) -> Law:
    """Return the law of a bushing."""
    assert push.a is not None
    assert push.b is not None
    ends = np.array([frames.place(push.a), frames.place(push.b)])
    K, D = (np.asarray(push.data[key], dtype=float).reshape(6, 6) for key in ("K", "D"))
    preload = np.asarray(push.data["preload"], dtype=float)

    def apply(now: Instant, out: Action) -> None:
        a, b = now.y[ends]
        x, ga, gb = relative(a, b)
        da, db = now.dy[ends]
        rate = np.sum(ga * da + gb * db, axis=(1, 2))
        J = np.eye(6)
        J[3:, 3:] = tangent(x[3:])  # angular velocity = J theta'
        damping = J.T @ D @ J
        f = preload - K @ x - damping @ rate
        out.loads[ends[0]] += np.tensordot(f, ga, 1)
        out.loads[ends[1]] += (on_b := np.tensordot(f, gb, 1))
        out.felt.append(np.concatenate([on_b[0], crossed(b[1:], on_b[1:]).sum(axis=0)]))
        blocks = now.pose.pulled(np.stack([ga, gb], axis=1), np.broadcast_to(ends, (6, 2)))
        out.slopes.append(((np.broadcast_to(frames.body[ends], (6, 2)), blocks), K, damping))
        out.stored += float(x @ (0.5 * K @ x - preload))
        out.damping += float(rate @ damping @ rate)

    return apply


def modal_load(push: Push, frames: Frames, scalars: Scalars) -> Law:
    """Return the law of a pattern of nodal forces that turns with a body."""
    assert push.body is not None
    body = frames.index(push.body)
    F, T = (np.asarray(push.data[key], dtype=float) for key in ("force", "torque"))
    modal = np.asarray(push.rest[0], dtype=float)

    def apply(now: Instant, out: Action) -> None:
        X = frames.bodies.split(now.q)[0][body]
        scale = factor(push.signal, now.t)
        world_F, world_T = scale * (F @ X[1:]), scale * (T @ X[1:])
        Q = np.zeros(frames.bodies.width)
        both = moment(X, world_T)
        both[0] = world_F
        Q[:FRAME] = both.ravel()
        Q[FRAME : FRAME + len(modal)] = scale * modal
        out.direct[body] += Q
        out.felt.append(np.concatenate([world_F, world_T]))
        out.work += float(Q @ now.v.reshape(len(out.direct), -1)[body])

    return apply


def moving(push: Push, frames: Frames, scalars: Scalars) -> Law:
    """Return the law of a force that travels along a path on a body."""
    assert push.reference is not None
    assert push.body is not None
    position = push.reference
    body = frames.index(push.body)
    lengths, pieces = (np.asarray(x) for x in push.rest)
    F = np.asarray(push.data["force"])

    def apply(now: Instant, out: Action) -> None:
        s = float(position(now.t))
        if not 0.0 <= s <= lengths[-1]:
            out.felt.append(np.zeros(6))
            return
        k = min(int(np.searchsorted(lengths, s, side="right")) - 1, len(lengths) - 2)
        X, xi = (x[body] for x in frames.bodies.split(now.q))
        place = pieces[k] @ (s - lengths[k]) ** np.arange(4)
        Phi = place[1:].T
        n = Phi.shape[1]
        world = factor(push.signal, now.t) * (F @ X[1:] if push.follow else F)
        Q = np.zeros(frames.bodies.width)
        Q[:FRAME] = np.outer(np.append(1.0, place[0] + Phi @ xi[:n]), world).ravel()
        Q[FRAME : FRAME + n] = Phi.T @ (X[1:] @ world)
        out.direct[body] += Q
        out.felt.append(np.append(world, np.zeros(3)))
        out.work += float(Q @ now.v.reshape(len(out.direct), -1)[body])

    return apply


def user(push: Push, frames: Frames, scalars: Scalars) -> Law:
    """Return the law of a force computed by a Python function."""
    assert push.a is not None
    assert push.b is not None
    ends = frames.place(push.a), frames.place(push.b)

    def apply(now: Instant, out: Action) -> None:
        a, b = now.y[ends[0]], now.y[ends[1]]
        da, db = (now.dy[k] for k in ends)
        wa, wb = (0.5 * crossed(y[1:], dy[1:]).sum(axis=0) for y, dy in ((a, da), (b, db)))
        axes, d = a[1:], b[0] - a[0]
        x = np.concatenate(
            [
                axes @ d,
                (axes @ b[1:].T).ravel(),
                axes @ (db[0] - da[0] - skew(wa) @ d),
                axes @ (wb - wa),
            ]
        )
        y = np.asarray(push.function(now.t, x), dtype=float)
        F, T = y[:3] @ axes, y[3:] @ axes
        on_a, on_b = moment(a, -T - crossed(d, F)), moment(b, T)
        on_a[0], on_b[0] = -F, F
        out.loads[ends[0]] += on_a
        out.loads[ends[1]] += on_b
        out.felt.append(np.concatenate([F, T]))
        out.work += float(np.sum(on_a * da) + np.sum(on_b * db))

    return apply


LAWS: dict[str, Callable[[Push, Frames, Scalars], Law]] = {
    "load": load,
    "along": along,
    "bushing": bushing,
    "stop": stop,
    "gear spring": gear_spring,
    "modal load": modal_load,
    "moving load": moving,
    "user": user,
    "contact": contact,
}
"""Laws by the word of a `Push`."""

REFUSED = {
    "pid": "it does not integrate the states of controllers",
    "memory": "it has no values that are sampled or kept from the steps before",
    "delay": "it does not keep the motion before",
    "network": "it has no states with equations of their own",
    "contact set": "it has no bristles and does not locate a touch in time",
    "contact slot": "it has no bristles and does not locate a touch in time",
    "contact pair": "it has no bristles and does not locate a touch in time",
    "slider": "it has no curves through nodes of beams",
    "contact track": "it has no bristles and does not locate a touch in time",
    "rail": "it has no bodies of revolution on rails",
    "tyre": "it does not integrate the slip of tyres",
    "plastic": "it has no plastic deformation that the end of a step keeps",
}
"""Laws of the engine that the moving frame does not have, and why."""
