"""System: modes, unknown loads and channels as one linear stochastic state-space model."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg as la
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.object_repr import described
from jousto.measurement.twin.motion.reference import InertialForce, Motion, cross
from jousto.reduction.reduced import ReducedPart

LOADS = ("fx", "fy", "fz", "mx", "my", "mz")
"""Components of a nodal load: forces, N, and moments, N m, along the body axes."""
FADED = 4.0
"""Decay exponent of a step beyond which its matrices are built from two half steps."""


@explained
@described
@dataclass(frozen=True, eq=False)
class UnknownLoad:
    """Unknown load, a random walk that is estimated from the gauges.

    A rough load obeys ``da = -a dt / tau + rate dW`` in the axes of the body; with a `size` it
    returns to its mean with the time constant ``tau = 2 size^2 / rate^2``, without a size it is a
    random walk. For a smooth load ``a'' + 2 c a' + c^2 a`` is white noise with ``c = rate / size``,
    so that a has the standard deviation `size` and a' the standard deviation `rate`; this suits
    loads without jumps, such as a swinging payload.

    Parameters
    ----------
    place : str
        Node where the load acts, such as ``"end"``; any name if `pattern` is given.
    components : sequence of str
        Some of ``fx fy fz mx my mz`` (N, N m).
    rate : float or (k,) array_like
        Standard deviation of the change in a second, N/s^0.5 or N m/s^0.5; for a smooth load that
        of its rate of change, N/s or N m/s. It need not be exact: `tune` computes it from data.
    size : float or (k,) array_like, optional
        Standard deviation about the mean in the long run, N or N m.
    mean : float or (k,) array_like
        Mean value, N or N m.
    smooth : bool
        Whether the load changes without jumps; needs a size.
    pattern : (n, k) array_like, optional
        Modal forces per unit of load, instead of a node: ``Phi^T L`` of a distributed load.

    Raises
    ------
    InputError
        For unknown components or numbers that are not positive.

    Examples
    --------
    >>> UnknownLoad("end", ("fx", "fz"), rate=1e4, size=2e4).labels
    ('end.fx', 'end.fz')
    """

    place: str
    components: Any = ("fx", "fy", "fz")
    rate: Any = 1e3
    size: Any = None
    mean: Any = 0.0
    smooth: bool = False
    pattern: Any = None

    def __post_init__(self) -> None:
        problems = Problems()
        where = f"unknown load '{self.place}'"
        given = (self.components,) if isinstance(self.components, str) else self.components
        components = tuple(part for name in given for part in str(name).split())
        pattern = self.pattern
        if pattern is not None:
            pattern = problems.array(
                where, "pattern", np.atleast_2d(np.asarray(pattern).T).T, (None, None)
            )
            k = 0 if pattern is None else pattern.shape[1]
            components = tuple(f"a{i + 1}" for i in range(k))
        else:
            for name in components:
                if name not in LOADS:
                    problems.add(where, f"no component '{name}'{suggest(name, LOADS)}")
            if len(set(components)) < len(components) or not components:
                problems.add(where, "components must be one or more, each once")
        k = len(components)
        values: dict[str, Any] = {}
        for key in ("rate", "size", "mean"):
            raw = getattr(self, key)
            if raw is None:
                values[key] = None
                continue
            try:
                values[key] = np.broadcast_to(np.array(raw, dtype=np.float64), (k,)).copy()
            except (TypeError, ValueError):
                problems.add(where, f"{key} is {raw!r}, must be 1 or {k} numbers")
                continue
            good = np.isfinite(values[key]) & (True if key == "mean" else values[key] > 0.0)
            if not np.all(good):
                kind = "finite" if key == "mean" else "positive"
                problems.add(where, f"{key} is {raw!r}, must be {kind}")
        if self.smooth and self.size is None:
            problems.add(where, "a smooth load needs a size, its standard deviation in N or N m")
        problems.raise_if_any()
        object.__setattr__(self, "components", components)
        object.__setattr__(self, "pattern", pattern)
        for key, value in values.items():
            object.__setattr__(self, key, value)

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the components, ``place.fx`` and so on."""
        return tuple(f"{self.place}.{name}" for name in self.components)

    def columns(self, reduced: ReducedPart) -> tuple[Array, Array]:
        """Return modal forces (n, k) and wrenches about the frame's origin (6, k) per unit load.

        Raises
        ------
        InputError
            If there is no such node, a moment acts on a node without rotations, or the pattern
            belongs to another part.
        """
        where = f"unknown load '{self.place}'"
        if self.pattern is not None:
            if len(self.pattern) != reduced.n:
                raise InputError(
                    Problem(where, f"pattern has {len(self.pattern)} rows for {reduced.n} modes")
                )
            return self.pattern, np.full((6, self.pattern.shape[1]), np.nan)
        k = reduced.node(self.place)
        turn = reduced.rotation(k)
        if turn is None and any(name in LOADS[3:] for name in self.components):
            raise InputError(
                Problem(where, f"node '{self.place}' has no rotations, so no moment can act on it")
            )
        x = reduced.nodes[k]
        modal, wrench = [], []
        for name in self.components:
            axis = np.eye(3)[LOADS.index(name) % 3]
            force = name in LOADS[:3]
            rows = reduced.modes[k] if force or turn is None else turn
            modal.append(axis @ rows)
            wrench.append(np.r_[axis, np.cross(x, axis)] if force else np.r_[np.zeros(3), axis])
        return np.array(modal).T, np.array(wrench).T

    def arms(self, reduced: ReducedPart) -> Array:
        """Return the derivative (3, k, n) of the moment of each unit load by the modes."""
        arms = np.zeros((3, len(self.components), reduced.n))
        if self.pattern is None:
            phi = reduced.modes[reduced.node(self.place)]
            for i, name in enumerate(self.components):
                if name in LOADS[:3]:
                    arms[:, i] = np.cross(phi, np.eye(3)[LOADS.index(name)], axisa=0).T
        return arms


@described
@dataclass(frozen=True, eq=False)
class System:
    """Linear model ``x' = A x + ..`` of dynamic modes, their rates and unknown loads.

    ``x = [p_d p_d' a]``; modes above `limit` are quasi-static, ``p_s = W_s^-2 (Phi_s^T L a + f)``.

    Parameters
    ----------
    reduced : ReducedPart
        Modes and invariants.
    damping : (n,) array
        Diagonal of D, 1/s.
    loads : sequence of UnknownLoad
        Unknown loads.
    limit : float
        Frequency above which modes follow statically, Hz.
    disturbance : float
        Additional white modal forces, kg^0.5 m/s^1.5.
    gauges : int
        Number of gauges with a discrepancy.
    discrepancy, lasting : float
        Standard deviation, m/m, and time constant, s, of the errors of the model and of the zero of
        each gauge: ``dd = -d dt / lasting + ...``, a state for each gauge.
    """

    reduced: ReducedPart
    damping: Array
    loads: tuple[UnknownLoad, ...]
    limit: float
    disturbance: float = 0.0
    gauges: int = 0
    discrepancy: float = 0.0
    lasting: float = 10.0
    labels: tuple[str, ...] = field(init=False)
    dynamic: NDArray[np.bool_] = field(init=False)
    columns: Array = field(init=False)
    wrenches: Array = field(init=False)
    rate: Array = field(init=False)
    size: Array = field(init=False)
    mean: Array = field(init=False)
    smooth: NDArray[np.bool_] = field(init=False)
    _discrete: dict[float, tuple[Array, Array, Array]] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        found = [load.columns(self.reduced) for load in self.loads]
        n = self.reduced.n

        def put(name: str, value: Any) -> None:
            object.__setattr__(self, name, value)

        put("labels", tuple(label for load in self.loads for label in load.labels))
        put("dynamic", self.reduced.frequencies < self.limit)
        put("columns", np.hstack([np.zeros((n, 0)), *(modal for modal, _ in found)]))
        put("wrenches", np.hstack([np.zeros((6, 0)), *(wrench for _, wrench in found)]))
        put("rate", np.concatenate([np.zeros(0), *(load.rate for load in self.loads)]))
        sizes = [
            np.full(len(load.components), np.inf) if load.size is None else load.size
            for load in self.loads
        ]
        put("size", np.concatenate([np.zeros(0), *sizes]))
        put(
            "smooth",
            np.concatenate(
                [
                    np.zeros(0, dtype=bool),
                    *(np.full(len(load.components), load.smooth) for load in self.loads),
                ]
            ),
        )
        put("mean", np.concatenate([np.zeros(0), *(load.mean for load in self.loads)]))

    @property
    def nd(self) -> int:
        """Number of dynamic modes."""
        return int(self.dynamic.sum())

    @property
    def na(self) -> int:
        """Number of unknown loads."""
        return len(self.labels)

    @property
    def nx(self) -> int:
        """Length of the state."""
        return 2 * self.nd + self.na + int(self.smooth.sum()) + self.misses

    @property
    def misses(self) -> int:
        """Number of model-error states at the end of the state; 0 without model error."""
        return self.gauges if self.discrepancy > 0.0 else 0

    @property
    def places(self) -> slice:
        """Indices of the loads in the state; the slopes of smooth loads follow after them."""
        return slice(2 * self.nd, 2 * self.nd + self.na)

    @property
    def static_states(self) -> Array:
        """Static states (nx, na) under constant unit loads, one column per load."""
        d = self.dynamic
        T = np.zeros((self.nx, self.na))
        T[: self.nd] = self.columns[d] / self.reduced.stiffness[d, None]
        T[self.places] = np.eye(self.na)
        return T

    @property
    def bound(self) -> Array:
        """Prior standard deviation of the loads (na,)."""
        return np.where(np.isfinite(self.size), self.size, 10.0 * self.rate)

    @cached_property
    def shape(self) -> Array:
        """Modal coordinates of the state (n, nx), without known forces on static modes."""
        C = np.zeros((self.reduced.n, self.nx))
        C[self.dynamic, : self.nd] = np.eye(self.nd)
        static = ~self.dynamic
        C[static, self.places] = self.columns[static] / self.reduced.stiffness[static, None]
        return C

    @cached_property
    def rates(self) -> Array:
        """Modal velocities of the state (n, nx); zero for static modes."""
        C = np.zeros((self.reduced.n, self.nx))
        C[self.dynamic, self.nd : 2 * self.nd] = np.eye(self.nd)
        return C

    @cached_property
    def accelerations(self) -> Array:
        """Modal accelerations of the state (n, nx), without known forces."""
        C = np.zeros((self.reduced.n, self.nx))
        d = self.dynamic
        C[d, : self.nd] = -np.diag(self.reduced.stiffness[d])
        C[d, self.nd : 2 * self.nd] = -np.diag(self.damping[d])
        C[d, self.places] = self.columns[d]
        return C

    def discrete(self, dt: float) -> tuple[Array, Array, Array]:
        """Return F, Gu and Q of ``x_k+1 = F x_k + Gu f_d + w``, ``cov w = Q``, for a step, s.

        The result is exact for forces that are constant in the step (Van Loan 1978).
        """
        key = dt = round(dt, 12)
        if key in self._discrete:
            return self._discrete[key]
        nx, nd = self.nx, self.nd
        A = np.zeros((nx, nx))
        A[:nd, nd : 2 * nd] = np.eye(nd)
        A[nd : 2 * nd] = self.accelerations[self.dynamic]
        noise, scale = np.zeros(nx), np.ones(nx)
        noise[nd : 2 * nd] = self.disturbance**2
        rough = np.flatnonzero(~self.smooth)
        at = 2 * nd + rough
        A[at, at] = -0.5 * (self.rate[rough] / self.size[rough]) ** 2
        noise[at] = self.rate[rough] ** 2
        smooth = np.flatnonzero(self.smooth)
        at, slope = 2 * nd + smooth, 2 * nd + self.na + np.arange(len(smooth))
        c = self.rate[smooth] / self.size[smooth]
        A[at, slope], A[slope, at], A[slope, slope] = 1.0, -(c**2), -2.0 * c
        noise[slope] = 4.0 * c**3 * self.size[smooth] ** 2
        last = np.arange(nx - self.misses, nx)
        A[last, last] = -1.0 / self.lasting
        noise[last] = 2.0 / self.lasting * self.discrepancy**2
        # scale the states: loads are 1e9 times as large as modal coordinates
        scale[self.places] = self.bound
        scale[slope] = self.rate[smooth]
        scale[last] = self.discrepancy
        A = A / scale[:, None] * scale
        if dt * np.abs(la.eigvals(A).real).max(initial=0.0) > FADED:
            # decaying states grow in backward time and overflow: square the half step
            F, G, Q = self.discrete(0.5 * dt)
            Q = F @ Q @ F.T + Q
            self._discrete[key] = (F @ F, F @ G + G, 0.5 * (Q + Q.T))
            return self._discrete[key]
        big = np.zeros((2 * nx, 2 * nx))
        big[:nx, :nx], big[:nx, nx:], big[nx:, nx:] = -A, np.diag(noise / scale**2), A.T
        E = la.expm(dt * big)
        F = E[nx:, nx:].T
        Q = F @ E[:nx, nx:]
        push = np.zeros((nx + nd, nx + nd))
        push[:nx, :nx], push[nd : 2 * nd, nx:] = A, np.eye(nd)
        G = la.expm(dt * push)[:nx, nx:] * scale[:, None]
        F = F * scale[:, None] / scale
        Q = 0.5 * (Q + Q.T) * np.outer(scale, scale)
        if len(self._discrete) > 64:  # bound the cache: clock jitter gives many different steps
            self._discrete.clear()
        self._discrete[key] = (F, np.asarray(G), Q)
        return self._discrete[key]

    def start(self) -> Array:
        """Return the prior covariance (nx, nx): unknown loads, small vibration."""
        nd, w2 = self.nd, self.reduced.stiffness[self.dynamic]
        T = self.static_states
        P = (T * self.bound**2) @ T.T
        last = np.arange(self.nx - self.misses, self.nx)
        P[last, last] = self.discrepancy**2
        slope = np.arange(2 * nd + self.na, self.nx - self.misses)
        P[slope, slope] = self.rate[self.smooth] ** 2
        shake = 0.09 * np.diag(P)[:nd] + 1e-30
        P[np.arange(nd), np.arange(nd)] += shake
        P[nd + np.arange(nd), nd + np.arange(nd)] += shake * w2
        return np.asarray(P)

    def known_forces(self, force: InertialForce, motion: Motion, p: Array, dp: Array) -> Array:
        """Return the modal forces (n,) of the frame's motion and of the mean loads."""
        return np.asarray(force(motion, p, dp) + self.columns @ self.mean)


@described
@dataclass(frozen=True, eq=False)
class Accelerometer:
    """Accelerometer on a node: acceleration minus gravity along a direction.

    Parameters
    ----------
    name : str
        Name of the channel.
    node : str
        Node of the part.
    direction : (3,) array_like
        Direction of its axis, body frame.
    noise : float
        Standard deviation, m/s2.
    """

    name: str
    node: str
    direction: Any = (0.0, 0.0, 1.0)
    noise: float = 0.05

    def __post_init__(self) -> None:
        problems = Problems()
        where = f"accelerometer '{self.name}'"
        t = problems.array(where, "direction", self.direction, (3,))
        if t is not None and not t.any():
            problems.add(where, "direction is zero")
        problems.positive(where, "noise", self.noise, "m/s2")
        problems.raise_if_any()
        assert t is not None
        object.__setattr__(self, "direction", t / np.linalg.norm(t))

    def row(self, reduced: ReducedPart) -> Array:
        """Row (n,): acceleration along the direction per unit modal acceleration."""
        return np.asarray(self.direction @ reduced.modes[reduced.node(self.node)])

    def frame_reading(self, reduced: ReducedPart, motion: Motion) -> float:
        """Return the reading due to the frame's motion alone, m/s2."""
        a, w, dw = motion
        u = reduced.nodes[reduced.node(self.node)]
        return float(self.direction @ (a + cross(dw, u) + cross(w, cross(w, u))))


def as_loads(loads: Any) -> tuple[UnknownLoad, ...]:
    """Return a list of unknown loads from loads or names of nodes."""
    if isinstance(loads, UnknownLoad):
        return (loads,)
    if isinstance(loads, str) or not isinstance(loads, Iterable):
        raise InputError(
            Problem(
                "Observer",
                f"loads is {loads!r}, must be UnknownLoad objects; give one for "
                "each place where forces act",
            )
        )
    found = tuple(loads)
    for load in found:
        if not isinstance(load, UnknownLoad):
            raise InputError(Problem("Observer", f"loads contains {load!r}, must be UnknownLoad"))
    return found


def as_rows(gauges: ArrayLike | Any, n: int) -> tuple[Array, tuple[str, ...]]:
    """Return rows (ng, n) and names of gauges from an array, sensors or a Reconstruction."""
    if hasattr(gauges, "B") and hasattr(gauges, "names"):
        return np.asarray(gauges.B), tuple(gauges.names)
    items: Any = gauges
    if not isinstance(items, np.ndarray) and isinstance(items, Iterable):
        items = tuple(items)
        if items and all(hasattr(x, "rows") and hasattr(x, "name") for x in items):
            names = tuple(
                x.name if len(x.rows) == 1 else f"{x.name}:{i + 1}"
                for x in items
                for i in range(len(x.rows))
            )
            return np.vstack([x.rows for x in items]), names
    problems = Problems()
    B = problems.array("Observer", "gauges", items, (None, n))
    problems.raise_if_any()
    assert B is not None
    return B, tuple(f"g{i + 1}" for i in range(len(B)))
