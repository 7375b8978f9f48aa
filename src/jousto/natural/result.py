"""NaturalRun: results of a run of the moving frame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, suggest
from jousto.base.object_repr import described
from jousto.simulation.results.diagnostics import Energy


@described
@dataclass(frozen=True, eq=False)
class NaturalRun(Mapping[str, Array]):
    """Results of a run of the moving frame: a mapping from the names of sensors to their values.

    Attributes
    ----------
    name : str
        Name of the mechanism.
    time : array (nt,)
        Instants, s.
    values : mapping of str to array (nt, k)
        Values of every sensor.
    facts : mapping of str to dict
        Unit, resolved_in, description and components of every sensor.
    energy : Energy
        Energy balance.
    position_residual, velocity_residual : arrays (nt,)
        Largest position residual, m or 1, and velocity residual, m/s or 1/s.
    iterations : array (nt,)
        Number of Newton iterations of the last step before each instant.
    q, v : arrays (nt, N)
        Coordinates ``[R, a, b, c, xi]`` and velocities of every body, padded by zeros to the
        largest number of modes.
    """

    name: str
    time: Array
    readings: Mapping[str, Array]
    facts: Mapping[str, dict[str, Any]]
    energy: Energy
    position_residual: Array
    velocity_residual: Array
    iterations: Array
    q: Array
    v: Array

    def __getitem__(self, name: str) -> Array:
        """Return the values of a sensor, (nt, k).

        Raises
        ------
        InputError
            For an unknown name; the message contains the nearest name.
        """
        if name not in self.readings:
            where = f"moving frame of {self.name!r}"
            raise InputError(
                Problem(where, f"no sensor {name!r}{suggest(str(name), self.readings)}")
            )
        return self.readings[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.readings)

    def __len__(self) -> int:
        return len(self.readings)

    def __eq__(self, other: object) -> bool:
        return self is other

    def __hash__(self) -> int:
        return object.__hash__(self)

    def about(self, name: str) -> dict[str, Any]:
        """Return unit, resolved_in, description and components of a sensor."""
        self[name]
        return self.facts[name]

    def __repr__(self) -> str:
        end = self.time[-1] if len(self.time) else 0.0
        mean = float(np.mean(self.iterations[1:])) if len(self.time) > 1 else 0.0
        return (
            f"<NaturalRun {self.name!r}: {len(self.time)} instants to {end:g} s, "
            f"{len(self)} sensors, {mean:.1f} iterations a step>"
        )
