"""Modal stress: the stress at named places in every mode."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.errors import Problems

Array = NDArray[np.float64]

COMPONENTS = ("s11", "s22", "s33", "s12", "s23", "s13")
"""Voigt order of the six stress components."""


@dataclass(frozen=True, eq=False)
class StressModes:
    """Stress of each mode at ns places; the stress of a moving body is ``modes @ p``.

    Parameters
    ----------
    labels : tuple of str
        Names of the places, such as ``e3.a.top``.
    positions : (ns, 3) array
        Where they are, part frame, m.
    axes : (ns, 3, 3) array
        Columns are the axes in which the stress is resolved, part frame.
    modes : (ns, 6, n) array
        ``[s11, s22, s33, s12, s23, s13]`` of each mode, Pa per unit modal coordinate.
    elasticity : (ns, 2) array, optional
        Young's modulus, Pa, and Poisson's ratio at each place; None if they are not known.

    Raises
    ------
    InputError
        Lengths that do not belong together, names used twice, or values that are not finite.
    """

    labels: tuple[str, ...]
    positions: Array
    axes: Array
    modes: Array
    elasticity: Array | None = None

    def __post_init__(self) -> None:
        problems = Problems()
        labels = tuple(self.labels)
        ns = len(labels)
        n = int(np.shape(self.modes)[-1]) if np.ndim(self.modes) == 3 else 0
        positions = problems.array("StressModes", "positions", self.positions, (ns, 3))
        axes = problems.array("StressModes", "axes", self.axes, (ns, 3, 3))
        modes = problems.array("StressModes", "modes", self.modes, (ns, 6, n))
        if len(set(labels)) != ns:
            twice = next(label for label in labels if labels.count(label) > 1)
            problems.add("StressModes", f"label '{twice}' is used more than once")
        elasticity = self.elasticity
        if elasticity is not None:
            elasticity = problems.array("StressModes", "elasticity", elasticity, (ns, 2))
        problems.raise_if_any()
        object.__setattr__(self, "labels", labels)
        object.__setattr__(self, "elasticity", elasticity)
        object.__setattr__(self, "positions", positions)
        object.__setattr__(self, "axes", axes)
        object.__setattr__(self, "modes", modes)

    def nearest(self, point: ArrayLike) -> str:
        """Return the label of the site nearest to a point of the part frame, m."""
        away = np.linalg.norm(self.positions - np.asarray(point, dtype=np.float64), axis=1)
        return self.labels[int(np.argmin(away))]

    def keep(self, indices: NDArray[np.intp]) -> StressModes:
        """Return the stress of some of the modes, in the order given."""
        return StressModes(
            self.labels, self.positions, self.axes, self.modes[:, :, indices], self.elasticity
        )
