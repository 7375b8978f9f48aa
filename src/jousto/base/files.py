"""Files: checks before reading and writing, and atomic writes."""

from __future__ import annotations

import contextlib
import csv
import errno
import importlib.util
import os
import shutil
import stat
import struct
import sys
import uuid
import zipfile
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any, BinaryIO

from jousto.base.errors import InputError, Problem

KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}
ENDLESS = 1 << 26
"""Largest length of a line of text, bytes."""

ENDLESS_LINE = f"a line of more than {ENDLESS >> 20} MB, which is not text"

POINTER = b"version https://git-lfs.github.com/spec/"
"""Beginning of the pointer that Git LFS stores in place of a large file."""

# exceptions of NumPy and zipfile for a damaged .npz file
DAMAGED_NPZ = (
    OSError,
    ValueError,
    EOFError,
    KeyError,
    IndexError,
    TypeError,
    RuntimeError,
    OverflowError,
    MemoryError,
    SyntaxError,
    struct.error,
    zlib.error,
    zipfile.BadZipFile,
)


def special(path: Path) -> str:
    """Return the kind of a path that is not a file (links followed); empty for files or nothing.

    >>> special(Path("."))
    'a folder'
    """
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return ""  # open() reports the error
    return "" if stat.S_ISREG(mode) else KINDS.get(stat.S_IFMT(mode), "something special")


def executed(path: Path) -> ModuleType:
    """Execute a Python file and return its module."""
    name = f"jousto_user_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def check_file(path: Path, remedy: str = "") -> None:
    """Raise InputError for an existing path that is not a file: folder, device, pipe.

    Raises
    ------
    InputError
        With the kind of the path.
    """
    found = special(path)
    if found:
        tail = f"; {remedy}" if remedy else ""
        raise InputError(Problem(str(path), f"is {found}, must be a file{tail}"))


def check_input(path: Path, remedy: str = "") -> None:
    """Raise InputError for unreadable paths: folders, devices, pipes, pointers of Git LFS.

    Missing files are not reported.

    Raises
    ------
    InputError
        With the kind of the path and, for a pointer, the command that loads the file.
    """
    check_file(path, remedy)
    with contextlib.suppress(OSError), path.open("rb") as file:
        if file.read(len(POINTER)) == POINTER:
            raise InputError(
                Problem(
                    str(path),
                    "is a pointer of Git LFS, not the file itself: fetch it with git lfs pull",
                )
            )


def check_text(path: Path, remedy: str = "") -> None:
    """Raise InputError like `check_input`, and for files whose first line has no end.

    Raises
    ------
    InputError
        With the kind of the path.
    """
    check_input(path, remedy)
    read = 0
    with contextlib.suppress(OSError), path.open("rb") as file:
        while (piece := file.read(1 << 20)) and b"\n" not in piece and b"\r" not in piece:
            read += len(piece)
            if read > ENDLESS:
                raise InputError(Problem(str(path), ENDLESS_LINE))


@contextmanager
def written(path: Path) -> Iterator[Path]:
    """Yield the path of a temporary file, which replaces the target at the end of the block.

    If the block fails, the temporary file is removed and the old file remains. For a link, the file
    behind it is replaced.

    Raises
    ------
    InputError
        If the path exists and is no file, or writing fails.
    """
    check_file(path)
    final = Path(os.path.realpath(path))
    made = False
    try:
        beside = beside_of(final)
        os.close(os.open(beside, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        made = True
        yield beside
        take_place(beside, final)
        made = False
    except OSError as error:
        raise unwritable(path, error) from error
    finally:
        if made:
            with contextlib.suppress(OSError):
                beside.unlink()


def beside_of(final: Path) -> Path:
    """Return the name of a temporary file in the folder of the file that it may replace.

    Raises
    ------
    OSError
        If the existing file is write-protected.
    """
    if final.exists() and not os.access(final, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    return final.with_name(f".{uuid.uuid4().hex}{final.suffix}")


def take_place(beside: Path, final: Path) -> None:
    """Replace a file by another one, with the permissions of the old one."""
    if final.exists():
        shutil.copymode(final, beside)
    os.replace(beside, final)


def write_table(path: str | Path, head: Iterable[Any], rows: Iterable[Iterable[Any]]) -> Path:
    """Write a table as CSV.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    target = Path(path)
    with written(target) as beside, beside.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        writer.writerows(rows)
    return target


Rows = tuple[Iterable[Any], Iterable[Iterable[Any]]]
"""Header and rows of a table."""


class Tabular:
    """Mixin of classes that can be written as a table."""

    def _csv(self) -> Rows:
        """Return the header and the rows."""
        raise NotImplementedError

    def to_csv(self, path: str | Path) -> Path:
        """Write the table as CSV, with units in the header.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        return write_table(path, *self._csv())


def create(path: Path) -> BinaryIO:
    """Open a new file for writing, without changing an old file that is already open.

    An existing file is never opened, so that only the new file is removed after a failure.

    Raises
    ------
    InputError
        If the path exists and is no file.
    OSError
        If the file cannot be created.
    """
    check_file(path)
    path.unlink(missing_ok=True)
    return open(path, "xb", buffering=0)


def unwritable(path: Path, error: OSError) -> InputError:
    """Return the error for a file that cannot be written, with reason and remedy.

    >>> print(unwritable(Path("a.csv"), OSError(errno.ENOSPC, "No space left on device")))
    a.csv: cannot be written: No space left on device; free some space
    """
    return InputError(Problem(str(path), f"cannot be written: {reason(path, error)}"))


def reason(path: Path, error: OSError) -> str:
    """Return the reason why a file could not be written, and the remedy."""
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return f"{error.strerror}; free some space"
    with contextlib.suppress(OSError):
        if not path.parent.exists():
            return f"the folder {path.parent} does not exist; create it first"
    return f"{error.strerror or str(error)}; choose another place"
