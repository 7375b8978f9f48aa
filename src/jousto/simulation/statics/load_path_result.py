"""Settings and results of path following: ArcLength, LoadPath, CriticalPoint, PathFailed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import Problems, SimulationError, suggest
from jousto.simulation.state import State


@dataclass(frozen=True, eq=False, init=False)
class ArcLength:
    """Arc-length method, which passes limit points of load and of displacement.

    Parameters
    ----------
    weight : float
        Weight of the load in the squared arc length of a step,
        ``x^T W x + (weight (s - s0) / (to - start))^2``; 1: spherical, 0: cylindrical (Crisfield
        1981). x^T W x is the mean over the bodies of ``|dR|^2 / size^2 + |dtheta|^2``.
    limit : int
        Maximum number of steps.
    """

    weight: float
    limit: int

    def __init__(self, weight: float = 1.0, *, limit: int = 400) -> None:
        problems = Problems()
        problems.number("ArcLength", "weight", weight, "", "0 or more", lambda x: x >= 0.0)
        problems.number("ArcLength", "limit", limit, "", "1 or more", lambda x: x >= 1)
        problems.raise_if_any()
        object.__setattr__(self, "weight", float(weight))
        object.__setattr__(self, "limit", int(limit))


@dataclass(frozen=True, eq=False)
class CriticalPoint:
    """Point of a path where the tangent stiffness is singular.

    Attributes
    ----------
    load : float
        Value of the parameter.
    kind : str
        "limit" (extremum of the load) or "bifurcation" (intersection with another path).
    state : State
    increments : (nv,) array
        The critical mode.
    shape : dict
        Nodal displacements (nodes, 3) of each body in the world frame, by its name; maximum 1.
    after : int
        Index of the last point of the path before this one.
    """

    load: float
    kind: str
    state: State
    increments: Array
    shape: dict[str, Array]
    after: int

    def __repr__(self) -> str:
        return f"<CriticalPoint: {self.kind} at {self.load:.6g}>"


@dataclass(frozen=True, eq=False)
class LoadPath:
    """Equilibria along a path; ``path["tip"]`` are the values of the sensor `tip` at its points.

    Attributes
    ----------
    parameter : str
    load : (n,) array
        Values of the parameter.
    states : tuple of State
    sensors : dict
        Values (n,) or (n, k) of each sensor, by its name.
    squares : (n,) array
        Lowest omega^2 of the tangent stiffness, rad2/s2; below 0 the equilibrium is unstable.
    unstable : (n,) int array
        Number of unstable modes, omega^2 < 0, among the computed ones nearest to zero.
    iterations : (n,) int array
        Newton iterations of each point.
    critical : tuple of CriticalPoint
    complete : bool
        Whether the path ends at the requested load.
    ended : str
        Reason of the end of the path.
    """

    parameter: str
    load: Array
    states: tuple[State, ...]
    sensors: dict[str, Array]
    squares: Array
    unstable: NDArray[np.int64]
    iterations: NDArray[np.int64]
    critical: tuple[CriticalPoint, ...]
    complete: bool
    ended: str = ""
    units: Mapping[str, str] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Array:
        if name not in self.sensors:
            raise KeyError(f"no sensor {name!r}{suggest(name, list(self.sensors))}")
        return self.sensors[name]

    def __len__(self) -> int:
        return len(self.load)

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Whether each point is a stable equilibrium, (n,)."""
        return np.asarray(self.unstable == 0)

    @property
    def limits(self) -> Array:
        """Loads of the limit points."""
        return np.array([p.load for p in self.critical if p.kind == "limit"])

    @property
    def bifurcations(self) -> Array:
        """Loads of the bifurcations."""
        return np.array([p.load for p in self.critical if p.kind == "bifurcation"])

    def __repr__(self) -> str:
        found = ", ".join(f"{p.kind} at {p.load:.5g}" for p in self.critical[:4])
        if len(self.critical) > 4:
            found += f" and {len(self.critical) - 4} more"
        return (
            f"<LoadPath: {len(self)} points over {self.parameter!r}, {self.load[0]:.5g} to "
            f"{self.load[-1]:.5g}{'; ' + found if found else ''}>"
        )


class PathFailed(SimulationError):
    """Error for a path that cannot be followed to its end; `path` contains its points so far."""

    def __init__(self, message: str, *, path: LoadPath, body: str = "") -> None:
        self.path = path
        super().__init__(message, time=path.states[-1].time if path.states else 0.0, body=body)
