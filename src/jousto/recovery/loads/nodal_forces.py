"""Nodal forces on the finite element model of a part, in balance, from all loads on its body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as sl

from jousto.base.arrays import Array, Ints
from jousto.base.errors import Problems, warn
from jousto.parts.part import Part
from jousto.recovery.loads.body_loads import BodyLoad, BodyLoads, group_norms
from jousto.recovery.loads.own_loads import DAMPING, OWN

NEAR = 1e-6
"""Distance of a load from a node or interface / size of the part, below which it acts there."""
LEVER = 1e-9
"""Moment / (largest load of the run at the size of the part) below which it is rounding."""
WARNED, REFUSED = 0.01, 0.1
"""Part of the loads that the inertia of the part does not balance: warning and error."""


@dataclass(frozen=True, eq=False)
class NodalForces:
    """Forces on the nodes of a part whose sum and moment vanish at each instant.

    Attributes
    ----------
    part : Part
    time : (nt,) array
        Instants, s.
    forces : (nt, nn, 3) array
        Forces on the nodes, part frame, N.
    relief : (nt,) array
        Resultant that a rigid acceleration of the part balances (inertia relief), relative to all
        loads; it is not zero since loads act on the deformed body, while statics refer to the
        undeformed one.
    held : (6,) int array
        Degrees of freedom (3 node + direction) whose supports are statically determinate and
        without reactions.
    """

    part: Part
    time: Array
    forces: Array
    relief: Array
    held: Ints


def nodal_forces(loads: BodyLoads, part: Part, times: list[float] | None = None) -> NodalForces:
    """Return the loads on a body as forces on the nodes of its part.

    Loads at interfaces become nodal forces through the interface: the transpose of its average.
    Inertia, Coriolis and centrifugal forces and the weight are ``-M z''`` with the mass matrix of
    the part and the acceleration of each node minus gravity, ``z'' = R'' - g + w' x u + w x (w x u)
    + 2 w x u' + Phi p''``, ``u = x + Phi p``. Modal damping is the distributed force ``M [R Phi]
    c`` with the modal forces ``-D p'`` and without resultant.

    Parameters
    ----------
    loads : BodyLoads
    part : Part
        Part of solids from which the body was reduced; for a rigid body, a part in its frame.
    times : list of float, optional
        Stored instants, s; by default all.

    Raises
    ------
    InputError
        With all problems: beams, another part, instants that are not stored, loads at no node or
        interface, moments on nodes of solids, a part whose inertia does not balance the loads.

    Warns
    -----
    JoustoWarning
        If more than a hundredth of the loads is not balanced.
    """
    where, problems, here = f"loads on '{loads.body}'", Problems(), loads.resolved("body")
    rows = _instants(problems, where, here, times)
    check_part(problems, where, here, part)
    problems.raise_if_any()
    nn, n = len(part.nodes), here.motion.p.shape[1]
    f = np.zeros((len(rows), 3 * nn))
    size = float(np.ptp(part.nodes, axis=0).max())
    top = max((np.abs(load.force).max(initial=0.0) for load in here.loads), default=0.0)
    for name, load in here.items():
        if load.kind not in OWN:
            _place(problems, where, f, part, (name, load), rows, (NEAR * size, LEVER * top * size))
    problems.raise_if_any()
    # inertia and weight: -M z''
    R, x = part.rigid_modes(), part.nodes
    Phi = here.modes[:nn].reshape(3 * nn, n)
    motion = here.motion.mapped(lambda values: values[rows])
    for k in range(len(rows)):
        w, dw = motion.w[k], motion.dw[k]
        u = x + (Phi @ motion.p[k]).reshape(nn, 3)
        du = (Phi @ motion.dp[k]).reshape(nn, 3)
        z = motion.acceleration[k] - motion.gravity[k] + np.cross(dw, u)
        z = z + np.cross(w, np.cross(w, u)) + 2.0 * np.cross(w, du)
        z = z + (Phi @ motion.ddp[k]).reshape(nn, 3)
        f[k] -= part.M @ z.ravel()
    # damping: distributed like inertia, with the given generalised forces
    for load in (one for one in here.loads if one.kind == DAMPING):
        shapes = np.hstack([R, Phi])
        MS = np.asarray(part.M @ shapes)
        Q = np.hstack([load.wrench, load.modal])[rows]
        f += np.linalg.solve(shapes.T @ MS, Q.T).T @ MS.T
    # inertia relief of the remaining forces: -M R c
    MR = np.asarray(part.M @ R)
    rest = f @ R
    f -= np.linalg.solve(R.T @ MR, rest.T).T @ MR.T
    relief = _unbalanced(here, rest, rows)
    _judge(where, part, relief)
    held = determinate_supports(part)
    return NodalForces(part, here.time[rows], f.reshape(len(rows), nn, 3), relief, held)


def _instants(
    problems: Problems, where: str, loads: BodyLoads, times: list[float] | None
) -> list[int]:
    """Return the indices of stored instants."""
    if times is None:
        return list(range(len(loads.time)))
    if not len(times):
        problems.add(where, "times is empty: name at least one instant, or leave it out for all")
    span = max(float(np.ptp(loads.time)), 1e-300)
    rows = []
    for t in np.atleast_1d(np.asarray(times, dtype=np.float64)):
        k = int(np.argmin(np.abs(loads.time - t)))
        if not abs(loads.time[k] - t) <= 1e-9 * span:
            problems.add(where, f"have no instant at {t:g} s; the nearest is {loads.time[k]:.9g} s")
        rows.append(k)
    return rows


def check_part(problems: Problems, where: str, loads: BodyLoads, part: Part) -> None:
    """Report a part of beams, or a part that is not that of the body."""
    nn = len(part.nodes)
    if part.dofs_per_node != 3 or part.solids is None:
        problems.add(
            where,
            f"part '{part.name}' does not consist of solids; for beams jo.design.equivalent_loads "
            "has loads for other programs",
        )
    elif loads.modes.shape[2] and (
        len(loads.nodes) < nn or not np.array_equal(loads.nodes[:nn], part.nodes)
    ):
        problems.add(where, f"the body was not reduced from part '{part.name}': other nodes")


def _place(
    problems: Problems,
    where: str,
    f: Array,
    part: Part,
    named: tuple[str, BodyLoad],
    rows: list[int],
    small: tuple[float, float],
) -> None:
    """Add a load to the nodal forces (nt, 3 nn) at the interface or node where it acts."""
    name, load = named
    force, moment = load.force[rows], load.moment[rows]
    if load.position is None:
        place = load.place or "the whole body"
        problems.add(where, f"{load.kind} {name!r} acts on {place}, not at one node or interface")
        return
    for tie in part.ties:
        if np.linalg.norm(tie.at - load.position) <= small[0]:
            f[:, tie.dofs] += np.hstack([force, moment]) @ tie.averaging
            return
    distance = np.linalg.norm(part.nodes - load.position, axis=1)
    k = int(np.argmin(distance))
    if distance[k] > small[0]:
        problems.add(
            where,
            f"{load.kind} {name!r} acts at {load.place}, {distance[k]:.3g} m from the nearest node "
            f"of part '{part.name}'; give the part an interface there",
        )
    elif np.abs(moment).max(initial=0.0) > small[1]:
        problems.add(
            where,
            f"{load.kind} {name!r} has a moment at {load.place}, but nodes of solids do not turn; "
            "give the part an interface there",
        )
    else:
        f[:, 3 * k : 3 * k + 3] += force


def _unbalanced(loads: BodyLoads, rest: Array, rows: list[int]) -> Array:
    """Return the resultant (nt, 6) about the origin relative to the sizes of all loads."""
    norms = sum(
        group_norms(np.hstack([load.force, load.moment, load.modal]))[rows] for load in loads.loads
    )
    size = np.asarray(norms).max(axis=0, initial=0.0)
    moment = rest[:, 3:] - np.cross(loads.center[rows], rest[:, :3])
    scale = np.array([size[0], size[1] + loads.arm * size[0]])
    both = np.stack([np.linalg.norm(x, axis=1) for x in (rest[:, :3], moment)], axis=1)
    return np.asarray((both / np.where(scale > 0.0, scale, 1.0)).max(axis=1))


def _judge(where: str, part: Part, relief: Array) -> None:
    """Warn about a part that does not balance the loads by its inertia, or refuse it."""
    worst = float(relief.max(initial=0.0))
    if worst <= WARNED:
        return
    message = (
        f"are not in balance with the inertia of part '{part.name}' ({part.mass:.6g} kg): "
        f"{worst:.1%} is left, taken up by inertia relief; its mass or centre is not that of the "
        "body, or the body bends so much that statics of its undeformed shape do not hold"
    )
    if worst > REFUSED:
        problems = Problems()
        problems.add(where, message)
        problems.raise_if_any()
    warn(where, message)


def determinate_supports(part: Part) -> Ints:
    """Return six degrees of freedom that support a part without constraint.

    They are selected for the most independent rigid motions, on nodes outside of rigid interfaces,
    since other programs tie the nodes of these.
    """
    tied = [tie.dofs for tie in part.ties if tie.kind == "rigid"]
    free = np.setdiff1d(np.arange(3 * len(part.nodes)), np.concatenate([[], *tied]).astype(int))
    centred = part.nodes - part.nodes.mean(axis=0)
    R = np.zeros((len(centred), 3, 6))
    R[:, :, :3] = np.eye(3)
    size = np.abs(centred).max()
    for axis in range(3):
        R[:, :, 3 + axis] = np.cross(np.eye(3)[axis], centred) / size
    _, _, order = sl.qr(R.reshape(-1, 6)[free].T, mode="economic", pivoting=True)
    return np.sort(free[order[:6]])
