"""Checksums stored after the end of an HDF5 file; data with wrong checksums are not read.

HDF5 ignores data after its end. Since HDF5 may crash on damaged files, checksums are checked before
it opens a file. They cover the layout and all constant data, piece by piece, and every BLOCK rows
of each column, written when the block is complete; so files of running or killed runs have valid
checksums too. Other programs that write to the file remove them; then only the structure is
checked.
"""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

BLOCK = 1024  # rows per block
FOOT = struct.Struct("<8sIIQ")  # mark, checksum and length of the text, start of the blocks
MARK = b"JOUSTOCK"
PIECE = 1 << 24
Write = Callable[[int, bytes], None]


class Seal:
    """Checksums of a file that is being written.

    Parameters
    ----------
    start : int
        Offset of the end of HDF5.
    columns : list of (offset, bytes of a row)
        Positions of the columns.
    rows : int
        Largest number of rows.
    """

    def __init__(self, start: int, columns: list[tuple[int, int]], rows: int) -> None:
        self._start = start
        self._columns = columns
        self._blocks = np.zeros((-(-rows // BLOCK), len(columns)), "<u4")
        self._running = [0] * len(columns)
        self._written = 0
        self._done = 0  # number of blocks in the file

    def add(self, data: list[bytes], rows: int, write: Write) -> None:
        """Add rows of all columns, and write the checksums of each block that becomes complete."""
        for k, ((_, width), block) in enumerate(zip(self._columns, data, strict=True)):
            view, at = memoryview(block), self._written
            while view:
                left = BLOCK - at % BLOCK
                piece, view = view[: left * width], view[left * width :]
                self._running[k] = zlib.crc32(piece, self._running[k])
                self._blocks[at // BLOCK, k] = self._running[k]
                at += len(piece) // width
                if at % BLOCK == 0:
                    self._running[k] = 0
        self._written += rows
        full = self._written // BLOCK
        if full > self._done:
            self._write_blocks(self._done, full, write)
            self._done = full

    def moved(self, start: int, columns: list[tuple[int, int]], rows: int) -> Seal:
        """Return the checksums of the same rows for another file."""
        other = Seal(start, columns, rows)
        other._blocks[:] = self._blocks[: len(other._blocks)]
        other._written = self._written
        return other

    @property
    def open_end(self) -> int:
        """Length of the file without the footer; without its footer a file counts as unfinished."""
        return self._start + self._blocks.nbytes

    def _write_blocks(self, first: int, last: int, write: Write) -> None:
        place = self._start + first * self._blocks.shape[1] * 4
        write(place, self._blocks[first:last].tobytes())

    def finish(self, pieces: Iterable[tuple[int, int, int]], write: Write, *, closed: bool) -> None:
        """Write the checksums of constant data; each piece is (offset, length, checksum)."""
        self._write_blocks(0, len(self._blocks), write)
        about = {
            "pieces": list(pieces),
            "columns": self._columns,
            "blocks": len(self._blocks),
            "rows": self._written if closed else None,
        }
        text = json.dumps(about, separators=(",", ":")).encode()
        foot = FOOT.pack(MARK, zlib.crc32(text), len(text), self._start)
        write(self._start + self._blocks.nbytes, text + foot)


class Sealed:
    """Checksums of a file that is read.

    Parameters
    ----------
    path : Path
        Path of the file.
    foot : tuple
        Content of the footer.

    Raises
    ------
    ValueError
        If constant data have a wrong checksum.
    """

    def __init__(self, path: Path, foot: tuple[bytes, int, int, int]) -> None:
        self._path = path
        _, checksum, length, start = foot
        with path.open("rb") as file:
            end = path.stat().st_size - FOOT.size
            file.seek(end - length)
            text = file.read(length)
            if zlib.crc32(text) != checksum:
                raise ValueError("its checksums are damaged")
            about: dict[str, Any] = json.loads(text)
            for offset, size, wanted in about["pieces"]:
                if _crc(file, offset, size) != wanted:
                    raise ValueError(f"bytes {offset} to {offset + size} were changed")
        self._columns = {offset: (k, width) for k, (offset, width) in enumerate(about["columns"])}
        self._start = start
        self._good: NDArray[np.bool_] = np.zeros((about["blocks"], len(self._columns)), bool)
        self._sums = self._read_sums()
        self.rows: int | None = about["rows"]  # number of rows; None while the file is open

    def _read_sums(self) -> NDArray[np.uint32]:
        with self._path.open("rb") as file:
            file.seek(self._start)
            raw = file.read(4 * self._good.size)
        return np.frombuffer(raw, "<u4").reshape(self._good.shape)

    def check(self, offset: int | None, name: str, first: int, last: int, length: int) -> None:
        """Raise ValueError if rows of a column at an offset have a wrong checksum.

        Each block is read once. While a run is in progress, the last rows of its file have no
        checksum yet.
        """
        if offset not in self._columns:
            return
        k, width = self._columns[offset]
        end = self.rows if self.rows is not None else length // BLOCK * BLOCK
        with self._path.open("rb") as file:
            for b in range(first // BLOCK, -(-last // BLOCK)):
                count = min(BLOCK, end - b * BLOCK)
                if count <= 0 or self._good[b, k]:
                    continue
                found = _crc(file, offset + b * BLOCK * width, count * width)
                # while the run continues, checksums in the file may be newer
                if found != self._sums[b, k]:
                    self._sums = self._read_sums()
                if found != self._sums[b, k]:
                    until = b * BLOCK + count - 1
                    raise ValueError(f"{name} was changed between rows {b * BLOCK} and {until}")
                self._good[b, k] = True


def sealed(path: Path) -> Sealed | None:
    """Return the checksums of a file, None if it has none."""
    size = path.stat().st_size
    if size < FOOT.size:
        return None
    with path.open("rb") as file:
        file.seek(size - FOOT.size)
        foot = FOOT.unpack(file.read(FOOT.size))
    return Sealed(path, foot) if foot[0] == MARK else None


def _crc(file: Any, offset: int, size: int) -> int:
    file.seek(offset)
    found = 0
    while size:
        piece = file.read(min(size, PIECE))
        if not piece:
            return -1
        found = zlib.crc32(piece, found)
        size -= len(piece)
    return found
