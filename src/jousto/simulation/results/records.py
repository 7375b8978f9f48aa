"""Records: where the results of a run are kept, in memory or in a file."""

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
    """How to draw a body and where its state is.

    Attributes
    ----------
    name, kind : str
        Name; "rigid" or "flexible".
    q_offset, v_offset, n : int
        Its place in q and v, number of modes.
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
    """What a `Solution` asks of the place where its results are kept."""

    @property
    def where(self) -> str:
        """Name of the place, for messages."""

    @property
    def attributes(self) -> dict[str, Any]:
        """Facts about the run."""

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of the sensors."""

    @property
    def length(self) -> int:
        """Number of instants."""

    def read(self, place: str, rows: slice = ALL, columns: Any = ALL) -> Array:
        """Return numbers of a piece of the row at some instants."""

    def memory(self) -> tuple[str, ...]:
        """Return which further arrays of a state are kept."""

    def inputs(self) -> tuple[str, ...]:
        """Return the names of the external inputs."""

    def about(self, sensor: str) -> dict[str, Any]:
        """Return unit, resolved_in, description and components of a sensor."""

    def model_text(self) -> str:
        """Return the text of the model file."""

    def events(self) -> tuple[Happening, ...]:
        """Return what happened."""

    def bodies(self) -> tuple[BodyShape, ...]:
        """Return the bodies with what is needed to draw them."""

    def body(self, name: str) -> BodyShape | None:
        """Return one of the bodies, None if there is none of that name."""

    def places(self) -> dict[str, tuple[int, int, int]]:
        """Return where each body has its state in q and v, and its number of modes."""

    def beams(self) -> tuple[BeamShape, ...]:
        """Return the beams."""

    def symbols(self) -> tuple[SymbolShape, ...]:
        """Return where joints, forces, sensors and named points are."""

    def beam_places(self) -> dict[str, tuple[NDArray[np.int64], NDArray[np.int64]]]:
        """Return where the nodes of each beam have their state in q and v."""

    def stressed(self) -> tuple[str, ...]:
        """Return the names of the bodies and beams whose stress is known."""

    def stress_modes(self, body: str) -> StressModes | None:
        """Return the stress of each mode of a body that there is."""

    def save(self, path: Path) -> None:
        """Write everything into a results file."""
