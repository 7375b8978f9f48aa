"""Share of the velocity-dependent inertia in the tangent (figure 6 of the source)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jousto.base.errors import Problems
from jousto.planar.results import PlanarRun


def inertia_share(run: PlanarRun, steps: NDArray[np.int_] | list[int]) -> NDArray[np.float64]:
    """Return ``||K_acc|| / ||K||`` at steps of a run, with the static tangent K of eq. 6.

    Norms are the largest singular values, over the unsupported unknowns.

    Parameters
    ----------
    run : PlanarRun
    steps : sequence of int
        Numbers of the steps; 0 is the start.

    Returns
    -------
    (n,) array

    Raises
    ------
    InputError
        If there is no such step.
    """
    problems = Problems()
    for k in steps:
        if not -len(run.time) <= k < len(run.time):
            problems.add("inertia_share", f"no step {k}; the run has {run.steps}")
    problems.raise_if_any()
    system = run.frame.system
    grid = np.ix_(system.free, system.free)
    shares = []
    for k in steps:
        loads = system.at_time(float(run.time[k]))
        p = system.evaluate(run.q[k], run.v[k], run.a[k], loads)
        K = system.stiffness(p, loads)[grid]
        Kacc, _ = system.elimination.inertia_tangents(p.q, p.v, p.a, system.M)
        shares.append(float(np.linalg.norm(Kacc[grid], 2) / np.linalg.norm(K, 2)))
    return np.array(shares)
