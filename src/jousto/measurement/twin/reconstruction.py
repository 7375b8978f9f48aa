"""Reconstruction: modal coordinates of a body from its strain gauges at each instant."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.linalg as la
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, count, warn
from jousto.base.object_repr import described
from jousto.measurement.twin.estimates import Told
from jousto.measurement.twin.signals import LARGEST, read_noise, read_strain, read_time

NOISE = 1e-6
"""Default standard deviation of a gauge, m/m."""
CONDITION = 1e4
"""Condition number from which a basis without prior amplifies noise (reported)."""
FAR_OFF = 10.0
"""Leave-one-out score of most gauges from which an estimate is doubtful; 1 is ideal."""
PARALLEL = 1e-9
"""Cosine of two gauge rows from which they carry the same information: 1 - this value."""
UNSEEN = 1e-9
"""Strain of a mode relative to the largest mode below which it is rounding."""
WEIGH = "weigh the modes by their stiffness (jo.twin.weigh_modes(B, e, part))"
"""Advice on modes that gauges cannot distinguish; none has to be left out."""


@described
@dataclass(frozen=True, eq=False)
class Estimate(Told):
    """Modal coordinates from gauges with quality measures.

    Attributes
    ----------
    residual : (nt, ng) array
        Measured minus reconstructed strain, ``e - B p``, m/m; nan where nothing was measured.
    leave_one_out : (nt, ng) array
        Measured strain minus its prediction by the *other* gauges, m/m; inf without a prediction.
    expected : (nt, ng) array
        Standard deviation of `leave_one_out` for correct noise and prior, m/m.
    condition : float
        Condition number of the gauges' rows, scaled by their noise: largest over smallest
        amplification.
    names : tuple of str
        Names of the gauges.
    discrepancy : float
        Model error in strain, m/m, from `Reconstruction.calibrated`.
    gains, errors : arrays, optional
        Data as in `Told`.
    """

    residual: Array
    leave_one_out: Array
    expected: Array
    condition: float
    names: tuple[str, ...]
    discrepancy: float = 0.0

    @property
    def missed(self) -> float:
        """Standard deviation of the model error in strain, m/m."""
        return self.discrepancy

    @property
    def score(self) -> Array:
        """Score (ng,): rms of `leave_one_out` divided by `expected`; 1 is ideal."""
        with np.errstate(invalid="ignore"):
            ratio = self.leave_one_out / self.expected
        ratio[~np.isfinite(ratio)] = np.nan
        seen = np.isfinite(ratio).sum(axis=0)
        total = np.nansum(ratio**2, axis=0)
        mean = np.divide(total, seen, out=np.full(len(seen), np.nan), where=seen > 0)
        return np.asarray(np.sqrt(mean))

    def __str__(self) -> str:
        def rms(x: Array) -> Array:
            good = np.isfinite(x)
            squares = np.where(good, x, 0.0) ** 2
            return np.asarray(np.sqrt(squares.sum(axis=0) / np.maximum(good.sum(axis=0), 1)))

        width = max(5, *(len(name) for name in self.names))
        lines = [
            f"{len(self)} instants, {self.p.shape[1]} modes, {len(self.names)} gauges, "
            f"condition {self.condition:.3g}",
            f"{'gauge':<{width}}  residual  left out  expected  score   (um/m, rms)",
        ]
        table = zip(
            self.names,
            rms(self.residual),
            rms(self.leave_one_out),
            rms(self.expected),
            self.score,
            strict=True,
        )
        for name, r, loo, expected, score in table:
            lines.append(
                f"{name:<{width}}  {1e6 * r:8.3f}  {1e6 * loo:8.3f}  {1e6 * expected:8.3f}"
                f"  {score:5.2f}"
            )
        return "\n".join(lines)


@explained
@described
@dataclass(frozen=True, eq=False)
class Reconstruction:
    """Modal coordinates from strains, ``p = (B^T Rn^-1 B + G^-1)^-1 B^T Rn^-1 e``.

    Weighted, regularised least-squares estimate of ``e = B p + noise`` with covariance ``P = (B^T
    Rn^-1 B + G^-1)^-1``; without prior and with equal noise the gain is the pseudoinverse ``B^+``.
    Each instant is independent: no model of the motion, no delay. The basis should contain the
    static shapes of the loads (as interfaces of a `CraigBampton` reduction do); else stress near
    loads and clamps is wrong.

    Parameters
    ----------
    B : (ng, n) array_like
        Strain of each mode at each gauge along its grid, m/m per unit modal coordinate:
        ``gauge_rows(gauges, reduced)``, or stacked ``sensor.rows``.
    noise : float, (ng,) or (ng, ng) array_like
        Standard deviation of each gauge, m/m, or their covariance matrix.
    prior : float, (n,) or (n, n) array_like, optional
        Standard deviation of each modal coordinate, or their covariance matrix G (about zero),
        for example from a simulated run: ``np.cov(p.T)``. Needed if there are fewer gauges than
        modes.
    names : sequence of str, optional
        Names of the gauges for messages; by default g1, g2, ...
    discrepancy : float
        Standard deviation of the strain that the modes do not represent, m/m, at any place; part of
        the band of the stress.
    errors : (k, ng, n) array_like, optional
        Standard deviation of the errors of each gauge that are constant over a record, per unit
        modal coordinate, from `gauge_errors`; part of the band of the stress.

    Raises
    ------
    InputError
        With all problems: fewer gauges than modes without a prior, gauges that cannot distinguish
        the modes, noise that is not positive, wrong shapes.

    Warns
    -----
    JoustoWarning
        For combinations of modes that only the prior determines, since no gauge responds to them;
        for equivalent gauges; and for a condition number that amplifies the noise strongly.

    Examples
    --------
    Two gauges, one mode, the first gauge four times as accurate:

    >>> twin = Reconstruction([[1.0], [1.0]], noise=(1e-6, 4e-6))
    >>> estimate = twin.estimate([[100e-6, 117e-6]])
    >>> estimate.p.round(9), estimate.band.round(9)
    (array([[0.000101]]), array([[9.7e-07]]))
    """

    B: Array
    noise: Any = NOISE
    prior: Any = None
    names: tuple[str, ...] = ()
    discrepancy: float = 0.0
    errors: Any = None

    def __post_init__(self) -> None:
        problems = Problems()
        where = "Reconstruction"
        B = problems.array(where, "B", self.B, (None, None))
        problems.raise_if_any()
        assert B is not None
        ng, n = B.shape
        names = tuple(self.names) or tuple(f"g{i + 1}" for i in range(ng))
        if len(names) != ng:
            problems.add(where, f"{count(len(names), 'name')} for {count(ng, 'row')} of B")
        if not ng or not n:
            problems.add(where, f"B has shape {B.shape}; give at least one gauge and one mode")
        R = read_noise(problems, where, "noise", self.noise, ng, "m/m", LARGEST)
        G = None
        if self.prior is not None:
            G = read_noise(problems, where, "prior", self.prior, n, "kg^0.5 m", np.inf)
        if self.errors is not None:
            errors = problems.array(where, "errors", self.errors, (None, ng, n))
            object.__setattr__(self, "errors", errors)
        problems.raise_if_any()
        assert R is not None
        object.__setattr__(self, "B", B)
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "noise", R)
        object.__setattr__(self, "prior", G)
        self._check()

    @property
    def n(self) -> int:
        """Number of modes."""
        return int(self.B.shape[1])

    @property
    def whitened(self) -> Array:
        """Rows of the gauges over their noise, ``L^-1 B`` with ``Rn = L L^T``."""
        return np.asarray(
            la.solve_triangular(la.cholesky(self.noise, lower=True), self.B, lower=True)
        )

    @property
    def condition(self) -> float:
        """Condition number of the whitened rows; inf with unobservable modes."""
        s = la.svdvals(self.whitened)
        if len(self.B) < self.n or s[-1] <= 1e-12 * s[0]:
            return float("inf")
        return float(s[0] / s[-1])

    @property
    def unobservable(self) -> Array:
        """Mode combinations without effect on any gauge (n, k), orthonormal columns."""
        return np.asarray(la.null_space(self.B, rcond=1e-9))

    def estimate(self, e: ArrayLike, time: ArrayLike | None = None) -> Estimate:
        """Return the modal coordinates of measured strains.

        Parameters
        ----------
        e : (nt, ng) or (ng,) array_like
            Strains, m/m; nan where a gauge has no value: the instant is estimated without this
            gauge.
        time : (nt,) array_like, optional
            Instants, s.

        Raises
        ------
        InputError
            For a wrong number of channels, infinite or far too large values (percent or um/m
            instead of m/m), or times that run backwards.

        Warns
        -----
        JoustoWarning
            For instants with too few gauges for the modes, whose p is nan, and for scores far above
            1 of most gauges, such as for strains in percent.
        """
        problems = Problems()
        strain = read_strain(problems, "Reconstruction.estimate", e, self.names)
        t = read_time(problems, "Reconstruction.estimate", time, strain)
        problems.raise_if_any()
        assert strain is not None and t is not None
        seen = np.isfinite(strain)
        masks, which = np.unique(seen, axis=0, return_inverse=True)
        which = which.reshape(-1)
        p = np.full((len(strain), self.n), np.nan)
        leave, expected = np.full_like(strain, np.nan), np.full_like(strain, np.nan)
        P = np.empty((len(masks), self.n, self.n))
        gains = np.zeros((len(masks), self.n, len(self.B)))
        blind = 0
        for m, mask in enumerate(masks):
            rows = np.flatnonzero(which == m)
            gain = self.gain(mask)
            if gain is None:
                P[m] = np.inf
                blind += len(rows)
                continue
            K, P[m] = gain
            gains[m][:, mask] = K
            known = strain[np.ix_(rows, mask)]
            p[rows] = known @ K.T
            leave[np.ix_(rows, mask)], expected[np.ix_(rows, mask)] = self._left_out(
                mask, P[m], known - p[rows] @ self.B[mask].T
            )
        if blind:
            warn(
                "Reconstruction.estimate",
                f"at {count(blind, 'instant')} of {len(strain)} too few gauges are left to "
                "determine "
                f"{count(self.n, 'mode')}; p is nan there, give a prior to continue",
            )
        residual = strain - p @ self.B.T
        found = Estimate(
            t,
            p,
            P,
            which,
            residual,
            leave,
            expected,
            self.condition,
            self.names,
            self.discrepancy,
            gains=gains if self.errors is not None else None,
            errors=self.errors,
        )
        score = found.score[np.isfinite(found.score)]
        if len(score) and np.median(score) > FAR_OFF:
            warn(
                "Reconstruction.estimate",
                f"the gauges contradict one another by {np.median(score):.3g} times what their "
                "noise explains (median score): strains in percent or another unit instead of m/m, "
                "gauges in another order or with another sign, missing modes, or noise= too small",
            )
        return found

    def calibrated(self, e: ArrayLike) -> Reconstruction:
        """Return the reconstruction with noise scaled to measured strains.

        The factor makes the leave-one-out residuals, averaged over the gauges, equal to their
        expected size. The noise then includes model errors, and its increase is used as the model
        error at all places.

        Raises
        ------
        InputError
            As for `estimate`; also if no gauge can be distinguished from the others.
        """
        scaled = self
        for _ in range(20):  # fixed-point iteration: the prior does not scale with the noise
            with warnings.catch_warnings():  # high scores are expected before the calibration
                warnings.filterwarnings("ignore", message=".*contradict one another")
                score = scaled.estimate(e).score
            good = score[np.isfinite(score)]
            if not len(good):
                raise InputError(
                    Problem(
                        "Reconstruction.calibrated",
                        "no gauge can be distinguished from the others, so the noise "
                        "cannot be estimated; add gauges or give a prior",
                    )
                )
            factor = float(np.sqrt(np.mean(good**2)))
            scaled = scaled._with_noise(factor**2 * scaled.noise)
            if abs(factor - 1.0) < 1e-3:
                break
        grown = float(np.mean(np.diag(scaled.noise)) - np.mean(np.diag(self.noise)))
        return scaled._with_noise(scaled.noise, float(np.sqrt(max(grown, 0.0))))

    def _with_noise(self, R: Array, discrepancy: float = 0.0) -> Reconstruction:
        with warnings.catch_warnings():  # the rows are unchanged and were checked before
            warnings.simplefilter("ignore")
            return replace(self, noise=R, discrepancy=discrepancy)

    def gain(self, mask: NDArray[np.bool_]) -> tuple[Array, Array] | None:
        """Return gain (n, k) and covariance (n, n) with the k gauges of a mask (ng,).

        None if the gauges cannot distinguish the modes and there is no prior.
        """
        B, R = self.B[mask], self.noise[np.ix_(mask, mask)]
        if self.prior is not None:
            # form without inverse of the prior, which may be singular
            GB = self.prior @ B.T
            if not len(B):
                return np.zeros((self.n, 0)), np.asarray(self.prior)
            factor = la.cho_factor(B @ GB + R)
            K = la.cho_solve(factor, GB.T).T
            IKB = np.eye(self.n) - K @ B
            return K, _even(IKB @ self.prior @ IKB.T + K @ R @ K.T)
        if len(B) < self.n:
            return None
        L = la.cholesky(R, lower=True)
        W = la.solve_triangular(L, B, lower=True)
        U, s, Vt = la.svd(W, full_matrices=False)
        if s[-1] <= 1e-12 * s[0]:
            return None
        K = la.solve_triangular(L, ((Vt.T / s) @ U.T).T, lower=True, trans="T").T
        return K, _even((Vt.T / s**2) @ Vt)

    def _left_out(self, mask: NDArray[np.bool_], P: Array, residual: Array) -> tuple[Array, Array]:
        """Return leave-one-out residuals of the gauges and their expected size.

        With ``Q = Rn^-1 - Rn^-1 B P B^T Rn^-1`` the residuals are ``(Q e)_g / Q_gg`` with the
        standard deviation ``Q_gg^-1/2``.
        """
        if not mask.any():
            return residual, residual
        B, R = self.B[mask], self.noise[np.ix_(mask, mask)]
        inverse = la.inv(R)
        weighted = inverse @ B
        diagonal = np.diag(inverse - weighted @ P @ weighted.T)
        known = diagonal > 1e-9 * np.diag(inverse)
        safe = np.where(known, diagonal, 1.0)
        # Q e = Rn^-1 (e - B p)
        value = np.where(known, residual @ inverse.T / safe, np.inf)
        size = np.where(known, 1.0 / np.sqrt(safe), np.inf)
        return value, np.broadcast_to(size, value.shape)

    def _check(self) -> None:
        """Raise InputError for unsolvable systems; warn of modes that depend on the prior alone."""
        ng, n = self.B.shape
        hidden = self.unobservable
        pairs = _parallel(self.B, self.names)
        alike = f"; {pairs} have parallel rows and count as one" if pairs else ""
        if hidden.shape[1] == 0:
            if self.prior is None and self.condition > CONDITION:
                warn(
                    "Reconstruction",
                    f"condition number {self.condition:.2g}: the gauges measure some "
                    "combinations of modes that much less than others, which amplifies the "
                    "noise; move gauges (place_gauges), "
                    f"{WEIGH}, or give a prior",
                )
            return
        rank = n - hidden.shape[1]
        found = f"{count(ng, 'gauge')} distinguish {rank} of {count(n, 'mode')}{alike}"
        size = np.linalg.norm(self.B, axis=0)
        blank = np.flatnonzero(size <= UNSEEN * size.max())
        which = ""
        if len(blank):
            numbers = ", ".join(str(j + 1) for j in blank)
            which = f"; no gauge is strained by {'mode' if len(blank) == 1 else 'modes'} {numbers}"
        if mixed := hidden.shape[1] - len(blank):
            others = "of the others" if len(blank) else "of modes"
            which += f"; {count(mixed, 'combination')} {others} cannot be seen"
        if self.prior is None:
            raise InputError(
                Problem(
                    "Reconstruction",
                    f"{found}{which}; add gauges elsewhere (other faces, axial and bending "
                    f"apart), {WEIGH}, or give prior= (covariance of the modes in a simulated run)",
                )
            )
        warn(
            "Reconstruction",
            f"{found}{which}; the prior alone determines the other "
            f"{count(hidden.shape[1], 'combination')}, check the bands",
        )


def _parallel(B: Array, names: Sequence[str]) -> str:
    """Return the names of gauges with parallel rows; empty if there are none."""
    length = np.linalg.norm(B, axis=1)
    unit = B / np.where(length > 0.0, length, 1.0)[:, None]
    cosine = np.abs(unit @ unit.T)
    found = [
        f"'{names[i]}' and '{names[j]}'"
        for i in range(len(B))
        for j in range(i)
        if cosine[i, j] > 1.0 - PARALLEL
    ]
    blind = [f"'{name}'" for name, size in zip(names, length, strict=True) if size == 0.0]
    text = ", ".join(found[:4]) + (", ..." if len(found) > 4 else "")
    return text if not blind else f"{text}{', ' if text else ''}{', '.join(blind)} (zero row)"


def _even(P: Array) -> Array:
    return np.asarray(0.5 * (P + P.T))
