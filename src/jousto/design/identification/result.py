"""Result at a minimum: how sure it is, and the tests of its residuals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.design.identification.certainty import certainty
from jousto.design.identification.identified import Fit, Identified
from jousto.design.identification.residuals import Residuals
from jousto.design.identification.search import Minimum, priors, robust
from jousto.design.identification.whiteness import whiteness


def result_at(
    residuals: Residuals,
    best: Minimum,
    others: Sequence[Minimum],
    loss: str,
    estimated: tuple[bool, ...],
    checks: Residuals | None,
) -> Identified:
    """Return the result at the minimum: how sure it is, and the tests of its residuals."""
    u, sought = best.u, residuals.unknowns
    J = residuals.jacobian(u, central=True)
    r = residuals.values(u)
    _, first, second = robust(loss, r**2)
    psi, curvature = first * r, first + 2.0 * second * r**2
    n = len(r)
    fits = _fits(residuals, u, len(sought))
    trusted = []
    for fit, free in zip(fits, estimated, strict=True):
        spread = 4.0 * np.sqrt(2.0 / max(len(fit.time), 1))
        trusted.append(loss == "linear" and (free or abs(fit.test.rms**2 - 1.0) < spread))
    sure = certainty(J, priors(sought, u)[1], psi, curvature, residuals.sizes, sought, u, trusted)
    dof = n - sum(fit.outside for fit in fits) - len(sought)
    dof -= sum(bench.scales for bench in residuals.benches)
    runs = sum(
        {id(b.evaluator.memory): b.evaluator.counts["runs"] for b in residuals.benches}.values()
    )
    minima = tuple(
        (
            {own.name: own.theta(x) for own, x in zip(sought, one.u, strict=True)},
            2.0 * one.F / max(dof, 1),
        )
        for one in others
    )
    return Identified(
        sought,
        u,
        sure,
        fits,
        () if checks is None else _fits(_as_fitted(checks, residuals), u, 0),
        float(r @ r),
        dof,
        any(estimated),
        minima,
        (),
        runs,
        best.jacobians + 1,
        0.0,
        loss,
        residuals,
    )


def _as_fitted(checks: Residuals, fitted: Residuals) -> Residuals:
    """Return the residuals of check records with the method and the estimated noise of the fit."""
    solver = fitted.solver
    made = checks if solver is None else checks.with_solver(solver)
    noise = {one.about.channel: float(np.mean(one.sd)) for one in fitted.compared}
    compared = []
    for one in made.compared:
        if one.about.sd is None and one.about.channel in noise:
            one = replace(one, sd=np.full(len(one.sd), noise[one.about.channel]))
        compared.append(one)
    return replace(made, compared=tuple(compared))


def _fits(residuals: Residuals, u: Array, unknowns: int) -> tuple[Fit, ...]:
    """Return measured and fitted values of all comparisons, with the tests of the residuals."""
    (shown,) = residuals.shown([u])
    if isinstance(shown, Exception):
        raise InputError(Problem("identify", " / ".join(str(shown).splitlines())))
    r = residuals.of(shown, u)
    n, first = len(r), 0
    fits: list[Fit] = []
    for one, (values, _) in zip(residuals.compared, shown, strict=True):
        about = one.about
        own = r[first : first + len(values)]
        first += len(values)
        there = np.isfinite(values)
        fits.append(
            Fit(
                residuals.benches[one.bench].name,
                about.channel,
                about.sensor,
                about.unit,
                about.time,
                about.y,
                np.where(there, about.y + own * one.sd, np.nan),
                one.sd,
                whiteness(own[there], about.y[there], one.sd[there], unknowns * len(own) / n),
                int(np.count_nonzero(~there)),
            )
        )
    return tuple(fits)
