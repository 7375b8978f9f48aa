"""Positions of the nodes of a body during a run."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, suggest
from jousto.model.beam_record import BeamShape
from jousto.simulation.results.records import BodyShape
from jousto.simulation.results.solution import Solution


def rotation_matrices(e: ArrayLike) -> Array:
    """Return rotation matrices A (..., 3, 3), local to world, of Euler parameters e (..., 4).

    ``A = 2 [e0^2 - 1/2 + e1^2 ...]`` (Rantalainen 2007, eq. 3.5); e, scalar first, is normalised.

    Examples
    --------
    >>> rotation_matrices([0.5**0.5, 0, 0, 0.5**0.5]).round(12) @ [1, 0, 0]  # 90 deg about z
    array([0., 1., 0.])
    """
    e = np.asarray(e, dtype=np.float64)
    e0, e1, e2, e3 = np.moveaxis(e / np.linalg.norm(e, axis=-1, keepdims=True), -1, 0)
    A = np.empty((*e0.shape, 3, 3))
    A[..., 0, 0] = 1.0 - 2.0 * (e2 * e2 + e3 * e3)
    A[..., 0, 1] = 2.0 * (e1 * e2 - e0 * e3)
    A[..., 0, 2] = 2.0 * (e1 * e3 + e0 * e2)
    A[..., 1, 0] = 2.0 * (e1 * e2 + e0 * e3)
    A[..., 1, 1] = 1.0 - 2.0 * (e1 * e1 + e3 * e3)
    A[..., 1, 2] = 2.0 * (e2 * e3 - e0 * e1)
    A[..., 2, 0] = 2.0 * (e1 * e3 - e0 * e2)
    A[..., 2, 1] = 2.0 * (e2 * e3 + e0 * e1)
    A[..., 2, 2] = 1.0 - 2.0 * (e1 * e1 + e2 * e2)
    return A


def find_body(run: Solution, name: str) -> BodyShape:
    """Return the body of a name; for a beam a body with its nodes as a line.

    Raises
    ------
    InputError
        If there is no such body; the message contains the nearest name.
    """
    beams = {beam.name: beam for beam in run.beams}
    if name in beams:
        return _line(beams[name])
    found = run.body(name)
    if found is None:
        names = [body.name for body in run.bodies]
        known = [*(x for x in names if x.rpartition(".node")[0] not in beams), *beams]
        raise InputError(Problem(run.where, f"no body '{name}'{suggest(name, known)}"))
    return found


def _line(beam: BeamShape) -> BodyShape:
    pairs = np.stack([np.arange(beam.n), np.arange(beam.n) + 1], axis=1)
    still = np.zeros((beam.n + 1, 3, 0))
    return BodyShape(beam.name, "beam", -1, -1, 0, beam.nodes, pairs, still)


def positions(
    run: Solution, body: str | BodyShape, times: ArrayLike | None = None, *, scale: float = 1.0
) -> Array:
    """Return the world positions of the nodes of a body, (nt, nn, 3) in m.

    ``r = R + A(e) (u0 + Phi p)`` (Rantalainen 2007, section 3.2)

    Parameters
    ----------
    run : Solution
        Results of the run.
    body : str or BodyShape
        Name of the body, or one of ``run.bodies``.
    times : (nt,) array_like, optional
        Instants within the run, s; positions between stored instants are interpolated linearly.
        None takes all stored instants.
    scale : float
        Factor on the deformation ``Phi p``, for pictures; no effect on beams.

    Raises
    ------
    InputError
        If there is no such body, or a time is outside the run.
    """
    shape = find_body(run, body) if isinstance(body, str) else body
    if shape.kind == "beam":
        r = run.beam_states(shape.name)[0][..., :3]
        if times is None:
            return r
        before, after, share = bracket(run, times)
        share = share[:, None, None]
        return np.asarray((1.0 - share) * r[before] + share * r[after])
    q = run.q[:, shape.q_offset : shape.q_offset + 7 + shape.n]
    if times is None:
        return _place(shape, q, scale)
    before, after, share = bracket(run, times)
    return (1.0 - share[:, None, None]) * _place(shape, q[before], scale) + share[
        :, None, None
    ] * _place(shape, q[after], scale)


def _place(shape: BodyShape, q: Array, scale: float) -> Array:
    R, e, p = q[:, :3], q[:, 3:7], q[:, 7:]
    bent = p @ shape.modes.reshape(3 * len(shape.nodes), shape.n).T
    u = shape.nodes + scale * bent.reshape(len(q), -1, 3)
    return np.asarray(R[:, None, :] + np.einsum("tab,tkb->tka", rotation_matrices(e), u))


def bracket(
    run: Solution, times: ArrayLike
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]]:
    """Return the indices of the stored instants around each time, and the weight of the later one.

    Raises
    ------
    InputError
        If a time is outside the run or not a number.
    """
    t = run.time
    wanted = np.atleast_1d(np.asarray(times, dtype=np.float64))
    slack = 1e-9 * max(float(t[-1] - t[0]), 1e-300)
    bad = wanted[~((wanted >= t[0] - slack) & (wanted <= t[-1] + slack))]
    if len(bad):
        raise InputError(
            Problem("times", f"{bad[0]:g} s is outside the run of {t[0]:g} to {t[-1]:g} s")
        )
    if len(t) == 1:
        none = np.zeros(len(wanted), dtype=np.intp)
        return none, none, np.zeros(len(wanted))
    after = np.clip(np.searchsorted(t, wanted), 1, len(t) - 1)
    before = after - 1
    share = np.clip((wanted - t[before]) / (t[after] - t[before]), 0.0, 1.0)
    return before, after, share
