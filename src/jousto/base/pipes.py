"""Broken pipes: a Python error, independent of other libraries in the process."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def broken_pipes_raise() -> Iterator[None]:
    """Make writing to an ended process raise BrokenPipeError within the block, Python's default.

    A library such as Gmsh resets SIGPIPE to its default, which ends the whole program without a
    message. Only the main thread can change this; in other threads the function has no effect.
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
