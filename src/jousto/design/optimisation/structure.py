"""Optimisation problems of linear structures under given forces over time."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import scipy.linalg as sl
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.signal import lfilter

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem as Trouble, Problems, suggest
from jousto.design.optimisation.elastic import Elastic, Motion
from jousto.design.optimisation.limits import Limit
from jousto.design.optimisation.problem import Problem
from jousto.design.studies.parameters.parameter import Parameter
from jousto.parts.frames.stress import StressOperator

WHERE = "StructureProblem"
GAUSS = np.polynomial.legendre.leggauss(5)


class StructureProblem(Problem):
    """Optimisation of a supported, modally damped linear structure, ``M z'' + K z = F(t)``.

    The structure starts at rest. The motion is exact for forces that are polynomials of degree 4
    between instants, at any natural frequencies: exponential of each mode, polynomial of the force
    through five Gauss points. Without mass the response is ``K z = F(t)``.

    Parameters
    ----------
    parameters : sequence of Parameter
    matrices : function
        Returns M and K (n, n), symmetric, for the parameters by name; None for M without mass.
    force : function
        Returns the loads F (n, nt) in N at times (nt,).
    time : (nt,) array_like
        Instants, evenly spaced from 0, s.
    cost : function
        Returns the cost to minimise, for the parameters by name.
    limits : sequence of Limit
        Limits on body "structure" with nodes "1" .. "n", one for each degree of freedom.
    damping : float
        Damping ratio of all modes, below 1.
    stress : function, optional
        Returns, for the parameters by name, the stress of each member per displacement, (n,), Pa/m,
        by member names. For `StressLimit` and `LifeLimit`, members are sites with the component
        s11.
    components : dict of str to sequence of str, optional
        Nodes of each part of the structure, from the support outwards, for an optimisation with
        ``machine="rigid"``; every node belongs to one part. Without them the structure is one part.

    Raises
    ------
    InputError
        If time, functions and their results at the start are inconsistent.

    Examples
    --------
    A bar of 1 m under 10 kN, whose stress shall stay below 100 MPa, needs 100 mm^2:

    >>> import jousto as jo
    >>> from jousto.design import StressLimit, StructureProblem, optimise
    >>> bar = StructureProblem(
    ...     [jo.Parameter("A", 1e-3, bounds=(1e-5, 1e-2), unit="m^2")],
    ...     lambda v: (None, [[210e9 * v["A"]]]),
    ...     lambda t: np.full((1, len(t)), 10e3),
    ...     [0.0, 1.0],
    ...     lambda v: 7850.0 * v["A"],
    ...     [StressLimit("structure", 100e6, criterion="s11")],
    ...     stress=lambda v: {"bar": [210e9]},
    ... )
    >>> round(1e6 * optimise(bar).values["A"], 2)
    100.0
    """

    def __init__(
        self,
        parameters: Sequence[Parameter],
        matrices: Callable[[Mapping[str, float]], tuple[ArrayLike | None, ArrayLike]],
        force: Callable[[Array], Array],
        time: ArrayLike,
        cost: Callable[[Mapping[str, float]], float],
        limits: Sequence[Limit],
        damping: float = 0.0,
        stress: Callable[[Mapping[str, float]], Mapping[str, ArrayLike]] | None = None,
        components: Mapping[str, Sequence[str]] | None = None,
    ) -> None:
        super().__init__(parameters, limits)
        problems, where = Problems(), WHERE
        t = problems.array(where, "time", time, (None,))
        problems.number(where, "damping", damping, "", "from 0 to below 1", lambda v: 0 <= v < 1)
        if t is not None and (
            len(t) < 2 or t[0] != 0.0 or np.ptp(np.diff(t)) > 1e-9 * t[-1] or t[1] <= 0.0
        ):
            problems.add(where, "time must start at 0 and be evenly spaced")
        functions: dict[str, Any] = {"matrices": matrices, "force": force, "cost": cost}
        if stress is not None:
            functions["stress"] = stress
        for key, function in functions.items():
            if not callable(function):
                problems.add(where, f"{key} is {function!r}, must be a function")
        problems.raise_if_any()
        assert t is not None
        self.time = t
        self._matrices, self._cost, self._damping = matrices, cost, damping
        self._stress = stress
        x, _ = GAUSS
        h = t[1]
        share = 0.5 * (1.0 + x)
        # column j: coefficients of the Lagrange polynomial of point j in powers of the share
        self._powers = np.linalg.inv(np.vander(share, increasing=True))
        points = (t[:-1, None] + h * share).ravel()
        F = _forces(force, points)
        self._force = F.reshape(F.shape[0], len(t) - 1, len(x))
        self._size = len(F)
        self.components = component_rows(components, self._size)
        massless = self.matrices(self.start)[0] is None
        self._still = _forces(force, t) if massless else None
        self._operator(self.start)

    def matrices(self, x: Array) -> tuple[Array | None, Array]:
        """Return mass (or None) and stiffness matrix (n, n) of a design.

        Raises
        ------
        InputError
            If the matrices are not symmetric, finite and of the size of the force.
        """
        made: Any = self._matrices(self.values(x))
        if not isinstance(made, (tuple, list)) or len(made) != 2:
            raise InputError(Trouble(WHERE, f"matrices returns {made!r}, must be M and K"))
        problems, size = Problems(), (self._size, self._size)
        found: list[Array | None] = []
        for name, one in zip("MK", made, strict=True):
            A = None if name == "M" and one is None else problems.array(WHERE, name, one, size)
            if A is not None and np.abs(A - A.T).max() > 1e-9 * np.abs(A).max():
                problems.add(WHERE, f"{name} is not symmetric")
            found.append(A)
        problems.raise_if_any()
        assert found[1] is not None
        return found[0], found[1]

    def _operator(self, x: Array) -> StressOperator | None:
        """Return the stress operator of the members.

        Raises
        ------
        InputError
            If `stress` does not return rows by names.
        """
        if self._stress is None:
            return None
        made: Any = self._stress(self.values(x))
        if not isinstance(made, Mapping) or not made:
            message = f"stress returns {made!r}, must be a dict of rows by the names of members"
            raise InputError(Trouble(WHERE, message))
        problems = Problems()
        rows = [problems.array(WHERE, f"stress[{k!r}]", v, (self._size,)) for k, v in made.items()]
        problems.raise_if_any()
        table = np.zeros((len(made), 6, self._size))
        table[:, 0] = rows
        places, axes = np.zeros((len(made), 3)), np.tile(np.eye(3), (len(made), 1, 1))
        matrix = sp.csr_array(table.reshape(-1, self._size))
        return StressOperator(tuple(map(str, made)), places, axes, matrix)

    def cost(self, x: Array) -> float:
        """Return the cost of a design."""
        return float(self._cost(self.values(x)))

    def elastic(self, x: Array) -> tuple[Elastic, ...]:
        """Return the static model of the structure."""
        K = sp.csr_array(self.matrices(x)[1])
        names = {str(i + 1): i for i in range(self._size)}
        held, rigid = np.zeros(0, dtype=np.intp), np.zeros((self._size, 0))
        return (Elastic("structure", K, held, rigid, self._operator(x), names),)

    def frequencies(self, x: Array) -> Array:
        """Return the natural frequencies, Hz.

        Raises
        ------
        InputError
            If the structure has no mass, or K is not positive definite.
        """
        M, K = self.matrices(x)
        if M is None:
            raise InputError(Trouble("frequency limit", "the structure has no mass"))
        return np.sqrt(_modes(M, K)[0]) / (2.0 * np.pi)

    def _weights(self, z: complex) -> Any:
        """Return the weights (5,) of ``int_0^1 exp(z (1 - s)) f(s) ds`` at Gauss' points.

        ``int_0^1 exp(z (1 - s)) s^k / k! ds = phi_(k+1)(z)``, by one exponential of a matrix
        (C. Van Loan, IEEE Trans. Autom. Control 23 (1978) 395-404).
        """
        n = len(self._powers)
        A = np.diag(np.ones(n, dtype=complex), 1)
        A[0, 0] = z
        phi = sl.expm(A)[0, 1:]
        return (phi * [math.factorial(k) for k in range(n)]) @ self._powers

    def run(self, x: Array) -> tuple[Motion, ...]:
        """Return the motion by modal superposition, or the static response without mass."""
        M, K = self.matrices(x)
        if M is None:
            assert self._still is not None
            (body,) = self.bodies(x)
            return (Motion(0, "", self.time, np.eye(self._size), body.solve(self._still)),)
        shapes, q = self.vibration(M, K, np.eye(self._size))
        return (Motion(0, "", self.time, shapes, q),)

    def vibration(self, M: Array, K: Array, carried: Array) -> tuple[Array, Array]:
        """Return modes (n, m) and their motion (m, nt) of a part that moves the nodes.

        Parameters
        ----------
        M, K : (m, m) array
            Mass and stiffness of the part.
        carried : (n, m) array
            Displacement of all nodes in each degree of freedom of the part.
        """
        w2, modes = _modes(M, K)
        shapes = carried @ modes
        w, h = np.sqrt(w2), self.time[1]
        pole = w * (-self._damping + 1j * np.sqrt(1.0 - self._damping**2))
        q = np.zeros((len(w), len(self.time)))
        for i, p in enumerate(pole):
            f = np.tensordot(shapes[:, i], self._force, axes=(0, 0))
            pushed = f @ self._weights(p * h) * h
            s = lfilter([1.0], [1.0, -np.exp(p * h)], pushed)
            q[i, 1:] = s.imag / p.imag
        return shapes, q


def component_rows(
    components: Mapping[str, Sequence[str]] | None, size: int
) -> dict[str, NDArray[np.intp]]:
    """Return the degrees of freedom of each part by name.

    Raises
    ------
    InputError
        If a node is unknown, is in no part or in several.
    """
    whole = {"structure": [str(i + 1) for i in range(size)]}
    given: Any = whole if components is None else components
    names = {str(i + 1): i for i in range(size)}
    problems = Problems()
    if not isinstance(given, Mapping):
        message = f"components is {given!r}, must be a dict of node names by the names of parts"
        raise InputError(Trouble(WHERE, message))
    every = [(part, str(node)) for part, nodes in given.items() for node in nodes]
    for part, node in every:
        if node not in names:
            problems.add(WHERE, f"components[{part!r}]: no node {node!r}{suggest(node, names)}")
    counts = [sum(node == one for _, node in every) for one in names]
    for node, times in zip(names, counts, strict=True):
        if times != 1:
            problems.add(WHERE, f"components: node {node!r} is in {times} parts, must be in one")
    problems.raise_if_any()
    return {
        str(part): np.array([names[str(node)] for node in nodes], dtype=np.intp)
        for part, nodes in given.items()
    }


def _forces(force: Callable[[Array], Array], time: Array) -> Array:
    """Return the nodal forces (n, nt).

    Raises
    ------
    InputError
        If the function returns something else.
    """
    F = np.asarray(force(time), dtype=np.float64)
    if F.ndim != 2 or F.shape[1] != len(time) or not np.all(np.isfinite(F)):
        message = "force must return finite numbers (n, nt) at any times of the run"
        raise InputError(Trouble(WHERE, message))
    return F


def _modes(M: Array, K: Array) -> tuple[Array, Array]:
    """Return squared circular frequencies, rad2/s2, and mass-normalised modes.

    Raises
    ------
    InputError
        If M or K is not positive definite.
    """
    try:
        w2, shapes = sl.eigh(K, M)
    except np.linalg.LinAlgError:
        message = "M is not positive definite: every degree of freedom needs mass"
        raise InputError(Trouble(WHERE, message)) from None
    if w2[0] <= 1e-14 * w2[-1]:
        raise InputError(Trouble(WHERE, "K is not positive definite: is the structure supported?"))
    return w2, shapes
