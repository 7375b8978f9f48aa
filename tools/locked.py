"""Run a command while nobody else runs one under the same lock: locked.py LOCKFILE COMMAND...

Two `make` at once in one folder shall not install into one environment at the same time. The lock
ends with the process, however it ends.
"""

import os
import subprocess
import sys
from pathlib import Path


def hold(lock: int) -> None:
    """Wait until the lock is ours; say so if that takes time."""
    try:
        import fcntl
    except ImportError:  # Windows: waits, asks again every second, ten times
        import msvcrt

        msvcrt.locking(lock, msvcrt.LK_LOCK, 1)
        return
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        print("another installation is under way here; waiting for it", flush=True)
        fcntl.flock(lock, fcntl.LOCK_EX)


if __name__ == "__main__":
    path = Path(sys.argv[1])
    path.parent.mkdir(parents=True, exist_ok=True)
    handle = os.open(path, os.O_RDWR | os.O_CREAT)
    hold(handle)
    sys.exit(subprocess.call(sys.argv[2:]))
