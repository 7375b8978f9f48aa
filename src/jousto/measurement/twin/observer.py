"""Observer: Kalman filter for the modal coordinates of a body with strain gauges."""

from __future__ import annotations

import copy
import zlib
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.object_repr import described
from jousto.measurement.twin.estimates import Estimates, Step, modal
from jousto.measurement.twin.kalman import (
    Balance,
    Gain,
    channels_of,
    check_balance,
    check_observable,
    drifted,
    first_gain,
    next_gain,
)
from jousto.measurement.twin.motion.reference import STILL, InertialForce, Motion, Reference, cross
from jousto.measurement.twin.motion.system import (
    Accelerometer,
    System,
    UnknownLoad,
    as_loads,
    as_rows,
)
from jousto.measurement.twin.reconstruction import NOISE
from jousto.measurement.twin.signals import LARGEST, read_noise, read_strain, read_time
from jousto.reduction.damping import modal_damping
from jousto.reduction.reduced import ReducedPart

JITTER = 1e-3
"""Clock jitter relative to a step that is ignored."""
MEMORY = ("F", "Gu", "K", "whiten", "predicted", "P")
"""Arrays of a gain that the next step needs."""


@explained
@described
class Observer:
    """Real-time estimate of modal coordinates and unknown loads of a flexible body.

    The state is ``x = [p p' a]`` with ``p'' + D p' + W2 p = Phi^T L a + f(motion of the frame)``
    where the loads a are random walks; the channels are strains ``e = B p``, accelerations, and the
    balance of the body. The filter is linear with gains that become constant, so that a step costs
    a tenth of a millisecond. The effect of the frame motion on the modes (inertia coupling ``-M_fr
    r''`` and velocity terms ``Q_v``) is a known force, computed from the invariants of the reduced
    part.

    Parameters
    ----------
    reduced : ReducedPart
        Part from `reduce`: the body is free, with unknown loads at *all* its joints. Part from
        `clamp`: the body is fixed at a node whose motion is the reference.
    gauges : (ng, n) array_like, sequence of gauges or Reconstruction
        Strain of each mode at each gauge.
    loads : sequence of UnknownLoad
        Unmeasured loads.
    step : float
        Usual time between two samples, s.
    damping : float, sequence of float or Rayleigh
        Damping ratio of the modes of this part, as in `FlexibleBody`.
    noise : float, (ng,) or (ng, ng) array_like
        Standard deviation of the gauges, m/m, or their covariance.
    reference : Reference, optional
        Motion of the frame; by default at rest and without weight.
    accelerometers : sequence of Accelerometer
        Further channels, after the gauges.
    balance : Balance, optional
        Equilibrium of the loads with weight and inertia of the reference motion, as an additional
        condition; for free parts with all loads on nodes.
    limit : float, optional
        Frequency, Hz, above which modes follow their load statically; by default half the sampling
        rate.
    disturbance : float
        White modal forces besides the loads, kg^0.5 m/s^1.5.
    discrepancy, lasting : float
        Standard deviation, m/m, and time constant, s, of local errors of the model and the zero of
        a gauge: a slow error of each gauge, and of the stress everywhere else, that averaging does
        not remove. `tune` computes its size from the record.
    gate : float, optional
        Number of standard deviations from the prediction beyond which samples are excluded and
        flagged.
    errors : (k, ng, n) array_like, optional
        Standard deviation of the errors of each gauge that are constant over a record, per unit
        modal coordinate, from `gauge_errors`. Their effect on the estimate is computed beside the
        filter, whose gain does not change, and is part of the bands of stress and damage.

    Raises
    ------
    InputError
        For impossible shapes, noise or damping, or without a strain channel: constant loads would
        then be unobservable, so that the estimate drifts.

    Warns
    -----
    JoustoWarning
        For loads that the channels cannot distinguish.

    Examples
    --------
    >>> import jousto as jo
    >>> steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    >>> part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 10, steel)
    >>> free = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4))
    >>> rod = jo.reduction.clamp(free, "start")
    >>> places = {"root": "e1.a.top", "mid": "e5.a.top"}
    >>> gauges = [jo.gauges.Gauge(name, rod, at) for name, at in places.items()]
    >>> tip = jo.twin.UnknownLoad("end", ("fz",), rate=50.0, size=100.0)
    >>> observer = jo.twin.Observer(rod, gauges, loads=[tip], step=1e-3, noise=1e-6)
    >>> step = observer.step(0.0, [14.3e-6 * k for k in (1.0, 0.6)])  # about F (L - x) / (W E)
    >>> print(step.names[0], step.loads.round())
    end.fz [-1.]
    """

    def __init__(
        self,
        reduced: ReducedPart,
        gauges: Any,
        *,
        loads: Any,
        step: float,
        damping: Any = 0.01,
        noise: ArrayLike = NOISE,
        reference: Reference | None = None,
        accelerometers: Any = (),
        balance: Balance | None = None,
        limit: float | None = None,
        disturbance: float = 0.0,
        discrepancy: float = 0.0,
        lasting: float = 10.0,
        gate: float | None = None,
        errors: ArrayLike | None = None,
    ) -> None:
        problems = Problems()
        where = "Observer"
        if not isinstance(reduced, ReducedPart):
            raise InputError(
                Problem(where, f"reduced is a {type(reduced).__name__}, must be a ReducedPart")
            )
        B, names = as_rows(gauges, reduced.n)
        self.accelerometers = problems.several(
            where, "accelerometers", accelerometers, Accelerometer
        )
        problems.positive(where, "step", step, "s")
        if limit is not None:
            problems.positive(where, "limit", limit, "Hz")
        if gate is not None:
            problems.positive(where, "gate", gate, "")
        if not np.isfinite(disturbance) or disturbance < 0.0:
            problems.add(where, f"disturbance is {disturbance!r}, must be 0 or positive")
        if not 0.0 <= discrepancy <= LARGEST:
            problems.add(where, f"discrepancy is {discrepancy!r} m/m, must be 0 to {LARGEST:g}")
        problems.positive(where, "lasting", lasting, "s")
        if len(B) and B.shape[1] != reduced.n:
            problems.add(where, f"gauges are of {B.shape[1]} modes, the part has {reduced.n}")
        if not len(B):
            problems.add(
                where,
                "no strain channel: accelerations are insensitive to constant loads, so that "
                "the estimate "
                "drifts away; add at least one gauge",
            )
        R = read_noise(problems, where, "noise", noise, len(B), "m/m", LARGEST)
        try:
            D = modal_damping(
                tuple(damping) if isinstance(damping, list | np.ndarray) else damping,
                reduced.frequencies,
            )
        except InputError as error:
            problems.found.extend(Problem(where, str(p)) for p in error.problems)
            D = np.zeros(reduced.n)
        found = as_loads(loads)
        self.errors = None
        if errors is not None:
            self.errors = problems.array(where, "errors", errors, (None, len(B), reduced.n))
        problems.raise_if_any()
        assert R is not None
        self.reduced = reduced
        self.B = B
        self.gauge_names = names
        self.reference = reference
        self.balance = balance
        self.gate = gate
        self.dt = float(step)
        self.noise = R
        self.system = System(
            reduced,
            D,
            found,
            0.5 / float(step) if limit is None else float(limit),
            disturbance,
            len(B),
            float(discrepancy),
            float(lasting),
        )
        self._force = InertialForce(reduced.invariants)
        self.inertia = reduced.invariants.I7
        check_balance(balance, self.system, reference)
        self.arms = np.concatenate(
            [np.zeros((3, 0, reduced.n)), *(load.arms(reduced) for load in found)], axis=1
        )
        self.channels = channels_of(self.system, B, R, self.names, self.accelerometers, balance)
        check_observable(self.system, self.channels)
        self.reset()

    # -- channels -----------------------------------------------------------------------------

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the measured channels: gauges, then accelerometers."""
        return (*self.gauge_names, *(x.name for x in self.accelerometers))

    # -- stepping -----------------------------------------------------------------------------

    def reset(self) -> None:
        """Reset the filter: the next sample is the first one."""
        self.time: float | None = None
        self._x = np.zeros(self.system.nx)
        self._gain: Gain | None = None
        self._f = np.zeros(self.reduced.n)
        # effect of constant gauge errors on the state
        self._drift: Array | None = None
        if self.errors is not None:
            self._drift = np.zeros((self.system.nx, self.errors[..., 0].size))

    def save(self) -> dict[str, Array]:
        """Return the state of the filter as arrays, for `load`.

        Returns
        -------
        dict of str to array
            State for `load` of an observer with the same arguments; empty before the first step.
        """
        gain = self._gain
        if gain is None or self.time is None:
            return {}
        own = {
            "clock": np.array([self.time, gain.key[0], float(gain.steady)]),
            "state": np.array(self._x),
            "force": np.array(self._f),
            "seen": gain.mask.astype(np.float64),
            "names": self._fingerprint(),
        }
        if self._drift is not None:
            own["drift"] = np.array(self._drift)
        return own | {name: np.array(getattr(gain, name)) for name in MEMORY}

    def load(self, memory: Mapping[str, ArrayLike]) -> None:
        """Restore the state that `save` returned; further steps are identical to the bit.

        Raises
        ------
        InputError
            If the state belongs to another observer; this one remains unchanged.
        """
        if not memory:
            self.reset()
            return
        known = {"clock": (3,), "state": self._x.shape, "force": self._f.shape}
        known |= {"seen": (len(self.channels.names),), "names": (1,)}
        if self._drift is not None:
            known["drift"] = self._drift.shape
        wanted = (*known, *MEMORY)
        kept = {name: np.array(memory[name], float, order="C") for name in wanted if name in memory}
        problems = Problems()
        for name in wanted:
            if name not in kept:
                problems.add(
                    "Observer.load", f"the state has no {name!r}; give the result of save()"
                )
            elif name in known and kept[name].shape != known[name]:
                problems.add(
                    "Observer.load",
                    f"{name!r} has shape {kept[name].shape}, must be {known[name]}: it is the "
                    "state of an observer with other modes, loads or channels",
                )
        if not problems.found and kept["names"] != self._fingerprint():
            problems.add(
                "Observer.load", "it is the state of an observer with other loads or channels"
            )
        problems.raise_if_any()
        time, step, steady = (float(x) for x in kept["clock"])
        mask = kept["seen"] > 0.5
        gain = {name: kept[name] for name in MEMORY}
        self._gain = Gain((step, mask.tobytes()), mask, steady=bool(steady), **gain)
        self._x, self._f, self.time = kept["state"], kept["force"], time
        self._drift = kept.get("drift")

    def _fingerprint(self) -> Array:
        """Return a hash (1,) of the names of loads and channels."""
        text = "\n".join((*self.system.labels, "", *self.channels.names))
        return np.array([float(zlib.crc32(text.encode()))])

    def step(self, t: float, e: ArrayLike, motion: Motion | None = None) -> Step:
        """Process one sample of all channels and return the estimate.

        Parameters
        ----------
        t : float
            Time, s, later than that of the last step.
        e : (ny,) array_like
            Strains of the gauges, m/m, then accelerations, m/s2; nan where nothing was measured.
        motion : tuple of three (3,) arrays, optional
            Current motion of the frame, if not from the reference: its acceleration minus gravity,
            w and w', body frame.

        Raises
        ------
        InputError
            If time does not increase, the number of channels is wrong, or strains are in percent or
            um/m.
        """
        problems = Problems()
        sample = read_strain(problems, "Observer.step", e, self.names, len(self.B))
        if not np.isfinite(t):
            problems.add("Observer.step", f"time is {t!r}, must be a number")
        elif self.time is not None and t <= self.time:
            problems.add(
                "Observer.step",
                f"time runs backwards or stands still: {t:.9g} s after {self.time:.9g} s; call "
                "reset() to begin anew",
            )
        if sample is not None and len(sample) != 1:
            problems.add("Observer.step", f"e holds {len(sample)} samples, must be one; use run")
        problems.raise_if_any()
        assert sample is not None
        return self._advance(float(t), sample[0], motion)

    def _advance(self, t: float, sample: Array, motion: Motion | None = None) -> Step:
        system, channels = self.system, self.channels
        if motion is None:
            motion = STILL if self.reference is None else self.reference.at(t)
        # known forces at the predicted state; their change with p is of second order
        f = system.known_forces(self._force, motion, system.shape @ self._x, system.rates @ self._x)
        # the balance channels always have the measured value zero
        y = np.zeros(len(channels.names))
        y[: len(sample)] = sample
        y -= self._offset(motion, f, self._x)
        seen = np.isfinite(y)
        dt = 0.0 if self.time is None else self._round_time(t - self.time)
        before = self._gain
        gain, x, innovation = self._predicted(before, dt, seen, f, y)
        if self.gate is not None:
            limit = self.gate / np.sqrt(self._precision(gain))
            wild = np.zeros_like(seen)
            wild[gain.mask] = np.abs(innovation) > limit
            wild[len(sample) :] = False
            if wild.any():
                seen = seen & ~wild
                gain, x, innovation = self._predicted(before, dt, seen, f, y)
        self._x = x + gain.K @ innovation
        self._gain, self._f, self.time = gain, f, t
        if self._drift is not None and self.errors is not None:
            p = modal(system, self._x, f)
            self._drift = drifted(self._drift, gain, channels, self.errors, p)
        whole = np.full(len(y), np.nan)
        score = np.full(len(y), np.nan)
        whole[gain.mask] = innovation
        score[gain.mask] = gain.whiten @ innovation
        return Step(t, self._x, gain, system, f, whole, score, seen[: len(sample)], self._drift)

    def _round_time(self, dt: float) -> float:
        """Return a time as a whole number of steps within the jitter, so that gains repeat."""
        whole = round(dt / self.dt) * self.dt
        return whole if whole > 0.0 and abs(dt - whole) < JITTER * self.dt else dt

    def _predicted(
        self, before: Gain | None, dt: float, seen: NDArray[np.bool_], f: Array, y: Array
    ) -> tuple[Gain, Array, Array]:
        if before is None:
            gain = first_gain(self.system, self.channels, seen)
            x = self._static_state(f)
        else:
            gain = next_gain(before, self.system, self.channels, dt, seen)
            d = self.system.dynamic
            x = gain.F @ self._x + gain.Gu @ (0.5 * (self._f[d] + f[d]))
        return gain, x, y[seen] - self.channels.H[seen] @ x

    def _static_state(self, f: Array) -> Array:
        """Return the state in static equilibrium with the known forces."""
        x = np.zeros(self.system.nx)
        d = self.system.dynamic
        x[: self.system.nd] = f[d] / self.reduced.stiffness[d]
        return x

    @staticmethod
    def _precision(gain: Gain) -> Array:
        """Inverse variance of each innovation (k,)."""
        inverse = np.linalg.inv(gain.whiten)
        return np.asarray(1.0 / (inverse**2).sum(axis=1))

    def _offset(self, motion: Motion, f: Array, x: Array) -> Array:
        """Return the readings due to known forces and frame motion alone (ny,).

        The predicted state gives the displacement of the load points: loads act on the deformed
        body.
        """
        system, reduced = self.system, self.reduced
        static = np.where(system.dynamic, 0.0, f / reduced.stiffness)
        parts = [self.B @ static]
        moved = np.where(system.dynamic, f, 0.0)
        parts += [
            np.array([x.row(reduced) @ moved + x.frame_reading(reduced, motion)])
            for x in self.accelerometers
        ]
        if self.balance is not None:
            loads = x[system.places] + system.mean
            carried = system.wrenches @ system.mean - self._inertia(motion)
            carried[3:] += (self.arms @ (system.shape @ x + static)) @ loads
            parts.append(carried)
        return np.concatenate(parts)

    def _inertia(self, motion: Motion) -> Array:
        """Return the inertial force and moment (6,) about the frame's origin."""
        a, w, dw = motion
        I = self.reduced.invariants
        S, J = I.first_moment, self.inertia
        force = I.mass * a + cross(dw, S) + cross(w, cross(w, S))
        return np.concatenate([force, cross(S, a) + J @ dw + cross(w, J @ w)])

    # -- whole records ------------------------------------------------------------------------

    def run(self, time: Any, e: ArrayLike | None = None) -> Estimates:
        """Return the estimate of a whole record; the observer itself is unchanged.

        Parameters
        ----------
        time : (nt,) array_like or Record
            Instants, s; or a record with the channels of the observer by name.
        e : (nt, ny) array_like
            Samples as for `step`; nan where nothing was measured.

        Raises
        ------
        InputError
            As for `step`, with all problems of the record.
        """
        problems = Problems()
        if e is None:
            time, e = self._from_record(time)
        sample = read_strain(problems, "Observer.run", e, self.names, len(self.B))
        t = read_time(problems, "Observer.run", time, sample)
        if t is not None and len(t) == 0:
            problems.add("Observer.run", "the record is empty")
        problems.raise_if_any()
        assert sample is not None and t is not None
        walker = copy.copy(self)
        walker.reset()
        return Estimates.collect(
            walker, [walker._advance(float(s), y) for s, y in zip(t, sample, strict=True)]
        )

    def _from_record(self, record: Any) -> tuple[Array, Array]:
        channels = getattr(record, "channels", None)
        if channels is None:
            raise InputError(
                Problem("Observer.run", "e is missing: give run(time, e) or a Record with channels")
            )
        missing = [name for name in self.names if name not in channels]
        if missing:
            raise InputError(
                Problem(
                    "Observer.run",
                    f"the record has no channel {', '.join(map(repr, missing))}; it has "
                    f"{', '.join(map(repr, channels))}",
                )
            )
        return np.asarray(record.time), np.stack([channels[name] for name in self.names], axis=1)

    def changed(
        self,
        *,
        noise: float = 1.0,
        rates: ArrayLike = 1.0,
        balance: float = 1.0,
        discrepancy: float | None = None,
        loads: tuple[UnknownLoad, ...] | None = None,
        reference: Reference | None = None,
    ) -> Observer:
        """Return an observer with other standard deviations or another motion.

        Parameters
        ----------
        noise, balance : float
            Factors of the noise of gauges and accelerometers, and of the balance.
        rates : float or (k,) array_like
            Factors of the rates of the loads, one for each `UnknownLoad`.
        discrepancy : float, optional
            New discrepancy, m/m.
        loads : tuple of UnknownLoad, optional
            The same loads with other numbers.
        reference : Reference, optional
            Another motion of the frame.
        """
        twin = copy.copy(self)
        twin.noise = noise**2 * self.noise
        twin.accelerometers = tuple(replace(x, noise=noise * x.noise) for x in self.accelerometers)
        factors = np.broadcast_to(np.asarray(rates, dtype=np.float64), (len(self.system.loads),))
        known = self.system.loads if loads is None else loads
        loads = tuple(
            replace(load, rate=factor * load.rate)
            for load, factor in zip(known, factors, strict=True)
        )
        missed = self.system.discrepancy if discrepancy is None else float(discrepancy)
        twin.system = replace(self.system, loads=loads, discrepancy=missed)
        if self.balance is not None:
            twin.balance = Balance(balance * self.balance.force, balance * self.balance.moment)
        if reference is not None:
            twin.reference = reference
        twin.channels = channels_of(
            twin.system, twin.B, twin.noise, twin.names, twin.accelerometers, twin.balance
        )
        twin.reset()
        return twin
