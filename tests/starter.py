"""A Python that has loaded the libraries of others and forks a process for each command of jousto.

A process of its own takes longer to import them than to do its work. Modules of jousto are
imported by each, so that what one forgets to import is missed as ever. Reads lines of JSON
(folder, file for the output, words, variables of the environment) and answers with exit codes.
"""

from __future__ import annotations

import gc
import importlib
import json
import os
import runpy
import signal
import sys

LIBRARIES = (
    *("cffi", "h5py", "matplotlib.figure", "matplotlib.backends.backend_agg"),
    *("matplotlib.collections", "numpy", "PIL", "pydantic", "rich.progress"),
    *("scipy.interpolate", "scipy.linalg", "scipy.optimize", "scipy.signal", "scipy.sparse"),
    *("scipy.sparse.csgraph", "scipy.sparse.linalg", "scipy.spatial", "scipy.special"),
    *("scipy.stats", "typer", "yaml"),
)
PATIENCE = 300  # s


def become(folder: str, out: str, words: list[str], settings: dict[str, str]) -> None:
    """Do in this process what `python -m jousto` does in a folder, its output to a file."""
    signal.alarm(PATIENCE)
    os.environ.update(settings)
    os.chdir(folder)
    to = os.open(out, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for number, of in enumerate((os.open(os.devnull, os.O_RDONLY), to, to)):
        os.dup2(of, number)
    sys.stdin, sys.stdout = open(0, closefd=False), open(1, "w", closefd=False)
    sys.stderr = open(2, "w", buffering=1, closefd=False, errors="backslashreplace")
    sys.path[0] = folder
    sys.argv = ["jousto", *words]
    runpy.run_module("jousto", run_name="__main__", alter_sys=True)


def main() -> None:
    """Fork for each line; a child that has done its command ends as every Python does."""
    for name in LIBRARIES:
        importlib.import_module(name)
    gc.freeze()  # or each child would go through, and copy, what it was given
    for line in sys.stdin:
        if not (child := os.fork()):
            return become(*json.loads(line))
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
    return None


if __name__ == "__main__":
    main()
