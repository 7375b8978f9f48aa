"""What the operating system grants to a thread that has to be on time."""

from __future__ import annotations

import ctypes
import os

PRIORITY = 10  # of 1 .. 99, below what drives devices
ALL = 3  # MCL_CURRENT | MCL_FUTURE


def hurry() -> str:
    """Ask that this thread goes before others and that its memory stays in place.

    Returns
    -------
    str
        What was not granted; empty if everything was.
    """
    refused = []
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except (AttributeError, OSError) as error:
        refused.append(f"it may not go before other programs ({_reason(error)})")
    try:
        if ctypes.CDLL(None, use_errno=True).mlockall(ALL):
            raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    except (AttributeError, OSError, TypeError) as error:
        refused.append(f"its memory may be moved to disk ({_reason(error)})")
    return "; ".join(refused)


def _reason(error: Exception) -> str:
    return error.strerror or "not on this system" if isinstance(error, OSError) else "not here"
