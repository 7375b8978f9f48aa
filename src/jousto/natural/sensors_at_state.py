"""Sensor values at given states, by the equations in natural coordinates."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.base import Sensor
from jousto.natural.equations.gears_at_start import wind_gears
from jousto.natural.equations.initial_state import angles, state_of_engine
from jousto.natural.equations.sensors import Reader
from jousto.natural.equations.system import Machine
from jousto.natural.equations.trapezoidal_step import PENALTY, Stepper
from jousto.simulation.state import State


@dataclass(frozen=True, eq=False)
class Instants:
    """Sensor values and constraint residuals of a machine at given states.

    Attributes
    ----------
    readings : dict of str to array (nt, k)
        Values of every sensor.
    names : tuple of str
        Name of the joint or drive of each constraint.
    gaps, rates : arrays (m,)
        Largest residual of each constraint over its scale in all states, and of its rate.
    """

    readings: dict[str, Array]
    names: tuple[str, ...]
    gaps: Array
    rates: Array

    def open_joints(self, most: float) -> tuple[str, ...]:
        """Return the names of joints and drives with relative residuals above `most`."""
        found = (name for name, gap in zip(self.names, self.gaps, strict=True) if gap > most)
        return tuple(dict.fromkeys(found))


def at_states(
    mechanism: Mechanism, states: Iterable[State], sensors: tuple[Sensor, ...], every: int = 1
) -> Instants:
    """Return sensor values at every `every`-th of consecutive states.

    Accelerations and multipliers follow from ``M q'' + Cq^T lam = Q`` and ``C'' = 0`` in natural
    coordinates, without time integration, so that another formulation of the same equations gives
    the same values to round-off. Work since the start is not known and set to zero.
    """
    machine = Machine(mechanism)
    reader = Reader(machine, sensors)
    machine.close()
    wind_gears(machine)
    near, last = angles(machine), 0.0
    rate: Array | None = None
    stepper: Stepper | None = None
    found: list[list[Array]] = []
    gaps = rates = np.zeros(len(machine.rows.offset))
    for k, state in enumerate(states):
        q, v = state_of_engine(machine, state)
        place = machine.place(q, state.time, near)
        before, rate = rate, place.slopes.times(v)
        if (
            before is not None
        ):  # predict angles, which may change by revolutions from one state to the next
            near = near + 0.5 * (state.time - last) * (before + rate)
            place = machine.place(q, state.time, near)
        near, last = place.s, state.time
        if k % every:
            continue
        if stepper is None:
            stepper = Stepper(machine, 1.0, place, penalty=PENALTY)
        motion = stepper.start(place, v, state.time)
        gaps = np.maximum(gaps, np.abs(place.C) / machine.limit)
        rates = np.maximum(rates, np.abs(machine.velocity_gaps(place, v, state.time)))
        found.append(reader.read(motion, machine.energies(motion)))
    readings = {s.name: np.stack([row[i] for row in found]) for i, s in enumerate(sensors)}
    return Instants(readings, tuple(machine.rows.names), gaps, rates)
