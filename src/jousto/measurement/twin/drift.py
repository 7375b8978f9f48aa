"""What errors of the gauges that stay do to a filter and to a smoother, exactly to first order."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array
from jousto.measurement.twin.kalman import Channels, Gain


def drifted(before: Array, gain: Gain, channels: Channels, errors: Array, p: Array) -> Array:
    """Return how far each error moves the state after one sample.

    The filter is linear: ``D = F D_before``, then ``D + K (V - H D)`` with what the errors add to
    the channels, ``V_g = E_g p``; the gain does not know of them.

    Parameters
    ----------
    before : (nx, k ng) array
        That of the sample before; zero at the first.
    gain : Gain
        Of this sample.
    channels : Channels
        Gauges first.
    errors : (k, ng, n) array
        From `gauge_errors`.
    p : (n,) array
        Modal coordinates now.
    """
    kinds, ng, _ = errors.shape
    D = gain.F @ before
    V = np.zeros((len(gain.mask), kinds, ng))
    each = np.arange(ng)
    V[each, :, each] = (errors @ p).T
    seen = gain.mask
    shown = V.reshape(len(V), -1)[seen] - channels.H[seen] @ D
    return np.asarray(D + gain.K @ shown)


def drifts(gains: tuple[Gain, ...], channels: Channels, errors: Array, p: Array) -> Array:
    """Return `drifted` (nt, nx, k ng) over a record of modal coordinates p (nt, n)."""
    D = np.zeros((len(gains[0].P), errors.shape[0] * errors.shape[1]))
    found = np.empty((len(gains), *D.shape))
    for k, gain in enumerate(gains):
        D = found[k] = drifted(D, gain, channels, errors, p[k])
    return found
