"""Worker processes that end with their parent, and file locks against a second program."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import parent_process
from multiprocessing.connection import wait
from pathlib import Path

from jousto.base.errors import InputError, Problem
from jousto.base.files import unwritable

try:
    import fcntl

    SHARED = True
except ImportError:  # Windows has no locks that several processes share
    SHARED = False

PATIENCE = 10.0
"""Shutdown timeout of the workers of a killed program, s."""
LOOK = 0.05
"""Period of the polls, s."""

_HELD: dict[str, int] = {}
"""Files that this process keeps locked until it ends."""


def end_with_parent() -> None:
    """End this process as soon as its parent process is gone."""
    parent = parent_process()
    if parent is None:
        return
    sentinel = parent.sentinel

    def watch() -> None:
        wait([sentinel])
        os._exit(1)

    threading.Thread(target=watch, name="jousto-parent", daemon=True).start()


def lock_shared(path: str) -> None:
    """Take a shared lock on a journal until this process ends."""
    if path and path not in _HELD and SHARED:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        _HELD[path] = handle
        _try_lock(handle, fcntl.LOCK_SH)


@contextmanager
def lock_exclusively(path: Path) -> Iterator[None]:
    """Open a journal for writing by this program only; its own processes may share the lock.

    Waits until the workers of a killed program have ended.

    Raises
    ------
    InputError
        If another program still writes the journal, or it cannot be opened.
    """
    if not SHARED:
        yield
        return
    handle = _open_when_free(path)
    try:
        yield
    finally:
        if os.fstat(handle).st_size == 0 and _is_same_file(handle, path):
            path.unlink()  # remove the empty file that was created for the lock
        os.close(handle)


def _open_when_free(path: Path) -> int:
    """Return the open file with a shared lock, once no other program has one."""
    until = time.monotonic() + PATIENCE
    while True:
        try:
            handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError as error:
            raise unwritable(path, error) from error
        # the file may have been removed between opening and locking
        if (
            _try_lock(handle, fcntl.LOCK_EX)
            and _is_same_file(handle, path)
            and _try_lock(handle, fcntl.LOCK_SH)
        ):
            return handle
        os.close(handle)
        if time.monotonic() > until:
            message = (
                "another study writes it at this moment: wait for it, stop it, or name another file"
            )
            raise InputError(Problem(str(path), message))
        time.sleep(LOOK)


def _try_lock(handle: int, kind: int) -> bool:
    """Return whether the lock was obtained; True on file systems without locks."""
    try:
        fcntl.flock(handle, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


def _is_same_file(handle: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(handle), os.stat(path))
    except FileNotFoundError:
        return False
