"""What every outcome of a study is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from jousto.base.object_repr import described
from jousto.design.studies.case import Case


@described
class Outcome(ABC):
    """A number that a study wants to know of every point.

    Attributes
    ----------
    name : str
        Of its column.
    needs_run : bool
        Whether the model is simulated for it.
    """

    name: str
    needs_run: ClassVar[bool] = True

    @abstractmethod
    def value(self, case: Case) -> float:
        """Return it for one point."""

    def unit(self, case: Case) -> str:
        """Return its SI unit."""
        return "1"

    def check(self, case: Case) -> str:
        """Return what is wrong with it for this machine, empty if nothing is."""
        return ""
