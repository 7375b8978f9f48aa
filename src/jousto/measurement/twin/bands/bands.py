"""Stress over the whole body from estimated modes, with confidence bands."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri
from scipy.stats import qmc

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.files import Rows, Tabular
from jousto.base.object_repr import described
from jousto.measurement.twin.estimates import Posterior
from jousto.recovery.fields.criteria import Criterion, check_criterion, evaluate, weights
from jousto.reduction.fields.stress import StressModes
from jousto.reduction.reduced import ReducedPart

BLOCK_BYTES = 64 << 20
DRAWS = 128
"""Number of samples of the distribution of a criterion."""
TINY = 1e-12
"""Variance of a component relative to the largest below which it is neglected."""
BENT = 0.05
"""Second-order bias of a criterion, in standard deviations, from which it is sampled instead of
linearised."""


@described
@dataclass(frozen=True, eq=False)
class Band(Tabular):
    """Values over time with confidence bands.

    Attributes
    ----------
    labels : (ns,) tuple of str
        Names of the sites.
    time : (nt,) array
        Instants, s.
    value : (nt, ns) array
        Best estimate, Pa.
    low, high : (nt, ns) array
        Ends of the band, Pa.
    level : float
        Confidence: share of the time in which the true value lies in the band, if noise and prior
        are correct.
    criterion : str
        Stress criterion of the value.
    """

    labels: tuple[str, ...]
    time: Array
    value: Array
    low: Array
    high: Array
    level: float
    criterion: str

    def inside(self, truth: Array) -> Array:
        """Return the share of instants with a known truth (nt, ns) inside the band, by site."""
        good = np.isfinite(self.low) & np.isfinite(truth)
        within = (self.low <= truth) & (truth <= self.high) & good
        return np.asarray(within.sum(axis=0) / np.maximum(good.sum(axis=0), 1))

    def _csv(self) -> Rows:
        """Return the columns time, value, low and high of every site, s and MPa."""
        head = ["time s"]
        for label in self.labels:
            head += [f"{label} {self.criterion} MPa", f"{label} low MPa", f"{label} high MPa"]
        columns = np.stack([self.value, self.low, self.high], axis=2).reshape(len(self.time), -1)
        table = np.column_stack([self.time, 1e-6 * columns])
        return head, ([f"{x:.9g}" for x in row] for row in table)

    def __str__(self) -> str:
        width = max(4, *(len(label) for label in self.labels))
        lines = [
            f"{self.criterion}, {100 * self.level:g} % band, {len(self.time)} instants, MPa",
            f"{'site':<{width}}       min       max  half width of the band (mean, largest)",
        ]
        for i, label in enumerate(self.labels):
            half = 0.5e-6 * (self.high[:, i] - self.low[:, i])
            lines.append(
                f"{label:<{width}}  {1e-6 * np.nanmin(self.value[:, i]):8.2f}  "
                f"{1e-6 * np.nanmax(self.value[:, i]):8.2f}  {np.nanmean(half):8.3f} "
                f"{np.nanmax(half):8.3f}"
            )
        return "\n".join(lines)


@explained
def stress_band(
    estimate: Posterior,
    modes: StressModes | ReducedPart,
    criterion: Criterion = "von-mises",
    *,
    sites: Sequence[str] | str | None = None,
    level: float = 0.95,
    scale: float = 0.0,
) -> Band:
    """Return the stress of sites over time with its confidence band.

    Components and normal stresses of planes are exact: ``s = S p`` with the covariance
    ``S P S^T``, plus the model error (a strain) times the modulus. Criteria
    are linearised,
    ``var = g^T S P S^T g``, where their second-order bias is below a twentieth of the standard
    deviation, and sampled elsewhere (near zero a von Mises stress is not normally distributed).

    Parameters
    ----------
    estimate : Posterior
        Estimate from `Reconstruction.estimate`, `Observer.run` or `smooth`.
    modes : StressModes or ReducedPart
        Stress of the same modes.
    criterion : str or Plane
        Criterion as in `stress_field`: ``"s11"`` .. ``"s13"``, ``"von-mises"``,
        ``"signed-von-mises"``, ``"principal-1"`` .. ``"principal-3"``, ``"signed-principal"``,
        ``"max-shear"`` or a `Plane`.
    sites : sequence of str, optional
        Labels; None for all sites. For a whole surface over a long time use `stress_blocks`.
    level : float
        Share of the band.
    scale : float
        Relative standard deviation of the error common to all stresses, from Young's modulus and
        the common gauge factor: ``sqrt(s_E^2 + s_k^2)``, such as 0.03. Strains cannot reveal these
        errors. Errors of single gauges belong to `Reconstruction` (``errors=gauge_errors(..)``).

    Raises
    ------
    InputError
        For unknown criteria or sites, modes of another part, a level outside (0, 1), or a scale
        outside [0, 1).
    """
    labels, S, missed = _select_sites(estimate, modes, sites)
    _check(criterion, level, scale)
    size = 8 * len(estimate) * len(labels) * 3
    if size > 64 * BLOCK_BYTES:
        raise InputError(
            Problem(
                "stress_band",
                f"{len(labels)} sites x {len(estimate)} instants take {size / 2**30:.1f} GiB; name "
                "sites, or go through stress_blocks",
            )
        )
    value, low, high = (np.empty((len(estimate), len(labels))) for _ in range(3))
    for instants, places, block in _blocks(estimate, S, missed, criterion, level, scale):
        value[instants, places], low[instants, places], high[instants, places] = block
    return Band(labels, estimate.time, value, low, high, level, str(criterion))


def stress_blocks(
    estimate: Posterior,
    modes: StressModes | ReducedPart,
    criterion: Criterion = "von-mises",
    *,
    sites: Sequence[str] | str | None = None,
    level: float = 0.95,
    scale: float = 0.0,
) -> Iterator[tuple[slice, slice, tuple[Array, Array, Array]]]:
    """Yield value, low and high of blocks of instants and sites, for whole surfaces.

    Parameters
    ----------
    estimate, modes, criterion, sites, level, scale
        As for `stress_band`.

    Yields
    ------
    instants, places : slice
        Instants and places of the block.
    values : tuple of three (nt, ns) arrays
        Value, low and high end of the band, Pa.
    """
    _, S, missed = _select_sites(estimate, modes, sites)
    _check(criterion, level, scale)
    return _blocks(estimate, S, missed, criterion, level, scale)


def _blocks(
    estimate: Posterior, S: Array, missed: Array, criterion: Criterion, level: float, scale: float
) -> Iterator[tuple[slice, slice, tuple[Array, Array, Array]]]:
    z = _quantile(level)
    linear = weights(criterion)
    ns, nt, m = len(S), len(estimate), len(estimate.covariances)
    # covariances of the stress by blocks of sites, then of instants
    wide = max(1, BLOCK_BYTES // (8 * 36 * max(m, 1)))
    for first in range(0, ns, wide):
        places = slice(first, min(first + wide, ns))
        if linear is not None:
            row = np.einsum("c,scj->sj", linear, S[places])
            variance = np.einsum("sj,mjk,sk->ms", row, estimate.covariances, row, optimize=True)
            variance += (missed[places] ** 2) @ linear**2
            deviation = np.sqrt(np.maximum(variance, 0.0))
        else:
            half = np.einsum("sci,mij->mscj", S[places], estimate.covariances, optimize=True)
            cov = np.einsum("mscj,sdj->mscd", half, S[places], optimize=True)
            cov[..., np.arange(6), np.arange(6)] += missed[places] ** 2
        long = max(1, BLOCK_BYTES // (8 * 6 * 48 * max(places.stop - first, 1)))
        for start in range(0, nt, long):
            instants = slice(start, min(start + long, nt))
            p, which = estimate.p[instants], estimate.which[instants]
            if linear is not None:
                value = p @ row.T
                variance = deviation[which] ** 2 + (scale * value) ** 2
                own = estimate.systematic(row, instants)
                if own is not None:
                    variance = variance + np.sum(own**2, axis=-1)
                spread = z * np.sqrt(variance)
                yield instants, places, (value, value - spread, value + spread)
            else:
                s = np.einsum("tj,scj->tsc", p, S[places], optimize=True)
                root = covariance_roots(cov)[which]
                own = estimate.systematic(S[places], instants)
                more = [] if own is None else [own]
                more += [scale * s[..., None]] if scale else []
                root = np.concatenate([root, *more], axis=-1) if more else root
                yield instants, places, criterion_band(s, root, criterion, level)


def covariance_roots(cov: Array) -> Array:
    """Return matrix square roots (..., 6, 6) of covariances, with orthogonal columns.

    Cholesky factors with a result independent of the processor, also for equally uncertain
    directions; a component that earlier ones determine to 1e-6 has zero deviation.
    """
    L = np.zeros_like(cov)
    for j in range(cov.shape[-1]):
        row = L[..., j, :j]
        rest = cov[..., j, j] - np.sum(row * row, axis=-1)
        own = np.sqrt(np.where(rest > TINY * cov[..., j, j], rest, 0.0))
        L[..., j, j] = own
        below = cov[..., j + 1 :, j] - np.sum(L[..., j + 1 :, :j] * row[..., None, :], axis=-1)
        inverse = np.divide(1.0, own, out=np.zeros_like(own), where=own > 0.0)
        L[..., j + 1 :, j] = below * inverse[..., None]
    return L


def criterion_band(
    s: Array, root: Array, criterion: Criterion, level: float
) -> tuple[Array, Array, Array]:
    """Return value, low and high (nt, ns) of a criterion of stresses with covariance roots."""

    def f(x: Array) -> Array:
        return evaluate(x, criterion)

    # second differences along the roots give gradient and curvature
    steps = np.swapaxes(root, -1, -2)
    middle = s[..., None, :]
    all_ = f(np.concatenate([middle, middle + steps, middle - steps], axis=-2))
    size = np.sqrt(np.sum(root * root, axis=(-2, -1)))
    value, low, high, far = linear_band(np.moveaxis(all_, -1, 0), size, level)
    if not far.any():
        return value, clip_low(low, criterion), high
    bent = np.argwhere(far)
    k = root.shape[-1]
    root = np.broadcast_to(root, (*s.shape, k))
    points = sample_points(k)
    step = max(1, BLOCK_BYTES // (8 * k * len(points)))
    for first in range(0, len(bent), step):
        t, k = bent[first : first + step].T
        drawn = f(s[t, k][:, None] + points @ np.swapaxes(root[t, k], -1, -2))
        drawn.sort(axis=1)
        ends = np.quantile(drawn, [0.5 - 0.5 * level, 0.5, 0.5 + 0.5 * level], axis=1)
        low[t, k], value[t, k], high[t, k] = ends
    return value, clip_low(low, criterion), high


def linear_band(
    found: Array, size: Array, level: float
) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Return linearised value, low and high of a criterion, and a mask of strong curvature.

    Parameters
    ----------
    found : (1 + 2 k, ...) array
        Criterion in the middle, one deviation up along each of k roots, and down.
    size : array
        Standard deviation of the stress.
    level : float
        Share of the band.
    """
    k = len(found) // 2
    value, up, down = found[0], found[1 : 1 + k], found[1 + k :]
    slope, both = up - down, np.add.reduce(up + down)
    spread = 0.5 * _quantile(level) * np.sqrt(np.add.reduce(slope * slope))
    bias = 0.5 * both - k * value
    return value.copy(), value - spread, value + spread, np.abs(bias) > BENT * size


@cache
def _quantile(level: float) -> float:
    """Return the two-sided normal quantile of a confidence."""
    return float(ndtri(0.5 + 0.5 * level))


def clip_low(low: Array, criterion: Criterion) -> Array:
    """Return the lower end of a band, not below zero for criteria without sign."""
    return np.maximum(low, 0.0) if criterion in ("von-mises", "max-shear") else low


@cache
def sample_points(k: int) -> Array:
    """Return fixed, normally distributed sample points (DRAWS, k)."""
    u = qmc.Sobol(k, scramble=True, rng=1).random(DRAWS)
    return np.asarray(ndtri(np.clip(u, 1e-9, 1.0 - 1e-9)))


def _check(criterion: Criterion, level: float, scale: float = 0.0) -> None:
    problems = Problems()
    check_criterion(criterion, where="stress_band")
    if not 0.0 < level < 1.0:
        problems.add("stress_band", f"level is {level!r}, must be between 0 and 1, such as 0.95")
    if not 0.0 <= scale < 1.0:
        problems.add("stress_band", f"scale is {scale!r}, must be a share such as 0.03 for 3 %")
    problems.raise_if_any()


def _select_sites(
    estimate: Posterior, modes: StressModes | ReducedPart, sites: Sequence[str] | str | None
) -> tuple[tuple[str, ...], Array, Array]:
    """Return labels, stress modes (ns, 6, n) and stress of the model error (ns, 6)."""
    problems = Problems()
    where = "stress_band"
    known = modes.stress if isinstance(modes, ReducedPart) else modes
    if known is None:
        raise InputError(Problem(where, "the part has no stress data; use part.with_stress"))
    n = estimate.p.shape[1]
    if known.modes.shape[2] != n:
        problems.add(where, f"stress of {known.modes.shape[2]} modes, the estimate has {n}")
    place = {label: i for i, label in enumerate(known.labels)}
    labels = known.labels if sites is None else (sites,) if isinstance(sites, str) else tuple(sites)
    for label in labels:
        if label not in place:
            problems.add(where, f"no stress site '{label}'{suggest(label, place)}")
    if not labels:
        problems.add(where, "sites is empty; None takes all of them")
    problems.raise_if_any()
    chosen = [place[label] for label in labels]
    elasticity = None if known.elasticity is None else known.elasticity[chosen]
    missed = model_error_stress(estimate.missed, elasticity, len(labels), where)
    return tuple(labels), known.modes[chosen], missed


def model_error_stress(missed: float, elasticity: Array | None, ns: int, where: str) -> Array:
    """Return the stress (ns, 6) of a model error in strain, from E and nu (ns, 2)."""
    found = np.zeros((ns, 6))
    if missed > 0.0:
        if elasticity is None:
            raise InputError(
                Problem(where, "the model error is a strain, but the sites have no modulus")
            )
        E, nu = elasticity.T
        found[:, :3] = (E * missed)[:, None]
        found[:, 3:] = (E / (2.0 * (1.0 + nu)) * missed)[:, None]
    return found
