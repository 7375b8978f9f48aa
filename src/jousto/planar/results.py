"""Results of planar frames: states, runs and equilibrium paths."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, suggest
from jousto.base.object_repr import described
from jousto.planar.frame import PlanarFrame
from jousto.planar.system import Loads, Point


@dataclass(frozen=True, eq=False)
class PlanarState:
    """State of a planar frame, the start of a run.

    Parameters
    ----------
    q, v : (n,) array
        Unknowns and their velocities, in the order of ``frame.system.names``.
    time : float
        Instant, s.
    a, s : (n,) array, optional
        Accelerations and algorithmic accelerations, to continue a run.
    """

    q: Array
    v: Array
    time: float = 0.0
    a: Array | None = None
    s: Array | None = None


def planar_rest(frame: PlanarFrame) -> PlanarState:
    """Return the state of the unloaded frame at rest."""
    return PlanarState(np.zeros(frame.system.size), np.zeros(frame.system.size))


def planar_spinning(
    frame: PlanarFrame, speed: float, about: tuple[float, float] = (0, 0)
) -> PlanarState:
    """Return the state of the unloaded frame in a rigid rotation; for frames without links.

    Parameters
    ----------
    frame : PlanarFrame
    speed : float
        Angular velocity, rad/s, counterclockwise.
    about : (float, float)
        Centre of rotation, m.

    Raises
    ------
    InputError
        If the frame has links.
    """
    if frame.links:
        text = "the frame has links; give PlanarState(q, v) with the velocities of its unknowns"
        raise InputError(Problem("planar_spinning", text))
    v = np.zeros((len(frame.nodes), 3))
    r = np.array(list(frame.nodes.values())) - np.asarray(about)
    v[:, 0], v[:, 1], v[:, 2] = -speed * r[:, 1], speed * r[:, 0], speed
    # stretches do not change
    rest = np.zeros(frame.system.size - v.size)
    return PlanarState(np.zeros(frame.system.size), np.concatenate([v.ravel(), rest]))


class Records:
    """Collector of the steps of a run."""

    def __init__(self, frame: PlanarFrame, t0: float, step: float, steps: int) -> None:
        self.frame, self.system, self.t0, self.step = frame, frame.system, t0, step
        self.held = np.setdiff1d(np.arange(self.system.size), self.system.free)
        self.q: list[Array] = []
        self.v: list[Array] = []
        self.a: list[Array] = []
        self.u: list[tuple[Array, Array, Array]] = []
        self.strains: list[tuple[Array, Array]] = []
        self.powers: list[tuple[float, float]] = []
        self.counts: list[tuple[int, int]] = []
        self.energies: list[tuple[float, float]] = []
        self.s: Array | None = None
        self.largest_ratio, self.worst_element = -np.inf, 0
        # time, element and ratio of the first instability
        self.first: tuple[float, int, float] | None = None

    def ratios(self, resultants: Any) -> Array:
        """Return the axial force of each element over its stability limit, (ne,)."""
        return np.asarray(resultants[:, 0] / self.system.limits)

    def add(self, p: Point, loads: Loads, s: Array, evaluations: int, solves: int) -> None:
        """Append one step."""
        self.q.append(p.q)
        self.v.append(p.v)
        self.a.append(p.a)
        self.u.append((p.slaves.u, p.slaves.v, p.slaves.a))
        self.strains.append(self.system.means(p))
        self.powers.append(self.system.powers(p, loads))
        self.counts.append((evaluations, solves))
        self.energies.append(self.system.energies(p))
        self.s = s
        ratio = self.ratios(self.strains[-1][1])
        i = int(ratio.argmax())
        if ratio[i] > self.largest_ratio:
            self.largest_ratio, self.worst_element = float(ratio[i]), i
        if self.first is None and ratio[i] > 1.0:
            self.first = self.t0 + (len(self.q) - 1) * self.step, i, float(ratio[i])

    def run(self, failure: str, history: tuple[float, ...]) -> PlanarRun:
        """Return the results of all steps."""
        unstable = None
        if self.first is not None:
            time, i, _ = self.first
            unstable = time, self.frame.beam_name(i), self.largest_ratio
        counts = np.array(self.counts)
        n = 3 * self.system.count
        motion = np.array(self.u)[:, :, :n].reshape(len(self.u), 3, -1, 3)
        strains = np.array(self.strains)
        powers = np.array(self.powers)
        works = np.zeros_like(powers)
        works[1:] = np.cumsum(0.5 * self.step * (powers[1:] + powers[:-1]), axis=0)
        return PlanarRun(
            frame=self.frame,
            time=np.asarray(self.t0 + self.step * np.arange(len(self.q)), dtype=np.float64),
            q=np.array(self.q),
            v=np.array(self.v),
            a=np.array(self.a),
            displacements=motion[:, 0],
            velocities=motion[:, 1],
            accelerations=motion[:, 2],
            strains=strains[:, 0],
            resultants=strains[:, 1],
            evaluations=counts[:, 0],
            solves=counts[:, 1],
            energies=np.array(self.energies),
            works=works,
            unstable=unstable,
            failure=failure,
            last_residuals=history,
            method_accelerations=self.s,
        )


class Shapes:
    """Base of motions and equilibria: displacements and strains of a frame."""

    frame: PlanarFrame
    displacements: Array
    strains: Array
    resultants: Array

    @property
    def positions(self) -> Array:
        """Positions of the nodes, (nt, nodes, 2), m."""
        unloaded = np.array(list(self.frame.nodes.values()), dtype=float)
        return np.asarray(unloaded + self.displacements[:, :, :2])

    def node(self, name: object) -> int:
        """Return the index of a node in the arrays.

        Raises
        ------
        InputError
            If there is no such node; the message contains the nearest name.
        """
        names = list(self.frame.nodes)
        if name not in names:
            hint = suggest(name, map(str, names))
            raise InputError(Problem(f"node {name!r}", f"there is none{hint}"))
        return names.index(name)


@described
@dataclass(frozen=True, eq=False)
class PlanarRun(Shapes):
    """Motion of a planar frame; arrays over time, nodes in the order of ``frame.nodes``.

    Attributes
    ----------
    frame : PlanarFrame
    time : (nt,) array
        Instants of all steps, s.
    q, v, a : (nt, n) array
        Unknowns with their velocities and accelerations.
    displacements, velocities, accelerations : (nt, nodes, 3) array
        x, y (m, m/s, m/s^2) and rotation (rad, rad/s, rad/s^2) of the nodes.
    strains : (nt, ne, 3) array
        eps, gam, kap (1/m) of the beams: of exact elements at the midpoint, of others the mean.
    resultants : (nt, ne, 3) array
        N, Q (N), M (N m) of the beams, as the strains, without damping.
    evaluations, solves : (nt,) array of int
        Numbers of residuals and linear systems of each step; zero for the start.
    energies : (nt, 2) array
        Kinetic and strain energy, J.
    works : (nt, 2) array
        Work of loads, gravity and prescribed motions, and work lost in damping, J, since the start;
        powers are integrated by the trapezoidal rule.
    unstable : (float, str, float) or None
        First instant at which a beam exceeds its limit of tension-shear stability, its name, and
        the largest ratio to the limit in the run.
    failure : str
        Reason of an early end; empty without one.
    last_residuals : tuple of float
        Residuals of Newton's iteration in the last step.
    method_accelerations : (n,) array or None
        Algorithmic accelerations, to continue the run.
    """

    frame: PlanarFrame
    time: Array
    q: Array
    v: Array
    a: Array
    displacements: Array
    velocities: Array
    accelerations: Array
    strains: Array
    resultants: Array
    evaluations: NDArray[np.int_]
    solves: NDArray[np.int_]
    energies: Array
    works: Array
    unstable: tuple[float, str, float] | None
    failure: str
    last_residuals: tuple[float, ...]
    method_accelerations: Array | None

    @property
    def steps(self) -> int:
        """Number of converged steps."""
        return len(self.time) - 1

    @property
    def balance(self) -> Array:
        """Energy balance (nt,), J: kinetic and strain energy, minus supplied and plus lost work.

        It is constant for an exact solution; its drift is of the order of the method.
        """
        return np.asarray(self.energies.sum(axis=1) - self.works[:, 0] + self.works[:, 1])

    @property
    def complete(self) -> bool:
        """Whether the run reached its end."""
        return not self.failure

    def state(self, k: int = -1) -> PlanarState:
        """Return the state at a step; a run that starts from the last state continues exactly."""
        last = k in (-1, self.steps)
        s = self.method_accelerations if last else None
        return PlanarState(self.q[k], self.v[k], float(self.time[k]), self.a[k], s)


@described
@dataclass(frozen=True, eq=False)
class PlanarPath(Shapes):
    """Equilibria of a planar frame under growing loads.

    Attributes
    ----------
    frame : PlanarFrame
    factors : (nt,) array
        Load factors.
    q : (nt, n) array
        Unknowns.
    displacements : (nt, nodes, 3) array
        x, y (m) and rotation (rad) of the nodes.
    strains : (nt, ne, 3) array
        eps, gam, kap (1/m) of the beams: of exact elements at the midpoint, of others the mean.
    resultants : (nt, ne, 3) array
        N, Q (N), M (N m) of the beams, as the strains, without damping.
    negative : (nt,) array of int
        Number of negative eigenvalues of the tangent: 0 for a stable equilibrium under
        conservative loads; a change indicates a limit or bifurcation point.
    residuals : tuple of tuples of float
        Residuals of Newton's iteration at each point.
    solves : (nt,) array of int
        Numbers of linear systems of each point, including those of steps that were halved.
    """

    frame: PlanarFrame
    factors: Array
    q: Array
    displacements: Array
    strains: Array
    resultants: Array
    negative: NDArray[np.int_]
    residuals: tuple[tuple[float, ...], ...]
    solves: NDArray[np.int_]

    def state(self, k: int = -1) -> PlanarState:
        """Return an equilibrium as the start of a run."""
        return PlanarState(self.q[k], np.zeros_like(self.q[k]))
