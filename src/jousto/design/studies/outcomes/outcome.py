"""Base class of the outcomes of a study."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from jousto.base.object_repr import described
from jousto.design.studies.case import Case


@described
class Outcome(ABC):
    """Base class: a number that a study computes at every point.

    Attributes
    ----------
    name : str
        Name of the column.
    needs_run : bool
        Whether the outcome needs a simulated run.
    """

    name: str
    needs_run: ClassVar[bool] = True

    @abstractmethod
    def value(self, case: Case) -> float:
        """Return the number at one point."""

    def unit(self, case: Case) -> str:
        """Return the SI unit of the number."""
        return "1"

    def check(self, case: Case) -> str:
        """Return the problem of the outcome for this machine, empty if there is none."""
        return ""
