"""Health states of measured channels by the engine, sample by sample."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.model.native import library

FOLLOW = 0.02  # weight of a new sample in the usual step length of a channel
WARM = 50  # number of samples before spikes are detected
PERSIST = 3  # number of samples at a new level that make a jump real


class HealthCheck:
    """Check of the credibility of every value of measured channels.

    Parameters
    ----------
    rules : ChannelRules
        Rules with `range` (m/m), `stuck` (samples), `spike` (usual steps) and `back` (samples).
    cells : tuple of two int
        Codes of an empty cell and of an infinite value.
    """

    def __init__(self, rules: Any, *, cells: tuple[int, int]) -> None:
        self._library, self._ffi = library.real_library(), library.ffi()
        r = self._ffi.new("jo_health *")
        r.empty, r.infinite = cells
        r.range, r.stuck, r.spike, r.back = rules.range, rules.stuck, rules.spike, rules.back
        r.follow, r.warm, r.persist = FOLLOW, WARM, PERSIST
        self.rule = r

    def __call__(
        self,
        memory: NDArray[np.float64],
        before: NDArray[np.uint8],
        values: NDArray[np.float64],
        cells: NDArray[Any] | None,
    ) -> NDArray[np.uint8]:
        """Return the states (k, n) of values (k, n); `memory` (8, n) is updated.

        Parameters
        ----------
        memory : (8, n) array
            Memory of jo_health_check, contiguous.
        before : (n,) uint8 array
            States of the previous sample.
        values : (k, n) array
        cells : (k, n) array
            Codes of the cells; None if all cells have values.
        """
        x = np.ascontiguousarray(values, dtype=np.float64)
        kind = None if cells is None else np.ascontiguousarray(cells, dtype=np.uint8)
        old = np.ascontiguousarray(before, dtype=np.uint8)
        states = np.empty(x.shape, dtype=np.uint8)
        view = self._ffi.from_buffer
        self._library.jo_health_check(
            self.rule,
            view("double[]", memory),
            view("unsigned char[]", old),
            view("double[]", x),
            self._ffi.NULL if kind is None else view("unsigned char[]", kind),
            view("unsigned char[]", states, require_writable=True),
            len(x),
            x.shape[1],
        )
        return states
