"""HDF5 files from other people: access to other files is refused, and damage raises ValueError."""

from __future__ import annotations

from collections.abc import Iterator, KeysView
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from jousto.base.errors import InputError, Problem
from jousto.base.files import check_input

# exceptions of h5py for damaged files and unexpected content
DAMAGE = (
    OSError,
    KeyError,
    IndexError,
    RuntimeError,
    ValueError,
    TypeError,
    AttributeError,
    OverflowError,
    EOFError,
)
DEFLATED = 1032  # largest compression ratio: the limit of zlib


def opened(path: Path) -> h5py.File:
    """Open a file for reading; the file may still be written by a run."""
    try:
        return h5py.File(path, "r", locking=False)
    except OSError as error:
        if "locking flag" not in str(error):
            raise
        return h5py.File(path, "r")  # this process has it open with locking


def said(error: BaseException) -> str:
    """Return the message of an error, in one short line."""
    text = str(error.args[0]) if error.args else type(error).__name__
    text = text.splitlines()[0] if text else type(error).__name__
    return text if len(text) <= 150 else f"{text[:147]}..."


@contextmanager
def damage(path: Path, remedy: str) -> Iterator[None]:
    """Convert errors of h5py and NumPy for damaged files into one message with a remedy."""
    try:
        yield
    except InputError as error:
        first = error.problems[0]
        if first.where == str(path):
            raise
        raise InputError(Problem(str(path), f"damaged: {first}; {remedy}")) from error
    except DAMAGE as error:
        raise InputError(Problem(str(path), f"damaged: {said(error)}; {remedy}")) from error


@contextmanager
def open_format(path: Path, mark: str, what: str, remedy: str) -> Iterator[Group]:
    """Open a file of a format of jousto; report damage found inside ``with``, with a remedy.

    Parameters
    ----------
    path : Path
    mark : str
        Required value of its attribute ``format``.
    what : str
        Kind of the file, for messages: ``"a results file"``.
    remedy : str
        Remedy for damage.

    Raises
    ------
    InputError
        If the file cannot be opened, is damaged, or has another format.
    """
    check_input(path)
    try:
        file = opened(path)
    except DAMAGE as error:
        if path.is_file() and not h5py.is_hdf5(path):
            message = (
                f"not {what}: it is not an HDF5 file, because it is damaged or of another kind"
            )
        else:
            message = f"not readable as HDF5, damaged ({said(error)})"
        raise InputError(Problem(str(path), message)) from error
    with file, damage(path, remedy):
        found = file.attrs.get("format", "")
        if not isinstance(found, str) or found != mark:
            kind = f"it is a file of {found!r}" if found else "it is some other HDF5 file"
            raise InputError(Problem(str(path), f"not {what}; {kind}"))
        yield Group(file)


class Group:
    """HDF5 group that gives access to the content of its own file only.

    Links to other files and other places, data kept in other files and virtual data sets are
    refused: they could expose the content of other files of the user.

    Parameters
    ----------
    group : h5py.Group
        The group.
    """

    def __init__(self, group: h5py.Group) -> None:
        self._group = group

    @property
    def attrs(self) -> Any:
        """Attributes of the group."""
        return self._group.attrs

    def keys(self) -> KeysView[str]:
        """Return the names of the members."""
        names: KeysView[str] = self._group.keys()
        return names

    def __iter__(self) -> Iterator[str]:
        return iter(self._group)

    def __len__(self) -> int:
        return len(self._group)

    def __contains__(self, name: str) -> bool:
        *way, last = name.split("/")
        here = self._group
        for step in way:
            if not isinstance(here, h5py.Group) or step not in here:
                return False
            here = _step(here, step)
        return isinstance(here, h5py.Group) and here.id.links.exists(last.encode())

    def __getitem__(self, name: str) -> Any:
        here = self._group
        for step in name.split("/"):
            if not isinstance(here, h5py.Group):
                raise ValueError(f"{_name(here)} is not a group")
            here = _step(here, step)
        return Group(here) if isinstance(here, h5py.Group) else _checked(here)

    def items(self) -> Iterator[tuple[str, Any]]:
        """Yield names and members."""
        return ((name, self[name]) for name in self._group)

    def values(self) -> Iterator[Any]:
        """Yield the members."""
        return (self[name] for name in self._group)

    def groups(self, name: str) -> Iterator[tuple[str, Group]]:
        """Yield names and groups within a subgroup."""
        for key, found in self.group(name).items():
            if not isinstance(found, Group):
                raise ValueError(f"{name}/{key} is not a group")
            yield key, found

    def group(self, name: str) -> Group:
        """Return a subgroup."""
        found = self[name]
        if not isinstance(found, Group):
            raise ValueError(f"{name} is not a group")
        return found

    def array(
        self, name: str, shape: tuple[int | None, ...], kinds: str = "f", *, finite: bool = False
    ) -> NDArray[Any]:
        """Return an array of a given shape (None: any length) and kind of numbers.

        Raises
        ------
        ValueError
            If the array has another shape or kind, or numbers that are not finite.
        """
        dataset = self[name]
        check_dataset(dataset, shape, kinds)
        found = np.asarray(dataset[()])
        if finite and found.dtype.kind == "f" and not np.isfinite(found).all():
            raise ValueError(f"{_name(dataset)} contains numbers that are not finite")
        return found


def check_dataset(dataset: Any, shape: tuple[int | None, ...], kinds: str = "f") -> None:
    """Raise ValueError unless a data set has a shape (None: any length) and kind of numbers."""
    if not isinstance(dataset, h5py.Dataset):
        raise ValueError(f"{_name(getattr(dataset, '_group', dataset))} is not a data set")
    found = dataset.shape
    fits = (
        found is not None
        and len(found) == len(shape)
        and all(b is None or a == b for a, b in zip(found, shape, strict=True))
    )
    if not fits:
        wanted = ", ".join("any" if n is None else str(n) for n in shape)
        raise ValueError(f"{_name(dataset)} has shape {found}, must be ({wanted})")
    if dataset.dtype.kind not in kinds:
        raise ValueError(f"{_name(dataset)} has type {dataset.dtype}, not that of its kind")


def _name(item: Any) -> str:
    return str(item.name or "").lstrip("/")


def _step(group: h5py.Group, name: str) -> Any:
    links, key = group.id.links, name.encode(errors="surrogateescape")
    place = f"{_name(group)}/{name}".lstrip("/")
    if not links.exists(key):
        raise KeyError(f"{place} is missing")
    if links.get_info(key).type != h5py.h5l.TYPE_HARD:
        raise ValueError(f"{place} is a link to another place, which may be another file")
    return group[name]


def _checked(dataset: Any) -> Any:
    if not isinstance(dataset, h5py.Dataset):
        raise ValueError(f"{_name(dataset)} is not a data set")
    plist = dataset.id.get_create_plist()
    if plist.get_external_count() or plist.get_layout() == h5py.h5d.VIRTUAL:
        raise ValueError(f"{_name(dataset)} keeps its data in another file")
    room = dataset.file.id.get_filesize() * (DEFLATED if dataset.chunks else 1)
    if dataset.nbytes > room:
        raise ValueError(f"{_name(dataset)} claims {dataset.nbytes:.3g} bytes, more than the file")
    return dataset
