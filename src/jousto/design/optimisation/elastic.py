"""Static model of a flexible body: stiffness, supports and stress."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.linalg as sl
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.base.arrays import Array, Sparse
from jousto.base.errors import InputError, Problem, suggest
from jousto.base.object_repr import described
from jousto.parts.frames.stress import StressOperator
from jousto.parts.part import Part
from jousto.reduction.sparse.factor import Solver, factorise


@described
@dataclass(frozen=True, eq=False)
class Elastic:
    """A linear elastic body: ``K z = f``.

    Parameters
    ----------
    name : str
        Name of the body.
    K : (ndof, ndof) sparse array
        Stiffness, N/m (N m for rotations).
    held : (nh,) int array
        Fixed degrees of freedom: none if K is regular, else as many as there are rigid motions, so
        that loads in balance cause no reactions.
    rigid : (ndof, nr) array
        Rigid motions.
    stress : StressOperator or None
        Stress from displacements.
    nodes : mapping of str to int
        Nodes by name.
    dofs_per_node : int
    points : (ndof, 3) array, optional
        Position of each degree of freedom, m.
    """

    name: str
    K: Sparse
    held: NDArray[np.intp]
    rigid: Array
    stress: StressOperator | None = None
    nodes: Mapping[str, int] = field(default_factory=dict)
    dofs_per_node: int = 1
    points: Array | None = None

    @classmethod
    def from_part(cls, name: str, part: Part) -> Elastic:
        """Return the static model of an unsupported part."""
        R = part.rigid_modes()
        # fix the six degrees of freedom whose rigid motions are most independent
        _, _, order = sl.qr(R.T, mode="economic", pivoting=True)
        held = np.sort(order[: R.shape[1]]).astype(np.intp)
        stress = part.stress if isinstance(part.stress, StressOperator) else None
        single = {k: v[0] for k, v in part.node_sets.items() if len(v) == 1}
        d = part.dofs_per_node
        return cls(name, part.K, held, R, stress, single, d, np.repeat(part.nodes, d, axis=0))

    @cached_property
    def _free(self) -> NDArray[np.intp]:
        free = np.ones(self.K.shape[0], dtype=bool)
        free[self.held] = False
        return np.flatnonzero(free)

    @cached_property
    def _factor(self) -> Solver:
        K = sp.csc_array(self.K)[self._free][:, self._free]
        free = self._free
        return factorise(
            sp.csc_array(K),
            f"body '{self.name}'",
            lambda i: f"degree of freedom {free[i]}",
            None if self.points is None else self.points[free],
        )

    def solve(self, f: Array) -> Array:
        """Return the displacements (ndof, nc) under loads (ndof, nc); supported ones are zero."""
        z = np.zeros(f.shape)
        z[self._free] = self._factor(f[self._free])
        return z

    def unbalance(self, f: Array) -> float:
        """Return the largest ratio of the resultant of loads (ndof, nc) to their size."""
        if not self.rigid.shape[1]:
            return 0.0
        size = np.abs(self.rigid).T @ np.abs(f)
        return float((np.abs(self.rigid.T @ f) / np.where(size > 0, size, 1.0)).max(initial=0.0))

    def node(self, name: str) -> int:
        """Return the index of a node from its name.

        Raises
        ------
        InputError
            If there is no such node.
        """
        if name not in self.nodes:
            message = f"no node {name!r}{suggest(name, self.nodes)}"
            raise InputError(Problem(f"body '{self.name}'", message))
        return self.nodes[name]


@described
@dataclass(frozen=True, eq=False)
class Motion:
    """Deformation of a body in a run: ``z(t) = shapes y(t)``.

    Parameters
    ----------
    body : int
        Index of the body in the problem.
    case : str
        Load case; empty if there is one only.
    time : (nt,) array
        Instants, s.
    shapes : (ndof, n) array
    coordinates : (n, nt) array
    """

    body: int
    case: str
    time: Array
    shapes: Array
    coordinates: Array


@described
@dataclass(frozen=True, eq=False)
class EquivalentLoad:
    """Static loads that cause the deformation of a run, and their derivatives by the design.

    ``f(t; x) = K z(t) = columns y(t; x)``, with y linear in the parameters x.

    Parameters
    ----------
    motion : Motion
        The motion at the design `at`.
    at : (nd,) array
    columns : (ndof, nc) array
        N.
    values : (nc, nt) array
        y at the design `at`.
    slopes : (nd, nc, nt) array or None
        ``dy/dx``; None for classical equivalent loads, which are constant.
    """

    motion: Motion
    at: Array
    columns: Array
    values: Array
    slopes: Array | None = None

    def coordinates(self, x: Array, instants: NDArray[np.intp]) -> Array:
        """Return the coordinates y (nc, ni) of a design at some instants."""
        y = self.values[:, instants]
        if self.slopes is not None:
            y = y + np.tensordot(x - self.at, self.slopes[:, :, instants], axes=(0, 0))
        return y
