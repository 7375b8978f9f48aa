"""Variants: the machines of a model file for other values of its parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from jousto.base.described import described
from jousto.design.studies.parameter import Parameter
from jousto.mechanism.mechanism import Mechanism
from jousto.schema.file.document import Document


@described
@dataclass(frozen=True, eq=False)
class Variants:
    """A model file as a function of its parameters; can be pickled.

    Parameters
    ----------
    build : function
        Reads a document, `build_model`.
    document : Document
        The file, read once.
    parameters : tuple of Parameter
        What may be varied.
    rigid, trust : bool
        As in `read_model`.
    """

    build: Callable[..., Any]
    document: Document
    parameters: tuple[Parameter, ...]
    rigid: bool = False
    trust: bool = False

    @property
    def text(self) -> str:
        """The text of the file."""
        return self.document.text

    def make(
        self, values: Mapping[str, float], kept: dict[Any, Any]
    ) -> tuple[Mechanism, Any, tuple[Any, ...]]:
        """Return the mechanism, how it is simulated, and what is to be checked for fatigue.

        Parameters
        ----------
        values : mapping
            Values of parameters in SI.
        kept : dict
            Reduced parts of other variants by what the file says of them.

        Raises
        ------
        InputError
            What is wrong with these values, with lines.
        """
        file = self.build(
            self.document, rigid=self.rigid, trust=self.trust, parameters=values, kept=kept
        )
        checks = () if file.fatigue is None else file.fatigue.checks
        return file.mechanism, file.simulation, tuple(checks)
