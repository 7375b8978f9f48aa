"""Files of a program: one C file with its header, or a project with build files."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path

from jousto.base.files import written
from jousto.base.version import __version__
from jousto.export import sources
from jousto.export.ports import Named
from jousto.export.program import Program, program
from jousto.model.model import Model
from jousto.simulation.solvers.base import Solver
from jousto.simulation.state import State

LIMIT = "#define JO_NO_ALLOCATION\n#define JO_ONE_FILE\n"
HOSTED = ("machine.h", "machine.c", "main.c")
HARDWARE = ("frame.h", "frame.c", "hardware.c")  # POSIX only: a second program


def plant_header(made: Program) -> str:
    """Return the header that defines the machine for the files around it."""
    upper = made.name.upper()
    return (
        f'#include "{made.name}.h"\n#define PLANT {made.name}_plant\n'
        f"#define PLANT_BYTES {upper}_BYTES\n"
    )


def known_headers(made: Program) -> dict[str, str]:
    """Return all headers by name."""
    return {
        **sources.headers(),
        "machine.h": sources.host("machine.h"),
        f"{made.name}.h": made.header,
        "plant.h": plant_header(made),
    }


def one_file(made: Program, *hosted: str) -> str:
    """Return engine, machine, constants and further files of engine/export as one C file."""
    files = {
        **sources.engine(),
        "machine.c": sources.host("machine.c"),
        f"{made.name}_data.c": made.source,
        **{name: sources.host(name) for name in hosted},
    }
    about = (
        f"/* {made.model.name}, {made.solver!r}: a machine in one file of C99, written by jousto "
        f"{__version__}.\n *\n"
        f" * cc -O2 -DMAIN {made.name}.c -o {made.name} -lm && ./{made.name}  runs it for 1 s "
        "and prints its outputs;\n"
        f" * without MAIN it is a part of your program, see {made.name}.h.\n"
        " * The engine in it is under the BSD-3-Clause licence of jousto. */\n"
    )
    return f"{about}{LIMIT}#include <math.h>\n{sources.join_files(files, known_headers(made))}"


def flat_files(made: Program, *hosted: str) -> dict[str, str]:
    """Return all files by name, in one folder, with further files of engine/export."""
    code = {name: value for name, value in known_headers(made).items() if "/" not in name}
    code |= sources.engine()
    code |= {name: sources.host(name) for name in ("machine.c", *hosted)}
    code[f"{made.name}_data.c"] = made.source
    return code


def public_header(made: Program) -> str:
    """Return the header of `one_file`: the functions of a machine, and names of its variables."""
    known = known_headers(made)
    text = sources.join_files({f"{made.name}_h": f'#include "{made.name}.h"\n'}, known)
    guard = f"{made.name.upper()}_MACHINE_H"
    return f"#ifndef {guard}\n#define {guard}\n{text}\n#endif\n"


def project(made: Program) -> dict[str, str]:
    """Return the files of a project by name: sources, a main program, build files."""
    head = "engine/"
    files = {f"{head}{name}": text for name, text in sources.headers().items()}
    files |= {f"{head}{name}": text for name, text in sources.engine().items()}
    files |= {name: sources.host(name) for name in HOSTED}
    files |= {f"hardware/{name}": sources.host(name) for name in HARDWARE}
    files |= {
        f"{made.name}.h": made.header,
        f"{made.name}_data.c": made.source,
        "plant.h": plant_header(made),
        "Makefile": MAKEFILE.replace("NAME", made.name),
        "CMakeLists.txt": CMAKE.replace("NAME", made.name),
        "README.txt": _readme(made),
    }
    return files


MAKEFILE = """\
CC ?= cc
CFLAGS ?= -O2
NAME: *.c *.h engine/*.c engine/*.h
\t$(CC) -std=c99 $(CFLAGS) -DJO_NO_ALLOCATION -I. -Iengine *.c engine/*.c -o $@ -lm
# the machine beside hardware, by datagrams or shared memory; on POSIX systems
NAME_hardware: *.c *.h engine/*.c engine/*.h hardware/*.c hardware/*.h
\t$(CC) -std=c99 $(CFLAGS) -DJO_NO_ALLOCATION -I. -Iengine -Ihardware \\
\t  $(filter-out main.c,$(wildcard *.c)) engine/*.c hardware/*.c -o $@ -lm
clean:
\trm -f NAME NAME_hardware
.PHONY: clean
"""

CMAKE = """\
cmake_minimum_required(VERSION 3.18)
project(NAME C)
set(CMAKE_C_STANDARD 99)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
file(GLOB engine engine/*.c)
add_library(NAME_machine STATIC machine.c NAME_data.c ${engine})
target_include_directories(NAME_machine PUBLIC . engine)
target_compile_definitions(NAME_machine PUBLIC JO_NO_ALLOCATION)
if(UNIX)
  target_link_libraries(NAME_machine PUBLIC m)
endif()
add_executable(NAME main.c)
target_link_libraries(NAME NAME_machine)
"""


def _readme(made: Program) -> str:
    ports = made.ports
    lines = [
        f"{made.model.name}: a machine in C99, written by jousto {__version__}",
        "",
        f"method    {made.solver!r}",
        f"memory    {made.bytes} bytes for one machine, provided by the caller; no allocation",
        "build     make, or cmake -B build && cmake --build build",
        f"run       ./{made.name} [seconds [rows]] prints the outputs as a table",
        f"hardware  make {made.name}_hardware (POSIX, not Windows), then "
        f"./{made.name}_hardware udp PORT",
        "          or shared FILE, see hardware/frame.h and hardware/hardware.c",
        "use       machine.h has the functions, "
        f"{made.name}.h the names of inputs, outputs, parameters",
        "",
    ]
    for title, found in (
        ("inputs", ports.inputs),
        ("outputs", ports.outputs),
        ("parameters", ports.parameters),
    ):
        lines.append(f"{title}: {len(found) or 'none'}")
        lines += [f"  {x.name} ({x.unit}): {x.about}" for x in found]
    return "\n".join([*lines, ""])


def write_program(
    model: Model,
    path: str | Path,
    solver: Solver | None = None,
    *,
    state: State | None = None,
    name: str = "",
    named: Sequence[Named] = (),
) -> Path:
    """Write a model as a C99 program without files, allocation and Python; return its path.

    Parameters
    ----------
    model : Model
        From `compile`.
    path : path
        ``.c``: one file, and its header ``.h`` beside it; ``.zip``: a project with the sources, a
        main program, a Makefile and a CMakeLists.txt.
    solver : Solver, optional
        Method of fixed step; None: the choice of `simulate` for 10 s.
    state : State, optional
        Initial state; None: that of the model.
    name : str
        Prefix of the names in C; empty is the name of the file.
    named : sequence of Named
        Named constants that become parameters, from `named_constants`.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        For functions of Python in the model, adaptive methods, or an unwritable path.
    """
    out = Path(path)
    made = program(model, solver, state=state, name=name or out.stem, named=named)
    write_files(
        out,
        made.name,
        project=lambda: project(made),
        header=lambda: public_header(made),
        source=lambda: one_file(made, "main.c"),
    )
    return out


def write_files(
    out: Path,
    name: str,
    *,
    project: Callable[[], dict[str, str]],
    header: Callable[[], str],
    source: Callable[[], str],
) -> None:
    """Write a project archive for a path that ends with ``.zip``, else one file and its header.

    Parameters
    ----------
    out : Path
    name : str
        Folder in the archive.
    project : function
        Function that returns the files of the project by name.
    header, source : function
        Functions that return the texts of the two files.

    Raises
    ------
    InputError
        If a path cannot be written.
    """
    if out.suffix.lower() == ".zip":
        with written(out) as beside, zipfile.ZipFile(beside, "w", zipfile.ZIP_DEFLATED) as file:
            for key, text in sorted(project().items()):
                entry = zipfile.ZipInfo(
                    f"{name}/{key}"
                )  # fixed date, so that the bytes are reproducible
                entry.compress_type = zipfile.ZIP_DEFLATED
                file.writestr(entry, text)
        return
    for place, text in ((out.with_suffix(".h"), header()), (out, source())):
        with written(place) as beside:
            beside.write_text(text, encoding="utf-8")
