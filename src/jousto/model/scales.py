"""Scales of the quantities of a model, to tell zero within round-off from other values."""

from __future__ import annotations

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array, read_only
from jousto.base.rounding import Scales
from jousto.model.model import Model, structure_of


def scales_of(model: Model) -> Scales:
    """Return mass, size and elastic stress of a model.

    The elastic stress of a modal body is ``m omega^2 / size`` with its highest frequency, that of a
    rod up to a factor of order one; of exact beams it is Young's modulus.
    """
    # complex steps: a derivative has no scale
    mass = sum(real(body.mass[0]) for body in model.bodies)
    size = real(model.size)
    stress = [real(body.mass[0]) * real(body.K.max()) / size for body in model.bodies if body.n]
    sections = (section for beam in model.beam_shapes for section in beam.sections)
    stress += [real(s.elasticity[0]) for s in sections if s.elasticity is not None]
    return Scales(mass, size, max(stress, default=0.0))


def velocity_metres(model: Model) -> Array:
    """Return the length, m (or m/s), of a unit of each velocity or increment (nv,).

    ``[R', w, p']`` have the lengths ``[1, size, 1 / sqrt(m)]``: rotations with an arm of the size
    of the mechanism, and mass-normalised modal coordinates by their root mean square over the body.
    Together with `Engine.row_metres`, all tolerances and comparisons then refer to lengths, so that
    results do not depend on the consistent system of units.
    """
    like = structure_of(model)
    if like.size == model.size:  # variants have the same masses of modal bodies
        model = like
    if model not in _METRES:
        _METRES[model] = _velocity_metres(model)
    return _METRES[model]


_METRES: WeakKeyDictionary[Model, Array] = WeakKeyDictionary()


def _velocity_metres(model: Model) -> Array:
    out = np.ones(model.nv)
    first = np.array([body.iv for body in model.bodies], dtype=np.intp)
    out[first[:, None] + np.arange(3, 6)] = real(model.size)
    for body in model.bodies:
        if body.n:
            out[body.iv + 6 : body.iv + 6 + body.n] = real(body.mass[0]) ** -0.5
    return read_only(out)


def position_metres(model: Model) -> Array:
    """Return the length, m, of a unit of each coordinate ``[R, e, p]`` (nq,)."""
    v = velocity_metres(model)
    parts = [v[b.iv + np.r_[0:3, [3] * 4, 6 : 6 + b.n]] for b in model.bodies]
    return np.concatenate(parts)


def largest_speed(model: Model, v: NDArray[Any]) -> float:
    """Return the largest of velocities (nv,) in m/s, see `velocity_metres`."""
    return float(np.abs(v * velocity_metres(model)).max(initial=0.0))


def speed_scale(model: Model, v: NDArray[Any], a: NDArray[Any]) -> float:
    """Return a typical speed of a mechanism, m/s: its own, or one reached over its size.

    ``max(|v|, sqrt(|a| size))``; it is zero at rest without acceleration.

    Parameters
    ----------
    model : Model
    v, a : (nv,) arrays
        Velocities and accelerations.
    """
    gained = np.sqrt(largest_speed(model, a) * real(model.size))
    return max(largest_speed(model, v), float(gained))


def real(x: complex) -> float:
    """Return the real part of a number."""
    return float(np.real(x))
