"""BeamShape: what recovery and pictures need to know of a beam."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from jousto.errors import Problems

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BeamShape:
    """A beam: its elements, the bodies at their ends, and the stress of its section.

    Parameters
    ----------
    name : str
        Name of the beam.
    bodies : (n + 1,) int array
        Numbers of the bodies at the nodes, along the beam.
    data : (n, 78) array
        Each element as the engine has it, see ``jo_beam`` in jousto.h.
    s : (n + 1,) array
        Length of the unstressed beam from its start to each node, m.
    labels : tuple of str
        Names of the points of the section.
    points : (np, 2) array
        Where they are, y and z from the axis, m.
    rows : (np, 6, 6) array
        ``[s11 s22 s33 s12 s23 s13]`` at each point for unit resultants ``[N Qy Qz Mx My Mz]``.
    outline : (k, 2) array
        Outer edge of the section, counterclockwise seen from ahead, m; empty if it is not known.
    elasticity : (2,) array or None
        Young's modulus, Pa, and Poisson's ratio; None if they are not known.

    Raises
    ------
    InputError
        If the arrays do not fit together.
    """

    name: str
    bodies: NDArray[np.int64]
    data: Array
    s: Array
    labels: tuple[str, ...] = ()
    points: Array = field(default_factory=lambda: np.zeros((0, 2)))
    rows: Array = field(default_factory=lambda: np.zeros((0, 6, 6)))
    outline: Array = field(default_factory=lambda: np.zeros((0, 2)))
    elasticity: Array | None = None

    def __post_init__(self) -> None:
        where, problems = f"beam '{self.name}'", Problems()
        bodies = np.asarray(self.bodies, dtype=np.int64)
        labels = tuple(self.labels)
        n, m = len(bodies) - 1, len(labels)
        data = problems.array(where, "data", self.data, (n, 78))
        s = problems.array(where, "s", self.s, (n + 1,))
        points = problems.array(where, "points", self.points, (m, 2))
        rows = problems.array(where, "rows", self.rows, (m, 6, 6))
        outline = problems.array(where, "outline", self.outline, (None, 2))
        elasticity = self.elasticity
        if elasticity is not None:
            elasticity = problems.array(where, "elasticity", elasticity, (2,))
        problems.raise_if_any()
        for name, value in (
            ("bodies", bodies),
            ("data", data),
            ("s", s),
            ("labels", labels),
            ("points", points),
            ("rows", rows),
            ("outline", outline),
            ("elasticity", elasticity),
        ):
            object.__setattr__(self, name, value)

    @property
    def n(self) -> int:
        """Number of elements."""
        return len(self.data)
