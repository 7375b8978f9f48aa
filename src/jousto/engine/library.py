"""The compiled engine: which of its builds fits this processor, and its header read by cffi."""

from __future__ import annotations

import functools
import re
from pathlib import Path
from typing import Any

import cffi

from jousto.errors import JoustoError

_HERE = Path(__file__).parent


@functools.cache
def header() -> str:
    """Return the declarations of jousto.h that cffi reads (between BEGIN and END)."""
    candidates = (_HERE / "jousto.h", _HERE.parents[2] / "engine" / "jousto.h")
    for path in candidates:
        if path.exists():
            text = path.read_text(encoding="utf-8")
            body = text.split("/* BEGIN */")[1].split("/* END */")[0]
            return re.sub(r"/\*.*?\*/", "", body, flags=re.DOTALL)
    raise JoustoError("jousto.h is missing from the installation; install jousto again")


def _path(name: str) -> Path | None:
    for suffix in (".so", ".dylib", ".dll"):
        path = _HERE / "lib" / (name + suffix)
        if path.exists():
            return path
    return None


@functools.cache
def ffi() -> Any:
    """Return the cffi view of the header; jo_real appears in it only behind pointers."""
    view = cffi.FFI()
    view.cdef("typedef double jo_real;" + header())
    return view


def _open(name: str) -> Any:
    path = _path(name)
    if path is None:
        raise JoustoError(
            f"the compiled engine {name} is missing from {_HERE / 'lib'}; "
            "install jousto again with a C compiler at hand (pip install .)"
        )
    library = ffi().dlopen(str(path))
    found = (library.jo_abi(), library.jo_model_size())
    wanted = (library.JO_ABI, ffi().sizeof("jo_model"))
    if found != wanted:
        raise JoustoError(
            f"{path} does not fit this version (interface and size {found}, not {wanted}); "
            "install jousto again"
        )
    return library


@functools.cache
def real_library() -> Any:
    """Return the fastest build that this processor can run.

    All builds run the same sources; they differ in instructions and therefore in round-off.
    """
    baseline = _open("jousto_engine")
    level = baseline.jo_cpu_level()
    for name, needed in (("jousto_engine_v4", 4), ("jousto_engine_v3", 3)):
        if level >= needed and _path(name) is not None:
            return _open(name)
    return baseline


@functools.cache
def complex_library() -> Any:
    """Return the build with a double complex scalar, for complex-step derivatives."""
    return _open("jousto_engine_complex")
