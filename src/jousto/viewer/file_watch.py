"""Detection of changed files behind a page, and their new content."""

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
    """Exception: the content has changed, so that the page must reload."""


class Watched:
    """Files behind a page.

    Parameters
    ----------
    files : sequence of path
        Displayed objects by file.
    make : callable
        Returns the scenes of all displayed objects from the present files.
    """

    def __init__(self, files: Sequence[Path], make: Callable[[], list[Scene]]) -> None:
        self._make = make
        self._known = {file: (write_stamp(file), content_mark(file)) for file in files}
        self._changed: Path | None = None

    def changed(self) -> Path | None:
        """Return a file whose content has changed; None if there is none.

        An unreadable file, for example one being written, counts as unchanged.
        """
        for file, (seen, known) in self._known.items():
            now = write_stamp(file)
            if now == seen:
                continue
            found = content_mark(file)
            if found is None:
                continue
            if found != known:
                return file
            self._known[file] = (now, known)
        return None

    def scenes(self) -> list[Scene]:
        """Return the scenes of the files' present content.

        Raises
        ------
        JoustoError
            If the content cannot be shown.
        """
        found = {file: (write_stamp(file), content_mark(file)) for file in self._known}
        scenes = self._make()
        self._known = found
        return scenes


def write_stamp(file: Path) -> tuple[int, ...] | None:
    """Return a value that changes at each write to a file; None if it does not exist."""
    try:
        about = file.stat()
    except OSError:
        return None
    return about.st_mtime_ns, about.st_size, about.st_ino


def content_mark(file: Path) -> Any:
    """Return the identity of a file's content (of results: the run); None if incomplete."""
    kind = hdf5_format(file)
    if kind != RESULTS:
        broken = kind == DAMAGED or (file.suffix.lower() in (".h5", ".hdf5") and not kind)
        return None if broken else write_stamp(file)
    from jousto.simulation.results.validate import open_results

    try:
        with open_results(file) as results:
            return str(results.attrs["run"])
    except (JoustoError, OSError, KeyError):
        return None


def unfinished_note(run: Solution | None) -> str:
    """Return a message for an unfinished or killed run; empty for a complete one."""
    if run is None or run.complete:
        return ""
    last = float(run.time[-1]) if run.nt else 0.0
    text = f"{run.where}: the run is unfinished: still running or killed; the {run.nt} instants "
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


def check_comparable(scenes: Sequence[Scene]) -> None:
    """Raise InputError if scenes cannot be overlaid.

    Raises
    ------
    InputError
        If the scenes are of different kinds.
    """
    words = {"run": "a run", "model": "a model", "part": "a part", "modes": "modes"}
    kinds = [scene.what for scene in scenes]
    if len(set(kinds)) > 1:
        named = [f"'{scene.title}' is {words.get(scene.what, scene.what)}" for scene in scenes]
        message = f"{', '.join(named)}: only objects of one kind can be overlaid"
        raise InputError(Problem("view", message))
