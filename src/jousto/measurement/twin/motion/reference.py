"""Reference: motion of a body's frame, and its inertial forces on the modes."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import UnivariateSpline

from jousto.base.arrays import Array
from jousto.base.errors import InputError, JoustoWarning, Problem, Problems, suggest
from jousto.base.object_repr import described
from jousto.mechanism.forces.loads import Gravity
from jousto.mechanism.joints.coupling import Drive
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.base import Sensor
from jousto.mechanism.signals.piecewise import Table
from jousto.model.compile import compile
from jousto.recovery.shape import find_body, rotation_matrices
from jousto.reduction.fields.invariants import Invariants
from jousto.reduction.reduced import ReducedPart
from jousto.simulation.kinematics import kinematics
from jousto.simulation.results.solution import Solution

Motion: TypeAlias = tuple[Array, Array, Array]
"""Acceleration of the frame's origin minus gravity, m/s2, angular velocity, rad/s, and angular
acceleration, rad/s2, all resolved in the body frame."""
STILL: Motion = (np.zeros(3), np.zeros(3), np.zeros(3))


@described
@dataclass(frozen=True, eq=False)
class Reference:
    """Motion of a body's frame over time, resolved in its own axes.

    Parameters
    ----------
    time : (nt,) array_like
        Instants, s, increasing; between them the motion is interpolated linearly.
    acceleration : (nt, 3) array_like
        Acceleration of the frame's origin *minus gravity*, m/s2, as measured by an accelerometer;
        (0, 0, 9.81) at rest if z points up.
    w, dw : (nt, 3) array_like
        Angular velocity, rad/s, and angular acceleration, rad/s2.

    Raises
    ------
    InputError
        For wrong shapes, values that are not finite, or times that run backwards.
    """

    time: Array
    acceleration: Array
    w: Array
    dw: Array

    def __post_init__(self) -> None:
        problems = Problems()
        t = problems.array("Reference", "time", self.time, (None,))
        nt = 0 if t is None else len(t)
        fields = {"time": t}
        for key in ("acceleration", "w", "dw"):
            fields[key] = problems.array("Reference", key, getattr(self, key), (nt, 3))
        if t is not None and not len(t):
            problems.add("Reference", "time is empty")
        if t is not None and (np.diff(t) <= 0.0).any():
            k = int(np.argmax(np.diff(t) <= 0.0))
            problems.add(
                "Reference", f"time runs backwards: {t[k]:g} s is followed by {t[k + 1]:g} s"
            )
        problems.raise_if_any()
        for key, value in fields.items():
            object.__setattr__(self, key, value)

    def at(self, t: float) -> Motion:
        """Return the motion at a time; constant outside the given times."""
        times = self.time
        k = min(max(int(np.searchsorted(times, t)), 1), max(len(times) - 1, 0))
        if len(times) == 1 or t >= times[-1]:
            return self.acceleration[-1], self.w[-1], self.dw[-1]
        if t <= times[0]:
            return self.acceleration[0], self.w[0], self.dw[0]
        s = (t - times[k - 1]) / (times[k] - times[k - 1])
        a, w, dw = ((1.0 - s) * x[k - 1] + s * x[k] for x in (self.acceleration, self.w, self.dw))
        return a, w, dw

    @classmethod
    def from_run(
        cls,
        run: Solution,
        body: str,
        *,
        node: str = "",
        reduced: ReducedPart | None = None,
        gravity: ArrayLike | None = None,
    ) -> Reference:
        """Return the motion of a body's frame, or of one of its nodes, in a run.

        Accelerations are differences of the stored velocities: use a short output step.

        Parameters
        ----------
        run : Solution
            Results of `simulate` or `kinematics`.
        body : str
            Name of a rigid or flexible body.
        node : str
            Name of a node with rotations, for a part from `clamp`; the frame of the body if empty.
        reduced : ReducedPart
            The part of the body, needed with `node`.
        gravity : (3,) array_like, optional
            Gravity in the world, m/s2; by default that of the run.

        Raises
        ------
        InputError
            For unknown bodies or nodes, or fewer than three instants.
        """
        shape = find_body(run, body)
        t = run.time
        if len(t) < 3:
            raise InputError(
                Problem(run.where, f"{len(t)} instants; an acceleration needs at least 3")
            )
        g = np.asarray(run.attributes.get("gravity", np.zeros(3)) if gravity is None else gravity)
        q, v = run.q, run.v
        A = rotation_matrices(q[:, shape.q_offset + 3 : shape.q_offset + 7])
        velocity = v[:, shape.v_offset : shape.v_offset + 3]
        w = v[:, shape.v_offset + 3 : shape.v_offset + 6]
        if node:
            p = q[:, shape.q_offset + 7 : shape.q_offset + 7 + shape.n]
            dp = v[:, shape.v_offset + 6 : shape.v_offset + 6 + shape.n]
            A, velocity, w = _at_node(node, reduced, A, velocity, w, p, dp)
        a = np.gradient(velocity, t, axis=0, edge_order=2) - g
        dw = np.gradient(w, t, axis=0, edge_order=2)
        return cls(t, np.einsum("tba,tb->ta", A, a), w, dw)

    @classmethod
    def from_angles(
        cls,
        mechanism: Mechanism,
        body: str,
        time: ArrayLike,
        measured: Mapping[str, ArrayLike],
        *,
        noise: float | Mapping[str, float] = 0.0,
        node: str = "",
    ) -> Reference:
        """Return the motion of a body's frame for measured joint coordinates.

        The drives of the mechanism follow the measured values, all other motions its kinematics
        (`kinematics`: elastic bodies bend under their weight but do not vibrate).

        Parameters
        ----------
        mechanism : Mechanism
            Mechanism with a `Drive` for every motion, without unknown items such as the payload.
        body : str
            Name of the body.
        time : (nt,) array_like
            Instants of the measured values, s.
        measured : mapping of str to (nt,) array_like
            Values of the coordinate of each drive by name, rad or m; other drives keep their
            signal.
        noise : float or mapping of str to float
            Standard deviation of the measured values, rad or m: they are smoothed by a spline that
            stays within it, since differentiation amplifies noise. 0: no smoothing.
        node : str
            Node as in `from_run`.

        Raises
        ------
        InputError
            For names that are not drives, values of another length than the times, or a mechanism
            with free motions.
        """
        problems = Problems()
        where = "Reference.from_angles"
        drives = {x.name: x for x in mechanism.couplings if isinstance(x, Drive)}
        t = problems.array(where, "time", time, (None,))
        nt = 0 if t is None else len(t)
        if t is not None and (nt < 7 or (np.diff(t) <= 0.0).any()):
            problems.add(where, "time must increase and have at least 7 instants")
        values = {}
        for name, given in measured.items():
            values[name] = problems.array(where, f"measured['{name}']", given, (nt,))
            if name not in drives:
                problems.add(where, f"no drive '{name}' in the mechanism{suggest(name, drives)}")
        problems.raise_if_any()
        assert t is not None
        signals = {}
        for name, x in values.items():
            assert x is not None
            sd = float(noise.get(name, 0.0)) if isinstance(noise, Mapping) else float(noise)
            if sd > 0.0:
                x = UnivariateSpline(t, x, w=np.full(nt, 1.0 / sd), k=5, s=nt)(t)
            signals[name] = Table(t, np.asarray(x), "cubic")
        items = [
            Drive(x.name, x.coordinate, signals[x.name])
            if isinstance(x, Drive) and x.name in signals
            else x
            for x in mechanism.items
            if not isinstance(x, Sensor)
        ]
        with warnings.catch_warnings():
            # measured values differ from the initial pose, so a corrected start needs no warning
            warnings.filterwarnings("ignore", ".*the start fits the drives", JoustoWarning)
            model = compile(Mechanism(*items, name=mechanism.name))
        parts = {x.name: getattr(x, "reduced", None) for x in mechanism.bodies}
        gravity = next((x.acceleration for x in items if isinstance(x, Gravity)), np.zeros(3))
        return cls.from_run(
            kinematics(model, t), body, node=node, reduced=parts.get(body), gravity=gravity
        )


def _at_node(
    node: str, reduced: ReducedPart | None, A: Array, velocity: Array, w: Array, p: Array, dp: Array
) -> tuple[Array, Array, Array]:
    """Return orientation, velocity (world) and angular velocity (node axes) of a node."""
    if reduced is None:
        raise InputError(Problem("Reference", f"node '{node}' needs reduced=, the body's part"))
    k = reduced.node(node)
    turn = reduced.rotation(k)
    if turn is None or reduced.n != p.shape[1]:
        raise InputError(
            Problem("Reference", f"node '{node}' has no rotations, or the part is not the body's")
        )
    u, du = reduced.nodes[k] + p @ reduced.modes[k].T, dp @ reduced.modes[k].T
    velocity = velocity + np.einsum("tab,tb->ta", A, np.cross(w, u) + du)
    theta = p @ turn.T
    small = np.hstack([np.ones((len(p), 1)), 0.5 * theta])
    T = rotation_matrices(small)
    return A @ T, velocity, np.einsum("tba,tb->ta", T, w + dp @ turn.T)


@described
@dataclass(frozen=True, eq=False)
class InertialForce:
    """Inertial force of the frame's motion on the modes (floating frame, docs/theory-bodies.md).

    ``f_j = w^T D_j(p) w - 2 w . G_j(p') - I3_j . a - B_j(p) . w'`` with
    ``N_j = N0_j + sum_k p_k E_kj``, ``D_j = tr(N_j) 1 - sym N_j``, ``B_j = axial N_j`` and
    ``G_j = axial sum_k p'_k E_kj``.
    """

    invariants: Invariants

    def __call__(self, motion: Motion, p: Array, dp: Array) -> Array:
        """Return the modal forces (n,), kg^0.5 m/s2.

        Parameters
        ----------
        motion : tuple
            Acceleration minus gravity, w and w', body frame.
        p, dp : (n,) array
            Modal coordinates and velocities.
        """
        a, w, dw = motion
        I = self.invariants
        f = -(a @ I.I3)
        if not (w.any() or dw.any()):
            return np.asarray(f)
        N = I.N0 + np.einsum("k,kjab->jab", p, I.E)
        G = np.einsum("k,kjab->jab", dp, I.E)
        f += np.einsum("jaa->j", N) * (w @ w) - np.einsum("a,jab,b->j", w, N, w)
        return np.asarray(f - _axial(N) @ dw - 2.0 * (_axial(G) @ w))


def cross(a: Array, b: Array) -> Array:
    """Return a x b of two vectors (3,), ten times as fast as numpy.cross."""
    a1, a2, a3 = a.tolist()
    b1, b2, b3 = b.tolist()
    return np.array([a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1])


def _axial(N: Array) -> Array:
    """Return the axial vectors ``int u x phi dm`` (n, 3) of ``int u phi^T dm``."""
    return np.stack(
        [N[:, 1, 2] - N[:, 2, 1], N[:, 2, 0] - N[:, 0, 2], N[:, 0, 1] - N[:, 1, 0]], axis=1
    )
