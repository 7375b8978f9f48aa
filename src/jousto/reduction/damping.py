"""Modal damping: the diagonal D of the modal forces ``-K p - D p'``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jousto.base.arrays import Array, frozen
from jousto.base.complexstep import floats
from jousto.base.declare import Declared
from jousto.base.errors import InputError, Problem, warn
from jousto.base.fields import field
from jousto.base.numbers import Number

# largest damping ratio; larger values are not even percentages and would suppress all motion
MOST = 100.0


class Rayleigh(Declared, section="damping", tag="rayleigh", by_value=True):
    """Damping proportional to mass and stiffness, ``D = alpha M + beta K``.

    Mode j has ``D_j = alpha + beta omega_j^2``, that is the damping ratio
    ``alpha / (2 omega_j) + beta omega_j / 2``.

    Raises
    ------
    InputError
        If a coefficient is negative or not finite.

    Examples
    --------
    Two per cent at 5 Hz and at 50 Hz:

    >>> r = Rayleigh.from_ratios((5.0, 0.02), (50.0, 0.02))
    >>> np.round(modal_damping(r, [5.0, 50.0]) / (4.0 * np.pi * np.array([5.0, 50.0])), 6)
    array([0.02, 0.02])
    """

    alpha: Number = field("Mass coefficient", unit="1/s", least=0, wanted="0 or positive")
    beta: Number = field("Stiffness coefficient", unit="s", least=0, wanted="0 or positive")

    @classmethod
    def from_ratios(cls, first: tuple[float, float], second: tuple[float, float]) -> Rayleigh:
        """Return the damping with given ratios at two frequencies.

        Parameters
        ----------
        first, second : tuple of float
            Frequency in Hz and damping ratio.

        Raises
        ------
        InputError
            If the frequencies are equal or not positive, or a coefficient would be negative.
        """
        (f1, z1), (f2, z2) = first, second
        if not (f1 > 0.0 and f2 > 0.0 and f1 != f2):
            message = f"frequencies are {f1:g} and {f2:g} Hz, must be positive and different"
            raise InputError(Problem("Rayleigh.from_ratios", message))
        w = 2.0 * np.pi * np.array([f1, f2])
        alpha, beta = np.linalg.solve(np.column_stack([0.5 / w, 0.5 * w]), [z1, z2])
        return cls(float(alpha), float(beta))


Damping = float | Sequence[float] | Array | Rayleigh
"""One damping ratio for all modes, one ratio per mode, or Rayleigh damping."""


def modal_damping(spec: Damping, frequencies: Sequence[float] | Array) -> Array:
    """Return the diagonal of the modal damping matrix, ``D_j = 2 zeta_j omega_j``.

    Parameters
    ----------
    spec : float, sequence of float or Rayleigh
        Damping ratio (1 is critical) of all modes, one ratio per mode, or Rayleigh damping.
    frequencies : (n,) array
        Undamped frequencies, Hz.

    Returns
    -------
    (n,) array
        1/s, read-only.

    Raises
    ------
    InputError
        If ratios are negative, not finite, or not one per mode.

    Examples
    --------
    >>> modal_damping(0.01, [10.0]).round(6)
    array([1.256637])
    """
    f = floats(frequencies)
    omega = 2.0 * np.pi * f
    if isinstance(spec, Rayleigh):
        D = spec.alpha + spec.beta * omega**2
    else:
        try:
            zeta = floats(spec)
        except (TypeError, ValueError):
            message = f"{spec!r} is neither a ratio, nor a list of ratios, nor Rayleigh(...)"
            raise InputError(Problem("damping", message)) from None
        if zeta.ndim > 1 or (zeta.ndim == 1 and zeta.shape != f.shape):
            shape = zeta.shape
            message = f"{shape[0]} ratios for {len(f)} modes" if zeta.ndim == 1 else f"{shape}"
            raise InputError(Problem("damping", f"{message}: give one ratio, or one per mode"))
        bad = np.flatnonzero(~(np.isfinite(zeta) & (zeta >= 0.0)))
        if len(bad):
            value = zeta.flat[bad[0]]
            raise InputError(Problem("damping", f"the ratio {value:g} must be 0 or positive"))
        if zeta.max(initial=0.0) > MOST:
            message = f"the ratio {zeta.max():g} must be at most {MOST:g}"
            raise InputError(Problem("damping", f"{message}: 1 is critical, 2 % is 0.02"))
        if zeta.max(initial=0.0) > 1.0:
            warn("damping", f"the ratio {zeta.max():g} is above 1 (is it in per cent?)", "damping")
        D = np.broadcast_to(2.0 * zeta * omega, f.shape).copy()
    return frozen(np.array(floats(D)))
