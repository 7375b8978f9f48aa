"""SupportedPart: a part held by clamps and springs, its modes, displacements and reactions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from jousto.base.arguments import explained
from jousto.base.arrays import Array, Index, skew
from jousto.base.errors import InputError, Problem, Problems, count, warn
from jousto.base.object_repr import described
from jousto.parts.part import Part
from jousto.reduction.modes import eigen
from jousto.reduction.modes.fixed_interface_response import rigid_left
from jousto.reduction.modes.ties import embedded
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.sparse.factor import Solver, factorise
from jousto.reduction.supports.mechanism import mechanism_left
from jousto.reduction.supports.overlaps import check_overlaps, held_directions
from jousto.reduction.supports.restraints import (
    held_coordinates,
    rigid_support,
    spring_stiffness,
)
from jousto.reduction.supports.softness import check_softness
from jousto.reduction.supports.support import SpringSupport, Support
from jousto.reduction.supports.system import (
    System,
    full_system,
    reduced_system,
)

ROUNDING = 1e-12  # force over the size of the terms of K u, below which it is rounding error
UNBALANCED = 1e-6  # sum of loads and reactions over their size, above which rounding is too large


@described
@dataclass(frozen=True, eq=False)
class SupportedModes:
    """Modes of a supported part.

    Attributes
    ----------
    frequencies : (k,) array
        Hz, ascending.
    shapes : (k, nodes, 3) array
        Displacements of the nodes, part axes, of unit modal mass, kg^-0.5.
    """

    frequencies: Array
    shapes: Array


@described
@dataclass(frozen=True, eq=False)
class Reaction:
    """Force of a support on a node of the part.

    Attributes
    ----------
    support : str
        Name of the support, such as ``Clamp on 'start'``.
    node : str
        Name of the node.
    at : (3,) array
        Position of the node, m, part frame.
    force, moment : (3,) array
        N and N m about the node, part axes.
    """

    support: str
    node: str
    at: Array
    force: Array
    moment: Array


@described
@dataclass(frozen=True, eq=False)
class SupportedState:
    """Static state of a supported part under loads and settlements.

    Attributes
    ----------
    displacements : (nodes, 3) array
        m, part axes.
    reactions : tuple of Reaction
        Reactions, one for each node of each support.
    balance : float
        Largest component of the resultant of loads and reactions (force, or moment over the size of
        the part), divided by the sum of their magnitudes. It is of the order of rounding errors.
    """

    displacements: Array
    reactions: tuple[Reaction, ...]
    balance: float

    def reaction(self, node: str) -> Array:
        """Return the force and moment (6,) of all supports of a node, N and N m."""
        found = [x for x in self.reactions if x.node == node]
        if not found:
            known = ", ".join(dict.fromkeys(x.node for x in self.reactions))
            raise InputError(
                Problem("reaction", f"no support at node {node!r}; there are: {known}")
            )
        return np.asarray(np.sum([np.append(x.force, x.moment) for x in found], axis=0))

    def __str__(self) -> str:
        lines = [f"{'support':<28} {'node':<10}" + "".join(f"{x:>12}" for x in HEADS)]
        for x in self.reactions:
            values = "".join(f"{v:12.5g}" for v in (*x.force, *x.moment))
            lines.append(f"{x.support:<28} {x.node:<10}{values}")
        return "\n".join([*lines, f"loads and reactions balance to {self.balance:.1e}"])


HEADS = ("Fx, N", "Fy, N", "Fz, N", "Mx, N m", "My, N m", "Mz, N m")


class SupportedPart:
    """Part held by clamps and springs; made by `clamp`.

    The held coordinates c have the settlement, the others f solve ``(K_ff + K_s) u_f = f_f - K_fc
    u_c``. Reactions are ``K u - f`` at clamps and ``-K_s u`` at springs. Supports may be statically
    indeterminate.

    Parameters
    ----------
    part : Part or ReducedPart
    supports : sequence of Clamp and SpringSupport
    solver : str, optional
        Library that factorises the stiffness, see `solvers`.

    Raises
    ------
    InputError
        If supports are unknown or contradict one another, or leave rigid motions, which are named.
    """

    def __init__(
        self, part: Part | ReducedPart, supports: Sequence[Support], *, solver: str | None = None
    ) -> None:
        self.part, self.supports = part, tuple(supports)
        self._solver = solver
        make: Any = reduced_system if isinstance(part, ReducedPart) else full_system
        self._system: System = make(part, self.supports)
        problems = Problems()
        check_overlaps(problems, self._system, self.supports)
        self._held, self._settled = held_coordinates(problems, self._system, self.supports)
        self._springs = spring_stiffness(problems, self._system, self.supports)
        problems.raise_if_any()
        self._check_rigid()

    def __repr__(self) -> str:
        return f"<SupportedPart {self.part.name!r}: {count(len(self.supports), 'support')}>"

    @explained
    def modes(self, count: int = 10) -> SupportedModes:
        """Return the modes of least frequency.

        Parameters
        ----------
        count : int
            Maximum number of modes.

        Raises
        ------
        InputError
            If the part has an internal motion without stiffness.
        """
        problems = Problems()
        given: object = count
        if isinstance(given, str):
            wanted = "must be a whole number, at least 1"
            problems.add("modes", f"count is {given!r}, a str, {wanted}", "count")
        else:
            problems.whole("modes", "count", count)
        problems.raise_if_any()
        s, free = self._system, self._free
        dense = len(free) <= eigen.DENSE_LIMIT
        problem = eigen.Flexibility(
            len(free),
            lambda y: s.lift(embedded(y, free, s.K.shape[0])),
            lambda f: s.lower(f)[free],
            self._K_ff.toarray() if dense else self._K_ff,
            None if dense else self._solve,
        )
        mu, X = eigen.spectrum(problem, s.M, modes=count, frequency_limit=None, where=s.where)
        mu, X = mu[:count], X[:, :count]
        # motions of unit stiffness become those of unit mass
        shapes = s.displacements(X / np.sqrt(mu))
        return SupportedModes(1.0 / (2.0 * np.pi * np.sqrt(mu)), np.moveaxis(shapes, 2, 0))

    @explained
    def statics(self, *loads: Any) -> SupportedState:
        """Return displacements and reactions under loads and the settlement of the clamps.

        Parameters
        ----------
        *loads : Weight, NodalForce, Pressure ... or (ndof,) array_like
            Loads as for `Part.load`, or its result. A reduced part takes `Weight`, in the share of
            its modes, and `NodalForce` at interfaces. None for the settlement alone.

        Raises
        ------
        InputError
            If a load does not fit, or the part has an internal motion without stiffness.

        Warns
        -----
        JoustoWarning
            If loads and reactions do not balance to 1e-6 because of rounding.
        """
        s, free, held = self._system, self._free, self._held
        f, u = s.load(loads), np.zeros(s.K.shape[0])
        u[held] = self._settled
        for _ in range(3):  # iterative refinement, since reactions are differences of large forces
            u[free] += self._solve((f - self._forces(u))[free])
        r = np.zeros(len(u))
        r[held] = (self._forces(u) - f)[held]
        reactions = self._reactions(r, u)
        # without loads and strain all forces are rounding errors of K u
        rounding = ROUNDING * float((abs(s.K) @ np.abs(u)).max())
        total, size = self._resultants(f, reactions)
        balance = total / size if size > rounding else 0.0
        if balance > UNBALANCED:
            warn(s.where, f"loads and reactions balance only to {balance:.1e} of their size")
        displacements = s.displacements(s.lift(u[:, None]))[:, :, 0]
        return SupportedState(displacements, reactions, balance)

    def _resultants(self, f: Array, reactions: Sequence[Reaction]) -> tuple[float, float]:
        """Return the resultant of loads and listed reactions, and the sum of their sizes, N.

        Both are the largest of forces and moments about the centroid over the size of the part.
        """
        s, R = self._system, self._rigid
        total, size = R.T @ f, np.abs(R).T @ np.abs(f)
        for x in reactions:
            B = np.eye(6)
            B[3:, :3] = skew(x.at - s.center)
            B[3:] /= s.length
            wrench = np.concatenate([x.force, x.moment])
            total, size = total + B @ wrench, size + np.abs(B) @ np.abs(wrench)
        return float(np.abs(total).max()), float(size.max())

    def _forces(self, u: Array) -> Array:
        """Return ``(K + K_s) u`` without the rounding of rigid motions, which strain springs only.

        ``K u = K (u - R a)`` with the rigid motions R a next to u.
        """
        R, unit = self._rigid, self._unit
        a = np.linalg.lstsq(unit[:, None] * R, unit * u, rcond=None)[0]
        return np.asarray(self._system.K @ (u - R @ a) + self._springs @ u)

    @cached_property
    def _rigid(self) -> Array:
        """Rigid motions (n, 6), rotations over the size of the part."""
        return np.asarray(self._system.motions / np.repeat([1.0, self._system.length], 3))

    @cached_property
    def _unit(self) -> Array:
        """Size of the part, m, at rotations of supported nodes, else 1, (n,)."""
        unit = np.ones(len(self._rigid))
        for node in (node for nodes in self._system.nodes for node in nodes):
            unit[node.places[3:][node.places[3:] >= 0]] = self._system.length
        return unit

    @cached_property
    def _free(self) -> Index:
        return np.setdiff1d(np.arange(self._system.K.shape[0]), self._held)

    @cached_property
    def _K_ff(self) -> sp.csc_array:
        return sp.csc_array(sp.csr_array(self._system.K + self._springs)[self._free][:, self._free])

    @cached_property
    def _solve(self) -> Solver:
        s, free = self._system, self._free
        if s.points is None:
            return _dense_solver(self._K_ff.toarray(), s.where)
        return factorise(
            self._K_ff,
            s.where,
            lambda k: s.label(int(free[k])),
            s.points[free],
            solver=self._solver,
        )

    def _check_rigid(self) -> None:
        """Raise InputError with the rigid motions that strain no support, or too softly."""
        s, R = self._system, self._rigid
        found = rigid_support(s, self.supports, self._held, self._unit, R)
        left = rigid_left(found.rows)
        if left.shape[1]:
            raise InputError(mechanism_left(s.where, left, s.center, s.length))
        check_softness(s, self.supports, found, R)

    def _reactions(self, r: Array, u: Array) -> tuple[Reaction, ...]:
        """Return the reactions from the forces on held coordinates and the displacements."""
        out = []
        for support, nodes in zip(self.supports, self._system.nodes, strict=True):
            name = f"{type(support).__name__} on {support.label}"
            for node in nodes:
                values = np.zeros(6)
                if isinstance(support, SpringSupport):
                    known = node.places >= 0
                    K = support.stiffness[np.ix_(known, known)]
                    values[known] = -K @ u[node.places[known]]
                else:
                    own = held_directions(support, node)
                    values[own] = r[node.places[own]]
                out.append(Reaction(name, node.name, node.at, values[:3], values[3:]))
        return tuple(out)


def _dense_solver(K: Array, where: str) -> Solver:
    """Return a function that solves ``K u = f`` for a matrix in mixed units."""
    scale = 1.0 / np.sqrt(np.diag(K))
    try:
        factor = la.cho_factor(scale[:, None] * K * scale)
    except la.LinAlgError:
        raise InputError(Problem(where, "its stiffness with the supports is singular")) from None
    return lambda f: scale * la.cho_solve(factor, scale * f)
