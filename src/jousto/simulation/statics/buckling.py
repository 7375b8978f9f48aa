"""buckling: loads at which the equilibrium of a mechanism turns unstable, and the modes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.linalg as sl
import scipy.sparse.linalg as spl
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import Problems, warn
from jousto.model.model import Model
from jousto.model.native.header import named
from jousto.model.native.native import IMAGINARY, displaced
from jousto.simulation.modes.linear import local, pictures
from jousto.simulation.modes.spectrum import DENSE
from jousto.simulation.state import State
from jousto.simulation.statics.balance import Balance
from jousto.simulation.statics.beam_strains import beam_strains
from jousto.simulation.statics.continuation import Point, factor
from jousto.simulation.statics.load_paths import LoadPath, PathFailed
from jousto.simulation.statics.paths import load_path
from jousto.simulation.statics.walk import Walk

# imaginary part over size of a load, below which a pair is two equal real loads: follower loads on
# unequal elements split equal loads by their own errors (rings: up to 3e-3), and by round-off
NEARLY = 1e-2
REACH = 1.5  # the path goes on to so many times the highest load of the linear theory
FAR = 1e9  # of the lowest load: infinite


@dataclass(frozen=True, eq=False)
class Buckling:
    """Critical values of a parameter: the lowest first, or in the order of the path.

    Attributes
    ----------
    parameter : str
    loads : (k,) array
    increments : (nv, k) array
        Modes: increments [dR (world), dtheta (body frame), dp] of every body.
    shapes : dict
        Body name to nodal displacements (k, nodes, 3), world; largest of a mode is 1.
    kinds : tuple of str
        "linear", or "limit" and "bifurcation" on the path.
    path : LoadPath or None
        The path, if it was followed.
    left_out : (m,) complex array
        Complex values among the loads of the linear theory, with positive imaginary part: there
        two modes join and may flutter under loads that follow, but stiffness does not vanish.
    """

    parameter: str
    loads: Array
    increments: Array
    shapes: dict[str, Array]
    kinds: tuple[str, ...]
    path: LoadPath | None = None
    left_out: NDArray[np.complex128] = field(default_factory=lambda: np.zeros(0, dtype=complex))

    def __repr__(self) -> str:
        found = ", ".join(f"{x:.6g}" for x in self.loads)
        return f"<Buckling: {found or 'none'} over {self.parameter!r}>"


@explained
def buckling(
    model: Model,
    parameter: str,
    count: int = 3,
    *,
    method: str = "linear",
    start: float | None = None,
    to: float | None = None,
    steps: int = 20,
    state: State | None = None,
    axis: ArrayLike | None = None,
    point: ArrayLike = (0.0, 0.0, 0.0),
) -> Buckling:
    """Find the loads beyond a start at which the equilibrium turns unstable.

    ``method="linear"``: with the tangent matrix A0 of the equilibrium at `start` and its rate A'
    there, ``(A0 + (s - start) A') x = 0``: right where displacements stay small up to the critical
    load. A' is exact, but of exact beams it is that of the linear stress alone, their shape held,
    as in classical theory: the terms of first order in bending are nothing without their second.
    ``method="path"``: the path is followed and the points where the tangent stiffness is singular
    are found on it, exactly, limit points too.

    Under loads that follow, A' is not symmetric and s may be complex. A pair whose imaginary part
    is below a hundredth of its size counts as two loads of its real part: equal loads, as those of
    a ring, are split so by the errors of the elements, and with a stiffness that small beside its
    fellows' nothing is safe. Other pairs are `left_out`, with a warning.

    Parameters
    ----------
    model : Model
        From `compile`.
    parameter : str
        Name of an `Input` that scales loads, "gravity" or "time", as for `load_path`.
    count : int
        Most loads.
    method : str
        "linear" or "path".
    start : float, optional
        Prestress; None is the input's present value, 0 for gravity.
    to : float, optional
        End of the path; None is half beyond the loads of the linear theory.
    steps : int
        Of the path.
    state : State, optional
        Near the first equilibrium.
    axis, point
        As for `load_path`.

    Raises
    ------
    InputError
        If the parameter does not exist or the values make no sense.
    PathFailed
        If there is no equilibrium to begin with.
    """
    problems = Problems()
    where = "buckling"
    problems.number(where, "count", count, "", "1 or more", lambda x: x >= 1)
    problems.number(where, "steps", steps, "", "1 or more", lambda x: x >= 1)
    if method not in ("linear", "path"):
        problems.add(where, f"method is {method!r}, must be 'linear' or 'path'")
    if to is not None:
        problems.number(where, "to", to, "")
    problems.raise_if_any()
    given = to is not None
    if method == "linear" or to is None:
        balance = Balance(model, parameter, state, axis=axis, point=point, where=where)
        linear = _linear(balance, balance.value if start is None else float(start), count)
        if method == "linear":
            return linear
        if not len(linear.loads):
            problems.add(where, "the linear theory finds no critical load; say how far: to=...")
            problems.raise_if_any()
        first = balance.value if start is None else float(start)
        to = first + REACH * float(linear.loads[-1] - first)
    reach = to
    for _ in range(1 if given else 3):
        try:
            path = load_path(
                model, parameter, to=reach, start=start, steps=steps, method="arc", state=state,
                axis=axis, point=point, enough=count,
            )  # fmt: skip
        except PathFailed as error:
            path = error.path
            if not path.critical:
                raise
        if len(path.critical) >= count:
            break
        reach += 2.0 * (reach - float(path.load[0]))
    found = path.critical[:count]
    increments = np.array([p.increments for p in found]).reshape(len(found), model.nv).T
    shapes = {
        name: np.array([p.shape[name] for p in found]) for name in (found[0].shape if found else ())
    }
    loads = np.array([p.load for p in found])
    return Buckling(parameter, loads, increments, shapes, tuple(p.kind for p in found), path)


def _linear(balance: Balance, start: float, count: int) -> Buckling:
    at = Walk(balance, start, start + 1.0).begin()
    lu = factor(balance, at)
    step = -lu.solve(balance.push(at.q, at.lam, at.value))
    slope = _rate(balance, at, step)
    n, nv = balance.size, balance.model.nv
    if n <= DENSE:
        values, vectors = sl.eig(-lu.solve(slope.toarray()))
    else:
        inverse = spl.LinearOperator((n, n), matvec=lambda x: -lu.solve(slope @ x), dtype=float)
        seed = np.random.default_rng(7).standard_normal(n)
        wanted = min(4 * count + 8, n - 2)
        values, vectors = spl.eigs(inverse, k=wanted, which="LM", v0=inverse @ seed)
    loads, shapes, left_out = _sorted(values, vectors[:nv], count)
    if len(left_out):
        A = balance.matrix(at.q, at.lam, at.value)
        left_out = left_out[[_known(A, slope, s) for s in left_out]]
    drawn = pictures(balance.model, at.q, local(balance.model, at.q, shapes))
    if len(left_out):
        pairs = ", ".join(f"{start + x.real:.4g} +- {x.imag:.3g}i" for x in left_out[:3])
        warn(
            "buckling",
            f"left out of the loads of {balance.parameter!r}: {pairs}"
            f"{' and more' if len(left_out) > 3 else ''}, complex as loads that follow make them. "
            "The equilibrium may flutter there instead of buckling; look at modes(..., "
            "damped=True) of states along load_path for a positive real part",
        )
    return Buckling(
        balance.parameter,
        start + loads,
        shapes,
        {name: np.real(x) for name, x in drawn.items()},
        ("linear",) * len(loads),
        left_out=start + left_out,
    )


def _sorted(values: Any, vectors: Any, count: int) -> tuple[Array, Array, NDArray[np.complex128]]:
    """Return real loads, their shapes, and the complex loads left out, of eigenvalues 1/load.

    A nearly real pair is two loads; its shapes are an orthonormal basis of the plane of the
    eigenvectors' real and imaginary parts.
    """
    finite = np.abs(values) > np.abs(values).max(initial=0.0) / FAR
    loads = np.where(finite, 1.0 / np.where(finite, values, 1.0), np.inf)
    ahead = finite & (loads.real > 0.0)
    nearly = ahead & (np.abs(loads.imag) <= NEARLY * np.abs(loads))
    chosen = np.flatnonzero(nearly)
    chosen = chosen[np.lexsort((loads[chosen].imag, loads[chosen].real))][:count]
    shapes = np.zeros((len(vectors), len(chosen)))
    for k, i in enumerate(chosen):
        x = vectors[:, i]
        plane = sl.qr(np.column_stack([x.real, x.imag]), mode="economic")[0]
        shapes[:, k] = x.real if loads[i].imag == 0.0 else plane[:, int(loads[i].imag > 0.0)]
    others = loads[ahead & ~nearly & (loads.imag > 0.0)]
    others = others[np.argsort(np.abs(others))][:count]
    if len(chosen) == count:
        others = others[np.abs(others) < loads[chosen[-1]].real]
    return loads[chosen].real, shapes, others


def _known(A: Any, slope: Any, s: complex) -> bool:
    """Return whether round-off leaves ``(A + s A') x = 0`` its s to NEARLY.

    By the condition ``|y| (|A| + |s A'|) |x| / |s y A' x|`` of s, which units leave (Higham and
    Higham, SIAM J. Matrix Anal. Appl. 20 (1998) 493-512). Where the determinant does not depend
    on s, solvers return infinite loads as huge ones.
    """
    near: Any = spl.splu((A + s * (1.0 + 1e-9) * slope).tocsc().astype(complex))
    seed = np.random.default_rng(7).standard_normal(A.shape[0]).astype(complex)
    x, y = near.solve(near.solve(seed)), near.solve(near.solve(seed, "H"), "H")
    size = abs(y) @ ((abs(A) + abs(s) * abs(slope)) @ abs(x))
    return bool(np.finfo(float).eps * size < NEARLY * abs(s * (y.conj() @ (slope @ x))))


def _rate(balance: Balance, at: Point, step: Array) -> Any:
    """Return the rate of the tangent matrix along the linear solution.

    Beams keep their shape and carry the linear stress, ``e0 -> e0 - s e'``: their stiffness of
    initial displacements, EA times a rotation, would need its partner of second order.
    """
    model = balance.model
    if not model.beams:
        return balance.slope(at.q, at.lam, at.value, step)
    nv, h = model.nv, 1j * IMAGINARY
    rates = beam_strains(model, displaced(model, at.q, h * step[:nv])).imag
    data = {}
    for i, beam in enumerate(model.beams):
        data[i] = beam.data.astype(complex)
        named("jo_beam_data", data[i]).e0[...] -= 1j * rates[i]
    still, alone = step.copy(), step.copy()
    still[:nv] = 0.0
    alone[nv:] = 0.0
    held = balance.variant(data=data).slope(at.q, at.lam, at.value, still)
    return held + balance.variant(beams=False).slope(at.q, at.lam, at.value, alone, 0.0)
