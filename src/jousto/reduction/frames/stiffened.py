"""stiffened: adds second-order displacements to a part that was reduced without them."""

from __future__ import annotations

from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from jousto.base.errors import InputError, Problem
from jousto.reduction.fields.stiffening import stiffening
from jousto.reduction.frames.clamp import by_mean_axes
from jousto.reduction.frames.stiffening_transform import Turn, turned_stiffening
from jousto.reduction.frames.transfer import relative_motion
from jousto.reduction.reduced import ReducedPart

_MADE: WeakKeyDictionary[ReducedPart, ReducedPart] = WeakKeyDictionary()


def stiffened(reduced: ReducedPart) -> ReducedPart:
    """Return the same modes with their second-order displacements, computed once per part.

    The displacements equal those of ``reduce(..., stiffening=True)``. They are computed in mean
    axes and transformed to the frame of the part.

    Raises
    ------
    InputError
        If the part has no finite element model, that model has no stress data, or the displacements
        need too much memory.
    """
    if reduced.stiffening is not None:
        return reduced
    if reduced not in _MADE:
        _MADE[reduced] = _made(reduced)
    return _MADE[reduced]


def _made(reduced: ReducedPart) -> ReducedPart:
    where = f"reduced part '{reduced.name}'"
    part = reduced.source
    if part is None:
        message = (
            "does not contain its mesh (as parts from files and parts of more than 30,000 "
            "degrees of freedom): reduce it with stiffening=True"
        )
        raise InputError(Problem(where, message))
    if part.second_order is None:
        message = (
            "was built from matrices, which contain no stress for geometric stiffening: build "
            "the part from beams or solids, or cut it into several bodies fixed together"
        )
        raise InputError(Problem(where, message))
    mean = by_mean_axes(reduced)
    blocks = [mean.modes[: len(part.nodes)]]
    if part.dofs_per_node == 6:
        assert mean.rotations is not None
        blocks.append(mean.rotations[: len(part.nodes)])
    X = np.concatenate(blocks, axis=1).reshape(-1, mean.n)
    framed = mean is not reduced
    mean = replace(mean, stiffening=stiffening(part, X))
    if not framed:
        return mean
    # reduced = mean V + t + theta x u0, so the frame moves by -t V^-1 in the mean-axes modes
    t, theta, V = relative_motion(reduced, mean, where)
    back = np.linalg.inv(V)
    field = turned_stiffening(mean, Turn(-t @ back, -theta @ back, V))
    return replace(reduced, stiffening=field)
