"""Exceptions of reliability analyses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from jousto.base.arrays import Array
from jousto.base.errors import JoustoError


class LimitStateError(JoustoError):
    """Exception: a limit state failed or is not finite at some values of its variables.

    Attributes
    ----------
    x : dict of float
        The values.
    """

    def __init__(self, message: str, x: Mapping[str, float]) -> None:
        self.x = dict(x)
        super().__init__(message)


class DesignPointError(JoustoError):
    """Exception: the search for a design point failed.

    Attributes
    ----------
    u : (n,) array
        The last point, standard normal.
    history : list of tuple
        Iterations, with the columns of the result's history.
    """

    def __init__(self, message: str, u: Array, history: Sequence[tuple[float, ...]] = ()) -> None:
        self.u = u
        self.history = list(history)
        super().__init__(message)
