"""Container of scenes and numbers for the page: a JSON header, then arrays.

``JOV1``, the length of the header (4 bytes), the header (UTF-8, padded with spaces so that the
arrays begin at a multiple of 8), the arrays. All numbers are little endian and in C order. In place
of an array, the header contains ``{"at": byte offset, "shape": [...], "type": "f8"}``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from jousto.base.errors import InputError, Problem

MAGIC = b"JOV1"
TYPES = {name: np.dtype(f"<{name}") for name in ("f8", "f4", "f2", "u4", "i4", "u2", "u1")}
ALIGNED = 8  # alignment of arrays, bytes
REFERENCE = {"at", "shape", "type"}


def pack(header: Mapping[str, Any]) -> bytes:
    """Return a header with NumPy arrays as bytes; each array is stored once.

    Arrays keep their type (f8, f4, f2, u4, i4, u2 or u1; other whole numbers become i4, booleans
    u1). Numbers that are not finite become null, since JSON cannot represent them.

    Parameters
    ----------
    header : mapping
        Mappings, lists, texts, numbers, None and arrays.

    Raises
    ------
    InputError
        If a whole number of an array does not fit into 32 bits.

    Examples
    --------
    >>> data = pack({"kind": "rows", "time": np.array([0.0, 0.5])})
    >>> data[:4], len(data) % 8, unpack(data)["time"]
    (b'JOV1', 0, array([0. , 0.5]))
    """
    pieces: list[bytes] = []
    places: dict[int, dict[str, Any]] = {}
    kept: list[np.ndarray[Any, Any]] = []  # references that keep array ids unique
    end = 0

    def written(value: Any) -> Any:
        nonlocal end
        if isinstance(value, np.ndarray):
            if id(value) not in places:
                array = _plain(value)
                places[id(value)] = {
                    "at": end,
                    "shape": list(array.shape),
                    "type": array.dtype.str[1:],
                }
                kept.append(value)
                pieces.append(_padded(array.tobytes(), b"\0"))
                end += len(pieces[-1])
            return places[id(value)]
        if isinstance(value, Mapping):
            return {str(key): written(entry) for key, entry in value.items()}
        if isinstance(value, list | tuple):
            return [written(entry) for entry in value]
        if isinstance(value, np.generic):
            value = value.item()
        if isinstance(value, float) and not math.isfinite(value):
            return None
        return value

    text = json.dumps(written(header), ensure_ascii=False, separators=(",", ":"))
    head = _padded(text.encode(), b" ")
    return b"".join([MAGIC, len(head).to_bytes(4, "little"), head, *pieces])


def unpack(data: bytes) -> dict[str, Any]:
    """Return the header of a container with its arrays as views of `data`.

    Raises
    ------
    InputError
        If the data are not a container, or are cut off.
    """
    head = data[:4] == MAGIC and len(data) >= 8
    start = 8 + int.from_bytes(data[4:8], "little")
    if not head or start > len(data):
        raise InputError(Problem("container", "does not begin with a header of jousto's viewer"))
    try:
        header = json.loads(data[8:start])
    except ValueError as error:
        raise InputError(Problem("container", f"has a damaged header: {error}")) from None

    def read(value: Any) -> Any:
        if isinstance(value, list):
            return [read(entry) for entry in value]
        if not isinstance(value, dict):
            return value
        if value.keys() != REFERENCE:
            return {key: read(entry) for key, entry in value.items()}
        shape, kind = value["shape"], TYPES[value["type"]]
        count = math.prod(shape)
        if start + value["at"] + count * kind.itemsize > len(data):
            raise InputError(Problem("container", f"ends within an array of shape {shape}"))
        return np.frombuffer(data, kind, count, start + value["at"]).reshape(shape)

    found = read(header)
    assert isinstance(found, dict)
    return found


def _plain(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Return an array converted to a type of the container."""
    if array.dtype.kind == "b":
        array = array.astype("u1")
    elif array.dtype.str[1:] not in TYPES:
        if array.dtype.kind not in "iu":
            raise InputError(Problem("container", f"does not accept arrays of {array.dtype}"))
        most = np.iinfo(np.int32)
        if array.size and (array.min() < most.min or array.max() > most.max):
            raise InputError(Problem("container", "accepts whole numbers of up to 32 bits only"))
        array = array.astype("i4")
    kind = TYPES[array.dtype.str[1:]]
    # a scalar keeps its shape ()
    return np.asarray(array, dtype=kind, order="C")


def _padded(data: bytes, filler: bytes) -> bytes:
    return data + filler * (-len(data) % ALIGNED)
