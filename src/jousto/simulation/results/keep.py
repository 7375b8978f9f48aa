"""Where a run keeps its results: in memory, or in a file if one is asked for or they are large."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.model.model import Model
from jousto.simulation.results.columns import columns
from jousto.simulation.results.memory import MemoryWriter
from jousto.simulation.results.solution import Solution
from jousto.simulation.results.writer import Facts, ResultsWriter

IN_MEMORY = 256 << 20  # bytes of results that stay in memory


class Keeper:
    """Takes the rows of a run and returns them as a `Solution`.

    Parameters
    ----------
    path : path or None
        File for the results; None keeps up to 256 MB in memory and more in a temporary file.
    model : Model
        The model.
    rows : int
        Number of instants at most.
    attributes : dict
        What is known before the run: solver, step ...
    text : str
        Text of the model file.

    Raises
    ------
    InputError
        If the file cannot be written or the disk has no room for it.
    """

    def __init__(
        self,
        path: str | Path | None,
        model: Model,
        rows: int,
        attributes: dict[str, Any],
        text: str = "",
    ) -> None:
        last = columns(model)[-1]
        self._folder: Path | None = None
        self._writer: ResultsWriter | MemoryWriter
        if path is None and 8 * rows * (last.first + last.count) <= IN_MEMORY:
            self._writer = MemoryWriter(model, rows, attributes, text)
            self.place = "the `solution` of this error"
            return
        if path is None:
            self._folder = Path(tempfile.mkdtemp(prefix="jousto-"))
        target = self._folder / "run.h5" if self._folder else Path(path or "")
        self.place = str(target)
        try:
            self._writer = ResultsWriter(target, model, rows, attributes, text)
        except BaseException:
            self.discard()
            raise

    @property
    def happened(self) -> int:
        """How many events were noted."""
        return len(self._writer.happened)

    def append(self, rows: NDArray[np.float64]) -> None:
        """Add rows (k, row_size) of the engine."""
        self._writer.append(rows)

    def note(self, happened: NDArray[np.float64]) -> None:
        """Add what happened (k, 4): time, source, change and count."""
        self._writer.note(happened)

    def close(self, complete: bool, facts: Facts) -> Solution:
        """Note how the run ended and return its results."""
        if isinstance(self._writer, MemoryWriter):
            return Solution(self._writer.close(complete, facts))
        self._writer.close(complete, facts)
        return Solution(self._writer.path, temporary=self._folder is not None)

    def discard(self) -> None:
        """Remove a temporary file that nobody has got."""
        if self._folder:
            shutil.rmtree(self._folder, ignore_errors=True)
