"""campbell: frequencies and eigenvalues of the modes of a mechanism over a parameter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.object_repr import described
from jousto.model.model import Model
from jousto.simulation.modes.large import MANY
from jousto.simulation.modes.linear import modes
from jousto.simulation.state import State


@described
@dataclass(frozen=True, eq=False)
class Campbell:
    """Eigenvalues of modes over a parameter, for Campbell diagrams and root loci.

    Attributes
    ----------
    values : (nv,) array
        Values of the parameter.
    eigenvalues : (nv, k) array
        Eigenvalues, 1/s, one column per mode, tracked from the first value on; NaN where the mode
        does not exist.
    parameter : str
        Name and unit of the parameter.
    """

    values: Array
    eigenvalues: NDArray[np.complex128]
    parameter: str

    @property
    def frequencies(self) -> Array:
        """Frequencies (nv, k), Hz."""
        return np.asarray(np.abs(self.eigenvalues.imag) / (2 * np.pi))

    @property
    def damping(self) -> Array:
        """Damping ratios (nv, k)."""
        return np.asarray(-self.eigenvalues.real / np.abs(self.eigenvalues))


def _small(model: Model) -> bool:
    return model.nv + model.nrow <= MANY


@explained
def campbell(
    build: Callable[[float], Model | tuple[Model, State]],
    values: Sequence[float] | Array,
    *,
    count: int = 10,
    above: float = 1e-3,
    parameter: str = "parameter",
) -> Campbell:
    """Return the eigenvalues of the damped modes of a mechanism over a parameter.

    Modes of neighbouring values are paired by the largest sum of the modal assurance criteria
    ``|x^H y|^2 / (x^H x  y^H y)`` (Allemang and Brown 1982), so that lines may cross.

    Parameters
    ----------
    build : function
        Function of the value that returns a model, or a model and the state of linearisation.
    values : sequence of float
        Values of the parameter, close enough that shapes of neighbouring values resemble.
    count : int
        Maximum number of modes, the lowest at the first value.
    above : float
        Lowest frequency of an oscillation, Hz.
    parameter : str
        Name and unit of the parameter, for the plot.

    Raises
    ------
    InputError
        If there are no values, or the models have different numbers of coordinates.
    """
    from scipy.optimize import linear_sum_assignment  # slow to import and rarely needed

    points = np.asarray(values, dtype=np.float64)
    if points.ndim != 1 or not len(points) or not np.isfinite(points).all():
        raise InputError(Problem("campbell", "values must be a list of finite numbers, not empty"))
    rows: list[NDArray[np.complex128]] = []
    shapes: NDArray[Any] = np.zeros((0, 0))
    for value in points:
        built = build(float(value))
        model, state = built if isinstance(built, tuple) else (built, None)
        found = modes(model, state, damped=True, count=None if _small(model) else 3 * count)
        swings = found.frequencies > above
        eigenvalues, vectors = found.eigenvalues[swings], found.increments[:, swings]
        vectors = vectors / np.linalg.norm(vectors, axis=0)
        if not rows:
            rows.append(eigenvalues[:count])
            shapes = vectors[:, :count]
            continue
        if len(vectors) != len(shapes):
            raise InputError(
                Problem(
                    "campbell",
                    f"the model for {value:g} has {len(vectors)} coordinates, that for "
                    f"{points[0]:g} has {len(shapes)}; keep the bodies and modes the same",
                )
            )
        alike = np.abs(shapes.conj().T @ vectors) ** 2
        old, new = linear_sum_assignment(-alike)
        row = np.full(len(rows[0]), complex(np.nan, np.nan))
        row[old] = eigenvalues[new]
        shapes = shapes.astype(np.complex128)
        shapes[:, old] = vectors[:, new]
        rows.append(row)
    return Campbell(points, np.array(rows), parameter)
