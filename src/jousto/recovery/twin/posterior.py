"""What a twin knows of the modal coordinates: values and covariances over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Posterior:
    """Modal coordinates over time with their covariance.

    Attributes
    ----------
    time : (nt,) array
        Instants, s; counted from 0 if no times were given.
    p : (nt, n) array
        Modal coordinates, kg^0.5 m; nan where they cannot be told.
    covariances : (m, n, n) array
        The different covariances of p that occurred.
    which : (nt,) int array
        Which of them holds at each instant.
    """

    time: Array
    p: Array
    covariances: Array
    which: NDArray[np.intp]

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
            One column for each independent error of standard deviation 1; None if there is none.
        """
        return None

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
