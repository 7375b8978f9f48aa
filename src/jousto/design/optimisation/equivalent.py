"""Equivalent static loads of a run, for static analyses with other programs."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.design.optimisation.machine import shapes_of
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.parts.part import Part
from jousto.recovery.shape import bracket, find_body
from jousto.simulation.results.solution import Solution


@explained
def equivalent_loads(
    run: Solution,
    body: FlexibleBody,
    times: ArrayLike | None = None,
    *,
    part: Part | None = None,
) -> Array:
    """Return the nodal loads that cause the deformation of a run in a body at rest.

    ``f(t) = K Phi p(t)`` with the stiffness K of the part, its modes Phi and the modal coordinates
    p of the run (W. S. Choi, G. J. Park, *Comput. Methods Appl. Mech. Eng.* 191 (2002) 2077-2094).
    The loads include reactions, inertia and damping as far as the modes represent these. On a free
    body they are in balance: with any six degrees of freedom supported statically, the reactions
    vanish, and the body has the deformation and stress of the run apart from a rigid motion.

    Parameters
    ----------
    run : Solution
        Results that contain the body.
    body : FlexibleBody
        The body.
    times : (nt,) array_like, optional
        Instants, s; values are interpolated between stored instants. None: all stored instants.
    part : Part, optional
        Part from which the body was reduced; None: the data stored by the reduction.

    Returns
    -------
    (nt, nodes, d) array
        Forces (d = 3) or forces and moments (d = 6) on the nodes of the part, N and N m, axes of
        the part.

    Raises
    ------
    InputError
        If the run has no such body or one with other modes, a time lies outside of the run, or the
        part is unknown or another one.

    Examples
    --------
    >>> import numpy as np
    >>> import jousto as jo
    >>> steel = jo.Material(E=210e9, nu=0.3, rho=7850)
    >>> part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.03), 4, steel)
    >>> bar = jo.FlexibleBody("bar", jo.reduce(part, jo.CraigBampton(["start", "end"], modes=2)))
    >>> wall = jo.Fixed("wall", jo.ground["origin"], bar["start"])
    >>> pull = jo.Force("pull", bar["end"], (0, 0, -100))
    >>> model = jo.compile(jo.Mechanism(bar, wall, pull))
    >>> run = jo.simulate(model, 1e-3, state=jo.equilibrium(model))
    >>> f = equivalent_loads(run, bar, 0.0)[0]
    >>> (f[[0, 4], 2].round(3) + 0.0).tolist()  # the wall's reaction and the pull, N
    [100.0, -100.0]
    """
    given: object = body
    if not isinstance(given, FlexibleBody):
        message = f"body is {given!r}, must be a FlexibleBody"
        raise InputError(Problem("equivalent_loads", message))
    where = f"body '{body.name}'"
    n, shape = body.n, find_body(run, body.name)
    part = body.reduced.source if part is None else part
    problems = Problems()
    if shape.n != n:
        problems.add(where, f"has {n} modes, that of the run {shape.n}: give the body of the run")
    if part is None:
        problems.add(
            where,
            "does not contain its part (it was read from a file or is very large): give part=...",
        )
    elif not np.array_equal(part.nodes, body.reduced.nodes[: len(part.nodes)]):
        problems.add(where, f"was not reduced from part '{part.name}': its nodes are different")
    problems.raise_if_any()
    assert part is not None
    p = run.coordinates(body.name)[:, 7:]
    if times is not None:
        before, after, share = bracket(run, times)
        p = (1.0 - share[:, None]) * p[before] + share[:, None] * p[after]
    f = part.K @ (shapes_of(body, part) @ p.T)
    return np.asarray(f.T).reshape(len(p), len(part.nodes), part.dofs_per_node)
