"""Stress of a few sites with confidence bands, sample by sample, with precomputed data."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.special import ndtri

from jousto.base.arrays import Array
from jousto.base.object_repr import described
from jousto.measurement.twin.bands.bands import (
    clip_low,
    covariance_roots,
    criterion_band,
    linear_band,
    model_error_stress,
)
from jousto.model.native.recover import Recovery
from jousto.recovery.fields.criteria import Criterion, weights
from jousto.recovery.fields.kernels import kernel
from jousto.reduction.fields.stress import StressModes

KEPT = 256
"""Cache size: covariances with their roots."""


@described
class SpotBand:
    """Stress of a few sites with the band of `stress_band`, sample by sample.

    Parameters
    ----------
    modes : StressModes
        Stress modes of the sites.
    criterion, level, scale
        As for `stress_band`.
    missed : float
        Standard deviation of the strain that the model misses, m/m.
    """

    def __init__(
        self,
        modes: StressModes,
        criterion: Criterion,
        level: float,
        scale: float = 0.0,
        missed: float = 0.0,
    ) -> None:
        self.S, self.criterion, self.level, self.scale = modes.modes, criterion, level, scale
        self.n = self.S.shape[2]
        self._missed = model_error_stress(missed, modes.elasticity, len(self.S), "Monitor")
        self._z = float(ndtri(0.5 + 0.5 * level))
        self._weights = weights(criterion)
        rows = self.S.reshape(-1, self.n)
        if self._weights is not None:
            rows = np.einsum("c,scj->sj", self._weights, self.S)
        self._rows = np.ascontiguousarray(rows.T)
        # zero, then plus and minus each of the six roots of a site's stress
        self._unit = np.vstack([np.zeros((1, 6)), np.eye(6), -np.eye(6)])[:, None, :]
        self._kept: dict[bytes, Array] = {}
        self._kernels: dict[bytes, tuple[Recovery, Array, Array]] = {}

    @property
    def linear(self) -> bool:
        """Whether the criterion is a weighted sum of components."""
        return self._weights is not None

    @property
    def quantile(self) -> float:
        """Two-sided normal quantile of the confidence."""
        return self._z

    @property
    def rows(self) -> tuple[Array, Array]:
        """Mode rows and model-error variances: (ns, n) and (ns,) if linear, else with 6."""
        if self._weights is None:
            return self.S, self._missed**2
        return self._rows.T, self._missed**2 @ self._weights**2

    def __call__(self, p: Array, P: Array, moved: Array | None = None) -> tuple[Array, ...]:
        """Return value, low and high (k, ns), Pa.

        Parameters
        ----------
        p : (k, n) array
            Modal coordinates.
        P : (n, n) array
            Covariance of the modal coordinates.
        moved : (k, n, m) array, optional
            Deviations of the coordinates due to constant gauge errors.
        """
        if self._weights is None:
            return self._bent(p, P, moved)
        value = p @ self._rows
        spread = self._spread(P)
        if self.scale or moved is not None:
            variance = spread * spread + (self.scale * value) ** 2
            if moved is not None:
                variance += np.sum((np.swapaxes(moved, 1, 2) @ self._rows) ** 2, axis=1)
            spread = np.sqrt(variance)
        spread = self._z * spread
        return value, value - spread, value + spread

    def _spread(self, P: Array) -> Array:
        """Return the standard deviation (ns,) of a linear criterion."""
        key = P.tobytes()
        found = self._kept.get(key)
        if found is None:
            assert self._weights is not None
            variance = np.einsum("js,jk,ks->s", self._rows, P, self._rows)
            variance += self._missed**2 @ self._weights**2
            found = np.sqrt(np.maximum(variance, 0.0))
            _keep(self._kept, key, found)
        return found

    def _bent(self, p: Array, P: Array, moved: Array | None) -> tuple[Array, ...]:
        recovery, root, noise = self._kernel(P)
        n, k = self.n, len(p)
        steps = [] if moved is None else list(np.moveaxis(moved, 2, 0))
        steps += [self.scale * p] if self.scale else []
        more = np.array(steps).reshape(-1, k, n)
        # mean coordinates, then plus and minus each root
        count = 1 + 2 * (6 + len(more))
        q = np.empty((count, k, n + 6))
        q[:, :, :n] = p
        q[:, :, n:] = self._unit if not steps else 0.0
        if steps:
            q[1:7, :, n:], q[count // 2 + 1 : count // 2 + 7, :, n:] = (
                self._unit[1:7],
                self._unit[7:],
            )
            q[7 : count // 2 + 1, :, :n] += more
            q[count // 2 + 7 :, :, :n] -= more
        found = recovery.values(q.reshape(-1, n + 6)).reshape(count, k, -1)
        size = noise
        if steps:
            own = (more @ self._rows).reshape(len(more), k, -1, 6)
            size = np.sqrt(noise * noise + np.einsum("jtsc,jtsc->ts", own, own))
        value, low, high, far = linear_band(found, size, self.level)
        if np.count_nonzero(far):
            bent = far.any(axis=1)
            value[bent], low[bent], high[bent] = self._sampled_band(
                p[bent], root, None if moved is None else moved[bent]
            )
        return value, clip_low(low, self.criterion), high

    def _sampled_band(self, p: Array, root: Array, moved: Array | None) -> tuple[Array, ...]:
        """Return the sampled band at instants with strong curvature of the criterion."""
        s = (p @ self._rows).reshape(len(p), -1, 6)
        parts = [np.broadcast_to(root, (len(p), *root.shape))]
        if moved is not None:
            own = np.swapaxes(np.swapaxes(moved, 1, 2) @ self._rows, 1, 2)
            parts.append(own.reshape(len(p), -1, 6, moved.shape[2]))
        if self.scale:
            parts.append(self.scale * s[..., None])
        return criterion_band(s, np.concatenate(parts, axis=-1), self.criterion, self.level)

    def _kernel(self, P: Array) -> tuple[Recovery, Array, Array]:
        """Return ``[S R]`` as the engine reads it: roots R (ns, 6, 6) and their norms (ns,)."""
        key = P.tobytes()
        found = self._kernels.get(key)
        if found is None:
            cov = self.S @ P @ np.swapaxes(self.S, 1, 2)
            cov[:, np.arange(6), np.arange(6)] += self._missed**2
            root = covariance_roots(cov)
            size = np.sqrt(np.sum(root * root, axis=(1, 2)))
            found = kernel(np.concatenate([self.S, root], axis=2), self.criterion), root, size
            _keep(self._kernels, key, found)
        return found


def _keep(store: dict[bytes, Any], key: bytes, value: Any) -> None:
    if len(store) >= KEPT:
        store.clear()
    store[key] = value
