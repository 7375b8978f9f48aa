"""Compiled models as C programs and functional mock-up units."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from jousto.base.errors import JoustoError

if TYPE_CHECKING:
    from jousto.export.ports import Named
    from jousto.measurement.monitor.monitor import Monitor
    from jousto.model.model import Model
    from jousto.simulation.solvers.base import Solver
    from jousto.simulation.state import State


def write_program(
    model: Model,
    path: str | Path,
    *,
    solver: Solver | None = None,
    state: State | None = None,
    name: str = "",
    named: Sequence[Named] = (),
) -> Path:
    """Write a compiled model as C99, see `jousto.export.project.write_program`."""
    from jousto.export.project import write_program as write

    return write(model, path, solver, state=state, name=name, named=named)


def write_twin(monitor: Monitor, path: str | Path, *, name: str = "") -> Path:
    """Write a monitor as C99, see `jousto.measurement.program.project.write_twin`."""
    from jousto.measurement.program.project import write_twin as write

    return write(monitor, path, name=name)


def write_fmu(
    model: Model,
    path: str | Path,
    *,
    solver: Solver | None = None,
    state: State | None = None,
    name: str = "",
    version: int = 3,
    on: Iterable[str] = ("here",),
    stop: float = 1.0,
    documents: dict[str, bytes] | None = None,
    derivatives: bool = False,
    named: Sequence[Named] = (),
) -> Path:
    """Write a functional mock-up unit with its picture, see `jousto.export.fmu.write_fmu`."""
    from jousto.export.fmu import PICTURES, write_fmu as write

    pictures = dict.fromkeys(PICTURES.get(version, ()), picture(model, state))
    documents = {**{k: v for k, v in pictures.items() if v}, **(documents or {})}

    return write(
        model,
        path,
        solver,
        state=state,
        name=name,
        version=version,
        on=on,
        stop=stop,
        documents=documents,
        derivatives=derivatives,
        named=named,
    )


def picture(model: Model, state: State | None = None) -> bytes:
    """Return a PNG of a machine at its start; empty if it has no visible shape."""
    from jousto.output.scenes.animate import still
    from jousto.scene.machine import at_state

    with tempfile.TemporaryDirectory(prefix="jousto-picture-") as folder:
        try:
            made = still(at_state(model, state), Path(folder) / "model.png", times=[0.0])
        except JoustoError:
            return b""
        return made.read_bytes()
