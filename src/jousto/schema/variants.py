"""Variants: mechanisms of a model file for other parameter values."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jousto.base.errors import InputError
from jousto.base.object_repr import described
from jousto.design.studies.parameters.parameter import Parameter
from jousto.mechanism.mechanism import Mechanism
from jousto.schema.file.document import DOCUMENTS, Document, read_document
from jousto.schema.file.parameters import expand

if TYPE_CHECKING:
    from jousto.parts.part import Part


@described
@dataclass(frozen=True, eq=False)
class Variants:
    """Model file as a function of its parameters; can be pickled.

    Parameters
    ----------
    build : function
        Function that builds a document, `build_model`.
    document : Document
        The file, read once.
    parameters : tuple of Parameter
        Parameters that may be varied.
    rigid, trust : bool
        As in `read_model`.
    unused : tuple of str
        Names of parameters without effect on the machine.
    """

    build: Callable[..., Any]
    document: Document
    parameters: tuple[Parameter, ...]
    rigid: bool = False
    trust: bool = False
    unused: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        """Hash of the file's text, of every file it names, and of the reading options."""
        data = expand(self.document).document.data
        files = contents(data, self.document.folder, {})
        from jousto.reduction.files.cache import key  # slow import, needed by studies only

        return key(self.document.text, files, self.rigid, self.trust)

    def parts(self, values: Mapping[str, float]) -> dict[str, Part]:
        """Return the parts of flexible bodies with a mesh, by body name."""
        from jousto.schema.bodies import parts_of  # late import: reading files creates variants

        return parts_of(self.document, values, self.trust)

    def make(
        self, values: Mapping[str, float], kept: dict[Any, Any]
    ) -> tuple[Mechanism, Any, tuple[Any, ...]]:
        """Return mechanism, simulation settings and fatigue checks for parameter values.

        Parameters
        ----------
        values : mapping
            Values of parameters in SI.
        kept : dict
            Reduced parts of other variants, by their entries in the file.

        Raises
        ------
        InputError
            With all problems of these values and their lines.
        """
        file = self.build(
            self.document, rigid=self.rigid, trust=self.trust, parameters=values, kept=kept
        )
        checks = () if file.fatigue is None else file.fatigue.checks
        return file.mechanism, file.simulation, tuple(checks)


def contents(data: Any, folder: Path, found: dict[str, str]) -> dict[str, str]:
    """Return hashes, by path, of the files named in data, and of the files that they name."""
    if isinstance(data, Mapping):
        data = list(data.values())
    if isinstance(data, list):
        for item in data:
            contents(item, folder, found)
    if not isinstance(data, str) or not data or "\0" in data or "\n" in data:
        return found
    try:
        path = folder / data
        name = str(path.resolve())
        if name in found or not path.is_file():
            return found
        with path.open("rb") as file:
            found[name] = hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:  # no file name, or an unreadable file
        return found
    if path.suffix.lower() in DOCUMENTS:
        with suppress(InputError):  # the reader of the file reports its problems
            contents(read_document(path).data, path.parent, found)
    return found
