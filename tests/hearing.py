"""Ctrl-C for programs that tests start."""

from __future__ import annotations

import signal


def hear() -> None:
    """Let a new process hear Ctrl-C, though tests that run in the background are deaf to it.

    To be the ``preexec_fn`` of a ``Popen``; without it the process would wait for ever.
    """
    signal.signal(signal.SIGINT, signal.SIG_DFL)
