"""The engine's header for cffi: parsed once when the engine is built, not at every start.

Run as a script by CMakeLists.txt, where jousto itself cannot be imported yet.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import re
import sys
from pathlib import Path
from typing import Any

MODULE = "declared"  # beside the libraries


def declarations(header: Path) -> str:
    """Return the C declarations of jousto.h for cffi: its rows of forces and all from BEGIN to END.

    ``jo_real`` appears in them only behind pointers, so that they fit all builds.
    """
    head, body = header.read_text(encoding="utf-8").split("/* END */")[0].split("/* BEGIN */")
    rows = re.findall(r"^    ROW\((\w+), (.+)\) \\$", head, flags=re.MULTILINE)
    names = ", ".join(f"JO_FORCE_{name}" for name, _ in rows)
    data = [f"typedef struct {{ jo_real {numbers}; }} jo_{name}_data;" for name, numbers in rows]
    forces = "\n".join([f"typedef enum {{ {names} }} jo_force_type;", *data])
    return f"typedef double jo_real;\n{forces}" + re.sub(r"/\*.*?\*/", "", body, flags=re.DOTALL)


def parsed(text: str) -> Any:
    """Return the cffi view of declarations."""
    import cffi

    view = cffi.FFI()
    view.cdef(text)
    return view


def write(header: Path, target: Path) -> None:
    """Write the module that holds the declarations as cffi has parsed them."""
    text = declarations(header)
    view = parsed(text)
    view.set_source(MODULE, None)
    draft = target.with_name(f"{target.name}.{os.getpid()}")
    view.emit_python_code(str(draft))
    with draft.open("a", encoding="utf-8") as file:
        file.write(f"digest = '{_digest(text)}'\n")
    os.replace(draft, target)


def view(header: Path, folder: Path) -> Any:
    """Return the cffi view of a header: as written when the engine was built, else parsed.

    Parameters
    ----------
    header : Path
        The file jousto.h.
    folder : Path
        Where the build puts the module; one of another header is not used.
    """
    text = declarations(header)
    file = folder / f"{MODULE}.py"
    if file.exists():
        spec = importlib.util.spec_from_file_location(f"{__package__}.{MODULE}", file)
        assert spec is not None and spec.loader is not None
        module: Any = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        if module.digest == _digest(text):
            return module.ffi
    return parsed(text)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


if __name__ == "__main__":
    write(Path(sys.argv[1]), Path(sys.argv[2]))
