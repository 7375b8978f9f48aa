"""Memory of a laid-out model as one block that can be copied, for machines with other numbers."""

from __future__ import annotations

import functools
from bisect import bisect_right
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.model.native import library

Bytes = NDArray[np.uint8]
Words = NDArray[np.uint64]

LINE = 64  # bytes of a cache line, on which copies begin
WORD = 8  # bytes of a pointer
LINKED = (
    *("coordinate", "link", "loop", "reach", "meet", "nlink", "nx", "nu", "nloop", "nreach"),
    *("nmeet", "node", "branch", "fill", "fill_first", "place", "nnode", "nnewton"),
)
"""Fields of a jo_model with the links of a tree and the pattern of Newton's matrix."""
LINKS, NEWTON = 4, 5  # numbers of arrays of links and loops, and of Newton's matrix
NUMBERS = ("jo_event",)  # structs without pointers that contain numbers of the model


class Laid:
    """Data shared by the engines of one model: the filled jo_model and its memory.

    Parameters
    ----------
    model : cffi pointer
        The jo_model.
    keep : list
        Its memory: NumPy arrays of numbers and cffi arrays of structs.
    counts : dict
        Number of structs or numbers at each address.
    base : Laid, optional
        Memory of a model without links, which this one extends.
    """

    def __init__(
        self, model: Any, keep: list[Any], counts: dict[int, int], base: Laid | None = None
    ) -> None:
        self.model, self.keep, self._counts, self._base = model, keep, counts, base

    @functools.cached_property
    def rooms(self) -> list[NDArray[Any]]:
        """Arrays of numbers, in the order in which they were laid out."""
        own = [x for x in self.keep if isinstance(x, np.ndarray)]
        return own if self._base is None else self._base.rooms + own

    @functools.cached_property
    def blocks(self) -> list[tuple[str, Bytes]]:
        """Bytes (count, size) of the structs by kind, the jo_model itself last."""
        ffi, found = library.ffi(), []
        for array in (*(x for x in self.keep if not isinstance(x, np.ndarray)), self.model):
            of = ffi.typeof(array).item
            data = np.frombuffer(ffi.buffer(array), np.uint8)
            found.append((of.cname, data.reshape(-1, ffi.sizeof(of))))
        if self._base is None:
            return found
        # in the order of a model that was laid out as a whole
        coordinate, links, newton = found[0], found[1 : 1 + LINKS], found[1 + LINKS : -1]
        last = len(self._base.blocks) - LINKS - NEWTON - 1
        head = [coordinate if x[0] == coordinate[0] else x for x in self._base.blocks[:last]]
        return [*head, *links, *(newton or self._base.blocks[-NEWTON - 1 : -1]), found[-1]]

    def count(self, pointer: int) -> int:
        """Return the number of structs or numbers at an address."""
        if self._base is not None and pointer not in self._counts:
            return self._base.count(pointer)
        return self._counts[pointer]

    @property
    def extends(self) -> bool:
        """Whether it consists of the memory of a model without links, and of these links."""
        return self._base is not None

    def on(self, base: Laid) -> Laid:
        """Return the links of this memory with the numbers of another memory without links."""
        model = library.ffi().new("jo_model *", base.model[0])
        for name in LINKED:
            setattr(model, name, getattr(self.model, name))
        return Laid(model, list(self.keep), self._counts, base)

    @functools.cached_property
    def image(self) -> Image:
        """Image of the memory, for copies."""
        return Image(self)


class Copy(Laid):
    """Memory copied from an image; its numbers may be replaced.

    Parameters
    ----------
    source : Image
        The image.
    memory : array
        The copied bytes.
    """

    def __init__(self, source: Image, memory: Bytes) -> None:
        self._source, self._memory = source, memory
        start = address(memory) + source.model
        super().__init__(library.ffi().cast("jo_model *", start), [memory], {})

    @functools.cached_property
    def rooms(self) -> list[NDArray[Any]]:
        """Arrays of numbers, in the order in which they were laid out."""
        return self._source.rooms(self._memory)

    @functools.cached_property
    def blocks(self) -> list[tuple[str, Bytes]]:
        """Bytes (count, size) of the structs by kind, the jo_model itself last."""
        return self._source.blocks(self._memory)

    def count(self, pointer: int) -> int:
        """Return the number of structs or numbers at an address."""
        return self._source.count(pointer, pointer - address(self._memory))


@functools.cache
def pointers(struct: str) -> tuple[int, ...]:
    """Return the indices of the pointers among the words of a struct; none for a number."""
    kind = library.ffi().typeof(struct)
    fields = kind.fields if kind.kind == "struct" else ()
    return tuple(f.offset // WORD for _, f in fields if f.type.kind in ("pointer", "function"))


def address(array: NDArray[Any]) -> int:
    """Return the address of the first byte of an array."""
    return int(array.__array_interface__["data"][0])


class Image:
    """One block of bytes with the numbers of a model and the structs that contain pointers.

    Pointers into the block are stored as offsets; other pointers lead to structs without numbers,
    which all copies share.

    Parameters
    ----------
    laid : Laid
        Memory of the model.

    Attributes
    ----------
    model : int
        Offset of the jo_model, bytes.
    """

    def __init__(self, laid: Laid) -> None:
        self._laid = laid
        own = [x for name, x in laid.blocks if is_copied(name)]
        parts: list[NDArray[Any]] = [*laid.rooms, *own]
        sizes = [-(-part.nbytes // LINE) * LINE for part in parts]
        self.starts = np.cumsum([0, *sizes]).tolist()
        self._firsts = [address(part) for part in parts]
        self._places = {address(part): i for i, part in enumerate(parts) if part.nbytes}
        self._bytes = np.zeros(self.starts[-1], np.uint8)
        for part, start in zip(parts, self.starts, strict=False):
            self._bytes[start : start + part.nbytes] = (
                np.ascontiguousarray(part).view(np.uint8).ravel()
            )
        self.model = self.starts[len(parts) - 1]  # offset of the jo_model
        self._relocate(parts)

    def _relocate(self, parts: list[NDArray[Any]]) -> None:
        """Replace the pointers into the block by offsets, and note their places."""
        first = np.array([address(part) for part in parts], np.uint64)
        order = np.argsort(first)
        first, ends = first[order], (first + np.array([p.nbytes for p in parts], np.uint64))[order]
        offsets = np.array(self.starts[:-1], np.uint64)[order]
        words = self._bytes.view(np.uint64)
        found = []
        for name, data in self._laid.blocks:
            columns = pointers(name)
            if not columns:
                continue
            start = self.starts[self._places[address(data)]] // WORD
            width = data.shape[1] // WORD
            at = start + (np.arange(len(data))[:, None] * width + np.array(columns)).ravel()
            place = np.searchsorted(first, words[at], side="right") - 1
            inside = (place >= 0) & (words[at] < ends[np.maximum(place, 0)])
            at, place = at[inside], place[inside]
            words[at] = words[at] - first[place] + offsets[place]
            found.append(at)
        self._pointers = np.concatenate(found)

    def count(self, pointer: int, offset: int) -> int:
        """Return the number of structs or numbers at a pointer, or at an offset in a copy."""
        if 0 <= offset < len(self._bytes):
            part = bisect_right(self.starts, offset) - 1
            pointer = self._firsts[part] + offset - self.starts[part]
        return self._laid.count(pointer)

    def copy(self) -> Copy:
        """Return a copy of the memory, whose numbers can be replaced."""
        raw = np.empty(len(self._bytes) + LINE, np.uint8)
        begin = -address(raw) % LINE
        memory = raw[begin : begin + len(self._bytes)]
        memory[:] = self._bytes
        memory.view(np.uint64)[self._pointers] += np.uint64(address(memory))
        return Copy(self, memory)

    def rooms(self, memory: Bytes) -> list[NDArray[Any]]:
        """Return the arrays of numbers in a copy."""
        return [
            memory[a : a + room.nbytes].view(room.dtype)
            for room, a in zip(self._laid.rooms, self.starts, strict=False)
        ]

    def blocks(self, memory: Bytes) -> list[tuple[str, Bytes]]:
        """Return the structs of a copy by kind, the jo_model itself last."""
        found = []
        for name, data in self._laid.blocks:
            place = self._places.get(address(data)) if is_copied(name) else None
            a = 0 if place is None else self.starts[place]
            own = data if place is None else memory[a : a + data.nbytes].reshape(data.shape)
            found.append((name, own))
        return found


def is_copied(struct: str) -> bool:
    """Return whether structs of a kind contain pointers or numbers of the model."""
    return bool(pointers(struct)) or struct in NUMBERS
