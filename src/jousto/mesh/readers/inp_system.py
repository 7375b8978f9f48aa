"""The coordinate system of nodes in Abaqus and CalculiX input files: ``*SYSTEM``."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.mesh.readers.inp_blocks import Block, real
from jousto.mesh.readers.raw import sensible


@dataclass
class LocalSystem:
    """Rectangular coordinate system of nodes: x = origin + axes x'."""

    origin: Array = field(default_factory=lambda: np.zeros(3))
    axes: Array = field(default_factory=lambda: np.eye(3))

    @classmethod
    def of(cls, block: Block) -> LocalSystem:
        """Return the system from the points a (origin), b (on x') and c (in the plane x'y').

        Without c, z' is the global z axis and x' the projection of the line ab; without b, the axes
        are global.
        """
        words = [word for line in block.lines for word in line.strip().rstrip(",").split(",")]
        try:
            numbers = sensible(np.array([real(word) for word in words]))
        except ValueError:
            numbers = np.zeros(1)
        if not len(numbers):
            return cls()
        if len(numbers) not in (3, 6, 9):
            raise InputError(Problem(block.where, "needs the coordinates of one to three points"))
        a, *more = numbers.reshape(-1, 3)
        if not more:
            return cls(a)
        x = more[0] - a
        z = np.cross(x, more[1] - a) if len(more) > 1 else np.array([0.0, 0.0, 1.0])
        x = x - z * (float(x @ z) / max(float(z @ z), float(np.finfo(np.float64).tiny)))
        if not (np.linalg.norm(x) > 0.0 and np.linalg.norm(z) > 0.0):
            raise InputError(
                Problem(block.where, "its points lie on a line, so that the axes are undefined")
            )
        x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
        return cls(a, np.stack([x, np.cross(z, x), z], axis=1))

    def __call__(self, block: Block, x: Array) -> Array:
        """Return positions (n, 3); ``SYSTEM=C`` means radius, angle in degrees, z."""
        kind = block.parameters.get("SYSTEM", "R").upper()[:1]
        x = sensible(x)
        if kind == "C":
            angle = np.radians(x[:, 1])
            x = np.stack([x[:, 0] * np.cos(angle), x[:, 0] * np.sin(angle), x[:, 2]], axis=1)
        elif kind != "R":
            found = block.parameters["SYSTEM"]
            raise InputError(
                Problem(
                    block.where,
                    f"SYSTEM={found} is not supported; export the nodes with SYSTEM=R (x, y, z) or"
                    " SYSTEM=C (radius, degrees, z)",
                )
            )
        out: Array = self.origin + x @ self.axes.T
        return out
