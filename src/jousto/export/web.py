"""WebAssembly module of a machine, without imports, for web pages and other hosts."""

from __future__ import annotations

import tempfile
from pathlib import Path

from jousto.export.program import Program
from jousto.export.project import flat_files
from jousto.export.toolchain import WEB, build

FLAGS = ("-DJO_NO_ALLOCATION", "-Wl,-z,stack-size=1048576")


def web_module(made: Program) -> bytes:
    """Return a machine as a WebAssembly module.

    It exports its memory and the functions of ``engine/export/page.c``: ``start``, ``advance``,
    ``set_input``, ``outputs`` and others. It has no fused multiply-add, so that results equal those
    of the engine built without it.

    Raises
    ------
    InputError
        If the package ziglang is not installed.
    """
    with tempfile.TemporaryDirectory(prefix="jousto-web-") as folder:
        out = Path(folder) / "machine.wasm"
        build(flat_files(made, "page.c"), WEB, out, flags=FLAGS)
        return out.read_bytes()
