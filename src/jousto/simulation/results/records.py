"""Records: storage of the results of a run, in memory or in a file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.object_repr import described
from jousto.model.beam_record import BeamShape
from jousto.model.frame_record import FrameShape
from jousto.model.symbol_record import SymbolShape
from jousto.reduction.fields.stress import StressModes
from jousto.simulation.results.events import Happening

ALL = slice(None)


@described
@dataclass(frozen=True, eq=False)
class BodyShape:
    """Geometry of a body for pictures, and the offsets of its state.

    Attributes
    ----------
    name, kind : str
        Name; "rigid" or "flexible".
    q_offset, v_offset, n : int
        First indices of its coordinates in q and v, number of modes.
    nodes : (nn, 3) array
        Undeformed positions, body frame, m.
    elements : (ne, m) int array
        Nodes of each element.
    modes : (nn, 3, n) array
        Translation mode shapes.
    mass : float or None
        kg; None in files of older versions.
    frame : FrameShape or None
        Elements of a modal body made of beams.
    """

    name: str
    kind: str
    q_offset: int
    v_offset: int
    n: int
    nodes: Array
    elements: NDArray[np.int64]
    modes: Array
    mass: float | None = None
    frame: FrameShape | None = None


class Records(Protocol):
    """Interface of the storage of a `Solution`."""

    @property
    def where(self) -> str:
        """Name of the storage in messages."""

    @property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the run: solver, step, ended ..."""

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of the sensors."""

    @property
    def length(self) -> int:
        """Number of instants."""

    def read(self, place: str, rows: slice = ALL, columns: Any = ALL) -> Array:
        """Return the values (k, width) of a dataset at some instants."""

    def memory(self) -> tuple[str, ...]:
        """Names of the stored arrays of a state besides q and v."""

    def inputs(self) -> tuple[str, ...]:
        """Names of the external inputs."""

    def about(self, sensor: str) -> dict[str, Any]:
        """Return unit, resolved_in, description and components of a sensor."""

    def model_text(self) -> str:
        """Text of the model file."""

    def events(self) -> tuple[Happening, ...]:
        """Events of the run, in order of time."""

    def contacts(self) -> tuple[Array, dict[str, Any], int]:
        """Contacts (k, 14) from touch to part, their sources, and the number left out."""

    def bodies(self) -> tuple[BodyShape, ...]:
        """Bodies with their geometry for pictures."""

    def body(self, name: str) -> BodyShape | None:
        """Return the body of a name; None if there is no such body."""

    def places(self) -> dict[str, tuple[int, int, int]]:
        """First index in q, first index in v and number of modes of each body, by its name."""

    def beams(self) -> tuple[BeamShape, ...]:
        """Beams of the mechanism."""

    def symbols(self) -> tuple[SymbolShape, ...]:
        """Symbols of joints, forces, sensors and named points, for pictures."""

    def beam_places(self) -> dict[str, tuple[NDArray[np.int64], NDArray[np.int64]]]:
        """First indices of the nodes (n + 1,) of each beam in q and in v, by its name."""

    def stressed(self) -> tuple[str, ...]:
        """Names of the bodies and beams with stress modes or section points."""

    def stress_modes(self, body: str) -> StressModes | None:
        """Return the stress modes of a body that exists; None if it has none."""

    def save(self, path: Path) -> None:
        """Write the results into a results file."""
