"""BeamShape: data of a beam for stress recovery and drawing."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.base.object_repr import described


@described
@dataclass(frozen=True, eq=False)
class SectionShape:
    """Stress points and outline of a beam section.

    Parameters
    ----------
    labels : tuple of str
        Names of the points of the section; empty if its stress is unknown.
    points : (np, 2) array
        Positions y, z from the axis, m.
    rows : (np, 6, 6) array
        ``[s11 s22 s33 s12 s23 s13]`` at each point for unit resultants ``[N Qy Qz Mx My Mz]``.
    outline : (k, 2) array
        Outline of the section, counterclockwise seen against x, m; empty if unknown.
    elasticity : (2,) array or None
        Young's modulus, Pa, and Poisson's ratio; None if unknown.

    Raises
    ------
    InputError
        If the arrays are inconsistent.
    """

    labels: tuple[str, ...] = ()
    points: Array = field(default_factory=lambda: np.zeros((0, 2)))
    rows: Array = field(default_factory=lambda: np.zeros((0, 6, 6)))
    outline: Array = field(default_factory=lambda: np.zeros((0, 2)))
    elasticity: Array | None = None

    def __post_init__(self) -> None:
        where, problems = "SectionShape", Problems()
        labels = tuple(self.labels)
        m = len(labels)
        points = problems.array(where, "points", self.points, (m, 2))
        rows = problems.array(where, "rows", self.rows, (m, 6, 6))
        outline = problems.array(where, "outline", self.outline, (None, 2))
        elasticity = self.elasticity
        if elasticity is not None:
            elasticity = problems.array(where, "elasticity", elasticity, (2,))
        problems.raise_if_any()
        for name, value in (
            ("labels", labels),
            ("points", points),
            ("rows", rows),
            ("outline", outline),
            ("elasticity", elasticity),
        ):
            object.__setattr__(self, name, value)


@described
@dataclass(frozen=True, eq=False)
class BeamShape:
    """A beam: its elements, the bodies at its nodes, and the stress of its sections.

    Parameters
    ----------
    name : str
        Name of the beam.
    bodies : (n + 1,) int array
        Indices of the bodies at the nodes, along the beam.
    data : (n, 78) or wider array
        Data of each element as in the engine, see ``jo_beam`` in jousto.h.
    s : (n + 1,) array
        Length of the unstressed beam from its start to each node, m.
    nodes : (n + 1, 3) array
        Nodes in the body frame, m.
    frames : (n + 1, 3, 3) array
        Axes of the node bodies, as columns in the body frame.
    sections : tuple of SectionShape
        The different sections.
    which : (n,) int array
        Index of the section of each element.

    Raises
    ------
    InputError
        If the arrays are inconsistent.
    """

    name: str
    bodies: NDArray[np.int64]
    data: Array
    s: Array
    nodes: Array
    frames: Array
    sections: tuple[SectionShape, ...]
    which: NDArray[np.int64]

    def __post_init__(self) -> None:
        where, problems = f"beam '{self.name}'", Problems()
        bodies, which = (np.array(x, dtype=np.int64) for x in (self.bodies, self.which))
        n = len(bodies) - 1
        data = problems.array(where, "data", self.data, (n, None))
        s = problems.array(where, "s", self.s, (n + 1,))
        nodes = problems.array(where, "nodes", self.nodes, (n + 1, 3))
        frames = problems.array(where, "frames", self.frames, (n + 1, 3, 3))
        if which.shape != (n,) or (n and not 0 <= which.min() <= which.max() < len(self.sections)):
            problems.add(
                where,
                f"which must be the index of a section of {len(self.sections)} for {n} elements",
            )
        problems.raise_if_any()
        for name, value in (
            ("bodies", bodies),
            ("data", data),
            ("s", s),
            ("nodes", nodes),
            ("frames", frames),
            ("which", which),
        ):
            object.__setattr__(self, name, value)

    @property
    def n(self) -> int:
        """Number of elements."""
        return len(self.data)

    @property
    def stressed(self) -> bool:
        """Whether the stress of a section is known."""
        return any(section.labels for section in self.sections)
