"""Results in memory, and the choice of their storage: memory, temporary file or file."""

from __future__ import annotations

import shutil
import tempfile
import uuid
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.complexstep import real_parts
from jousto.base.errors import InputError, Problem
from jousto.base.files import unwritable
from jousto.model.beam_record import BeamShape
from jousto.model.contact_points import contact_sources
from jousto.model.model import Model
from jousto.model.scales import scales_of
from jousto.model.start_complex_step import plain_model
from jousto.model.symbol_record import SymbolShape
from jousto.reduction.fields.stress import StressModes
from jousto.simulation.results.contact_table import ContactTable
from jousto.simulation.results.events import Happening, happenings, joints_of, sources
from jousto.simulation.results.records import ALL, BodyShape
from jousto.simulation.results.row_layout import Column, columns
from jousto.simulation.results.solution import Solution
from jousto.simulation.results.writer import (
    EVENT_COLUMNS,
    EVENTS,
    FORMAT,
    FORMAT_VERSION,
    Facts,
    ResultsWriter,
)
from jousto.simulation.state import MEMORY

IN_MEMORY = 256 << 20  # maximum size of results in memory, bytes; larger ones go into a file


@dataclass(frozen=True, eq=False)
class MemoryRecords:
    """Results in memory: the rows of a run and its model.

    Attributes
    ----------
    model : Model
        The model.
    rows : (nt, row_size) array
        Rows of the engine.
    happened : (k, 4) array
        Time, source, change and count of each event.
    facts : dict
        How the run ended: ended, complete, wall_time, real_time_factor.
    about_run : dict
        Attributes known before the run: solver, step ...
    text : str
        Text of the model file.
    touched : ContactTable
        Contacts from touch to part.
    """

    model: Model
    rows: Array
    happened: Array
    facts: Facts
    about_run: dict[str, Any]
    text: str
    touched: ContactTable = field(default_factory=ContactTable)

    def __getstate__(self) -> dict[str, Any]:
        """Return the state to be pickled, without the force functions of the model."""
        forces = tuple(replace(force, function=None) for force in self.model.forces)
        model = replace(self.model, forces=forces, beams=())
        return {name: getattr(self, name) for name in self.__dataclass_fields__} | {"model": model}

    @property
    def where(self) -> str:
        """Name of the storage in messages."""
        return f"results of '{self.model.name}'"

    @cached_property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the run: solver, step, ended ..."""
        return {
            "format": FORMAT,
            "format_version": FORMAT_VERSION,
            "name": self.model.name,
            "scales": scales_of(self.model).array(),
            **self.facts,
            **self.about_run,
        }

    @cached_property
    def sensors(self) -> tuple[str, ...]:
        """Names of the sensors."""
        return tuple(sensor.name for sensor in self.model.sensors)

    @property
    def length(self) -> int:
        """Number of instants."""
        return len(self.rows)

    @cached_property
    def _columns(self) -> dict[str, Column]:
        return {column.place: column for column in columns(self.model)}

    def read(self, place: str, rows: slice = ALL, columns: Any = ALL) -> Array:
        """Return the values (k, width) of a dataset at some instants."""
        column = self._columns[place]
        block = self.rows[rows, column.first : column.first + column.count]
        return np.array(block[:, 0] if column.width is None else block[:, columns])

    def memory(self) -> tuple[str, ...]:
        """Names of the stored arrays of a state besides q and v."""
        return tuple(name for name in MEMORY if f"state/{name}" in self._columns)

    def inputs(self) -> tuple[str, ...]:
        """Names of the external inputs."""
        return self.model.inputs

    def about(self, sensor: str) -> dict[str, Any]:
        """Return unit, resolved_in, description and components of a sensor."""
        found = self.model.sensors[self.sensors.index(sensor)]
        return {
            "unit": found.unit,
            "resolved_in": found.resolved_in,
            "description": found.description,
            "components": tuple(found.components),
        }

    def model_text(self) -> str:
        """Text of the model file."""
        return self.text

    def events(self) -> tuple[Happening, ...]:
        """Events of the run, in order of time."""
        names = sources(self.model)
        return happenings(self.happened, names, len(self.model.events), joints_of(self.model))

    def contacts(self) -> tuple[Array, dict[str, Any], int]:
        """Contacts (k, 14) from touch to part, their sources, and the number left out."""
        return self.touched.rows, contact_sources(self.model), self.touched.dropped

    def bodies(self) -> tuple[BodyShape, ...]:
        """Bodies with their geometry for pictures."""
        return tuple(map(self._body, range(len(self.model.bodies))))

    def body(self, name: str) -> BodyShape | None:
        """Return the body of a name; None if there is no such body."""
        place = self._place_of.get(name)
        return None if place is None else self._body(place)

    def _body(self, place: int) -> BodyShape:
        body, shape = self.model.bodies[place], self.model.shapes[place]
        return BodyShape(
            body.name,
            shape.kind,
            body.iq,
            body.iv,
            body.n,
            np.array(shape.nodes),
            np.array(shape.elements),
            np.array(shape.modes),
            float(body.mass[0]),
            shape.frame,
        )

    @cached_property
    def _place_of(self) -> dict[str, int]:
        return {body.name: i for i, body in enumerate(self.model.bodies)}

    def places(self) -> dict[str, tuple[int, int, int]]:
        """First index in q, first index in v and number of modes of each body, by its name."""
        return {body.name: (body.iq, body.iv, body.n) for body in self.model.bodies}

    def beams(self) -> tuple[BeamShape, ...]:
        """Beams of the mechanism."""
        return self.model.beam_shapes

    def symbols(self) -> tuple[SymbolShape, ...]:
        """Symbols of joints, forces, sensors and named points, for pictures."""
        return tuple(self.model.symbols)

    def beam_places(self) -> dict[str, tuple[NDArray[np.int64], NDArray[np.int64]]]:
        """First indices of the nodes (n + 1,) of each beam in q and in v, by its name."""
        bodies = self.model.bodies
        return {
            beam.name: (
                np.array([bodies[k].iq for k in beam.bodies]),
                np.array([bodies[k].iv for k in beam.bodies]),
            )
            for beam in self.model.beam_shapes
        }

    def stressed(self) -> tuple[str, ...]:
        """Names of the bodies and beams with stress modes or section points."""
        pairs = zip(self.model.bodies, self.model.shapes, strict=True)
        names = [body.name for body, shape in pairs if shape.stress is not None]
        return (*names, *(beam.name for beam in self.model.beam_shapes if beam.stressed))

    def stress_modes(self, body: str) -> StressModes | None:
        """Return the stress modes of a body that exists; None if it has none."""
        return self.model.shapes[self._place_of[body]].stress

    def save(self, path: Path) -> None:
        """Write the results into a results file."""
        if not self.length:
            raise InputError(Problem(str(path), "the results contain no instant; nothing to save"))
        writer = ResultsWriter(path, self.model, self.length, self.about_run, self.text)
        try:
            writer.append(self.rows)
            writer.note(self.happened)
            writer.touch(self.touched.rows, self.touched.dropped)
        except OSError as error:
            writer.discard()
            raise unwritable(path, error) from error
        writer.close(bool(self.facts["complete"]), self.facts)


def displaced_results(run: Solution, along: float) -> Solution:
    """Return the real results ``x + s x'`` of a run with derivatives x', for a real number s."""
    records: Any = run._records
    model, rows = plain_model(records.model, along), real_parts(records.rows, along)
    return Solution(replace(records, model=model, rows=rows))


class MemoryWriter:
    """Collector of the rows of a run in memory.

    Memory for all rows is reserved at the start; the system assigns it as rows are written.
    """

    def __init__(self, model: Model, rows: int, attributes: dict[str, Any], text: str) -> None:
        last = columns(model)[-1]
        self._model = model
        self._rows = np.empty((rows, last.first + last.count))
        self._about = {**attributes, "run": uuid.uuid4().hex}
        self._text = text
        self.written = 0
        self.happened = np.zeros((0, len(EVENT_COLUMNS)))
        self.touched = ContactTable()

    def append(self, rows: Array) -> None:
        """Add rows (k, row_size) of the engine."""
        self._rows[self.written : self.written + len(rows)] = rows
        self.written += len(rows)

    def note(self, happened: Array) -> None:
        """Add events (k, 4): time, source, change, count; only the first EVENTS are kept."""
        if len(happened) and len(self.happened) < EVENTS:
            self.happened = np.vstack([self.happened, happened])[:EVENTS]

    def touch(self, rows: Array, dropped: int) -> None:
        """Add contacts (k, 14) from touch to part, and the number that the engine dropped."""
        self.touched.add(rows, dropped)

    def close(self, complete: bool, facts: Facts) -> MemoryRecords:
        """Return the collected rows and events."""
        rows = self._rows[: self.written]
        known = {"real_time_factor": float("nan"), **facts, "complete": int(complete)}
        about, text = self._about, self._text
        return MemoryRecords(self._model, rows, self.happened, known, about, text, self.touched)


class Keeper:
    """Collector of the rows of a run, which `close` returns as a `Solution`.

    Parameters
    ----------
    path : path or None
        File for the results; With None up to 256 MB are stored in memory, and more in a temporary
        file.
    model : Model
        The model.
    rows : int
        Maximum number of instants.
    attributes : dict
        Attributes known before the run: solver, step ...
    text : str
        Text of the model file.

    Raises
    ------
    InputError
        If the file cannot be written or the disk has no room for it.
    """

    def __init__(
        self,
        path: str | Path | None,
        model: Model,
        rows: int,
        attributes: dict[str, Any],
        text: str = "",
    ) -> None:
        last = columns(model)[-1]
        self._about = model, attributes, text
        self._folder: Path | None = None
        self._writer: ResultsWriter | MemoryWriter
        if path is None and 8 * rows * (last.first + last.count) <= IN_MEMORY:
            self._writer = MemoryWriter(model, rows, attributes, text)
            self.place = "the `solution` of this error"
            return
        if path is None:
            self._folder = Path(tempfile.mkdtemp(prefix="jousto-"))
        target = self._folder / "run.h5" if self._folder else Path(path or "")
        self.place = str(target)
        try:
            self._writer = ResultsWriter(target, model, rows, attributes, text)
        except BaseException:
            self.discard()
            raise

    @property
    def happened(self) -> int:
        """Number of events so far."""
        return len(self._writer.happened)

    def append(self, rows: NDArray[np.float64]) -> None:
        """Add rows (k, row_size) of the engine."""
        self._writer.append(rows)

    def note(self, happened: NDArray[np.float64]) -> None:
        """Add events (k, 4): time, source, change and count."""
        self._writer.note(happened)

    def touch(self, rows: NDArray[np.float64], dropped: int = 0) -> None:
        """Add contacts (k, 14) from touch to part, and the number that the engine dropped."""
        self._writer.touch(rows, dropped)

    def close(self, complete: bool, facts: Facts) -> Solution:
        """Add the ending of the run to the attributes and return the results."""
        if isinstance(self._writer, MemoryWriter):
            return Solution(self._writer.close(complete, facts))
        if not self._writer.placed:  # no row was written: an existing file at the path stays
            self.discard()
            model, attributes, text = self._about
            return Solution(MemoryWriter(model, 0, attributes, text).close(False, facts))
        self._writer.close(complete, facts)
        return Solution(self._writer.path, temporary=self._folder is not None)

    def discard(self) -> None:
        """Remove the file if it is temporary or has no rows."""
        writer = getattr(self, "_writer", None)
        if isinstance(writer, ResultsWriter) and not writer.placed:
            writer.discard()
        if self._folder:
            shutil.rmtree(self._folder, ignore_errors=True)
