"""Ensemble: machines of equal structure that step together, each in one vector lane."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.model.loop_joints import loops_of
from jousto.model.model import Model, structure_of
from jousto.model.native import library
from jousto.model.native.header import kind
from jousto.model.native.layout import Layout
from jousto.model.native.memory_image import Bytes, Words, address, pointers
from jousto.model.native.native import Engine

OWN = ("size", "gravity")
"""Fields of a jo_model that may differ between machines of one structure, besides its numbers."""

_LAID: WeakKeyDictionary[Model, tuple[str, _Laid | None]] = WeakKeyDictionary()


def machines() -> int:
    """Return the number of machines that this processor advances together; 1 without a build."""
    return 1 if library.lanes() is None else int(library.lanes().jo_machines())


def structure(model: Model) -> str:
    """Return a key, equal for machines that can be advanced together; empty if this one cannot.

    Machines of equal structure differ only in numbers: they have the same bodies and modes, joints,
    forces, signals and sensors, in the same order. A machine with friction, beams, events, damage
    meters, moving loads or user functions is advanced alone, and so is a tree in joint coordinates
    that closes loops or stands on flexible bodies.
    """
    if model not in _LAID:
        laid = _Laid(model) if _is_plain(model) else None
        like = structure_of(model)
        if like is not model:
            sign = structure(like)
        else:
            sign = "" if laid is None else f"{laid.sign()} {int(model.redundant)}"
        _LAID[model] = (sign, laid)
    return _LAID[model][0]


def _is_plain(model: Model) -> bool:
    alone = (model.frictions, model.beams, model.events, model.meters, loops_of(model).loops)
    locked = any(joint.lock >= 0 for joint in model.joints)
    return not (any(alone) or locked or model.mixed) and all(
        force.law.side_by_side for force in model.forces
    )


class _Laid:
    """Memory of a model for single runs of the engine, as arrays of bytes.

    Attributes
    ----------
    rooms : list of arrays
        Arrays of numbers of the model.
    blocks : list of (str, array)
        Structs of the model by kind, the jo_model itself last.
    """

    def __init__(self, model: Model) -> None:
        ffi = library.ffi()
        layout = Layout(library.real_library(), ffi, model, np.dtype(np.float64), {}, False)
        # keep only the memory, since the layout would keep the model alive
        self._keep = layout.laid
        self.rooms: list[Array] = layout.laid.rooms
        self.blocks: list[tuple[str, Bytes]] = layout.laid.blocks
        memory: list[NDArray[Any]] = [*self.rooms, *(data for _, data in self.blocks)]
        starts, sizes = [address(x) for x in memory], [x.nbytes for x in memory]
        self.order = np.argsort(np.array(starts, np.uint64))
        self.starts = np.array(starts, np.uint64)[self.order]
        self.ends = self.starts + np.array(sizes, np.uint64)[self.order]

    def places(self, pointers: Words) -> tuple[NDArray[np.intp], Words]:
        """Return the target of each pointer (index of an array or block) and the offset in it.

        The index is -1 for null pointers.
        """
        at = np.searchsorted(self.starts, pointers, side="right") - 1
        found = np.maximum(at, 0)
        inside = (at >= 0) & (pointers < self.ends[found])
        place = np.where(inside, self.order[found], -1)
        return place, np.where(inside, pointers - self.starts[found], pointers)

    def sign(self) -> str:
        """Return a hash of the structure: of everything except the numbers."""
        digest = hashlib.blake2b(digest_size=16)
        for room in self.rooms:
            digest.update(f"{room.size} ".encode())
        for struct, data in self.blocks:
            data = data.copy()
            digest.update(f"{struct} {len(data)} ".encode())
            if columns := list(pointers(struct)):
                words = data.view(np.uint64)
                place, offset = self.places(words[:, columns])
                words[:, columns] = offset
                digest.update(place.tobytes())
            if struct == "jo_model":
                fields = dict(library.ffi().typeof(struct).fields)
                for name in OWN:
                    data[:, fields[name].offset : fields[name].offset + 8] = 0
            digest.update(data.tobytes())
        return digest.hexdigest()


def _aligned(count: int, machines: int) -> Array:
    """Return an array of zeros (count, machines) that begins on a cache line."""
    raw = np.zeros(count * machines + 8)
    first = -address(raw) % 64 // 8
    return raw[first : first + count * machines].reshape(count, machines)


class Ensemble:
    """Machines of equal structure that the engine advances together.

    Parameters
    ----------
    engines : sequence of Engine
        As many as `machines`, at the same time; each with its model and its start state.

    Raises
    ------
    ValueError
        If their structures differ, or there is another number of them.
    """

    def __init__(self, engines: Sequence[Engine]) -> None:
        models = [engine.model for engine in engines]
        kinds = {structure(model) for model in models}
        times = {float(engine.time[0]) for engine in engines}
        if len(kinds) != 1 or "" in kinds or len(times) != 1 or len(engines) != machines():
            raise ValueError(f"needs {machines()} machines of one structure at the same time")
        self._library, self._ffi = library.lanes(), library.ffi()
        self._keep: list[Any] = []
        self._model = self._interleaved(
            [laid for _, laid in map(_LAID.__getitem__, models) if laid]
        )
        self._model.redundant = int(models[0].redundant)
        self._model.size = min(model.size for model in models)
        gravity = _aligned(3, len(engines))
        np.stack([engine.gravity for engine in engines], axis=1, out=gravity)
        self._model.gravity = self._pointer(gravity)
        self._keep.append(gravity)
        data = self._library.jo_data_new(self._model)
        if data == self._ffi.NULL:
            raise MemoryError("no memory for the engine's workspace")
        self._data = self._ffi.gc(data, self._library.jo_data_free)
        self.row_size = int(self._library.jo_row_size(self._model))
        self._count = self._ffi.new("long long *", engines[0].steps_done)
        for name in ("q", "v", "time", "input", "turn"):
            own = [getattr(engine, name) for engine in engines]
            self._view(getattr(self._library, f"jo_data_{name}")(data), len(own[0]))[:] = np.array(
                own
            ).T

    def _interleaved(self, laid: list[_Laid]) -> Any:
        """Return the jo_model of all machines: numbers interleaved, the rest from the first."""
        first, count = laid[0], len(laid)
        rooms = []
        for i in range(len(first.rooms)):
            room = _aligned(first.rooms[i].size, count)
            np.stack([one.rooms[i] for one in laid], axis=1, out=room)
            rooms.append(room)
        blocks = [data.copy() for _, data in first.blocks]
        self._keep += [rooms, blocks]
        memory: list[NDArray[Any]] = [*rooms, *blocks]
        new = np.array([address(x) for x in memory], np.uint64)
        for (struct, _), data in zip(first.blocks, blocks, strict=True):
            columns = list(pointers(struct))
            if not columns:
                continue
            words = data.view(np.uint64)
            place, offset = first.places(words[:, columns])
            scale = np.where((place >= 0) & (place < len(rooms)), np.uint64(count), np.uint64(1))
            moved = new[np.maximum(place, 0)] + offset * scale
            words[:, columns] = np.where(place >= 0, moved, 0)
        return self._ffi.cast("jo_model *", address(blocks[-1]))

    def run(self, solver: Any, steps: int, every: int) -> Array:
        """Advance all machines; return rows (machines, k, row_size), one per `every` steps.

        The rows of a machine that failed are not finite from the failure on.
        """
        room = _aligned(
            ((int(self._count[0]) % every) + steps) // every * self.row_size, machines()
        )
        written = self._ffi.new("int *", 0)
        status = self._library.jo_run(
            self._model, self._data, solver, steps, every, self._count, written, self._pointer(room)
        )
        if kind("jo_status", status) != "ok":  # every machine failed
            room[int(written[0]) * self.row_size :] = np.nan
        return np.ascontiguousarray(room.T).reshape(machines(), -1, self.row_size)

    def row(self) -> Array:
        """Return the current states as rows (machines, row_size)."""
        room = _aligned(self.row_size, machines())
        self._library.jo_row(self._model, self._data, self._pointer(room))
        return np.ascontiguousarray(room.T)

    def _pointer(self, array: Array) -> Any:
        return self._ffi.cast("jo_real *", address(array))

    def _view(self, pointer: Any, count: int) -> Array:
        if not count:
            return np.zeros((0, machines()))
        buffer = self._ffi.buffer(self._ffi.cast("char *", pointer), 8 * count * machines())
        return np.frombuffer(buffer, np.float64).reshape(count, machines())
