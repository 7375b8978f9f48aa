"""Estimates of modal coordinates with covariances, per step and over a record."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.object_repr import described
from jousto.measurement.twin.kalman import Channels, Gain
from jousto.measurement.twin.motion.reference import Reference
from jousto.measurement.twin.motion.system import System


@described
@dataclass(frozen=True, eq=False)
class Posterior:
    """Modal coordinates over time with their covariance.

    Attributes
    ----------
    time : (nt,) array
        Instants, s; counted from 0 if no times were given.
    p : (nt, n) array
        Modal coordinates, kg^0.5 m; nan where they are unknown.
    covariances : (m, n, n) array
        The distinct covariances of p.
    which : (nt,) int array
        Index of the covariance at each instant.
    """

    time: Array
    p: Array
    covariances: Array
    which: NDArray[np.intp]

    def deviations(self, instants: slice) -> Array | None:
        """Return the deviations of p due to gauge errors that are constant over a record.

        Parameters
        ----------
        instants : slice
            Indices of the instants.

        Returns
        -------
        (nt, n, k) array or None
            One column for each independent error of standard deviation 1; None without such errors.
        """
        return None

    def systematic(self, S: Array, instants: slice) -> Array | None:
        """Return the deviations of rows S (..., n) of p due to constant gauge errors.

        Parameters
        ----------
        S : (..., n) array
            Rows, such as those of the stress at sites.
        instants : slice
            Indices of the instants.

        Returns
        -------
        (nt, ..., k) array or None
            As for `deviations`.
        """
        moved = self.deviations(instants)
        if moved is None:
            return None
        return np.moveaxis(np.tensordot(moved, S, axes=([1], [S.ndim - 1])), 1, -1)

    @property
    def missed(self) -> float:
        """Standard deviation of the model error in strain, m/m."""
        return 0.0

    def __len__(self) -> int:
        return len(self.time)

    @property
    def covariance(self) -> Array:
        """Covariance of p at every instant (nt, n, n); large for long histories."""
        return np.asarray(self.covariances[self.which])

    @property
    def band(self) -> Array:
        """Standard deviation of p (nt, n)."""
        variances = np.einsum("mjj->mj", self.covariances)
        return np.asarray(np.sqrt(np.maximum(variances, 0.0))[self.which])


@described
@dataclass(frozen=True, eq=False)
class Step:
    """Estimate after one sample.

    Attributes
    ----------
    time : float
        s.
    x : (nx,) array
        State: dynamic modes, their velocities, and unknown loads minus their mean.
    gain : Gain
        Gain and covariances of the step.
    system : System
        Model of the state.
    force : (n,) array
        Known modal forces, kg^0.5 m/s2.
    innovation : (ny,) array
        Channels minus their prediction; nan for channels that were not used.
    score : (ny,) array
        Innovations, decorrelated and divided by their standard deviations.
    seen : (ny,) bool array
        Mask of the measured channels that were used.
    drift : (nx, k) array or None
        Effect of each constant gauge error on the state, for standard deviations of 1.
    """

    time: float
    x: Array
    gain: Gain
    system: System
    force: Array
    innovation: Array
    score: Array
    seen: NDArray[np.bool_]
    drift: Array | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknown loads."""
        return self.system.labels

    @cached_property
    def p(self) -> Array:
        """Modal coordinates (n,), kg^0.5 m."""
        return modal(self.system, self.x, self.force)

    @property
    def dp(self) -> Array:
        """Modal velocities (n,), kg^0.5 m/s."""
        return np.asarray(self.system.rates @ self.x)

    @property
    def covariance(self) -> Array:
        """Covariance of p (n, n)."""
        C = self.system.shape
        return np.asarray(C @ self.gain.P @ C.T)

    @property
    def loads(self) -> Array:
        """Unknown loads (na,), N and N m, axes of the body."""
        return np.asarray(self.x[self.system.places] + self.system.mean)

    @property
    def load_covariance(self) -> Array:
        """Covariance of the loads (na, na)."""
        return np.asarray(self.gain.P[self.system.places, self.system.places])


class Follower(Protocol):
    """Protocol of the data that an estimate needs from its observer."""

    system: System
    channels: Channels
    errors: Array | None
    reference: Reference | None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the measured channels."""


@described
@dataclass(frozen=True, eq=False)
class Estimates(Posterior):
    """Modal coordinates, loads and innovations over a record.

    Attributes
    ----------
    observer : Observer
        Observer that computed the estimate.
    states : (nt, nx) array
        States.
    P : (m, nx, nx) array
        Distinct covariances; `which` has the index for each sample.
    forces : (nt, n) array
        Known modal forces, kg^0.5 m/s2.
    innovations, scores : (nt, ny) arrays
        Channels minus their prediction, and the same transformed to independent values of standard
        deviation 1.
    gains : tuple of Gain
        Gain of every step (the same object where it repeats).
    smoothed : bool
        Whether every instant uses the whole record, or only earlier samples.
    moved : (nt, n, k) array or None
        Deviation of p by each constant gauge error, for standard deviations of 1.
    """

    observer: Follower
    states: Array
    P: Array
    forces: Array
    innovations: Array
    scores: Array
    gains: tuple[Gain, ...]
    smoothed: bool = False
    moved: Array | None = None

    @classmethod
    def collect(cls, observer: Follower, steps: list[Step]) -> Estimates:
        """Return steps as one record."""
        system = observer.system
        known: dict[int, int] = {}
        gains: list[Gain] = []
        which = np.empty(len(steps), dtype=np.intp)
        for k, step in enumerate(steps):
            place = known.setdefault(id(step.gain), len(gains))
            if place == len(gains):
                gains.append(step.gain)
            which[k] = place
        P = np.array([gain.P for gain in gains])
        states = np.array([step.x for step in steps])
        forces = np.array([step.force for step in steps])
        return cls(
            time=np.array([step.time for step in steps]),
            p=modal(system, states, forces),
            covariances=spread(system, P),
            which=which,
            observer=observer,
            states=states,
            P=P,
            forces=forces,
            innovations=np.array([step.innovation for step in steps]),
            scores=np.array([step.score for step in steps]),
            gains=tuple(step.gain for step in steps),
            moved=None if observer.errors is None else system.shape @ _drifts(steps),
        )

    def deviations(self, instants: slice) -> Array | None:
        """Return the deviations of p due to gauge errors; see `Posterior.deviations`."""
        return None if self.moved is None else self.moved[instants]

    @property
    def missed(self) -> float:
        """Standard deviation of the model error in strain, m/m."""
        return self.observer.system.discrepancy

    @property
    def dp(self) -> Array:
        """Modal velocities (nt, n), kg^0.5 m/s."""
        return np.asarray(self.states @ self.observer.system.rates.T)

    @property
    def load_names(self) -> tuple[str, ...]:
        """Names of the unknown loads."""
        return self.observer.system.labels

    @property
    def loads(self) -> Array:
        """Unknown loads (nt, na), N and N m, axes of the body."""
        system = self.observer.system
        return np.asarray(self.states[:, system.places] + system.mean)

    @property
    def load_band(self) -> Array:
        """Standard deviation of the loads (nt, na)."""
        variance = np.einsum("mjj->mj", self.P)[:, self.observer.system.places]
        return np.asarray(np.sqrt(np.maximum(variance, 0.0))[self.which])

    @property
    def likelihood(self) -> float:
        """Log-likelihood of the record, up to a constant."""
        logs = {id(gain): 2.0 * np.sum(np.log(np.diag(gain.whiten))) for gain in self.gains}
        total = np.nansum(self.scores**2) - sum(logs[id(gain)] for gain in self.gains)
        return float(-0.5 * total)


def modal(system: System, states: Array, forces: Array) -> Array:
    """Return modal coordinates (.., n) of states and known modal forces."""
    static = np.where(system.dynamic, 0.0, forces / system.reduced.stiffness)
    return np.asarray(states @ system.shape.T + static)


def _drifts(steps: list[Step]) -> Array:
    return np.array([step.drift for step in steps])


def spread(system: System, P: Array) -> Array:
    """Return covariances of p (m, n, n) from covariances of the state."""
    C = system.shape
    return np.asarray(C @ P @ C.T)


@described
@dataclass(frozen=True, eq=False)
class Told(Posterior):
    """Modal coordinates from gauges at each instant, ``p = K e``.

    Attributes
    ----------
    gains : (m, n, ng) array, optional
        Modal coordinates per strain of each gauge, for each of the covariances.
    errors : (k, ng, n) array, optional
        Gauge errors as in `Reconstruction`.
    """

    gains: Array | None = field(default=None, kw_only=True)
    errors: Array | None = field(default=None, kw_only=True)

    def deviations(self, instants: slice) -> Array | None:
        """Return the deviations of p due to gauge errors; see `Posterior.deviations`.

        A gauge error ``v_g`` changes p by ``K_g v_g``.
        """
        if self.errors is None or self.gains is None:
            return None
        # errors of one gauge (factor, place, angle) are independent: add their variances
        size = np.sqrt(np.sum((self.p[instants] @ np.swapaxes(self.errors, 1, 2)) ** 2, axis=0))
        return np.asarray(self.gains[self.which[instants]] * size[:, None, :])
