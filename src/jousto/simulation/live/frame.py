"""Frames: inputs and outputs of a machine as bytes, in the format of engine/export/frame.h."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array

HEAD = struct.Struct("<4sHHIIQd")
"""Mark "JOFR", version, kind, checksum of the names, count, sequence number, time stamp."""
VERSION = 1
NUMBERS = 1 << 64
"""Number of sequence numbers; 0 follows the last one."""
LEAP, LATE = 3000, 100
"""Distances of a sequence number ahead of and behind the last one, above which a frame is accepted
only if the next frame confirms it."""
INPUTS, OUTPUTS = 0, 1
"""Kinds of frames: to a machine, and from it."""


def mark_of(inputs: Sequence[str], outputs: Sequence[str]) -> int:
    """Return the checksum of the names of inputs and outputs, with which both sides are compared.

    Examples
    --------
    >>> hex(mark_of(["push"], ["tip.x"]))
    '0x45d16cf6'
    """
    text = "".join(f"{name}\n" for name in [*inputs, "", *outputs])
    return zlib.crc32(text.encode())


def pack(kind: int, mark: int, sequence: int, time: float, values: ArrayLike) -> bytes:
    """Return the bytes of a frame; `values` are doubles in the order of the names."""
    numbers = np.asarray(values, dtype="<f8")
    return HEAD.pack(b"JOFR", VERSION, kind, mark, len(numbers), sequence, time) + numbers.tobytes()


@dataclass
class Received:
    """Reader of the frames of one sender, with counts of accepted and rejected frames.

    Parameters
    ----------
    kind : int
        INPUTS or OUTPUTS.
    mark : int
        From `mark_of`.
    count : int
        Number of values in a frame.

    Attributes
    ----------
    taken, wrong, old, lost : int
        Numbers of frames. taken: accepted. wrong: of another size, version or machine, or not
        finite. old: with a sequence number not above the last one, or far from it and not
        confirmed by the next frame (RFC 3550, appendix A.1: one forged frame must not end a link).
        lost: missing between two accepted frames.
    last : int
        Sequence number of the last accepted frame.
    awaited : int
        Sequence number that would confirm a distant one; -1 if there is none.
    time : float
        Time stamp of the last accepted frame, s.

    Examples
    --------
    The second frame of three is lost, the first comes again:

    >>> frames = [pack(INPUTS, 7, k, 0.1 * k, [float(k)]) for k in range(3)]
    >>> reader = Received(INPUTS, 7, 1)
    >>> [reader.read(frames[k]) is not None for k in (0, 2, 1)]
    [True, True, False]
    >>> str(reader)
    '2 taken, 1 lost, 1 old, 0 wrong'
    """

    kind: int
    mark: int
    count: int
    taken: int = 0
    wrong: int = 0
    old: int = 0
    lost: int = 0
    last: int = 0
    time: float = 0.0
    awaited: int = -1

    def read(self, frame: bytes) -> Array | None:
        """Return the values (count,) of a frame; None if the frame is rejected."""
        values = self._fitting(frame)
        if values is None:
            self.wrong += 1
            return None
        sequence, time = HEAD.unpack_from(frame)[5:]
        if not self._follows(sequence):
            self.old += 1
            return None
        self.awaited = -1
        self.taken, self.last, self.time = self.taken + 1, sequence, time
        return values

    def _follows(self, sequence: int) -> bool:
        """Return whether a frame with this sequence number may follow the last accepted frame."""
        ahead, behind = ((sequence - self.last) % NUMBERS, (self.last - sequence) % NUMBERS)
        if not sequence or not self.taken or sequence == self.awaited:
            return True
        if 0 < ahead < LEAP:
            self.lost += ahead - 1
            return True
        if behind >= LATE:
            self.awaited = (sequence + 1) % NUMBERS
        return False

    def _fitting(self, frame: bytes) -> Array | None:
        if len(frame) != HEAD.size + 8 * self.count:
            return None
        name, version, kind, mark, count, _, time = HEAD.unpack_from(frame)
        if (name, version, kind, mark, count) != (
            b"JOFR",
            VERSION,
            self.kind,
            self.mark,
            self.count,
        ):
            return None
        values = np.frombuffer(frame, "<f8", offset=HEAD.size).astype(np.float64)
        return values if np.isfinite(time) and np.isfinite(values).all() else None

    def __str__(self) -> str:
        return f"{self.taken} taken, {self.lost} lost, {self.old} old, {self.wrong} wrong"
