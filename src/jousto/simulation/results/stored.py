"""Results in a file; each array is read when it is first used."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.files import written
from jousto.model.beam_record import BeamShape
from jousto.model.symbol_record import SymbolShape
from jousto.reduction.fields.stress import StressModes
from jousto.simulation.results.contact_table import read_contacts
from jousto.simulation.results.events import Happening, happenings
from jousto.simulation.results.legacy_symbols import GROUP as CONNECTIONS, read_connections
from jousto.simulation.results.records import ALL, BodyShape
from jousto.simulation.results.stress import (
    BEAMS,
    beam_knows_stress,
    knows_stress,
    read_beam,
    read_frame,
    read_stress,
)
from jousto.simulation.results.symbols import GROUP as SYMBOLS, check_symbols, read_symbols
from jousto.simulation.results.validate import examine, open_results
from jousto.simulation.results.writer import EVENT_COLUMNS
from jousto.simulation.state import MEMORY


class FileRecords:
    """Results in a file.

    The results of a run that continues or was killed are readable up to the last written piece.

    Parameters
    ----------
    path : Path
        The results file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._places: dict[str, tuple[int, int, int]] | None = None
        self._beams: tuple[BeamShape, ...] | None = None
        self._seal = examine(path)
        with open_results(path) as file:
            self.attributes: dict[str, Any] = {
                key: _plain(value) for key, value in file.attrs.items()
            }
            self.sensors = tuple(file["sensors"])
            self.length = min(int(file["rows"][()]), len(file["time"]))

    @property
    def where(self) -> str:
        """Name of the storage in messages."""
        return str(self.path)

    @contextmanager
    def _open(self) -> Iterator[Any]:
        with open_results(self.path) as file:
            if file.attrs["run"] != self.attributes["run"]:
                raise InputError(
                    Problem(
                        str(self.path),
                        "was overwritten by another run; open it again, load(path), or give every "
                        "run its own file",
                    )
                )
            yield file

    def read(self, place: str, rows: slice = ALL, columns: Any = ALL) -> Array:
        """Return the values (k, width) of a dataset at some instants."""
        start, stop, step = rows.indices(self.length)
        with self._open() as file:
            dataset = file[place]
            if self._seal is not None and stop != start:
                first, last = (start, stop) if step > 0 else (stop + 1, start + 1)
                offset = dataset.id.get_offset()
                self._seal.check(offset, place, first, last, self.length)
            if dataset.ndim == 1:
                return np.asarray(dataset[start:stop:step])
            return np.asarray(dataset[start:stop:step, columns])

    def memory(self) -> tuple[str, ...]:
        """Names of the stored arrays of a state besides q and v."""
        with self._open() as file:
            return tuple(name for name in MEMORY if f"state/{name}" in file)

    def inputs(self) -> tuple[str, ...]:
        """Names of the external inputs."""
        with self._open() as file:
            return tuple(name.decode() for name in file["state/input"].attrs["names"])

    def about(self, sensor: str) -> dict[str, Any]:
        """Return unit, resolved_in, description and components of a sensor."""
        with self._open() as file:
            attrs = file[f"sensors/{sensor}"].attrs
            return {
                "unit": str(attrs["unit"]),
                "resolved_in": str(attrs["resolved_in"]),
                "description": str(attrs["description"]),
                "components": tuple(c.decode() for c in file[f"components/{sensor}"][()]),
            }

    def model_text(self) -> str:
        """Text of the model file."""
        with self._open() as file:
            return str(file["model"].asstr()[()])

    def events(self) -> tuple[Happening, ...]:
        """Events of the run, in order of time."""
        with self._open() as file:
            if "events" not in file:
                return ()
            table = file["events"]
            count = int(table["rows"][()])
            columns = [table[name][:count] for name, _, _ in EVENT_COLUMNS]
            names = [name.decode() for name in table["names"][()]]
            joints = [""] * len(names)
            if "joints" in table:
                joints = [name.decode() for name in table["joints"][()]]
            return happenings(np.stack(columns, axis=1), names, int(table.attrs["events"]), joints)

    def contacts(self) -> tuple[Array, dict[str, Any], int]:
        """Contacts (k, 14) from touch to part, their sources, and the number left out."""
        with self._open() as file:
            return read_contacts(file)

    def bodies(self) -> tuple[BodyShape, ...]:
        """Bodies with their geometry for pictures."""
        with self._open() as file:
            return tuple(_read_body(name, group) for name, group in file["bodies"].items())

    def body(self, name: str) -> BodyShape | None:
        """Return the body of a name; None if there is no such body."""
        if name not in self.places():
            return None
        with self._open() as file:
            return _read_body(name, file["bodies"][name])

    def places(self) -> dict[str, tuple[int, int, int]]:
        """First index in q, first index in v and number of modes of each body, by its name."""
        if self._places is None:
            with self._open() as file:
                self._places = {
                    name: (
                        int(group.attrs["q_offset"]),
                        int(group.attrs["v_offset"]),
                        int(group.attrs["modes"]),
                    )
                    for name, group in file["bodies"].items()
                }
        return self._places

    def beams(self) -> tuple[BeamShape, ...]:
        """Beams of the mechanism."""
        if self._beams is None:
            with self._open() as file:
                groups = file[BEAMS].items() if BEAMS in file else ()
                self._beams = tuple(read_beam(name, group) for name, group in groups)
        return self._beams

    def symbols(self) -> tuple[SymbolShape, ...]:
        """Symbols of joints, forces, sensors and named points, for pictures."""
        with self._open() as file:
            if SYMBOLS in file:
                return check_symbols(read_symbols(file[SYMBOLS]), file["bodies"])
            if CONNECTIONS in file:
                return check_symbols(read_connections(file[CONNECTIONS]), file["bodies"])
            return ()

    def beam_places(self) -> dict[str, tuple[NDArray[np.int64], NDArray[np.int64]]]:
        """First indices of the nodes (n + 1,) of each beam in q and in v, by its name."""
        with self._open() as file:
            if BEAMS not in file:
                return {}
            return {name: (beam["iq"][()], beam["iv"][()]) for name, beam in file[BEAMS].items()}

    def stressed(self) -> tuple[str, ...]:
        """Names of the bodies and beams with stress modes or section points."""
        with self._open() as file:
            names = [name for name, group in file["bodies"].items() if knows_stress(group)]
            if BEAMS in file:
                names += [name for name, group in file[BEAMS].items() if beam_knows_stress(group)]
            return tuple(names)

    def stress_modes(self, body: str) -> StressModes | None:
        """Return the stress modes of a body that exists; None if it has none."""
        with self._open() as file:
            return read_stress(file["bodies"][body])

    def save(self, path: Path) -> None:
        """Copy the results into another results file."""
        with self._open():
            pass  # the file still contains this run
        with written(path) as beside:
            shutil.copyfile(self.path, beside)


def _read_body(name: str, group: Any) -> BodyShape:
    return BodyShape(
        name=name,
        kind=str(group.attrs["kind"]),
        q_offset=int(group.attrs["q_offset"]),
        v_offset=int(group.attrs["v_offset"]),
        n=int(group.attrs["modes"]),
        nodes=np.asarray(group["nodes"]),
        elements=np.asarray(group["elements"]),
        modes=np.asarray(group["mode_shapes"]),
        mass=float(group.attrs["mass"]) if "mass" in group.attrs else None,
        frame=read_frame(group),
    )


def _plain(value: Any) -> Any:
    if isinstance(value, bytes):
        return value.decode(errors="replace").rstrip()
    return value.item() if isinstance(value, np.generic) else value
