"""Free motions of a machine: drift of their phase by elastic bodies, and growth of deviations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jousto.base.arrays import Array, Ints
from jousto.base.errors import JoustoError
from jousto.design.flexibility.quasi_static import (
    INDEPENDENT,
    admissible_motions,
    modal_velocities,
)
from jousto.model.model import Model
from jousto.model.native.native import Engine, displaced
from jousto.model.scales import velocity_metres
from jousto.simulation.results.solution import Solution
from jousto.simulation.running.simulate import simulate
from jousto.simulation.state import put

MOVED = 1e-7
"""Displacement at the start of the second run / size of the machine."""
REGULAR = 30.0
"""Growth of a deviation in a run, up to which a motion is regular: its phase runs away linearly."""
UNEVEN = 4.0
"""Factor on the drift for motions that are not one harmonic oscillation: in large or coupled swings
a deviation of the phase where the motion is slow grows where it is fast."""
AHEAD = 1e-6
"""Time, s, of the differences for rates of readings."""
ALMOST_STILL = 1e-9
"""Kinetic energy of free motions / strain energy, below which they do not move."""


@dataclass(frozen=True, eq=False)
class Swings:
    """Free motions of the machine with rigid bodies.

    Attributes
    ----------
    slower : float
        Period with elastic bodies / period with rigid ones - 1.
    growth : float
        Factor of deviations in irregular motions; 1 for regular ones.
    rates : mapping of str to (nt, k) array
        Rates of the values of each sensor along the free motions.
    """

    slower: float
    growth: float
    rates: Mapping[str, Array]

    def drift(self, time: Array, rate: Array) -> float:
        """Return the largest difference of a reading by the phase of free motions, in its unit.

        The time of the free part of the reading is stretched: ``slower int |y'| dt``, times
        `UNEVEN`. The most is the range of this part, ``(1 + slower)^4`` times larger: a softer
        spring makes the swing ``(1 + slower)^2`` times larger, and readings of second order, such
        as the height of a swing, the square of it.

        Parameters
        ----------
        time : (nt,) array
            Instants, s.
        rate : (nt,) array
            Rate of the reading along the free motions.
        """
        steps = 0.5 * (rate[1:] + rate[:-1]) * np.diff(time)
        part = np.concatenate([[0.0], np.cumsum(steps)])
        most = float(np.ptp(part)) * (1.0 + self.slower) ** 4
        return min(most, UNEVEN * self.slower * float(np.abs(steps).sum()))


def free_swings(
    model: Model, run: Solution, instants: Ints, strain: float, how: dict[str, Any]
) -> Swings | None:
    """Return the free motions along a run of the machine with rigid bodies; None if it has none.

    Parameters
    ----------
    model : Model
        Model of the run.
    run : Solution
    instants : (nt,) int array
        Indices of stored instants.
    strain : float
        Largest strain energy of the changing part of the loads, J.
    how : dict
        Arguments of `simulate` of the run.
    """
    engine = Engine(replace(model, tree=()))
    kinetic, rates = 0.0, []
    for state in run.each_state(instants):
        put(engine, replace(state, work=None), run.where)
        engine.lam[:] = 0.0
        a, N = np.array(engine.accelerations()[0]), rigid_motions(engine)
        if not N.shape[1]:
            return None
        M = engine.newton_matrix(1.0, 0.0, 0.0)[: model.nv, : model.nv]
        project = N @ np.linalg.solve(N.T @ M @ N, N.T @ M)
        v, a = project @ state.v, project @ a
        kinetic = max(kinetic, 0.5 * float(v @ M @ v))
        here = np.array(engine.sensors())
        q = displaced(model, state.q, AHEAD * v)
        put(engine, replace(state, q=q, v=state.v + AHEAD * a, work=None, joint=None), run.where)
        engine.accelerations()
        rates.append((np.array(engine.sensors()) - here) / AHEAD)
    table = np.array(rates)
    by_name = {s.name: table[:, s.offset : s.offset + s.count] for s in model.sensors}
    return Swings(period_change(strain, kinetic), deviation_growth(model, run, how), by_name)


def rigid_motions(engine: Engine) -> Array:
    """Return the increments (nv, f) that joints and drives permit without bending any body."""
    N = admissible_motions(engine)
    modal = modal_velocities(engine.model)
    bending = N[modal]
    _, s, Vt = np.linalg.svd(bending)
    rank = int((s > INDEPENDENT * s.max(initial=0.0)).sum())
    return np.asarray(N @ Vt[rank:].T)


def period_change(strain: float, kinetic: float) -> float:
    """Return how much longer the period of free motions is with elastic bodies, as a share.

    Rayleigh's quotient with the static deformation: the strain energy V of the changing part of
    the loads is added to the kinetic energy T of the free motion, ``sqrt(1 + V / T) - 1``. For a
    spring k_s in series with a part k_p it is exact, ``V / T = k_s / k_p``: the period with the
    rigid part is shorter by ``1 - 1 / sqrt(1 + k_s / k_p)``.

    Parameters
    ----------
    strain, kinetic : float
        Largest values over the run, J.
    """
    if kinetic <= ALMOST_STILL * strain or kinetic == 0.0:
        return 0.0
    return float(np.sqrt(1.0 + strain / kinetic) - 1.0)


def deviation_growth(model: Model, run: Solution, how: dict[str, Any]) -> float:
    """Return the factor by which a deviation of a run grows beyond a regular motion.

    The run is repeated from a start that is displaced by `MOVED` along a free motion. In a regular
    motion the deviation grows with its phase, up to `REGULAR`; in an irregular one exponentially.

    Parameters
    ----------
    model : Model
        Model of the run.
    run : Solution
    how : dict
        Arguments of `simulate` of the run.
    """
    first = next(run.each_state([0]))
    engine, metres = Engine(replace(model, tree=())), velocity_metres(model)
    put(engine, replace(first, work=None), run.where)
    N = metres[:, None] * rigid_motions(engine)
    along = N @ np.ones(N.shape[1]) / np.sqrt(N.shape[1])
    q = displaced(model, first.q, MOVED * model.size * along / metres)
    try:
        other = simulate(model, **how | {"state": replace(first, q=q, joint=None, work=None)})
    except JoustoError:
        return float("inf")
    count = min(run.nt, other.nt)
    places = np.concatenate([b.iq + np.arange(3) for b in model.bodies])
    away = np.abs(other.q[:count] - run.q[:count])[:, places].max(initial=0.0)
    return float(max(1.0, away / (MOVED * model.size) / REGULAR))
