"""Table of the contacts of a run, from touch to part, in memory and in a results file."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.model.contact_points import contact_sources
from jousto.model.model import Model
from jousto.simulation.results.sparse_image import reserve

GROUP = "contacts"
CONTACTS = 10_000
"""Largest number of contacts in the results of a run."""
COLUMNS = (
    ("force", "1", "index of the force, see sources"),
    ("on", "1", "of a set: shape that is touched; else -1"),
    ("of", "1", "of a set: the other shape; else -1"),
    ("touch", "s", "instant of the touch"),
    ("part", "s", "instant of the part; NaN for a contact that touches at the end"),
    ("approach", "m/s", "speed of approach at the touch"),
    ("rebound", "m/s", "speed at the part"),
    ("force_max", "N", "largest normal force"),
    ("depth_max", "m", "largest depth of the overlap"),
    ("impulse", "N s", "impulse of the normal force"),
    ("friction_impulse", "N s", "integral of the size of the friction force"),
    ("lost_restitution", "J", "energy lost by the normal force"),
    ("lost_friction", "J", "energy lost by friction"),
    ("steps", "1", "number of steps"),
)
"""Name, unit and description of each column, as ``jo_touched`` of the engine."""
Write = Callable[[int, bytes], None]


class ContactTable:
    """Contacts of a run, of which the first `CONTACTS` are kept and the others counted."""

    def __init__(self) -> None:
        self.rows = np.zeros((0, len(COLUMNS)))
        self._left_out = 0
        self._dropped = 0

    def add(self, rows: Array, dropped: int = 0) -> None:
        """Add contacts (k, 14); `dropped` is the number for which the engine had no room so far."""
        self._dropped = max(self._dropped, dropped)
        room = CONTACTS - len(self.rows)
        self._left_out += max(0, len(rows) - room)
        if len(rows) and room > 0:
            self.rows = np.vstack([self.rows, rows[:room]])

    @property
    def dropped(self) -> int:
        """Number of contacts that are not kept."""
        return self._left_out + self._dropped

    # -- in a file -------------------------------------------------------------------------------

    @staticmethod
    def describe(file: Any, model: Model) -> tuple[int, ...]:
        """Create the group in a file; return the offsets of its numbers, none without contacts."""
        if not model.touches:
            return ()
        made = [reserve(file, f"{GROUP}/{name}", (), "<i8") for name in ("rows", "dropped")]
        made[0].attrs["description"] = "contacts written so far"
        made[1].attrs["description"] = "contacts beyond them, which are not in this file"
        values = reserve(file, f"{GROUP}/values", (CONTACTS, len(COLUMNS)), "<f8")
        for key, k in (("columns", 0), ("units", 1), ("descriptions", 2)):
            values.attrs[key] = json.dumps([column[k] for column in COLUMNS])
        text = json.dumps(contact_sources(model), ensure_ascii=False).encode()
        file[f"{GROUP}/sources"] = np.frombuffer(text, dtype=np.uint8)
        file.flush()
        return tuple(dataset.id.get_offset() for dataset in (*made, values))

    def pieces(self, places: tuple[int, ...]) -> list[tuple[int, bytes]]:
        """Return offsets and contents of its numbers."""
        if not places:
            return []
        counts = [np.array(x, "<i8").tobytes() for x in (len(self.rows), self.dropped)]
        return list(zip(places, [*counts, self.rows.astype("<f8").tobytes()], strict=True))

    def write(self, places: tuple[int, ...], write: Write, first: int = 0) -> None:
        """Write its numbers, of the rows those from `first` on."""
        for (offset, data), k in zip(self.pieces(places), (0, 0, first), strict=False):
            skip = 8 * len(COLUMNS) * k
            write(offset + skip, data[skip:])

    def checks(self, places: tuple[int, ...]) -> list[tuple[int, int, int]]:
        """Return offset, length and checksum of each of its pieces."""
        return [(at, len(data), zlib.crc32(data)) for at, data in self.pieces(places)]


def read_contacts(file: Any) -> tuple[Array, dict[str, Any], int]:
    """Return the contacts (k, 14) in a results file, their sources, and the number left out.

    Raises
    ------
    ValueError
        If the group is damaged.
    """
    if GROUP not in file:
        return np.zeros((0, len(COLUMNS))), {"contacts": [], "sets": []}, 0
    group = file[GROUP]
    count, values = int(group["rows"][()]), group["values"]
    if not 0 <= count <= len(values) or values.shape[1] != len(COLUMNS):
        raise ValueError(f"{GROUP}/rows is {count}, {GROUP}/values has {values.shape}")
    sources = json.loads(group["sources"][()].tobytes().decode())
    return np.asarray(values[:count]), sources, int(group["dropped"][()])
