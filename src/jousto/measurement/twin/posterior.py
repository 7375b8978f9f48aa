"""The estimate of the modal coordinates: values and covariances over time."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.described import described


@described
@dataclass(frozen=True, eq=False)
class Posterior:
    """Modal coordinates over time with their covariance.

    Attributes
    ----------
    time : (nt,) array
        Instants, s; counted from 0 if no times were given.
    p : (nt, n) array
        Modal coordinates, kg^0.5 m; nan where they are unknown.
    covariances : (m, n, n) array
        The different covariances of p that occurred.
    which : (nt,) int array
        Which of them is valid at each instant.
    """

    time: Array
    p: Array
    covariances: Array
    which: NDArray[np.intp]

    def deviations(self, instants: slice) -> Array | None:
        """Return what errors of the gauges that stay through a record move p by.

        Parameters
        ----------
        instants : slice
            Which of the instants.

        Returns
        -------
        (nt, n, k) array or None
            One column for each independent error of standard deviation 1; None if there is none.
        """
        return None

    def systematic(self, S: Array, instants: slice) -> Array | None:
        """Return deviations by errors that stay, of what is linear in p by rows S (..., n).

        Parameters
        ----------
        S : (..., n) array
            Rows, such as those of the stress at sites.
        instants : slice
            Which of the instants.

        Returns
        -------
        (nt, ..., k) array or None
            As `deviations`.
        """
        moved = self.deviations(instants)
        if moved is None:
            return None
        return np.moveaxis(np.tensordot(moved, S, axes=([1], [S.ndim - 1])), 1, -1)

    @property
    def missed(self) -> float:
        """Standard deviation of the strain that the model misses anywhere, m/m."""
        return 0.0

    def __len__(self) -> int:
        return len(self.time)

    @property
    def covariance(self) -> Array:
        """Covariance of p at every instant (nt, n, n); large for long histories."""
        return np.asarray(self.covariances[self.which])

    @property
    def band(self) -> Array:
        """Standard deviation of p (nt, n)."""
        variances = np.einsum("mjj->mj", self.covariances)
        return np.asarray(np.sqrt(np.maximum(variances, 0.0))[self.which])


@described
@dataclass(frozen=True, eq=False)
class Told(Posterior):
    """Modal coordinates that gauges tell instant by instant, ``p = K e``.

    Attributes
    ----------
    gains : (m, n, ng) array, optional
        Modal coordinates per strain of each gauge, for each of the covariances.
    errors : (k, ng, n) array, optional
        As of `Reconstruction`.
    """

    gains: Array | None = field(default=None, kw_only=True)
    errors: Array | None = field(default=None, kw_only=True)

    def deviations(self, instants: slice) -> Array | None:
        """Return what the errors of the gauges move p by; see `Posterior.deviations`.

        An error ``v_g`` of gauge g moves p by ``K_g v_g``.
        """
        if self.errors is None or self.gains is None:
            return None
        # errors of one gauge (factor, place, angle) are independent: one deviation of their size
        size = np.sqrt(np.sum((self.p[instants] @ np.swapaxes(self.errors, 1, 2)) ** 2, axis=0))
        return np.asarray(self.gains[self.which[instants]] * size[:, None, :])
