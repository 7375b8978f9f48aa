"""weigh_modes: prior of modal coordinates by their stiffness, with a size from the strains."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg as la
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, JoustoWarning, Problem, Problems, count
from jousto.base.object_repr import described
from jousto.measurement.twin.loads import modal_loads
from jousto.measurement.twin.reconstruction import NOISE, Reconstruction
from jousto.measurement.twin.signals import LARGEST, read_noise, read_strain
from jousto.parts.part import Part
from jousto.reduction.reduced import ReducedPart

KINDS = ("energy", "loads")
STRAINLESS = 1e-10  # ratio of a strain and the largest possible one, up to which it is round-off
# smallest singular value of unit strains of loads, below which two loads are indistinguishable
ALIKE = 1e-8
# share of a mode that the strains determine, below which the mode is listed as not seen
UNSEEN = 0.01
# logarithms of the weight over the squared singular values, between which the evidence is searched
RANGE, STEPS = 14.0, 113
SYMMETRY = 1e-9  # asymmetry of a stiffness over its largest entry, above which it is refused


@described
@dataclass(frozen=True, eq=False)
class WeighedModes:
    """Modes weighed by their stiffness.

    Attributes
    ----------
    reconstruction : Reconstruction
        Reconstruction with the prior covariance ``(a W)^-1``.
    by : str
        ``"energy"`` with W the stiffness K, or ``"loads"`` with ``W = K^2``.
    a : float
        Weight; 1/a is the mean square of ``w_j p_j`` (twice the strain energy of a mode, J), or of
        the modal load ``w_j^2 p_j``.
    effective : float
        Number of combinations of modes that the strains determine, ``tr(S (S^T R^-1 S + a W)^-1 S^T
        R^-1)``.
    seen : (n,) array
        Share of each mode that the strains determine; the rest comes from the prior, which is zero.
    evidence : float
        Logarithm of the probability of the strains with this weight, relative to no motion.
    """

    reconstruction: Reconstruction
    by: str
    a: float
    effective: float
    seen: Array
    evidence: float
    stiffness: Array

    def place_loads(
        self, e: ArrayLike, loads: Any, reduced: ReducedPart | None = None
    ) -> tuple[Array, Array]:
        """Return static loads at known places from strains, with their standard deviation.

        ``F = (H^T C^-1 H)^-1 H^T C^-1 e`` with ``H = S K^-1 L`` and ``C = R + S (b W)^-1 S^T``:
        least squares with noise and other motions in the strains. The weight b of the other
        motions, and W (K or ``K^2``), have the largest evidence for the strains not explained by
        the loads, the projection onto the complement of ``R^-1/2 H`` (restricted maximum
        likelihood: Patterson, Thompson, *Biometrika* 58 (1971) 545-554). Where the loads explain
        all, b is infinite and C is R. The band neglects motions that strain the gauges like the
        loads, so that less than the noise remains; with as many loads as gauges nothing remains. In
        contrast to loads from modal coordinates (`jousto.twin.place_loads`), these loads are not
        reduced by the prior.

        Parameters
        ----------
        e : (nt, ng) array_like
            Strains, m/m, without gaps.
        loads : (n, na) array_like or sequence of UnknownLoad
            Modal loads ``L = Phi^T`` of unit loads, or loads with their places.
        reduced : ReducedPart, optional
            The part, for loads by their place.

        Returns
        -------
        F : (nt, na) array
            N and N m.
        band : (na,) array
            Standard deviation at each instant.

        Raises
        ------
        InputError
            For wrong sizes, gaps, loads that strain no gauge, or loads that the gauges cannot
            distinguish.
        """
        where, problems = "WeighedModes.place_loads", Problems()
        twin = self.reconstruction
        strain = read_strain(problems, where, e, twin.names)
        L = problems.array(where, "loads", modal_loads(where, loads, reduced), (twin.n, None))
        if strain is not None and not np.isfinite(strain).all():
            problems.add(where, "the strains have gaps (nan); leave out these instants")
        elif strain is not None and not len(strain):
            problems.add(where, "the strains have no instants")
        problems.raise_if_any()
        assert strain is not None and L is not None
        # strains in units of the noise: of modes, of unit loads, measured
        root = la.cholesky(twin.noise, lower=True)
        S = la.solve_triangular(root, twin.B, lower=True)
        H = S @ la.solve(self.stiffness, L, assume_a="pos")
        E = la.solve_triangular(root, strain.T, lower=True)
        _check_loads(problems, where, H, S @ la.inv(self.stiffness), L, reduced)
        # noise and other motions
        C = np.eye(len(S)) + _rest(S, H, E, self.stiffness)
        root = la.cholesky(C, lower=True)
        white = la.solve_triangular(root, H, lower=True)
        size = np.linalg.norm(white, axis=0)
        unit = white / size
        F = la.lstsq(unit, la.solve_triangular(root, E, lower=True))[0] / size[:, None]
        band = np.sqrt(np.diag(la.inv(unit.T @ unit))) / size
        return np.asarray(F.T), np.asarray(band)

    @property
    def unseen(self) -> tuple[int, ...]:
        """Numbers, from 1, of the modes that the strains determine to less than 1 %."""
        return tuple(int(j) + 1 for j in np.flatnonzero(self.seen < UNSEEN))

    def __str__(self) -> str:
        n = len(self.seen)
        listed = ", ".join(map(str, self.unseen)) or "none"
        return (
            f"weight a {self.a:.4g} by {self.by}, {self.effective:.2f} of {n} modes are decided "
            f"by {len(self.reconstruction.names)} gauges\nmodes not seen: {listed}"
        )


@explained
def weigh_modes(
    B: ArrayLike,
    e: ArrayLike,
    part: ReducedPart | ArrayLike,
    *,
    noise: Any = NOISE,
    names: Sequence[str] = (),
    by: str | None = None,
) -> WeighedModes:
    """Return a reconstruction whose modes are weighed by their stiffness.

    The modal coordinates minimise ``(S p - e)^T R^-1 (S p - e) + a p^T W p`` with the rows S = B of
    the gauges: a stiff mode needs more evidence, so that no mode has to be excluded by hand. W is
    the stiffness K of the modes (the strain energy) or ``K^2`` (the size of the modal loads ``K
    p``). With K the strain between few gauges tends to zero, with ``K^2`` it is smooth there. The
    weight a has the largest evidence (MacKay, *Neural Computation* 4 (1992) 415-447): with ``R^-1/2
    S W^-1/2 = U s V^T`` and ``d = U^T R^-1/2 e`` of nt instants

        ``-2 log ev(a) = sum_i [nt log(1 + s_i^2/a) + |d_i|^2 / (1 + s_i^2/a)]``

    Parameters
    ----------
    B : (ng, n) array_like
        Strain of each mode at each gauge as for `Reconstruction`, m/m per unit coordinate.
    e : (nt, ng) array_like
        Strains of a typical record, m/m; instants with gaps (nan) are left out.
    part : ReducedPart or (n,) or (n, n) array_like
        Stiffness K of the modes: that of the part, or ``omega^2``, 1/s2. For a clamped body the
        result of `clamp`.
    noise : float, (ng,) or (ng, ng) array_like
        Standard deviation of each gauge, m/m, or their covariance matrix R.
    names : sequence of str, optional
        Names of the gauges.
    by : str, optional
        ``"energy"`` or ``"loads"``; None: the choice with the larger evidence.

    Returns
    -------
    WeighedModes
        Result; its `reconstruction` estimates modes, its `place_loads` estimates loads at known
        places.

    Raises
    ------
    InputError
        For wrong sizes, no instant without gaps, a stiffness that is not positive, or strains not
        larger than the noise, which determine no weight.

    Examples
    --------
    Two gauges and three modes, the third ten times as stiff as the second:

    >>> B = [[1.0, 0.5, 0.5], [1.0, -0.5, -0.5]]
    >>> found = weigh_modes(B, [[300e-6, 100e-6]], [1.0, 4.0, 40.0], by="energy")
    >>> p = found.reconstruction.estimate([[300e-6, 100e-6]]).p
    >>> (1e6 * p).round(0)
    array([[200., 182.,  18.]])
    """
    where, problems = "weigh_modes", Problems()
    S = problems.array(where, "B", B, (None, None))
    problems.raise_if_any()
    assert S is not None
    ng, n = S.shape
    if not ng or not n:
        text = (
            f"B has {count(ng, 'row')} and {count(n, 'column')}; give at least one gauge and mode"
        )
        problems.add(where, text, "B")
        problems.raise_if_any()
    if names and len(names) != ng:
        problems.add(where, f"{len(names)} names for {ng} rows of B")
    labels = tuple(names) if len(names) == ng else tuple(f"g{k + 1}" for k in range(ng))
    strain = read_strain(problems, where, e, labels)
    R = read_noise(problems, where, "noise", noise, ng, "m/m", LARGEST)
    K = _stiffness(problems, where, part, n)
    if by not in (None, *KINDS):
        problems.add(where, f"by is {by!r}, must be 'energy', 'loads' or None", "by")
    complete = None
    if strain is not None:
        complete = strain[np.isfinite(strain).all(axis=1)]
        if not len(strain):
            problems.add(where, "the strains have no instants")
        elif not len(complete):
            problems.add(where, "every instant of the strains has a gap; leave out dead gauges")
    problems.raise_if_any()
    assert R is not None and K is not None and complete is not None
    kinds = KINDS if by is None else (by,)
    tried = [_weighed(S, complete, K, R, labels, kind) for kind in kinds]
    return max(tried, key=lambda found: found.evidence)


def _weighed(
    S: Array, complete: Array, K: Array, R: Array, labels: tuple[str, ...], by: str
) -> WeighedModes:
    """Return the modes with the weight of the largest evidence of one kind."""
    where, (ng, n) = "weigh_modes", S.shape
    W = K if by == "energy" else K @ K
    # all in units of the noise and of the root of the strain energy
    noise_root, energy_root = la.cholesky(R, lower=True), la.cholesky(W, lower=True)
    white = la.solve_triangular(noise_root, S, lower=True)
    white = la.solve_triangular(energy_root, white.T, lower=True).T
    U, s, _ = la.svd(white, full_matrices=False)
    d = U.T @ la.solve_triangular(noise_root, complete.T, lower=True)
    power = (d**2).sum(axis=1)
    a, evidence = _likeliest_weight(where, s**2, power, len(complete))
    G = la.cho_solve((energy_root, True), np.eye(n)) / a
    # fewer gauges than modes: the result reports the modes that are not seen
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", JoustoWarning)
        found = Reconstruction(S, noise=R, prior=0.5 * (G + G.T), names=labels)
    gain = found.gain(np.ones(ng, dtype=bool))
    assert gain is not None
    effective = float((s**2 / (s**2 + a)).sum())
    return WeighedModes(found, by, a, effective, np.diag(gain[0] @ S).copy(), evidence, K)


def _check_loads(
    problems: Problems, where: str, H: Array, flexibility: Array, L: Array, part: ReducedPart | None
) -> None:
    """Raise an error for loads without strain (columns of H), or alike for all gauges."""
    size = np.linalg.norm(H, axis=0)
    moved = np.linalg.norm(L, axis=0)
    if part is not None:  # a load at a clamp causes no motion except round-off
        moved = np.maximum(moved, float(np.abs(part.modes).max()))
    still = np.flatnonzero(size <= STRAINLESS * np.linalg.norm(flexibility, 2) * moved)
    for k in still:
        problems.add(
            where,
            f"load {k + 1} strains none of the gauges, so that they do not measure it: it acts at "
            "a clamp, or moves no mode; leave it out",
            "loads",
        )
    problems.raise_if_any()
    ng, na = H.shape
    if ng < na or la.svdvals(H / size)[-1] < ALIKE:
        problems.add(where, f"{count(ng, 'gauge')} cannot distinguish {count(na, 'load')}")
    problems.raise_if_any()


def _rest(S: Array, H: Array, E: Array, K: Array) -> Array:
    """Return the covariance (ng, ng) of strains from motions not caused by the loads.

    All arguments are in units of the noise: strains of modes S (ng, n), of unit loads H (ng, na),
    and measured E (ng, nt). Kind and weight of the prior have the largest restricted likelihood.
    """
    left = la.qr(H)[0][:, H.shape[1] :]  # complement of the strains of the loads
    best, covariance = 0.0, np.zeros((len(S), len(S)))
    if not left.shape[1]:
        return covariance
    for W in (K, K @ K):
        modes = la.solve_triangular(la.cholesky(W, lower=True), S.T, lower=True).T
        U, s, _ = la.svd(left.T @ modes, full_matrices=False)
        if not s[0] > STRAINLESS * np.linalg.norm(modes, 2):
            # other motions cause the same strains as the loads, so they cannot be distinguished
            continue
        power = ((U.T @ (left.T @ E)) ** 2).sum(axis=1)
        log_b, loss, _ = _most_likely(s**2, power, E.shape[1])
        if loss < best:
            best, covariance = loss, modes @ modes.T * np.exp(-log_b)
    return covariance


def _stiffness(problems: Problems, where: str, part: Any, n: int) -> Array | None:
    """Return the stiffness (n, n) of the modes, or report one of the wrong size."""
    given = part.stiffness if isinstance(part, ReducedPart) else part
    if given is None or isinstance(given, str | Part):
        problems.add(
            where,
            f"part is {part!r}, must be a ReducedPart from clamp, or the stiffness of the modes",
            "part",
        )
        return None
    shape = (n, n) if np.ndim(given) == 2 else (n,)
    W = problems.array(where, "stiffness", given, shape)
    if W is None:
        return None
    W = np.diag(W) if W.ndim == 1 else W
    if np.abs(W - W.T).max() > SYMMETRY * np.abs(W).max():
        problems.add(where, "the stiffness is not symmetric")
        return None
    size = np.sqrt(np.abs(np.diag(W)))
    if not size.all() or la.eigvalsh(W / np.outer(size, size))[0] <= 0.0:
        problems.add(
            where,
            "the stiffness has a mode without strain energy, must be positive; of a part that is "
            "held give that of clamp(part, node)",
        )
        return None
    return np.asarray(0.5 * (W + W.T))


def _likeliest_weight(where: str, s2: Array, power: Array, instants: int) -> tuple[float, float]:
    """Return the weight of the largest evidence and its logarithm.

    Parameters
    ----------
    where : str
        Prefix of messages.
    s2 : (k,) array
        Squared singular values.
    power : (k,) array
        Sums of the squared coordinates of the strains, in units of the noise.
    instants : int
        Number of instants.
    """
    if not s2[0] > 0.0:
        raise InputError(Problem(where, "no gauge is strained by any mode"))
    log_a, loss, k = _most_likely(s2, power, instants)
    if loss >= 0.0 or k == STEPS - 1:
        rms = float(np.sqrt(power.sum() / max(instants * len(power), 1)))
        raise InputError(
            Problem(
                where,
                f"the strains are {rms:.3g} times the noise (rms): they contain no motion by which "
                "modes could be weighed; take a record with loads, or the noise of the gauges",
            )
        )
    if k == 0:
        raise InputError(
            Problem(where, "the strains are too large for their noise; give noise= in m/m")
        )
    return float(np.exp(log_a)), -loss


def _most_likely(s2: Array, power: Array, instants: int) -> tuple[float, float, int]:
    """Return the likeliest log a, its loss (0 without motion), and its place on the grid."""

    def loss(log_a: float) -> float:
        ratio = s2 * np.exp(-log_a)
        # relative to the evidence of no motion, power / 2
        gained = power * ratio / (1.0 + ratio)
        return 0.5 * float((instants * np.log1p(ratio) - gained).sum())

    def slope(log_a: float) -> float:
        ratio = s2 * np.exp(-log_a)
        return 0.5 * float(((power / (1.0 + ratio) - instants) * ratio / (1.0 + ratio)).sum())

    grid = np.log(s2[0]) + np.linspace(-1.0, 1.0, STEPS) * RANGE * np.log(10.0)
    losses = np.array([loss(x) for x in grid])
    k = int(losses.argmin())
    if k in (0, STEPS - 1):
        return float(grid[k]), float(losses[k]), k
    # the optimum is where the slope vanishes: the loss itself is flat there and determines only
    # half of the digits
    low, high = float(grid[k - 1]), float(grid[k + 1])
    if slope(low) < 0.0 < slope(high):
        log_a = float(brentq(slope, low, high, xtol=1e-14))
        return log_a, loss(log_a), k
    best = minimize_scalar(loss, bounds=(low, high), method="bounded", options={"xatol": 1e-9})
    return float(best.x), float(best.fun), k
