"""Header of the engine for cffi, parsed once when the engine is built.

CMakeLists.txt runs this file as a script, before jousto can be imported.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import re
import sys
from pathlib import Path
from typing import Any

MODULE = "declared"  # name of the module beside the libraries


def declarations(header: Path) -> str:
    """Return the C declarations of jousto.h for cffi: tables, and the text from BEGIN to END.

    They use ``jo_real`` only behind pointers, so that they fit all builds.
    """
    head, body = header.read_text(encoding="utf-8").split("/* END */")[0].split("/* BEGIN */")
    kinds = _rows(head, "JO_FORCES")
    names = ", ".join(f"JO_FORCE_{name}" for name, _ in kinds)
    data = [f"typedef struct {{ jo_real {numbers}; }} jo_{name}_data;" for name, numbers in kinds]
    rows = [("none", ""), *_rows(head, "JO_METHODS")]
    methods = ", ".join(f"JO_METHOD_{name}" for name, _ in rows)
    enums = [
        f"typedef enum {{ {names} }} jo_force_type;",
        f"typedef enum {{ {methods} }} jo_method;",
    ]
    tables = "\n".join(enums + data)
    return f"typedef double jo_real;\n{tables}" + re.sub(r"/\*.*?\*/", "", body, flags=re.DOTALL)


def _rows(head: str, table: str) -> list[tuple[str, str]]:
    """Return the rows of a table of the header: each name and the text after it."""
    text = head.split(f"#define {table}(ROW)")[1].split("/* the last row */")[0]
    for name, numbers in re.findall(r"#define (JO_\w+_LAW) (.*)", head):
        text = text.replace(name, numbers)
    return re.findall(r"ROW\((\w+), ([^()]*(?:\([^()]*\)[^()]*)*)\)", text.replace("\\\n", ""))


def parsed(text: str) -> Any:
    """Return the cffi view of C declarations."""
    import cffi

    view = cffi.FFI()
    view.cdef(text)
    return view


def write(header: Path, target: Path) -> None:
    """Write the module with the declarations parsed by cffi."""
    text = declarations(header)
    view = parsed(text)
    view.set_source(MODULE, None)
    draft = target.with_name(f"{target.name}.{os.getpid()}")
    view.emit_python_code(str(draft))
    with draft.open("a", encoding="utf-8") as file:
        file.write(f"digest = '{_digest(text)}'\n")
    os.replace(draft, target)


def view(header: Path, folder: Path) -> Any:
    """Return the cffi view of a header, as written by the build or else parsed now.

    Parameters
    ----------
    header : Path
        The file jousto.h.
    folder : Path
        Folder with the module of the build, which is used if it belongs to the same header.
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
