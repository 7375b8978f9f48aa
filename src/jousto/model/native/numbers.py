"""Numbers of a model in the memory of another model of equal structure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.model.model import BodyModel, ForceModel, Model
from jousto.model.native import library
from jousto.model.native.memory_image import Laid

REAL = 8  # bytes of a number


def write_numbers(laid: Laid, was: Model, now: Model, pad: int) -> None:
    """Write the numbers of a model over those of a model of equal structure.

    Parameters
    ----------
    laid : Laid
        Memory with the numbers of `was`, used by no engine.
    was, now : Model
        Models of equal structure; objects that are the same in both are left alone.
    pad : int
        Multiple to which modal arrays are padded.
    """
    m = laid.model
    m.size = now.size
    for i, body in _changed(was.bodies, now.bodies):
        _write_body(m.body[i], body, was.bodies[i])
    for i, signal in _changed(was.signals, now.signals):
        _write(m.signal[i].data, signal.data)
    for i, force in _changed(was.forces, now.forces):
        _write(m.force[i].data, force_numbers(force, now, pad))
    for i, friction in _changed(was.frictions, now.frictions):
        _write(m.friction[i].data, friction.data)
    for i, event in _changed(was.events, now.events):
        m.event[i].threshold = event.threshold


def _changed(was: Sequence[Any], now: Sequence[Any]) -> list[tuple[int, Any]]:
    """Return the objects that differ, with their indices."""
    if was is now:
        return []
    return [(i, b) for i, (a, b) in enumerate(zip(was, now, strict=True)) if a is not b]


def _write_body(struct: Any, body: BodyModel, was: BodyModel) -> None:
    for name in ("mass", "S0", "J0"):
        _write(getattr(struct, name), getattr(body, name))
    if body.n:
        _write(struct.D, body.D)


def _write(pointer: Any, numbers: NDArray[np.float64]) -> None:
    """Copy numbers to an address."""
    size = numbers.size * REAL
    library.ffi().buffer(pointer, size)[:] = np.ascontiguousarray(numbers).tobytes()


def force_numbers(force: ForceModel, model: Model, pad: int) -> NDArray[Any]:
    """Return the numbers of a force in memory; modal loads are padded like the modes."""
    if force.kind != "modal load":
        return force.data
    return padded_array(force.data, 6 - (-model.bodies[force.body].n // pad) * pad)


def padded_array(array: NDArray[Any], length: int) -> NDArray[Any]:
    """Return an array with the last axis padded by zeros."""
    out = np.zeros((*array.shape[:-1], length), array.dtype)
    out[..., : array.shape[-1]] = array
    return out
