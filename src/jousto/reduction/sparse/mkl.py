"""The runtime library of Intel MKL, which the package mkl installs together with pypardiso."""

from __future__ import annotations

import ctypes
import os
import site
import sys
from functools import cache
from pathlib import Path

ENDINGS = (".dll", ".dylib")
"""Endings of shared libraries on Windows and macOS; on Linux a version follows ``.so``."""


@cache
def mkl_runtime() -> ctypes.CDLL:
    """Return ``mkl_rt``, from the environment variable `PYPARDISO_MKL_RT` or the folders of Python.

    The package pypardiso searches all folders below the installation of Python when it is imported,
    which takes seconds. It is asked only if the library is not in the usual folders.
    """
    given = os.environ.get("PYPARDISO_MKL_RT")
    if given:
        return ctypes.CDLL(given)
    for path in runtime_files():
        try:
            return ctypes.CDLL(str(path))
        except OSError:
            continue
    from pypardiso import PyPardisoSolver

    library = PyPardisoSolver().libmkl
    assert isinstance(library, ctypes.CDLL)
    return library


def runtime_files() -> list[Path]:
    """Return the files ``mkl_rt`` in the usual folders of libraries, short names first."""
    roots = dict.fromkeys((sys.prefix, site.getuserbase(), sys.base_prefix))
    found: list[Path] = []
    for root in roots:
        for folder in (Path(root) / "lib", Path(root) / "Library" / "bin"):
            names = os.listdir(folder) if folder.is_dir() else []
            found += sorted((folder / name for name in names if _is_runtime(name)), key=_length)
    return found


def _length(path: Path) -> int:
    return len(path.name)


def _is_runtime(name: str) -> bool:
    """Return whether a file is the runtime library, not its import library or an archive.

    Examples
    --------
    >>> [_is_runtime(name) for name in ("libmkl_rt.so.3", "mkl_rt.2.dll", "mkl_rt.lib")]
    [True, True, False]
    """
    stem = name.removeprefix("lib")
    return stem.startswith("mkl_rt.") and (".so" in stem or stem.endswith(ENDINGS))
