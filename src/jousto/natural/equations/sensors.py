"""Sensor values of a motion in natural coordinates."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from jousto.base.arrays import Array, crossed
from jousto.base.rotations import euler_parameters
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.sensors.base import Reading, Sensor
from jousto.natural.equations.friction import reaction
from jousto.natural.equations.supported import is_sum
from jousto.natural.equations.system import Machine
from jousto.natural.equations.trapezoidal_step import Motion


class Reader:
    """Evaluator of the sensors of a mechanism, to be built before ``machine.close()``.

    Parameters
    ----------
    machine : Machine
        The machine.
    sensors : tuple of Sensor
        Sensors to evaluate.
    """

    def __init__(self, machine: Machine, sensors: tuple[Sensor, ...]) -> None:
        self.machine = machine
        self.sensors = sensors
        self._reads = [self._made(sensor.reading, sensor) for sensor in sensors]

    def read(self, motion: Motion, energies: dict[str, float]) -> list[Array]:
        """Return the values of every sensor."""
        pose = motion.place.pose
        moved = pose.y, pose.rates(motion.v), pose.rates(motion.a) + motion.drift
        now = _Now(motion, moved, energies)
        return [np.atleast_1d(read(now)) for read in self._reads]

    def _made(self, reading: Reading, sensor: Sensor) -> Callable[[_Now], Any]:
        kind, of = reading.kind, reading.of
        if isinstance(of, Marker):
            return self._motion(reading)
        if kind == "deformation momentum":
            return self._momenta(of)
        if kind in ("modal", "stress", "von mises", "principal", "bridge"):
            return self._modes(reading)
        if kind in ("coordinate", "rate"):
            place = self.machine.scalars.coordinate(of)
            return lambda now: self._coordinate(now, place, kind)
        if kind == "energy":
            return lambda now: now.energies[of]
        if kind == "signal":
            return lambda now: of(now.motion.t)
        if kind == "multiplier":
            rows = self.machine.rows.of[id(of)]
            factors = np.asarray(of.lines[0].factors)
            return lambda now: -now.motion.lam[rows][0] * factors
        if kind == "reaction":
            return self._reaction(of, reading.axes)
        if kind in ("element", "friction") or is_sum(reading):
            return self._force(reading, len(sensor.components))
        raise TypeError(f"no reading {kind!r}")

    def _resolved(self, axes: Marker | None) -> Callable[[_Now, Array], Array]:
        if axes is None:
            return lambda now, x: x
        at = self.machine.frames.place(axes)
        return lambda now, x: (x.reshape(-1, 3) @ now.moved[0][at, 1:].T).ravel()

    def _motion(self, reading: Reading) -> Callable[[_Now], Any]:
        frames, kind = self.machine.frames, reading.kind
        at = frames.place(reading.of)
        by = reading.other
        if by is None and kind == "acceleration parts":
            by = Marker(reading.of.body, "frame", np.zeros(3), None, np.eye(3))
        other = None if by is None else frames.place(by)
        resolve = self._resolved(reading.axes)

        def orientation(now: _Now) -> Array:
            axes = now.moved[0][at, 1:].T
            if (
                other is not None
            ):  # rotation, in world axes, from the axes of the other marker to these
                axes = axes @ now.moved[0][other, 1:]
            e = euler_parameters(axes)
            return np.append(e[:1], resolve(now, e[1:]))

        def motion(now: _Now) -> Array:
            x = (
                marker_motion(now, at)
                if other is None
                else relative_motion(marker_motion(now, at), marker_motion(now, other))
            )
            return resolve(now, x[kind])

        def parts(now: _Now) -> Array:
            assert other is not None
            return resolve(
                now, acceleration_parts(marker_motion(now, at), marker_motion(now, other))
            )

        return {"orientation": orientation, "acceleration parts": parts}.get(kind, motion)

    def _momenta(self, body: FlexibleBody) -> Callable[[_Now], Any]:
        i, n, bodies = self.machine.frames.index(body), body.n, self.machine.bodies
        I = body.reduced.invariants

        def momenta(now: _Now) -> Array:
            p, rate = (bodies.split(x)[1][i, :n] for x in (now.motion.place.q, now.motion.v))
            about = I.I4 + np.einsum("j,jak->ak", p, I.I5)
            return np.concatenate([I.I3 @ rate, about @ rate])

        return momenta

    def _modes(self, reading: Reading) -> Callable[[_Now], Any]:
        body, kind, rows, other = reading.of, reading.kind, reading.rows, reading.other
        i, n = self.machine.frames.index(body), body.n
        bodies = self.machine.bodies

        def modal(now: _Now) -> Array:
            p, rate = (bodies.split(x)[1][i, :n] for x in (now.motion.place.q, now.motion.v))
            if kind == "modal":
                return np.concatenate([p, rate])
            assert rows is not None
            apparent = 0.0 if other is None else float(other(now.motion.t))
            if kind == "bridge":
                return np.array([bridge(rows[:4, :n] @ p + rows[4, :4] * apparent)])
            values = rows[:, :n] @ p
            if kind == "stress":
                return np.asarray(values + apparent)
            tensors = voigt(values.reshape(-1, 6))
            principal = np.linalg.eigvalsh(tensors)[:, ::-1]
            if kind == "principal":
                return np.asarray(principal.ravel())
            gaps = principal - np.roll(principal, 1, axis=1)
            return np.asarray(np.sqrt(0.5 * np.sum(gaps * gaps, axis=1)))

        return modal

    def _coordinate(self, now: _Now, place: tuple[str, int], kind: str) -> float:
        i = self.machine.scalars.number(place)
        if kind == "coordinate":
            return float(now.motion.place.s[i])
        return float(now.motion.place.slopes.times(now.motion.v)[i])

    def _reaction(self, joint: Joint, axes: Marker | None) -> Callable[[_Now], Any]:
        machine, resolve = self.machine, self._resolved(axes)

        def react(now: _Now) -> Array:
            y, gradients, lam = now.moved[0], now.motion.place.gradients, now.motion.lam
            return resolve(now, reaction(joint, machine.rows, machine.scalars, y, gradients, lam))

        return react

    def _force(self, reading: Reading, count: int) -> Callable[[_Now], Any]:
        place, first = self.machine.felt[id(reading.of)], int(reading.other or 0)
        resolve = self._resolved(reading.axes)
        laws = len(reading.of.pushes) if getattr(reading.of, "summed", False) else 1

        def force(now: _Now) -> Array:
            felt = now.motion.action.felt[place : place + laws]
            values = np.sum(felt, axis=0)[first : first + count]
            return np.asarray(values) if count < 3 else resolve(now, values)

        return force


class _Now:
    """Motion of a machine with the motion of its markers."""

    def __init__(
        self, motion: Motion, moved: tuple[Array, Array, Array], energies: dict[str, float]
    ) -> None:
        self.motion, self.moved, self.energies = motion, moved, energies


def marker_motion(now: _Now, at: int) -> dict[str, Array]:
    """Return position, orientation, velocities and accelerations of a marker in the world.

    ``w = sum e_k x e_k' / 2`` over the axes e_k, and ``w' = sum e_k x e_k'' / 2``.
    """
    y, v, a = (x[at] for x in now.moved)
    return {
        "position": y[0],
        "velocity": v[0],
        "acceleration": a[0],
        "angular velocity": 0.5 * crossed(y[1:], v[1:]).sum(axis=0),
        "angular acceleration": 0.5 * crossed(y[1:], a[1:]).sum(axis=0),
    }


def relative_motion(of: dict[str, Array], by: dict[str, Array]) -> dict[str, Array]:
    """Return the motion of a marker relative to another one that moves and rotates."""
    x = {key: of[key] - by[key] for key in of}
    w, turn = by["angular velocity"], by["angular acceleration"]
    d, u = x["position"], x["velocity"] - crossed(w, x["position"])
    x["acceleration"] = (
        x["acceleration"] - crossed(turn, d) - crossed(w, crossed(w, d)) - 2.0 * crossed(w, u)
    )
    x["velocity"] = u
    x["angular acceleration"] = x["angular acceleration"] - crossed(w, x["angular velocity"])
    return x


def acceleration_parts(of: dict[str, Array], by: dict[str, Array]) -> Array:
    """Return the parts (15,) of the acceleration of a marker relative to another one.

    The parts are the acceleration of the other marker, the centripetal, the tangential, the
    Coriolis and the relative one, each in world axes.
    """
    w, turn = by["angular velocity"], by["angular acceleration"]
    moved = relative_motion(of, by)
    d = moved["position"]
    return np.concatenate(
        [
            by["acceleration"],
            crossed(w, crossed(w, d)),
            crossed(turn, d),
            2.0 * crossed(w, moved["velocity"]),
            moved["acceleration"],
        ]
    )


def voigt(s: Array) -> Array:
    """Return tensors (k, 3, 3) of stresses (k, 6) ``[s11 s22 s33 s12 s23 s13]``."""
    return s[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3)


def bridge(r: Array) -> float:
    """Return output over supply voltage of a Wheatstone bridge, with arms 1, 2 parallel to 4, 3.

    ``(R1 R3 - R2 R4) / ((R1 + R2) (R3 + R4))`` with the relative changes r of the resistances.
    """
    R = 1.0 + r
    return float((R[0] * R[2] - R[1] * R[3]) / ((R[0] + R[1]) * (R[2] + R[3])))
