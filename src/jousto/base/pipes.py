"""Broken pipes: an error of Python, whatever other libraries in the process have set."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def broken_pipes_raise() -> Iterator[None]:
    """Make writing to a process that has ended a BrokenPipeError meanwhile, as Python starts.

    A library such as Gmsh sets SIGPIPE back to its default, which ends the whole program without
    a word. Only the main thread may change this; in others nothing is changed.
    """
    pipe = getattr(signal, "SIGPIPE", None)
    if pipe is None or threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(pipe, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(pipe, before)
