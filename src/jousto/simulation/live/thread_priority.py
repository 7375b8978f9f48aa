"""Real-time priority and locked memory of a thread."""

from __future__ import annotations

import ctypes
import os

PRIORITY = 10  # real-time priority of 1 .. 99, below that of device drivers
ALL = 3  # MCL_CURRENT | MCL_FUTURE


def hurry() -> str:
    """Request real-time priority and locked memory for this thread; return the refused requests.

    Returns
    -------
    str
        The refused requests as a text; empty if both were granted.
    """
    refused = []
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except (AttributeError, OSError) as error:
        refused.append(f"real-time priority was refused ({_reason(error)})")
    try:
        if ctypes.CDLL(None, use_errno=True).mlockall(ALL):
            raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    except (AttributeError, OSError, TypeError) as error:
        refused.append(f"locked memory was refused ({_reason(error)})")
    return "; ".join(refused)


def _reason(error: Exception) -> str:
    return error.strerror or "not on this system" if isinstance(error, OSError) else "not here"
