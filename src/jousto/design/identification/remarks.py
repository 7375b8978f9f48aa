"""Remarks on a result: what an engineer must know before the numbers are used."""

from __future__ import annotations

import numpy as np

from jousto.base.errors import count
from jousto.design.identification.identified import WHITE, Fit, Identified
from jousto.design.identification.modal import ModalBench
from jousto.design.identification.residuals import Residuals
from jousto.design.studies.parameters.parameter import Parameter

ALIKE = 0.6
"""Assurance criterion below which two modes are not the same."""
NEAR = 1e-3
"""Share of the size of an unknown within which it is on its bound."""


def troubles(found: Identified, residuals: Residuals) -> list[str]:
    """Return what must be looked at before the numbers are used."""
    return [
        *_bounds(found),
        *_noise(found, residuals),
        *_signs(found, residuals),
        *_white(found),
        *_unlike(residuals, found),
    ]


def asides(found: Identified) -> list[str]:
    """Return how the measurement was taken."""
    return [
        f"'{fit.channel}': {count(fit.outside, 'sample')} outside of the run are left out"
        for fit in found.fits
        if fit.outside
    ]


def _bounds(found: Identified) -> list[str]:
    lines = []
    for own, u in zip(found.unknowns, found.u, strict=True):
        for side, end in zip(("lower", "upper"), own.ends, strict=True):
            if np.isfinite(end) and abs(u - end) < NEAR * own.size:
                lines.append(
                    f"'{own.name}' ends on its {side} bound {own.theta(end):.6g}; the interval is "
                    "one-sided"
                )
    return lines


def _noise(found: Identified, residuals: Residuals) -> list[str]:
    """Return remarks on noise that is not as large as given."""
    lines = []
    for fit, one in zip(found.fits, residuals.compared, strict=True):
        rms = fit.test.rms
        if one.about.sd is not None and abs(rms**2 - 1.0) > 4.0 * np.sqrt(2.0 / len(fit.time)):
            lines.append(
                f"residuals of '{fit.channel}' are {rms:.3g} times the sd that is given; intervals "
                "use the residuals"
            )
    return lines


def _signs(found: Identified, residuals: Residuals) -> list[str]:
    """Return remarks on channels that fit better with the other sign."""
    lines = []
    for fit, one in zip(found.fits, residuals.compared, strict=True):
        if isinstance(one.about.gain, Parameter):
            k = found.names.index(one.about.gain.name)
            if found.u[k] < 0.0 and not found.unknowns[k].log:
                lines.append(_turned(fit, found.u[k]))
            continue
        gain = _best_gain(fit)
        if gain < -0.5 and fit.test.explained < 0.0:
            lines.append(_turned(fit, gain))
    return lines


def _best_gain(fit: Fit) -> float:
    """Return the factor on the fitted curve that is nearest to the measurement."""
    good = np.isfinite(fit.fitted)
    a, b = fit.fitted[good], fit.measured[good]
    a, b = a - a.mean(), b - b.mean()
    size = float(a @ a)
    return float(a @ b) / size if size > 0.0 else 0.0


def _turned(fit: Fit, gain: float) -> str:
    return (
        f"'{fit.channel}' fits with gain {gain:.3g}: wired with the other sign? Compare with "
        f"'-{fit.channel}'"
    )


def _white(found: Identified) -> list[str]:
    bad = [fit.channel for fit in found.fits if fit.test.p < WHITE]
    if not bad:
        return []
    names = ", ".join(f"'{name}'" for name in bad)
    return [
        f"residuals of {names} are not white: the model lacks something, or the noise remembers; "
        "intervals allow for that memory, not for a wrong model"
    ]


def _unlike(residuals: Residuals, found: Identified) -> list[str]:
    """Return remarks on measured modes whose shape no mode of the machine has."""
    lines = []
    theta = residuals.theta(found.u)
    for bench in residuals.benches:
        if not isinstance(bench, ModalBench):
            continue
        (result,) = bench.results([theta])
        for i, value in enumerate(result.mac):
            if value < ALIKE:
                lines.append(
                    f"mode {i + 1} of {bench.name!r} has MAC {value:.2f} with its mode of the "
                    "machine: not the same mode?"
                )
    return lines
