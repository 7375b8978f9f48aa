"""buckling: critical loads of a mechanism and their modes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

import numpy as np
import scipy.linalg as sl
import scipy.sparse as sp
import scipy.sparse.linalg as spl
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import Problems, warn
from jousto.model.model import Model
from jousto.model.native.header import named
from jousto.model.native.native import IMAGINARY, displaced
from jousto.simulation.modes.linear import local, normalised_shapes
from jousto.simulation.modes.spectrum import DENSE
from jousto.simulation.second_order import with_second_order
from jousto.simulation.state import State
from jousto.simulation.statics.beam_strains import beam_strains
from jousto.simulation.statics.continuation import Point, factor
from jousto.simulation.statics.load_path import load_path
from jousto.simulation.statics.load_path_result import LoadPath, PathFailed
from jousto.simulation.statics.path_following import Walk
from jousto.simulation.statics.residual import Balance

# imaginary part over size of a load, below which a pair is two equal real loads: follower loads on
# unequal elements split equal loads by their own errors (rings: up to 3e-3), and by round-off
NEARLY = 1e-2
REACH = 1.5  # end of the path over the highest load of the linear theory
FAINT = 1e-15  # 1/load over the largest 1/load, below which it is round-off and the load infinite
# ratio of neighbouring loads, above which the lower ones belong to weakly supported motions
WIDE = 1e4
LOW = 1e-2  # upper bound of the loads of weakly supported motions over the shift of `_gap`
HELD = 1e-14  # round-off of the stiffness of rigid motions over the largest stiffness


@dataclass(frozen=True, eq=False)
class Buckling:
    """Critical values of a load parameter in ascending order, or in the order of the path.

    Attributes
    ----------
    parameter : str
    loads : (k,) array
    increments : (nv, k) array
        Modes: increments [dR (world), dtheta (body frame), dp] of every body.
    shapes : dict
        Nodal displacements (k, nodes, 3) of each body in the world frame, by its name; maximum of
        a mode 1.
    kinds : tuple of str
        "linear", or "limit" and "bifurcation" on the path.
    path : LoadPath or None
        Path of ``method="path"``.
    left_out : (m,) complex array
        Complex loads of the linear theory, with positive imaginary part. At these loads two modes
        coalesce and may flutter under follower loads; the stiffness is not singular.
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
    """Return the critical loads beyond a start, at which the equilibrium becomes unstable.

    ``method="linear"`` solves ``(A0 + (s - start) A') x = 0`` with the tangent matrix A0 of the
    equilibrium at `start` and its derivative A' by the load; it is accurate if displacements stay
    small up to the critical load. A' is exact, except for exact beams: there it contains the linear
    stress in the undeformed shape alone, as in classical theory, because first-order terms in
    bending are wrong without the second-order terms. ``method="path"`` follows the path and finds
    the points of singular tangent stiffness on it, limit points included.

    Under follower loads A' is not symmetric and s may be complex. A pair with an imaginary part
    below a hundredth of its modulus counts as two loads at its real part, because element errors
    split equal loads, such as those of a ring, into such pairs. Other pairs are `left_out`, with a
    warning. Modal bodies have geometric stiffness here, also if their parts were reduced without
    ``stiffening=True``.

    Parameters
    ----------
    model : Model
        From `compile`.
    parameter : str
        Name of an `Input` that scales loads, "gravity" or "time", as for `load_path`.
    count : int
        Maximum number of loads.
    method : str
        "linear" or "path".
    start : float, optional
        Value of the parameter at the prestressed equilibrium; None: the current value of the
        input, 0 for gravity.
    to : float, optional
        End of the path; None is 1.5 times the highest load of the linear theory.
    steps : int
        Number of steps of the path.
    state : State, optional
        Starting point for the first equilibrium.
    axis, point
        As for `load_path`.

    Raises
    ------
    InputError
        If the parameter does not exist, a value is invalid, or a modal body has no geometric
        stiffness because its part comes from matrices or from a file without stiffening.
    PathFailed
        If there is no equilibrium at `start`.
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
    model = with_second_order(model, where)
    given = to is not None
    if method == "linear" or to is None:
        balance = Balance(model, parameter, state, axis=axis, point=point, where=where)
        linear = _linear(balance, balance.value if start is None else float(start), count)
        if method == "linear":
            return linear
        if not len(linear.loads):
            problems.add(where, "the linear theory has no critical load; give the end, to=...")
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
    step = -factor(balance, at).solve(balance.push(at.q, at.lam, at.value))
    pencil = _Pencil(_regularised(balance, at), _rate(balance, at, step))
    nv = balance.model.nv
    found, vectors = pencil.near(0.0, count)
    gap = _gap(found)
    if gap:
        further, beyond = pencil.near(gap, count)
        soft, firm = np.abs(found) < LOW * gap, np.abs(further) >= LOW * gap
        found = np.concatenate([found[soft], further[firm]])
        vectors = np.hstack([vectors[:, soft], beyond[:, firm]])
    loads, shapes, left_out = _sorted(found, vectors[:nv], count, pencil.knows)
    drawn = normalised_shapes(balance.model, at.q, local(balance.model, at.q, shapes))
    if len(left_out):
        pairs = ", ".join(f"{start + x.real:.4g} +- {x.imag:.3g}i" for x in left_out[:3])
        warn(
            "buckling",
            f"complex loads are left out of the loads of {balance.parameter!r}: {pairs}"
            f"{' and more' if len(left_out) > 3 else ''}, which are complex because of follower "
            "loads. The equilibrium may flutter there instead of buckling; check modes(..., "
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


def _regularised(balance: Balance, at: Point) -> Any:
    """Return the tangent matrix with an added stiffness of the size of its round-off.

    The stiffness of rigid motions is the sum of the rows of K over all nodes, with the round-off
    ``eps max|K|``: bodies on softer springs would move under forces that are round-off. The added
    term is ``HELD max|K| / sum(D) D`` with the metric D of `Balance.metric`; with it the rigid
    motions stay smaller than the deformations.
    """
    nv = balance.model.nv
    A = balance.matrix(at.q, at.lam, at.value)
    metric = balance.metric(at.q, at.lam, at.value)
    added = np.zeros(A.shape[0])
    added[:nv] = HELD * float(abs(A[:nv, :nv]).max()) / metric.sum() * metric
    return (A + sp.diags(added)).tocsc()


class _Pencil:
    """Eigenproblem ``(A + s A') x = 0`` of the tangent matrix and its derivative by the load.

    Parameters
    ----------
    A, slope : sparse matrices (n, n)
    """

    def __init__(self, A: Any, slope: Any) -> None:
        self.A, self.slope = A, slope

    def near(self, about: float, count: int) -> tuple[Any, Any]:
        """Return the loads s (k,) nearest to a value and their x (n, k); inf for no load.

        For small systems all loads are returned.
        """
        n = self.A.shape[0]
        lu = spl.splu((self.A + about * self.slope).tocsc())
        if n <= DENSE:
            values, vectors = sl.eig(-lu.solve(self.slope.toarray()))
        else:
            inverse = spl.LinearOperator(
                (n, n), matvec=lambda x: -lu.solve(self.slope @ x), dtype=float
            )
            seed = np.random.default_rng(7).standard_normal(n)
            wanted = min(4 * count + 8, n - 2)
            values, vectors = spl.eigs(inverse, k=wanted, which="LM", v0=inverse @ seed)
        finite = np.abs(values) > FAINT * np.abs(values).max(initial=0.0)
        return np.where(finite, about + 1.0 / np.where(finite, values, 1.0), np.inf), vectors

    def knows(self, s: complex) -> bool:
        """Return whether s is an eigenvalue whose error by round-off is below `NEARLY`.

        Inverse iteration at s gives the load ``-y A x / y A' x`` and its condition number
        ``|y| (|A| + |s A'|) |x| / |s y A' x|``, which does not depend on units (Higham and Higham,
        SIAM J. Matrix Anal. Appl. 20 (1998) 493-512). It excludes two kinds of wrong values of
        eigensolvers: huge values in place of infinite loads, if the determinant does not depend on
        s, and tiny values of motions whose only stiffness is round-off.
        """
        A, slope = self.A, self.slope
        near: Any = _factor(lambda k: A + s * (1.0 + 1e-9 * k) * slope)
        if near is None:
            return False
        back = slope.conj().T.tocsc()
        x = y = np.random.default_rng(7).standard_normal(A.shape[0]).astype(complex)
        for _ in range(2):
            x, y = near.solve(slope @ x), near.solve(back @ y, "H")
            x, y = x / np.linalg.norm(x), y / np.linalg.norm(y)
        rate = y.conj() @ (slope @ x)
        size = abs(y) @ ((abs(A) + abs(s) * abs(slope)) @ abs(x))
        missed = abs(y.conj() @ (A @ x) + s * rate)
        return bool(np.finfo(float).eps * size + missed < NEARLY * abs(s * rate))


def _factor(matrix: Callable[[int], Any]) -> Any:
    """Return the LU factors of the first regular matrix among matrix(1), matrix(2), matrix(3).

    None if all are singular. Rounding may make a pivot of a nearly singular matrix exactly 0.
    """
    for k in (1, 2, 3):
        try:
            return spl.splu(matrix(k).tocsc().astype(complex))
        except RuntimeError:
            continue
    return None


def _gap(loads: Any) -> float:
    """Return a shift above the loads that are tiny compared with the others; 0 without such loads.

    Motions on very soft springs have loads so small that an eigensolver with a shift at 0 finds
    no others.
    """
    ascending = np.sort(np.abs(loads[np.isfinite(loads) & (loads != 0.0)]))
    if len(ascending) < 2:
        return 0.0
    ratios = ascending[1:] / ascending[:-1]
    wide = np.flatnonzero(ratios > WIDE)
    return 0.7 * float(ascending[wide[0] + 1]) if len(wide) else 0.0


def _sorted(
    loads: Any, vectors: Any, count: int, known: Callable[[complex], bool]
) -> tuple[Array, Array, NDArray[np.complex128]]:
    """Return the real loads (k,), their shapes (n, k) and the omitted complex loads (m,).

    A nearly real pair counts as two loads; its shapes are an orthonormal basis of the plane of the
    real and imaginary parts of the eigenvectors.
    """
    ahead = np.isfinite(loads) & (loads.real > 0.0)
    nearly = ahead & (np.abs(loads.imag) <= NEARLY * np.abs(loads))
    places = np.flatnonzero(nearly)
    order = places[np.lexsort((loads[places].imag, loads[places].real))]
    chosen = list(islice((i for i in order if known(loads[i])), count))
    shapes = np.zeros((len(vectors), len(chosen)))
    for k, i in enumerate(chosen):
        x = vectors[:, i]
        plane = sl.qr(np.column_stack([x.real, x.imag]), mode="economic")[0]
        shapes[:, k] = x.real if loads[i].imag == 0.0 else plane[:, int(loads[i].imag > 0.0)]
    others = loads[ahead & ~nearly & (loads.imag > 0.0)]
    others = others[np.argsort(np.abs(others))][:count]
    if len(chosen) == count:
        others = others[np.abs(others) < loads[chosen[-1]].real]
    others = others[[known(s) for s in others]] if len(others) else others
    return loads[chosen].real, shapes, others


def _rate(balance: Balance, at: Point, step: Array) -> Any:
    """Return the derivative A' of the tangent matrix along the linear solution.

    Beams retain their shape and have the linear stress, ``e0 -> e0 - s e'``: the stiffness of
    initial displacements, EA times a rotation, is left out because it is wrong without the terms
    of second order.
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
