"""Motion of a single part from a run: prescribed frame motion and nodal loads."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.measurement.twin.motion.balance import check_balance
from jousto.measurement.twin.motion.nodal_loads import given_at_nodes, loads_at_nodes
from jousto.measurement.twin.motion.reference import InertialForce, Motion, Reference
from jousto.recovery.loads.body_loads import BodyLoads
from jousto.recovery.shape import find_body, rotation_matrices
from jousto.reduction.damping import Damping, modal_damping
from jousto.reduction.reduced import ReducedPart
from jousto.simulation.results.solution import Solution

MOST, CLOSE = 60, 1e-12
"""Maximum iterations of a step, and the relative change of coordinates at convergence."""


@explained
def drive_part(
    run: Solution,
    body: str,
    reduced: ReducedPart,
    loads: BodyLoads | Mapping[str, ArrayLike],
    *,
    damping: Damping = 0.0,
    start: tuple[ArrayLike, ArrayLike] | None = None,
) -> Array:
    """Return the modal coordinates (nt, n) of a part moved as a body of a run, kg^0.5 m.

    ``M_pp p'' + D p' + K p = Q_e,p + Q_v,p - C_p^T lam - M_pr r''`` with the reference motion r of
    the run (Altarriba 2010, eq. 42): the frame moves as in the run, and the reactions of the joints
    act at their nodes, ``Phi^T A^T F + Psi^T A^T T``. In the run the body may be rigid or have
    fewer modes, so that the stress of a detailed part needs no new run. The feedback of the
    deformation on the motion is not recomputed: it is that of the run. Newmark's method (average
    acceleration) over the stored instants, with accelerations of the frame from differences: errors
    decrease with the square of the output step, which must resolve the relevant vibrations.

    Parameters
    ----------
    run : Solution
        Results with the sensors that `loads` names.
    body : str
        Name of the rigid or flexible body whose frame moves the part; the frame of the part lies
        in it.
    reduced : ReducedPart
        The part.
    loads : BodyLoads or mapping of str to (nt, 3) or (nt, 6) array_like
        `loads_of(run, body)`, all loads in the run, each at the node of the part where it acts. Or
        a mapping from node names to the force, or force and moment about the node, on the part,
        world axes, N and N m: *all* loads on the part except its weight. A `ReactionSensor`
        measures the load on the body of its marker b; the load on the body of marker a is the
        opposite.
    damping : float, sequence of float or Rayleigh
        Damping of the modes.
    start : tuple of two (n,) array_like, optional
        Modal coordinates and velocities at the first instant; by default at rest under its loads.

    Raises
    ------
    InputError
        For unknown bodies or nodes, loads of another shape, loads that balance less than nine
        tenths of the motion (such as without a motor's moment), or a frame that turns so fast that
        the steps do not converge.

    Warns
    -----
    JoustoWarning
        If more than a hundredth is missing; force and moment are named.
    """
    where = "drive_part"
    shape, t, n = find_body(run, body), run.time, reduced.n
    reference = Reference.from_run(run, body)
    A = rotation_matrices(run.q[:, shape.q_offset + 3 : shape.q_offset + 7])
    problems = Problems()
    if isinstance(loads, BodyLoads):
        wrenches = loads_at_nodes(problems, where, reduced, loads, t)
    else:
        wrenches = given_at_nodes(problems, where, reduced, loads, A)
    f = np.zeros((len(t), n))
    for node, force, moment in wrenches:
        f += force @ reduced.modes[node]
        turn = reduced.rotation(node)
        if turn is not None:
            f += moment @ turn
    first = [problems.array(where, f"start[{i}]", x, (n,)) for i, x in enumerate(start or ())]
    if len(first) not in (0, 2):
        problems.add(where, f"start has {len(first)} arrays, must be coordinates and velocities")
    problems.raise_if_any()
    K, D = reduced.stiffness, modal_damping(damping, reduced.frequencies)
    inertial = InertialForce(reduced.invariants)
    p, v, a = (np.zeros((len(t), n)) for _ in range(3))
    if not first:
        _settle(p[0], lambda x: (f[0] + inertial(reference.at(t[0]), x, v[0])) / K, t[0])
    else:
        p[0], v[0] = first
        a[0] = f[0] + inertial(reference.at(t[0]), p[0], v[0]) - D * v[0] - K * p[0]
    for k in range(1, len(t)):
        h = t[k] - t[k - 1]
        motion = reference.at(t[k])
        before, speed = p[k - 1] + h * v[k - 1] + h * h / 4 * a[k - 1], v[k - 1] + h / 2 * a[k - 1]

        external, soft = f[k] - D * speed - K * before, 1.0 + h / 2 * D + h * h / 4 * K
        a[k] = a[k - 1]
        _settle(
            a[k], partial(_acceleration, h, inertial, motion, before, speed, external, soft), t[k]
        )
        p[k], v[k] = before + h * h / 4 * a[k], speed + h / 2 * a[k]
    check_balance(reduced, reference, wrenches, A, (p, v, a))
    return p


def _acceleration(
    h: float,
    inertial: InertialForce,
    motion: Motion,
    before: Array,
    speed: Array,
    external: Array,
    soft: Array,
    x: Array,
) -> Array:
    """Return p'' at the end of a step; the inertial force depends on p'' too."""
    force = inertial(motion, before + h * h / 4 * x, speed + h / 2 * x)
    return np.asarray((external + force) / soft)


def _settle(x: Array, better: Callable[[Array], Array], time: float) -> None:
    """Iterate ``x = better(x)`` in place until it converges."""
    for _ in range(MOST):
        found = better(x)
        change, size = float(np.abs(found - x).max()), float(np.abs(found).max(initial=0.0))
        x[:] = found
        if change <= CLOSE * size:
            return
    raise InputError(
        Problem(
            "drive_part",
            f"the step to {time:g} s does not converge: the frame turns too fast for the output "
            "step or for the softest mode; store more often, or give a stiffer part",
        )
    )
