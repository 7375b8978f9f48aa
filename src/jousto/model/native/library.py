"""Compiled engine: choice of the build for this processor, and the header read by cffi."""

from __future__ import annotations

import functools
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

from jousto.base.errors import InputError, Problem
from jousto.model.native.declarations import view

_HERE = Path(__file__).parent

BUILDS = {"v3": 3, "baseline": 0}
"""Builds of the engine, fastest first, with the x86-64 level that each needs."""


def _path(name: str) -> Path | None:
    for suffix in (".so", ".dylib", ".dll"):
        path = _HERE / "lib" / (name + suffix)
        if path.exists():
            return path
    return None


@functools.cache
def ffi() -> Any:
    """Return the cffi view of jousto.h."""
    for header in (_HERE.parents[3] / "engine" / "jousto.h", _HERE / "jousto.h"):
        if header.exists():
            return view(header, _HERE / "lib")
    raise InputError(Problem("jousto.h", "is missing from the installation; install jousto again"))


@functools.cache
def _loaded(name: str) -> tuple[Any, Any]:
    """Return a build and its path, without checking its interface."""
    path = _path(name)
    if path is None:
        raise InputError(
            Problem(
                f"the compiled engine {name}",
                f"is missing from {_HERE / 'lib'}; install jousto again on a computer with a C "
                f"compiler (pip install .)",
            )
        )
    # keep the library loaded: when Python exits, engine memory may be freed after its library
    return ffi().dlopen(str(path), getattr(ffi(), "RTLD_NODELETE", 0)), path


@functools.cache
def _open(name: str) -> Any:
    library, path = _loaded(name)
    found = (library.jo_abi(), library.jo_model_size())
    wanted = (library.JO_ABI, ffi().sizeof("jo_model"))
    if found != wanted:
        raise InputError(
            Problem(
                str(path),
                f"does not fit this version (interface and size {found}, not {wanted}); "
                "install jousto again",
            )
        )
    return library


@functools.cache
def real_library() -> Any:
    """Return the build that runs the models: the fastest one for this processor.

    The environment variable ``JOUSTO_CPU`` selects another one of `BUILDS`. All builds run the
    same sources; they differ in instructions and therefore in round-off.

    Raises
    ------
    InputError
        If ``JOUSTO_CPU`` is no build, or one that is not installed or cannot run on this processor.
    """
    asked = os.environ.get("JOUSTO_CPU", "").strip()
    if asked and asked not in BUILDS:
        known = ", ".join(sorted(BUILDS))
        raise InputError(Problem("JOUSTO_CPU", f"is {asked!r}; allowed: {known}"))
    return build(asked or next(name for name in BUILDS if _runs(name)))


def build(name: str) -> Any:
    """Return the build with a name of `BUILDS`."""
    if _level() < BUILDS[name]:
        raise InputError(Problem("engine", f"this processor cannot run the build {name}"))
    return _open(_file(name))


def _runs(name: str) -> bool:
    return name == "baseline" or (_level() >= BUILDS[name] and _path(_file(name)) is not None)


def _level() -> int:
    return int(_loaded("jousto_engine")[0].jo_cpu_level())


def _file(name: str) -> str:
    return "jousto_engine" if name == "baseline" else f"jousto_engine_{name}"


LANES = {"v4": 4, "v3": 3}
"""Builds for machines in parallel, widest vectors first, with the x86-64 level that each needs."""


@functools.cache
def lanes() -> Any:
    """Return the build that steps several machines at once; None if this processor has none."""
    asked = os.environ.get("JOUSTO_CPU", "").strip()
    for name, level in LANES.items():
        if _level() >= level and asked in ("", name) and _path(f"jousto_lanes_{name}") is not None:
            with suppress(OSError):  # a library that cannot be loaded counts as missing
                return _open(f"jousto_lanes_{name}")
    return None


@functools.cache
def complex_library() -> Any:
    """Return the build with a double complex scalar, for complex-step derivatives."""
    return _open("jousto_engine_complex")
