"""Processes that end with the program that started them, and a file that one program writes."""

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
"""Time that processes of a killed program get to end, s."""
LOOK = 0.05
"""Time between two tries, s."""

_HELD: dict[str, int] = {}
"""Files that this process holds until it ends."""


def end_with_parent() -> None:
    """End this process as soon as the one that started it is gone, however that ended."""
    parent = parent_process()
    if parent is None:
        return
    sentinel = parent.sentinel

    def watch() -> None:
        wait([sentinel])
        os._exit(1)

    threading.Thread(target=watch, name="jousto-parent", daemon=True).start()


def hold(path: str) -> None:
    """Share a journal until this process ends: no other program takes it over meanwhile."""
    if path and path not in _HELD and SHARED:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        _HELD[path] = handle
        _locked(handle, fcntl.LOCK_SH)


@contextmanager
def taken_over(path: Path) -> Iterator[None]:
    """Write a journal as the only program that does; processes of this one may share it.

    Waits for processes of a program that was killed, which end by themselves.

    Raises
    ------
    InputError
        If another program still writes it, or it cannot be opened.
    """
    if not SHARED:
        yield
        return
    handle = _alone(path)
    try:
        yield
    finally:
        if os.fstat(handle).st_size == 0 and _same(handle, path):
            path.unlink()  # nothing was written: it was made to be locked
        os.close(handle)


def _alone(path: Path) -> int:
    """Return the file, opened and shared, after no other program had it."""
    until = time.monotonic() + PATIENCE
    while True:
        try:
            handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError as error:
            raise unwritable(path, error) from error
        # what was there first may have been removed meanwhile
        if (
            _locked(handle, fcntl.LOCK_EX)
            and _same(handle, path)
            and _locked(handle, fcntl.LOCK_SH)
        ):
            return handle
        os.close(handle)
        if time.monotonic() > until:
            message = (
                "another study writes it at this moment: wait for it, stop it, or name another file"
            )
            raise InputError(Problem(str(path), message))
        time.sleep(LOOK)


def _locked(handle: int, kind: int) -> bool:
    """Return whether a lock is ours; file systems without locks have no use for it."""
    try:
        fcntl.flock(handle, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


def _same(handle: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(handle), os.stat(path))
    except FileNotFoundError:
        return False
