"""Files that are shown: whether another run has taken the place of one, and what is in them now."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jousto.base.errors import InputError, JoustoError, Problem
from jousto.schema.output_paths import DAMAGED, RESULTS, hdf5_format

if TYPE_CHECKING:
    from jousto.scene.scene import Scene
    from jousto.simulation.results.solution import Solution


class Renewed(InputError):
    """What is shown has changed: the page has to be loaded again."""


class Watched:
    """The files behind a page.

    Parameters
    ----------
    files : sequence of path
        What is shown of files.
    make : callable
        Returns the scenes of everything that is shown, from the files as they are.
    """

    def __init__(self, files: Sequence[Path], make: Callable[[], list[Scene]]) -> None:
        self._make = make
        self._known = {file: (stamp(file), mark(file)) for file in files}
        self._changed: Path | None = None

    def changed(self) -> Path | None:
        """Return a file that contains something else than it did, None if there is none.

        A file that cannot be read now, as it is just being written, has not changed yet.
        """
        for file, (seen, known) in self._known.items():
            now = stamp(file)
            if now == seen:
                continue
            found = mark(file)
            if found is None:
                continue
            if found != known:
                return file
            self._known[file] = (now, known)
        return None

    def scenes(self) -> list[Scene]:
        """Return what is in the files now.

        Raises
        ------
        JoustoError
            If that cannot be shown.
        """
        found = {file: (stamp(file), mark(file)) for file in self._known}
        scenes = self._make()
        self._known = found
        return scenes


def stamp(file: Path) -> tuple[int, ...] | None:
    """Return what changes whenever a file is written; None if it is gone."""
    try:
        about = file.stat()
    except OSError:
        return None
    return about.st_mtime_ns, about.st_size, about.st_ino


def mark(file: Path) -> Any:
    """Return what tells contents of a file apart: of results their run; None if it is not whole."""
    kind = hdf5_format(file)
    if kind != RESULTS:
        broken = kind == DAMAGED or (file.suffix.lower() in (".h5", ".hdf5") and not kind)
        return None if broken else stamp(file)
    from jousto.simulation.results.validate import open_results

    try:
        with open_results(file) as results:
            return str(results.attrs["run"])
    except (JoustoError, OSError, KeyError):
        return None


def unended(run: Solution | None) -> str:
    """Return a sentence on a run that has no end, because it still goes on or was killed."""
    if run is None or run.complete:
        return ""
    last = float(run.time[-1]) if run.nt else 0.0
    text = (
        f"{run.where}: the run has no end, it still goes on or was killed; the {run.nt} instants "
    )
    text += f"up to {last:.6g} s are shown"
    try:
        about = Path(run.where).stat()
        used = 512 * about.st_blocks
    except (OSError, AttributeError):
        return text
    if about.st_size > 2 * used + (1 << 20):
        text += (
            f". Its {about.st_size / 1e6:.0f} MB are mostly room that takes none of the disk "
            f"({used / 1e6:.1f} MB do); copy it with a program that keeps such holes"
        )
    return text


def alike(scenes: Sequence[Scene]) -> None:
    """Check that scenes can be drawn over one another.

    Raises
    ------
    InputError
        If they are of different kinds.
    """
    words = {"run": "a run", "model": "a model", "part": "a part", "modes": "modes"}
    kinds = [scene.what for scene in scenes]
    if len(set(kinds)) > 1:
        named = [f"'{scene.title}' is {words.get(scene.what, scene.what)}" for scene in scenes]
        message = f"{', '.join(named)}: only things of one kind are drawn over one another"
        raise InputError(Problem("view", message))
