"""Upper bounds of a criterion at many sites over a whole run, the cheapest first."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from jousto.base.arrays import Array, Index
from jousto.recovery.hotspots.measures import Measure
from jousto.recovery.hotspots.windows import SAFETY, UNIT, Windows, cut_windows, spectral

STRIDES = (128, 16)  # number of instants in a window, coarse and fine
SMALLEST = 1e-8  # weight of a coordinate without stress over the mean weight
SMALLEST_MARGIN = 1e-280  # smallest margin, for sites without stress
PAIRS = 4096  # number of pairs of site and window evaluated at a time
BLOCK = 1 << 22  # number of values in memory at a time
PIECE = 1 << 17  # number of values that fit into the cache


@dataclass(eq=False)
class Effort:
    """Number of evaluations of the criterion at knots of windows, and at all their instants."""

    knots: int = 0
    full: int = 0


@dataclass(frozen=True, eq=False)
class Search:
    """Stress modes and path of modal coordinates, transformed for the computation of bounds.

    The coordinates y, ``p = T y``, are the principal components of the path, weighted by the mean
    stress of each over the sites, so that a few of them cause most of the stress. The criterion is
    a function of ``g = G S p = B y``.

    Attributes
    ----------
    modes : (ns, 6, n) array
        Stress of the modes.
    p : (nt, n) array
        Modal coordinates.
    measure : Measure
        The criterion.
    T : (n, n) array
        Transformation ``p = T y``.
    y : (k, n) array
        Path; its last instant is repeated to fill the last window.
    windows : tuple of Windows
        Coarse and fine windows; the fine ones divide the coarse ones.
    margin : (ns,) array
        Bound of the rounding errors of the criterion and of its bounds.
    effort : Effort
        Number of evaluations.
    """

    modes: Array
    p: Array
    measure: Measure
    T: Array
    y: Array
    windows: tuple[Windows, ...]
    margin: Array
    effort: Effort = field(default_factory=Effort)

    def rows(self, at: Index | slice) -> Array:
        """Return B (nk, r, n) of sites."""
        return np.asarray(np.matmul(self.measure.rows @ self.modes[at], self.T))

    def whole(self) -> Array:
        """Return bounds (ns,) over the run, ``|B L|_2 max |z|`` of the whitened path ``y = L z``.

        L is diagonal, since y are principal components. The 2-norm is computed only where the
        Frobenius norm and the sum over the coordinates are not small enough.
        """
        y = self.y
        scale = np.sqrt((y**2).mean(axis=0))
        z = np.divide(y, scale, out=np.zeros_like(y), where=scale > 0.0)
        reach = float(np.sqrt((z**2).sum(axis=1).max(initial=0.0)))
        highest = np.abs(y).max(axis=0)
        out = np.empty(len(self.modes))
        step = max(1, BLOCK // (len(self.measure.rows) * y.shape[1] + 1))
        for first in range(0, len(out), step):
            at = slice(first, first + step)
            B = self.rows(at)
            box = np.sqrt((B**2).sum(axis=1)) @ highest
            out[at] = np.minimum(box, spectral(B * scale) * reach)
        return np.asarray(out * (1.0 + SAFETY * UNIT * (len(scale) + SAFETY)) + self.margin)

    def refine(self, places: Index, below: Array) -> tuple[Array, Index, Array]:
        """Return the largest exact values of sites, their instants, and bounds over the run.

        Parameters
        ----------
        places : (nk,) int array
            Indices of the sites.
        below : (nk,) array
            Values of interest: windows whose bound is lower are not evaluated.

        Returns
        -------
        best : (nk,) array
            Largest ranked value; -inf if no window was evaluated.
        when : (nk,) int array
            Its instant; the first one of equal values.
        upper : (nk,) array
            Bound over the run; equal to `best` if no other window can exceed it.
        """
        nk = len(places)
        best, when = np.full(nk, -np.inf), np.zeros(nk, dtype=np.intp)
        upper = np.full(nk, -np.inf)
        B = self.rows(places)
        columns, norm = np.sqrt((B**2).sum(axis=1)), spectral(B)
        margin, below = self.margin[places], np.array(below)
        slack = self._slack(norm)
        # coarse windows of all sites, in pieces that fit into the cache
        coarse = self.windows[0]
        kept_place, kept_window = [], []
        for some in _pieces(nk, max(1, PIECE // (B.shape[1] * len(coarse.knots)))):
            F = self._majorant(B[some], coarse.knots)
            U = coarse.strays(columns[some], norm[some])
            U += np.maximum(F[:, :-1], F[:, 1:])
            U += margin[some][:, None]
            if (
                self.measure.tight
            ):  # values at knots, which are instants of the run, are lower bounds
                known = F.max(axis=1) - slack[some] - margin[some]
                below[some] = np.maximum(below[some], known)
            chosen = U > below[some][:, None]
            which, column = np.nonzero(chosen)
            kept_place.append(which + some.start)
            kept_window.append(column)
            U[chosen] = -np.inf
            upper[some] = U.max(axis=1)
        place, window = np.concatenate(kept_place), np.concatenate(kept_window)
        # fine windows in the remaining coarse ones, for pairs of site and window
        for finer in self.windows[1:]:
            parts = coarse.stride // finer.stride
            kept_place, kept_window = [], []
            for some in _pieces(len(place), PAIRS):
                k, w = place[some], window[some][:, None] * parts + np.arange(parts)
                knots = np.concatenate([w, w[:, -1:] + 1], axis=1)
                F = self._majorant(B[k], finer.knots[knots])
                U = np.maximum(F[:, :-1], F[:, 1:]) + margin[k][:, None]
                U += finer.strays_of_pairs(columns[k], norm[k], w)
                if self.measure.tight:
                    np.maximum.at(below, k, F.max(axis=1) - slack[k] - margin[k])
                chosen = U > below[k][:, None]
                np.maximum.at(upper, k, np.where(chosen, -np.inf, U).max(axis=1))
                which, column = np.nonzero(chosen)
                kept_place.append(k[which])
                kept_window.append(w[which, column])
            place = np.concatenate([*kept_place, np.zeros(0, dtype=np.intp)])
            window = np.concatenate([*kept_window, np.zeros(0, dtype=np.intp)])
            coarse = finer
        # all instants of the remaining windows, both ends included
        stride, nt = coarse.stride, len(self.p)
        for some in _pieces(len(place), PAIRS):
            k = place[some]
            t = np.minimum(window[some][:, None] * stride + np.arange(stride + 1), nt - 1)
            s = np.matmul(self.p[t], np.swapaxes(self.modes[places[k]], 1, 2))
            value = self.measure.rank(self.measure.value(s))
            self.effort.full += value.size
            at = np.argmax(value, axis=1)
            found, instant = value[np.arange(len(k)), at], t[np.arange(len(k)), at]
            # first instant of the largest value: sort by site, value, then instant
            order = np.lexsort((instant, -found, k))
            first = order[np.concatenate([[True], np.diff(k[order]) > 0])] if len(k) else order
            better = found[first] > best[k[first]]
            better |= (found[first] == best[k[first]]) & (instant[first] < when[k[first]])
            first = first[better]
            best[k[first]], when[k[first]] = found[first], instant[first]
        return best, when, np.maximum(upper, best)

    def _majorant(self, B: Array, y: Array) -> Array:
        """Return F (nk, m) at instants y (m, n) or (nk, m, n)."""
        if y.ndim == 3:
            g = np.matmul(y, np.swapaxes(B, 1, 2))
        else:
            nk, r, n = B.shape
            g = np.moveaxis((B.reshape(nk * r, n) @ y.T).reshape(nk, r, len(y)), 1, 2)
        self.effort.knots += g.shape[0] * g.shape[1]
        return self.measure.majorant(g)

    def _slack(self, norm: Array) -> Array:
        """Return the largest difference (nk,) of majorant and criterion; `norm` is that of B."""
        # the margin of principal_bounds is relative to the norm of the tensor, which may be much
        # larger than a principal value: the first one is 0 in compression
        return np.asarray(1e-6 * norm * np.sqrt((self.y**2).sum(axis=1).max(initial=0.0)))


def prepare(modes: Array, p: Array, measure: Measure) -> Search:
    """Return the search for sites with stress modes (ns, 6, n) on a path (nt, n)."""
    ns, _, n = modes.shape
    nt = len(p)
    rows = measure.rows
    # weights of the coordinates: squared stress of the modes, averaged over the sites
    H = np.zeros((n, n))
    columns, raw = np.empty((ns, n)), np.empty((ns, n))
    step = max(1, BLOCK // (6 * n + 1))
    for first in range(0, ns, step):
        S = modes[first : first + step]
        GS = rows @ S
        H += np.tensordot(GS, GS, ((0, 1), (0, 1)))
        columns[first : first + step] = np.sqrt((GS**2).sum(axis=1))
        raw[first : first + step] = np.sqrt((S**2).sum(axis=1))
    H /= max(ns, 1)
    weight = float(np.trace(H)) / n
    H += (SMALLEST * weight if weight > 0.0 else 1.0) * np.eye(n)
    values, vectors = np.linalg.eigh(H)
    half = (vectors * np.sqrt(values)) @ vectors.T
    inverse = (vectors / np.sqrt(values)) @ vectors.T
    y = p @ half
    V = np.linalg.eigh(y.T @ y)[1]
    T = inverse @ V
    y = y @ V
    # rounding errors of the sums above; the difference of p and T y is computed
    highest_p, highest_y = np.abs(p).max(axis=0), np.abs(y).max(axis=0)
    ops = UNIT * (n + SAFETY)
    rest = np.abs(p - y @ T.T).max(axis=0) + ops * (highest_p + np.abs(T) @ highest_y)
    size = float(np.linalg.norm(rows))
    turned = raw @ np.abs(T) @ highest_y
    margin = columns @ rest + SAFETY * ops * size * (raw @ highest_p + turned)
    margin += SMALLEST_MARGIN  # also for sites without stress, so that bounds exceed values
    # windows; the last one is filled with the last instant
    strides = [stride for stride in STRIDES if stride < nt] or [STRIDES[-1]]
    count = -(-max(nt - 1, 1) // strides[0])
    filled = np.concatenate([y, np.repeat(y[-1:], count * strides[0] + 1 - nt, axis=0)])
    windows = tuple(cut_windows(filled, stride) for stride in strides)
    return Search(modes, p, measure, T, y, windows, margin)


def _pieces(count: int, step: int) -> list[slice]:
    return [slice(first, min(first + step, count)) for first in range(0, count, step)]
