"""Sparse file in memory, for the layout of an HDF5 file before its data exist."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any

import h5py
import numpy as np

PAGE = 4096  # bytes


class SparseImage(io.RawIOBase):
    """Seekable file in memory that stores only the written pages.

    HDF5 crashes the process if the disk is full. Therefore HDF5 writes into this image, and
    ordinary file calls, whose errors are exceptions, copy the written pages to the disk.

    Examples
    --------
    >>> image = SparseImage()
    >>> image.truncate(10**12)
    1000000000000
    >>> image.seek(5 * 10**11), image.write(b"here")
    (500000000000, 4)
    >>> list(image.pieces())
    [(500000000000, b'here')]
    """

    def __init__(self) -> None:
        self._pages: dict[int, bytearray] = {}
        self._written: list[tuple[int, int]] = []
        self._at = 0
        self.size = 0

    def readable(self) -> bool:
        """Return True."""
        return True

    def writable(self) -> bool:
        """Return True."""
        return True

    def seekable(self) -> bool:
        """Return True."""
        return True

    def tell(self) -> int:
        """Return the position."""
        return self._at

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Move to an offset from the start, the position or the end."""
        self._at = offset + {io.SEEK_SET: 0, io.SEEK_CUR: self._at, io.SEEK_END: self.size}[whence]
        return self._at

    def truncate(self, size: int | None = None) -> int:
        """Set the length."""
        self.size = self._at if size is None else size
        return self.size

    def write(self, data: Any) -> int:
        """Write bytes at the position."""
        view = memoryview(data).cast("B")
        done = 0
        while done < len(view):
            number, start = divmod(self._at + done, PAGE)
            count = min(PAGE - start, len(view) - done)
            page = self._pages.setdefault(number, bytearray(PAGE))
            page[start : start + count] = view[done : done + count]
            done += count
        self._written.append((self._at, done))
        self._at += done
        self.size = max(self.size, self._at)
        return done

    def readinto(self, buffer: Any) -> int:
        """Read bytes at the position; holes read as zeros."""
        view = memoryview(buffer).cast("B")
        length = max(0, min(len(view), self.size - self._at))
        done = 0
        while done < length:
            number, start = divmod(self._at + done, PAGE)
            count = min(PAGE - start, length - done)
            page = self._pages.get(number, bytes(PAGE))
            view[done : done + count] = page[start : start + count]
            done += count
        self._at += done
        return done

    @property
    def held(self) -> int:
        """Memory of the pages, bytes."""
        return PAGE * len(self._pages)

    def copy(self) -> SparseImage:
        """Return an independent copy."""
        other = SparseImage()
        other._pages = {number: bytearray(page) for number, page in self._pages.items()}
        other._written = self._ranges()
        other.size = self.size
        return other

    def _ranges(self) -> list[tuple[int, int]]:
        """Return (offset, length) of each written range, in ascending order."""
        joined: list[list[int]] = []
        for start, length in sorted(self._written):
            if joined and start <= joined[-1][1]:
                joined[-1][1] = max(joined[-1][1], start + length)
            else:
                joined.append([start, start + length])
        return [(start, end - start) for start, end in joined]

    def pieces(self) -> Iterator[tuple[int, bytes]]:
        """Yield (offset, bytes) of each written range, in ascending order."""
        for start, length in self._ranges():
            self.seek(start)
            yield start, self.read(length)


def reserve(file: h5py.File, place: str, shape: tuple[int, ...], kind: str) -> h5py.Dataset:
    """Return a new contiguous dataset with allocated but unwritten space in the file.

    Its data are written later, at its offset, by ordinary file calls.
    """
    layout = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    layout.set_layout(h5py.h5d.CONTIGUOUS)
    layout.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    layout.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    links = h5py.h5p.create(h5py.h5p.LINK_CREATE)
    links.set_create_intermediate_group(True)
    space = h5py.h5s.create_simple(shape) if shape else h5py.h5s.create(h5py.h5s.SCALAR)
    numbers = h5py.h5t.py_create(np.dtype(kind))
    name = place.encode()
    return h5py.Dataset(h5py.h5d.create(file.id, name, numbers, space, layout, links))
