"""Cache of reductions on disk, with the content of their input as key.

A finished reduction is read from the cache; an interrupted reduction continues after its last
finished stage. The key is a hash of the part, the method and the options, so that an entry never
belongs to other input. A file appears only when it is complete.
"""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import os
import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.base.errors import InputError, Problem, warn
from jousto.base.files import DAMAGED_NPZ, written
from jousto.base.object_repr import described
from jousto.reduction.reduced import ReducedPart

RECIPE = 2
"""Version of the results; incremented when the same input leads to another result."""

AUTOMATIC = 30_000
"""Degrees of freedom above which reductions are cached by default."""

FINISHED = "part.h5"

ENTRY = re.compile(r"(mesh-)?[0-9a-f]{40}")
"""Pattern of the names of cache folders: a key."""

OWN = re.compile(r"part\.h5|[a-z-]+\.npz|\.[0-9a-f]{32}\.(h5|npz)")
"""Pattern of the file names in these folders: the part, its stages, and unfinished files."""

STALE = 86400.0
"""Age above which a partially written file belongs to a killed process, s."""


class NotHashable(Exception):
    """Error raised for input whose content cannot be hashed, such as a function."""


@described
@dataclass(frozen=True)
class ReductionCache:
    """Folder of finished and interrupted reductions.

    Parameters
    ----------
    folder : path, optional
        Folder of the cache. With None it is the folder in the environment variable `JOUSTO_CACHE`
        or, without it, the cache folder of the user (``~/.cache/jousto/reductions`` on Linux).
        Other files in the folder are never changed.
    limit : float
        Largest total size, bytes; above it the least recently used reductions are removed.

    Examples
    --------
    >>> import tempfile
    >>> cache = ReductionCache(tempfile.mkdtemp())
    >>> cache.size
    0
    """

    folder: Path | str | None = None
    limit: float = 10e9

    def __post_init__(self) -> None:
        folder: object = self.folder
        if folder is not None and not isinstance(folder, (str, os.PathLike)):
            message = f"is {folder!r}, must be True, False, a folder or ReductionCache(folder)"
            raise InputError(Problem("cache", message))

    @property
    def path(self) -> Path:
        """Folder of the cache."""
        if self.folder is not None:
            return Path(self.folder)
        if os.environ.get("JOUSTO_CACHE"):
            return Path(os.environ["JOUSTO_CACHE"])
        import platformdirs

        return Path(platformdirs.user_cache_dir("jousto", appauthor=False)) / "reductions"

    @property
    def size(self) -> int:
        """Total size of the entries, bytes."""
        return sum(_size(entry) for entry in self.entries())

    def entries(self) -> tuple[Path, ...]:
        """Return the folders of all reductions, least recently used first.

        Folders with other names or other content do not count as reductions.
        """
        if not self.path.is_dir():
            return ()
        return tuple(sorted((p for p in self.path.iterdir() if _is_ours(p)), key=_used))

    def clear(self) -> None:
        """Remove all reductions."""
        for entry in self.entries():
            _remove(entry)

    def entry(self, key: str) -> Entry:
        """Return the entry of a reduction."""
        return Entry(self, self.path / key)

    def prune(self, keep: Path) -> None:
        """Remove the least recently used reductions until the rest fits the limit.

        Partially written files of killed processes are removed first.
        """
        entries = self.entries()
        for entry in entries:
            _remove_stale(entry)
        total = sum(_size(entry) for entry in entries)
        for entry in entries:
            if total <= self.limit:
                break
            if entry != keep:
                total -= _size(entry)
                _remove(entry)


class Entry:
    """Files of one reduction: one per finished stage, or the reduced part."""

    def __init__(self, cache: ReductionCache, folder: Path) -> None:
        self.cache = cache
        self.folder = folder
        self._full = False

    def finished(self) -> ReducedPart | None:
        """Return the reduced part if it exists."""
        path = self.folder / FINISHED
        if not path.exists():
            return None
        try:
            reduced = ReducedPart.load(path)
        except InputError:
            # the file is damaged or of another version: compute again
            with contextlib.suppress(OSError):
                path.unlink()
            return None
        with contextlib.suppress(OSError):
            os.utime(self.folder)
        return reduced

    def finish(self, reduced: ReducedPart) -> None:
        """Store the reduced part and remove the files of its stages."""
        if self._full:
            return
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            reduced.save(self.folder / FINISHED)
        except (InputError, OSError) as error:
            self._give_up(error)
            return
        for path in _files(self.folder):
            # files whose names begin with a dot are being written by another thread or process
            if path.suffix == ".npz" and not path.name.startswith("."):
                with contextlib.suppress(OSError):
                    path.unlink()
        self.cache.prune(self.folder)

    def read(self, stage: str) -> dict[str, NDArray[Any]] | None:
        """Return the arrays of a stage, or None if the file is missing or damaged."""
        path = self._file(stage)
        try:
            with path.open("rb") as raw, np.load(raw, allow_pickle=False) as file:
                return {name: np.asarray(file[name]) for name in file.files}
        except FileNotFoundError:
            return None
        except DAMAGED_NPZ:
            with contextlib.suppress(OSError):
                path.unlink()
            return None

    def write(self, stage: str, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Write the arrays of a stage; the file appears when it is complete."""
        if self._full:
            return
        path = self._file(stage)
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with written(path) as beside, beside.open("wb") as file:
                np.savez(file, **arrays)  # type: ignore[arg-type]
                file.flush()
                os.fsync(file.fileno())
        except (InputError, OSError) as error:
            self._give_up(error)

    def _file(self, stage: str) -> Path:
        return self.folder / f"{stage.replace(' ', '-')}.npz"

    def _give_up(self, error: Exception) -> None:
        self._full = True
        warn(
            "reduce",
            f"cannot store results of the reduction in {self.folder} ({error}); the reduction "
            f"continues without them. Free disk space, choose another folder (cache=...), or give "
            f"cache=False",
        )


def choose(cache: ReductionCache | Path | str | bool | None, size: int) -> ReductionCache | None:
    """Return the cache for a part of `size` degrees of freedom, see `reduce`; None for no cache."""
    if cache is None:
        return ReductionCache() if size >= AUTOMATIC else None
    if isinstance(cache, bool):
        return ReductionCache() if cache else None
    return cache if isinstance(cache, ReductionCache) else ReductionCache(cache)


def key(*things: object, instead: Callable[[Any], object] | None = None) -> str:
    """Return a hash of the content of arrays, matrices, dataclasses and plain values.

    Parameters
    ----------
    *things : object
        Objects that are hashed.
    instead : function, optional
        Function that returns the object to hash in place of each object.

    Raises
    ------
    NotHashable
        If the content of an object is unknown.

    Examples
    --------
    >>> key(np.eye(2), {"a": 1}) == key(np.eye(2), {"a": 1}) != key(np.eye(2), {"a": 2})
    True
    """
    digest = hashlib.blake2b(digest_size=20)
    _add(digest, RECIPE, None)
    for thing in things:
        _add(digest, thing, instead)
    return digest.hexdigest()


def _add(digest: Any, thing: object, instead: Callable[[Any], object] | None) -> None:
    if instead is not None:
        thing = instead(thing)
    digest.update(type(thing).__qualname__.encode() + b":")
    if thing is None or isinstance(thing, (bool, int, float, complex, str, Path)):
        digest.update(repr(thing).encode() + b";")
    elif isinstance(thing, bytes):
        digest.update(thing + b";")
    elif isinstance(thing, (np.ndarray, np.generic)):
        array = np.asarray(thing)
        if array.dtype.hasobject:
            raise NotHashable(f"array of {array.dtype}")
        digest.update(f"{array.dtype.str}{array.shape};".encode())
        digest.update(np.ascontiguousarray(array).data)
    elif sp.issparse(thing):
        matrix: Any = thing
        if matrix.format not in ("csr", "csc"):
            matrix = matrix.tocsr()
        if not matrix.has_canonical_format:
            matrix = matrix.copy()
            matrix.sum_duplicates()
        for array in (matrix.indptr, matrix.indices):
            _add(digest, array.astype(np.int64) if array.dtype != np.int32 else array, instead)
        _add(digest, matrix.data, instead)
    elif isinstance(thing, Mapping):
        digest.update(f"{len(thing)};".encode())
        for name, value in thing.items():
            _add(digest, name, instead)
            _add(digest, value, instead)
    elif isinstance(thing, Sequence):
        digest.update(f"{len(thing)};".encode())
        for item in thing:
            _add(digest, item, instead)
    elif isinstance(thing, (set, frozenset)):
        _add(digest, sorted(thing, key=repr), instead)
    elif dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        for item in dataclasses.fields(thing):
            _add(digest, item.name, instead)
            _add(digest, getattr(thing, item.name), instead)
    elif callable(thing) or not hasattr(thing, "__dict__"):
        raise NotHashable(type(thing).__qualname__)
    else:
        _add(digest, dict(vars(thing)), instead)


def _is_ours(folder: Path) -> bool:
    """Return whether a folder is a cached reduction, by its name and all its files."""
    if not ENTRY.fullmatch(folder.name) or folder.is_symlink() or not folder.is_dir():
        return False
    try:
        with os.scandir(folder) as found:
            return all(
                OWN.fullmatch(item.name) and item.is_file(follow_symlinks=False) for item in found
            )
    except OSError:
        return False


def _files(folder: Path) -> list[Path]:
    """Return the cache files in a folder."""
    try:
        return [path for path in folder.iterdir() if OWN.fullmatch(path.name)]
    except OSError:
        return []


def _remove(folder: Path) -> None:
    """Remove the cache files of a reduction, and its folder if nothing else is in it."""
    for path in _files(folder):
        with contextlib.suppress(OSError):
            path.unlink()
    with contextlib.suppress(OSError):
        folder.rmdir()


def _remove_stale(folder: Path) -> None:
    """Remove partially written files of killed processes."""
    for path in _files(folder):
        with contextlib.suppress(OSError):
            if path.name.startswith(".") and time.time() - path.stat().st_mtime > STALE:
                path.unlink()


def _size(folder: Path) -> int:
    total = 0
    for path in _files(folder):
        with contextlib.suppress(OSError):
            total += path.stat().st_size
    return total


def _used(folder: Path) -> float:
    try:
        return folder.stat().st_mtime
    except OSError:
        return time.time()
