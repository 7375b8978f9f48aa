"""Search of the best values: weighted least squares with priors, bounds and robust losses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.design.identification.residuals import Residuals
from jousto.design.identification.unknowns import Unknown

STAGES = (0.125, 0.25, 0.5)
"""Shares of the record that are fitted first: over a long one what oscillates has false minima."""
FEWEST = 8
"""Samples for each unknown that a stage must have."""
LOSSES = ("linear", "huber", "soft_l1", "cauchy")
NEAR, ROUGH = 1e-8, 1e-3
"""Relative change of coordinates and sum of squares that ends the search: of all, and of a part."""
MOST = 200
"""Largest number of trials of one search."""


@dataclass(frozen=True, eq=False)
class Minimum:
    """End of one search.

    Attributes
    ----------
    u : (p,) array
        Coordinates.
    F : float
        ``1/2 sum rho(r) + 1/2 prior``.
    trials, jacobians : int
        Numbers of trials and of Jacobians.
    message : str
        Why the search ended.
    ended : bool
        Whether it reached a minimum.
    """

    u: Array
    F: float
    trials: int
    jacobians: int
    message: str
    ended: bool


def search(
    residuals: Residuals,
    u0: Array,
    loss: str = "linear",
    *,
    hold: float = 0.0,
    near: float = NEAR,
) -> Minimum:
    """Return the minimum found from start values.

    Parameters
    ----------
    residuals : Residuals
    u0 : (p,) array
        Start values.
    loss : str
        Loss of the residuals, see `LOSSES`; the prior stays quadratic.
    hold : float
        Weight of the start values: residuals ``hold (u - u0) / size``.
    near : float
        Relative change at which the search ends.

    Raises
    ------
    InputError
        If the runs fail at the start values.
    """
    from scipy.optimize import least_squares

    unknowns = residuals.unknowns
    ends = np.array([own.ends for own in unknowns]).T
    sizes = np.array([own.size for own in unknowns])

    def prior(u: Array) -> tuple[Array, Array]:
        r, J = priors(unknowns, u)
        if hold:
            r = np.concatenate([r, hold * (u - u0) / sizes])
            J = np.vstack([J, np.diag(hold / sizes)])
        return r, J

    n = sum(residuals.sizes)

    def rho(z: Array) -> Array:
        """Return the loss and its two derivatives by the squared residuals; priors are linear."""
        found = np.vstack([z, np.ones_like(z), np.zeros_like(z)])
        found[:, :n] = robust(loss, z[:n])
        return found

    if not np.all(np.isfinite(residuals.values(u0))):
        reason = residuals.failures[-1]
        values = ", ".join(
            f"{own.name} {own.theta(x):.6g}" for own, x in zip(unknowns, u0, strict=True)
        )
        raise InputError(Problem("identify", f"the run fails at {values}: {reason}"))

    def both(u: Array) -> Array:
        return np.concatenate([residuals.values(u), prior(u)[0]])

    def slopes(u: Array) -> Array:
        return np.vstack([residuals.jacobian(u), prior(u)[1]])

    given: Any = "linear" if loss == "linear" else rho
    found: Any = least_squares(
        both,
        np.clip(u0, *ends),
        slopes,
        bounds=(ends[0], ends[1]),
        method="trf",
        x_scale="jac",
        loss=given,
        ftol=near,
        xtol=near,
        gtol=None,
        max_nfev=MOST,
    )
    return Minimum(
        found.x,
        float(found.cost),
        int(found.nfev),
        int(found.njev),
        str(found.message),
        found.status > 0,
    )


def priors(unknowns: Sequence[Unknown], u: Array) -> tuple[Array, Array]:
    """Return the residuals (m,) of prior knowledge and their derivatives (m, p) by u."""
    found = [(k, own.prior(x)) for k, (own, x) in enumerate(zip(unknowns, u, strict=True))]
    known = [(k, *one) for k, one in found if one is not None]
    r, J = np.array([x for _, x, _ in known]), np.zeros((len(known), len(u)))
    for i, (k, _, slope) in enumerate(known):
        J[i, k] = slope
    return r, J


def loss_at(residuals: Residuals, u: Array, loss: str) -> float:
    """Return ``F = 1/2 sum rho(r^2) + 1/2 sum prior^2`` at u."""
    r = priors(residuals.unknowns, u)[0]
    return 0.5 * float(robust(loss, residuals.values(u) ** 2)[0].sum() + r @ r)


def robust(loss: str, z: Array) -> Array:
    """Return a loss and its first two derivatives (3, n) by the squared residuals z."""
    one = np.ones_like(z)
    if loss == "linear":
        return np.vstack([z, one, 0.0 * one])
    if loss == "soft_l1":
        t = 1.0 + z
        return np.vstack([2.0 * (np.sqrt(t) - 1.0), t**-0.5, -0.5 * t**-1.5])
    if loss == "cauchy":
        t = 1.0 + z
        return np.vstack([np.log1p(z), 1.0 / t, -1.0 / t**2])
    small = z <= 1.0
    root = np.sqrt(np.where(small, 1.0, z))
    return np.vstack(
        [np.where(small, z, 2.0 * root - 1.0), 1.0 / root, np.where(small, 0.0, -0.5 * root**-3)]
    )


def staged(residuals: Residuals, u0: Array) -> Minimum:
    """Return the minimum of the linear loss, searched over growing shares of the record."""
    u = u0
    for share in STAGES:
        part = residuals.until(share)
        if part.sizes == residuals.sizes or sum(part.sizes) < FEWEST * len(u):
            continue
        part.failures = residuals.failures
        u = search(part, u, hold=1.0, near=ROUGH).u
    return search(residuals, u)
