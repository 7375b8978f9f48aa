"""Expected readings of a machine with an elastic body, from a run in which the body is rigid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import median_filter

from jousto.base.arrays import Array, Ints
from jousto.design.flexibility.impacts import has_impact
from jousto.design.flexibility.quasi_static import HeldBodies, held_bodies
from jousto.design.flexibility.swinging import Swings, free_swings
from jousto.design.flexibility.variant_runs import VariantRun
from jousto.design.flexibility.vibration import highest_frequency, vibration
from jousto.model.model import Model, SensorModel
from jousto.model.native.native import Engine, displaced
from jousto.simulation.state import State, put

SCATTER = (0.85, 1.0, 1.2)
"""Factors on the natural frequencies; the largest difference of all counts, since the frequencies
change with the pose and with the bodies that the estimate leaves out."""
RESONANT = 3.0
"""Largest vibration / static deformation, from which on there is no estimate. A load that begins
suddenly reaches 2; beyond, the loads feed the vibration cycle by cycle, and its damping, its phase
and the change of its frequency decide."""
RETUNED = 0.05
"""Change of the period of free motions, from which on there is no estimate: after five swings they
are a quarter of a period apart, and drives excite them otherwise."""
KINEMATIC = ("m", "rad", "m/s", "rad/s")
"""Units of readings that do not jump with a load."""
SHARP = 1.25
"""Factor on the vibration of all other readings, such as forces, accelerations and stresses: modes
of high frequency decide there, whose peaks lie between the stored instants."""
AROUND = 11
"""Number of neighbouring second differences whose median is that without a jump."""
ABOVE = 2.0
"""Second difference / that without a jump, from which on it is a jump."""
MARGIN = 1.15
"""Factor of the estimates for what they leave out: terms of second order in the deformation."""
INSTANTS = 401
"""Largest number of instants of an estimate."""
OPERATIONS = 2e9
"""Largest number of operations of an estimate, about nv^3 at each instant."""
FEWEST = 60
"""Number of instants below which no estimate is made coarser."""


@dataclass(frozen=True, eq=False)
class Expected:
    """Estimate of the readings of a machine with an elastic body.

    Attributes
    ----------
    full : Model
        The machine with the elastic body.
    held : HeldBodies
        The elastic bodies along the rigid run.
    first : float
        First natural frequency of the body as the joints hold it, w, rad/s.
    highest : float
        Highest frequency of its loads, W, rad/s.
    ratio : float
        ``r = W / w``.
    amplification : float
        Largest vibration / largest static deformation, as square roots of strain energies;
        infinite if the first frequency falls to 0, so that the body buckles.
    impact : bool
        Whether a stop is hit or a velocity jumps in the run: then everything may be lost.
    swings : Swings or None
        Free motions of the machine; None if drives prescribe everything.
    static : (nt, nout) array
        Readings with the static deformation under the loads of the run.
    deformations : tuple of (nt, n) array
        Deformation with vibration, for each factor of `SCATTER`.
    readings : tuple of (nt, nout) array
        Readings with it.
    """

    full: Model
    held: HeldBodies
    first: float
    highest: float
    ratio: float
    amplification: float
    impact: bool
    swings: Swings | None
    static: Array
    deformations: tuple[Array, ...]
    readings: tuple[Array, ...]

    @property
    def bound(self) -> float:
        """Largest deflection / static deflection in one smooth stroke, ``1 / (1 - r)``.

        From ``r = 1`` on, and after an impact, there is no bound: infinite.
        """
        return 1.0 / (1.0 - self.ratio) if self.ratio < 1.0 and not self.impact else float("inf")

    @property
    def bounded(self) -> bool:
        """Whether there is an estimate: no impact, no resonance, and free motions not retuned."""
        return self.amplification < RESONANT and self.slower < RETUNED and not self.impact

    @property
    def slower(self) -> float:
        """Period of free motions with elastic bodies / with rigid ones - 1; 0 without any."""
        return 0.0 if self.swings is None else self.swings.slower

    def deformation(self, body: str) -> Array:
        """Return the modal coordinates (nt, n) of a body with the static deformation."""
        return self._coordinates(body, self.held.static)

    def vibrations(self, body: str) -> list[Array]:
        """Return the modal coordinates (nt, n) of a body with vibration, for each factor."""
        return [self._coordinates(body, p) for p in self.deformations]

    def _coordinates(self, body: str, more: Array) -> Array:
        """Return the modal coordinates of a body with a deviation of all bodies from the run."""
        first = 0
        for one in self.full.bodies:
            if one.name == body:
                place = slice(one.iq + 7, one.iq + 7 + one.n)
                run = np.array([state.q[place] for state in self.held.states])
                return np.asarray(run + more[:, first : first + one.n])
            first += one.n
        raise KeyError(body)

    def static_drift(self, static: Array) -> float:
        """Return the drift of a reading with the static deformation, all of whose motion is free.

        Parameters
        ----------
        static : (nt,) array
            Reading with the static deformation.
        """
        if self.swings is None:
            return 0.0
        return MARGIN * self.swings.drift(self.held.time, np.gradient(static, self.held.time))

    def difference(self, sensor: SensorModel, component: int, base: Array, jumped: float) -> float:
        """Return the upper figure of the difference of a reading, in its unit.

        The static difference and the vibration about it are added, whatever their phase, and the
        drift of free motions.

        Parameters
        ----------
        sensor : SensorModel
            Sensor of the full machine.
        component : int
            Index of its value.
        base : (nt,) array
            Reading of the rigid run.
        jumped : float
            Its largest jump, see `upper`.
        """
        k = sensor.offset + component
        static = self.static[:, k]
        found = self.upper(base, static, [one[:, k] for one in self.readings], jumped)
        if self.swings is None:
            return found
        rates = self.swings.rates.get(sensor.name)
        if rates is None:
            return found + self.static_drift(static)
        return found + MARGIN * self.swings.drift(self.held.time, rates[:, component])

    def upper(self, base: Array, static: Array, vibrating: Sequence[Array], jumped: float) -> float:
        """Return the upper figure of a difference without drift, in the unit of the reading.

        Forces, accelerations and stresses jump with the loads: their vibration is multiplied by
        `SHARP`, and the `jump` of the reading is added.

        Parameters
        ----------
        base, static : (nt,) array
            Reading of the rigid run, and with the static deformation.
        vibrating : sequence of (nt,) array
            Readings with vibration, for each factor of `SCATTER`.
        jumped : float
            Largest jump of the reading of the rigid run; NaN for places, angles and their rates,
            which cannot jump.
        """
        if not self.bounded:
            return float("inf")
        vibration = max(float(np.abs(one - static).max()) for one in vibrating)
        if not np.isnan(jumped):
            vibration = SHARP * vibration + jumped
        largest = MARGIN * (float(np.abs(static - base).max()) + vibration)
        return largest if self.swings is None else largest * self.swings.growth


def jump(values: Array, unit: str) -> float:
    """Return the largest jump of a reading between stored instants, in its unit; NaN if it cannot.

    A load that is applied within one interval is sudden for modes that the stored instants do not
    resolve, and the elastic body passes it on with up to twice its height: the difference is at
    most the jump itself. A jump is a second difference far above those around it.

    Parameters
    ----------
    values : (nt,) array
        Reading at evenly spaced instants.
    unit : str
    """
    if unit in KINEMATIC:
        return float("nan")
    second = np.abs(np.diff(values, 2))
    if not len(second):
        return 0.0
    # zeros before the start: loads that begin there may jump
    around = median_filter(second, AROUND, mode="constant")
    return float(np.maximum(second - ABOVE * around, 0.0).max())


def expected_readings(full: Model, begin: State | None, simple: VariantRun, body: int) -> Expected:
    """Return the estimate of the readings of the full machine from a run of the simpler one.

    Parameters
    ----------
    full : Model
        The machine with the elastic body.
    begin : State or None
        Its state at the start; None is that of the model.
    simple : VariantRun
        The machine with the rigid body, and its run.
    body : int
        Index of the body.
    """
    run, instants = simple.run, _instants(simple.run.nt, full.nv)
    held = held_bodies(full, simple.model, run, instants)
    stiffness = np.concatenate([np.real(b.K) for b in full.bodies])
    highest = highest_frequency(held.time, held.static * np.sqrt(stiffness))
    first = held.first(body)
    start = _start(full, begin, held)
    pairs = [vibration(held, *start, factor) for factor in SCATTER]
    engine = Engine(replace(full, tree=()))
    rates = np.gradient(held.static, held.time, axis=0)
    changing = held.static - held.static.mean(axis=0)
    strain = 0.5 * float((changing**2 @ stiffness).max(initial=0.0))
    return Expected(
        full=full,
        held=held,
        first=first,
        highest=highest,
        ratio=highest / first if first > 0.0 else float("inf"),
        amplification=_amplification(held.static, start[0], [p for p, _ in pairs], stiffness)
        if first > 0.0
        else float("inf"),
        impact=has_impact(simple.model, run),
        swings=free_swings(simple.model, run, instants, strain, simple.arguments),
        static=_sensed(engine, held, held.static, rates),
        deformations=tuple(p for p, _ in pairs),
        readings=tuple(_sensed(engine, held, p, dp) for p, dp in pairs),
    )


def _start(full: Model, begin: State | None, held: HeldBodies) -> tuple[Array, Array]:
    """Return the deformation of the full machine at the start beyond that of the run, and rate."""
    q, v = (full.q0, full.v0) if begin is None else (begin.q, begin.v)
    first, positions = held.states[0], _positions(full)
    return (
        np.real(q)[positions] - first.q[positions],
        np.real(v)[held.modal] - first.v[held.modal],
    )


def _amplification(
    static: Array, start: Array, vibrating: Sequence[Array], stiffness: Array
) -> float:
    """Return the largest deformation with vibration / that without, and that at the start."""
    root = np.sqrt(stiffness)
    size = [float(np.linalg.norm(p * root, axis=-1).max()) for p in (static, start, *vibrating)]
    return max(size[2:]) / (size[0] + size[1]) if size[0] + size[1] > 0.0 else 1.0


def _instants(count: int, nv: int) -> Ints:
    """Return indices of evenly spaced stored instants."""
    most = int(np.clip(OPERATIONS / max(nv, 1) ** 3, FEWEST, INSTANTS))
    return np.unique(np.linspace(0, count - 1, min(most, count)).round().astype(np.intp))


def _positions(model: Model) -> Ints:
    """Return the indices of the modal coordinates in q."""
    return np.concatenate(
        [np.arange(b.iq + 7, b.iq + 7 + b.n, dtype=np.intp) for b in model.bodies]
    )


def _sensed(engine: Engine, held: HeldBodies, p: Array, dp: Array) -> Array:
    """Return all sensor values (nt, nout) with given additional deformations and their rates."""
    out = np.empty((len(held.time), engine.model.nout))
    for k, state in enumerate(held.states):
        q = displaced(engine.model, state.q, held.increments(k, p[k]))
        v = state.v + held.increments(k, dp[k])
        put(engine, replace(state, q=q, v=v), "estimate")
        engine.accelerations()
        out[k] = np.real(engine.sensors())
    return out
