"""What goes wrong in a reliability analysis, beyond wrong input."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from jousto.base.arrays import Array
from jousto.base.errors import JoustoError


class LimitStateError(JoustoError):
    """A limit state failed, or gave no number, at some values of its variables.

    Attributes
    ----------
    x : dict of float
        The values.
    """

    def __init__(self, message: str, x: Mapping[str, float]) -> None:
        self.x = dict(x)
        super().__init__(message)


class DesignPointError(JoustoError):
    """No design point was found.

    Attributes
    ----------
    u : (n,) array
        The last point, standard normal.
    history : list of tuple
        What was tried: as in the result.
    """

    def __init__(self, message: str, u: Array, history: Sequence[tuple[float, ...]] = ()) -> None:
        self.u = u
        self.history = list(history)
        super().__init__(message)
