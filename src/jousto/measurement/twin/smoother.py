"""Smoothed estimates from a whole record, and sampled histories."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.object_repr import described
from jousto.measurement.twin.estimates import Estimates, modal, spread
from jousto.measurement.twin.kalman import STEADY, Gain, backward, drifts


def smooth(observed: Estimates) -> Estimates:
    """Return modes and loads at every instant from the whole record.

    Rauch-Tung-Striebel smoother (AIAA Journal 3, 1965), backwards over a record that `Observer.run`
    processed, which removes the delay between loads and their estimates, and narrows the bands. It
    uses later samples, so it is not for real time.

    Parameters
    ----------
    observed : Estimates
        Estimates from `Observer.run`.

    Raises
    ------
    InputError
        If the record is smoothed already.
    """
    if observed.smoothed:
        raise InputError(Problem("smooth", "the record is smoothed already"))
    gains = observed.gains
    back = _Backward()
    states = observed.states.copy()
    inputs = _inputs(observed)
    observer = observed.observer
    drift = before = None
    if observer.errors is not None:
        before = drifts(gains, observer.channels, observer.errors, observed.p)
        drift = before.copy()
    which = np.empty(len(gains), dtype=np.intp)
    kept: list[Array] = [gains[-1].P]
    which[-1] = 0
    P, pair, steady = gains[-1].P, None, False
    for k in range(len(gains) - 2, -1, -1):
        this, after = gains[k], gains[k + 1]
        G = back(this, after)
        states[k] += G @ (states[k + 1] - after.F @ observed.states[k] - inputs[k + 1])
        if drift is not None and before is not None:
            drift[k] += G @ (drift[k + 1] - after.F @ before[k])
        if steady and pair == (id(this), id(after)):
            which[k] = len(kept) - 1
            continue
        new = this.P + G @ (P - after.predicted) @ G.T
        new = 0.5 * (new + new.T)
        size = np.sqrt(np.maximum(np.diag(new), 1e-300))
        change = (np.abs(new - P) / np.outer(size, size)).max(initial=0.0)
        steady = bool(change < STEADY) and pair == (id(this), id(after))
        pair, P = (id(this), id(after)), new
        which[k] = len(kept)
        kept.append(new)
    system = observer.system
    covariances = np.array(kept)
    return replace(
        observed,
        p=modal(system, states, observed.forces),
        covariances=spread(system, covariances),
        which=which,
        states=states,
        P=covariances,
        smoothed=True,
        moved=None if drift is None else system.shape @ drift,
    )


@described
@dataclass(frozen=True, eq=False)
class Histories:
    """Sampled histories of the modal coordinates, equally likely given the record.

    Attributes
    ----------
    time : (nt,) array
        Instants, s.
    p : (nt, n, count) array
        Modal coordinates.
    loads : (nt, na, count) array
        Unknown loads, N and N m.
    """

    time: Array
    p: Array
    loads: Array


def sample_posterior(observed: Estimates, count: int = 50, *, seed: int = 1) -> Histories:
    """Return sampled histories of modes and loads given a record (posterior distribution).

    Durbin and Koopman, Biometrika 89 (2002) 603: a history of the model is simulated, its channels
    are measured, filtered and smoothed like the record, and the error of the smoother is added to
    the smoothed record. Use it for quantities of whole histories, such as damage.

    Parameters
    ----------
    observed : Estimates
        Estimates from `Observer.run`, smoothed or not.
    count : int
        Number of histories.
    seed : int
        Seed of the random numbers.
    """
    smoothed = observed if observed.smoothed else smooth(observed)
    system, channels = observed.observer.system, observed.observer.channels
    rng = np.random.default_rng(seed)
    gains, nx = observed.gains, system.nx
    roots: dict[int, tuple[Gain, Array]] = {}
    noise = np.linalg.cholesky(channels.R)
    true = np.empty((len(gains), nx, count))
    found = np.empty_like(true)
    x = _root(gains[0].predicted) @ rng.standard_normal((nx, count))
    estimate = np.zeros((nx, count))
    for k, gain in enumerate(gains):
        if k:
            if id(gain) not in roots:
                roots[id(gain)] = gain, _root(gain.predicted - gain.F @ gains[k - 1].P @ gain.F.T)
            x = gain.F @ x + roots[id(gain)][1] @ rng.standard_normal((nx, count))
            estimate = gain.F @ estimate
        seen = gain.mask
        y = channels.H[seen] @ x + noise[seen] @ rng.standard_normal((len(noise), count))
        estimate = estimate + gain.K @ (y - channels.H[seen] @ estimate)
        true[k], found[k] = x, estimate
    back = _Backward()
    for k in range(len(gains) - 2, -1, -1):
        after = gains[k + 1]
        found[k] += back(gains[k], after) @ (found[k + 1] - after.F @ found[k])
    error = true - found
    loads = smoothed.states[:, system.places, None] + system.mean[:, None] + error[:, system.places]
    p = smoothed.p[..., None] + np.einsum("nx,txc->tnc", system.shape, error, optimize=True)
    return Histories(observed.time, np.asarray(p), loads)


class _Backward:
    """Smoother gains for pairs of filter gains, cached."""

    def __init__(self) -> None:
        self._known: dict[tuple[int, int], Array] = {}

    def __call__(self, this: Gain, after: Gain) -> Array:
        key = (id(this), id(after))
        if key not in self._known:
            if len(self._known) > 256:
                self._known.clear()
            self._known[key] = backward(this, after)
        return self._known[key]


def _inputs(observed: Estimates) -> Array:
    """Return the effect of known forces on the state in each step (nt, nx)."""
    d = observed.observer.system.dynamic
    f = observed.forces[:, d]
    added = np.zeros_like(observed.states)
    for k in range(1, len(f)):
        added[k] = observed.gains[k].Gu @ (0.5 * (f[k - 1] + f[k]))
    return added


def _root(P: Array) -> Array:
    """Return a square root of a covariance that may be singular."""
    size = np.sqrt(np.maximum(np.diag(P), 1e-300))
    values, vectors = np.linalg.eigh(P / np.outer(size, size))
    return np.asarray(size[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))
