"""Gmsh as the tests use it by themselves."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def opened(gmsh: Any) -> Iterator[None]:
    """Open a silent session; Gmsh lets a broken pipe end the program: take that back."""
    pipe = getattr(signal, "SIGPIPE", None)
    before = signal.getsignal(pipe) if pipe else None
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        yield
    finally:
        gmsh.finalize()
        if pipe:
            signal.signal(pipe, before)
