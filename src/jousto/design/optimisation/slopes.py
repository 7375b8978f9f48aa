"""Derivatives of functions of a design by differences within its bounds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from jousto.base.arrays import Array
from jousto.design.optimisation import loads as esl
from jousto.design.optimisation.problem import Problem

Function = Callable[[Array], Array]


def differences(problem: Problem, function: Function, x: Array, size: float) -> Array:
    """Return the derivatives (m, nd) of a function: central differences, one-sided at bounds."""
    columns = []
    for i in range(len(x)):
        up, down = esl.sides(problem, x, i, size)
        columns.append((function(up) - function(down)) / (up[i] - down[i]))
    return np.stack(columns, axis=-1)
