"""A machine as WebAssembly: one module without imports, for pages and other hosts."""

from __future__ import annotations

import tempfile
from pathlib import Path

from jousto.export.program import Program
from jousto.export.project import flat
from jousto.export.toolchain import WEB, build

FLAGS = ("-DJO_NO_ALLOCATION", "-Wl,-z,stack-size=1048576")


def web_module(made: Program) -> bytes:
    """Return a machine as a module of WebAssembly.

    It exports its memory and the functions of ``engine/export/page.c``: ``start``, ``advance``,
    ``set_input``, ``outputs`` and others. There are no fused products, so that it computes what
    the engine's build without them computes.

    Raises
    ------
    InputError
        Without the package ziglang.
    """
    with tempfile.TemporaryDirectory(prefix="jousto-web-") as folder:
        out = Path(folder) / "machine.wasm"
        build(flat(made, "page.c"), WEB, out, flags=FLAGS)
        return out.read_bytes()
