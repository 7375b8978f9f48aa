"""Covariances of the Kalman filter: channels, gains, effect of gauge errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.errors import InputError, Problem, Problems, count, warn
from jousto.base.fields import field
from jousto.base.numbers import Positive
from jousto.base.object_repr import described
from jousto.measurement.twin.motion.system import Accelerometer, System

STEADY = 1e-5
"""Relative change of the covariance per step below which the gain is constant."""

CENTERED = 1e-6
"""Largest ``|int phi dm| / sqrt(mass)`` of a floating part, whose modes do not move its mass
centre."""
BALANCE = ("balance fx", "balance fy", "balance fz", "balance mx", "balance my", "balance mz")


@described
@dataclass(frozen=True, eq=False)
class Gain:
    """Matrices of one step of the filter.

    Attributes
    ----------
    key : tuple
        Length of the step, and the used channels.
    mask : (ny,) bool array
        Mask of the used channels.
    F, Gu : (nx, nx), (nx, nd) arrays
        Transition of the state and effect of known forces.
    K : (nx, k) array
        Gain of the innovations.
    whiten : (k, k) array
        Matrix that transforms innovations to independent ones of variance 1; lower triangular.
    predicted, P : (nx, nx) arrays
        Covariance before and after the channels were used.
    steady : bool
        Whether the gain repeats for equal step and channels.
    """

    key: tuple[float, bytes]
    mask: NDArray[np.bool_]
    F: Array
    Gu: Array
    K: Array
    whiten: Array
    predicted: Array
    P: Array
    steady: bool


@described
@dataclass(frozen=True, eq=False)
class Channels:
    """Rows of all channels on the state, with their noise.

    Attributes
    ----------
    H : (ny, nx) array
        Channel per unit of state.
    R : (ny, ny) array
        Covariance of the noise.
    names : tuple of str
        Names.
    """

    H: Array
    R: Array
    names: tuple[str, ...]


def first_gain(system: System, channels: Channels, mask: NDArray[np.bool_]) -> Gain:
    """Return the gain of the first sample, without a prediction."""
    nx = system.nx
    P = system.start()
    key = (0.0, mask.tobytes())
    return _updated(key, mask, np.eye(nx), np.zeros((nx, system.nd)), P, channels, None)


def next_gain(
    last: Gain, system: System, channels: Channels, dt: float, mask: NDArray[np.bool_]
) -> Gain:
    """Return the gain of the next sample; the same object if it is stationary."""
    key = (round(dt, 12), mask.tobytes())
    if last.steady and last.key == key:
        return last
    F, Gu, Q = system.discrete(dt)
    P = F @ last.P @ F.T + Q
    return _updated(key, mask, F, Gu, 0.5 * (P + P.T), channels, last)


def _updated(
    key: tuple[float, bytes],
    mask: NDArray[np.bool_],
    F: Array,
    Gu: Array,
    P: Array,
    channels: Channels,
    last: Gain | None,
) -> Gain:
    scale = np.sqrt(np.diag(channels.R)[mask])
    H = channels.H[mask] / scale[:, None]
    R = channels.R[np.ix_(mask, mask)] / np.outer(scale, scale)
    PH = P @ H.T
    S = H @ PH + R
    L = la.cholesky(0.5 * (S + S.T), lower=True)
    K = la.cho_solve((L, True), PH.T).T
    # Joseph's form keeps the covariance positive semidefinite
    IKH = np.eye(len(P)) - K @ H
    after = IKH @ P @ IKH.T + K @ R @ K.T
    after = 0.5 * (after + after.T)
    steady = False
    if last is not None and last.key == key:
        size = np.sqrt(np.maximum(np.diag(after), 1e-300))
        change = np.abs(after - last.P) / np.outer(size, size)
        steady = bool(change.max(initial=0.0) < STEADY)
    whiten = la.solve_triangular(L, np.diag(1.0 / scale), lower=True) if len(L) else L
    # contiguous rows: products are identical to the bit after `load`
    F, Gu, K, whiten = (np.ascontiguousarray(x) for x in (F, Gu, K / scale, whiten))
    return Gain(key, mask, F, Gu, K, whiten, P, after, steady)


def backward(this: Gain, after: Gain) -> Array:
    """Return the smoother gain ``P F^T P_pred^-1`` (nx, nx)."""
    size = np.sqrt(np.maximum(np.diag(after.predicted), 1e-300))
    balanced = after.predicted / np.outer(size, size)
    values, vectors = la.eigh(0.5 * (balanced + balanced.T))
    good = values > 1e-13 * values[-1]
    inverse = (vectors[:, good] / values[good]) @ vectors[:, good].T
    return np.asarray(this.P @ after.F.T / size @ inverse / size)


def drifted(before: Array, gain: Gain, channels: Channels, errors: Array, p: Array) -> Array:
    """Return the effect of each gauge error on the state after one sample.

    The filter is linear: ``D = F D_before``, then ``D + K (V - H D)`` with the channel errors ``V_g
    = E_g p``; the gain does not consider these errors.

    Parameters
    ----------
    before : (nx, k ng) array
        Effect at the sample before; zero for the first one.
    gain : Gain
        Gain of this sample.
    channels : Channels
        Gauges first.
    errors : (k, ng, n) array
        Gauge errors from `gauge_errors`.
    p : (n,) array
        Modal coordinates now.
    """
    kinds, ng, _ = errors.shape
    D = gain.F @ before
    V = np.zeros((len(gain.mask), kinds, ng))
    each = np.arange(ng)
    V[each, :, each] = (errors @ p).T
    seen = gain.mask
    shown = V.reshape(len(V), -1)[seen] - channels.H[seen] @ D
    return np.asarray(D + gain.K @ shown)


def drifts(gains: tuple[Gain, ...], channels: Channels, errors: Array, p: Array) -> Array:
    """Return `drifted` (nt, nx, k ng) over a record of modal coordinates p (nt, n)."""
    D = np.zeros((len(gains[0].P), errors.shape[0] * errors.shape[1]))
    found = np.empty((len(gains), *D.shape))
    for k, gain in enumerate(gains):
        D = found[k] = drifted(D, gain, channels, errors, p[k])
    return found


class Balance(Declared, by_value=True):
    """Accuracy with which loads balance weight and inertia of the reference motion.

    ``sum G_k a_k = M_rr [R'' - g; w'] - Q_v`` about the frame's origin: six equations treated as
    channels, with the noise of effects outside the reference (vibration of the frame).
    """

    force: Positive = field("Standard deviation of the forces", unit="N")
    moment: Positive = field("Standard deviation of the moments", unit="N m")


def channels_of(
    system: System,
    B: Array,
    noise: Array,
    names: tuple[str, ...],
    accelerometers: Sequence[Accelerometer],
    balance: Balance | None,
) -> Channels:
    """Return the channels of an observer: gauges (rows B), accelerometers, balance of loads."""
    rows = [B @ system.shape]
    if system.misses:
        rows[0][:, -system.misses :] = np.eye(len(B))
    rows += [(x.row(system.reduced) @ system.accelerations)[None] for x in accelerometers]
    variances = [x.noise**2 for x in accelerometers]
    if balance is not None:
        six = np.zeros((6, system.nx))
        six[:, system.places] = system.wrenches
        rows.append(six)
        variances += 3 * [balance.force**2] + 3 * [balance.moment**2]
        names += BALANCE
    ng, ny = len(B), len(B) + len(variances)
    R = np.zeros((ny, ny))
    R[:ng, :ng] = noise
    R[np.arange(ng, ny), np.arange(ng, ny)] = variances
    return Channels(np.vstack(rows), R, names)


def check_balance(balance: Balance | None, system: System, reference: Any) -> None:
    """Raise InputError for a balance that the part or the loads do not permit."""
    if balance is None:
        return
    problems = Problems()
    I = system.reduced.invariants
    if np.isnan(system.wrenches).any():
        problems.add("Observer", "balance needs loads on nodes; the force of a pattern is unknown")
    if np.abs(I.I3).max(initial=0.0) > CENTERED * np.sqrt(I.mass):
        problems.add(
            "Observer",
            "balance needs a floating part; one that is fixed by `clamp` has a reaction at its "
            "node "
            "that is not a declared load",
        )
    if reference is None:
        problems.add("Observer", "balance needs reference=, the motion that the loads balance")
    problems.raise_if_any()


def check_observable(system: System, channels: Channels) -> None:
    """Raise InputError for unobservable loads; warn of combinations bounded by the prior only."""
    if not system.na:
        return
    # state under constant loads: A x = 0 for x = T a
    scale = system.bound / np.sqrt(np.diag(channels.R))[:, None]
    seen = (channels.H @ system.static_states) * scale
    _, s, Vt = np.linalg.svd(seen)
    s = np.r_[s, np.zeros(system.na - len(s))]
    # unobservable: the effect of the whole prior load is below one standard deviation of noise
    hidden = Vt[s < 1.0]
    if not len(hidden):
        return
    weight = np.sqrt((hidden**2).sum(axis=0))
    names = ", ".join(f"{label}" for label, x in zip(system.labels, weight, strict=True) if x > 0.5)
    open_ended = [
        label
        for label, x, size in zip(system.labels, weight, system.size, strict=True)
        if x > 1e-3 and not np.isfinite(size)
    ]
    found = f"{count(len(hidden), 'combination')} of {count(system.na, 'load')}"
    if open_ended:
        raise InputError(
            Problem(
                "Observer",
                f"{found} is not observable by the channels and would drift "
                f"without bound ({', '.join(open_ended)}); give these loads a size, "
                "or add gauges or a balance",
            )
        )
    warn(
        "Observer",
        f"{found} is not observable by the channels and bounded by its size alone"
        f"{f' (mainly {names})' if names else ''}; check the bands",
    )
