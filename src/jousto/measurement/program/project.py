"""A monitor as C files: one file with its header, or a project with build files."""

from __future__ import annotations

from pathlib import Path

from jousto.base.version import __version__
from jousto.export import sources
from jousto.export.ports import identifier
from jousto.export.program import KEYWORDS
from jousto.export.project import CMAKE, write_files
from jousto.measurement.monitor.monitor import Monitor
from jousto.measurement.program.plan import Plan, plan_of

ENGINE = ("channel_health.c", "damage_meter.c", "stress_recovery.c")
ENGINE_HEADERS = ("jousto.h", "rainflow.h")
HOSTED = ("gauged_twin.h", "gauged_twin.c", "bands.h", "bands.c", "watch.c")


RECIPE = """\
CC ?= cc
CFLAGS ?= -O2
NAME: *.c *.h engine/*.c engine/*.h
\t$(CC) -std=c99 $(CFLAGS) -I. -Iengine *.c engine/*.c -o $@ -lm
clean:
\trm -f NAME
.PHONY: clean
"""


def _plant(made: Plan) -> str:
    upper = made.name.upper()
    return (
        f'#include "{made.name}.h"\n#define PLANT {made.name}_plan\n'
        f"#define PLANT_BYTES {upper}_BYTES\n#define PLANT_INPUTS {upper}_INPUTS\n"
    )


def _headers(made: Plan) -> dict[str, str]:
    """Return the texts of all headers by name."""
    everything = sources.headers()
    return {
        **{name: everything[name] for name in ENGINE_HEADERS},
        "gauged_twin.h": sources.host("gauged_twin.h"),
        "bands.h": sources.host("bands.h"),
        f"{made.name}.h": made.header,
        "plant.h": _plant(made),
    }


def _code(made: Plan) -> dict[str, str]:
    """Return the texts of all C files by name, in order of dependence."""
    engine = {name: sources.find(name) for name in ENGINE}
    hosted = {name: sources.host(name) for name in HOSTED if name.endswith(".c")}
    return {**engine, f"{made.name}_data.c": made.source, **hosted}


def one_file(made: Plan) -> str:
    """Return the whole program as one C file."""
    about = (
        f"/* A twin of gauges in one file of C99, written by jousto {__version__}.\n *\n"
        f" * cc -O2 -DMAIN {made.name}.c -o {made.name} -lm && ./{made.name} samples.csv  reads "
        "strains and prints stress and damage;\n"
        f" * without MAIN it is a part of your program, see {made.name}.h.\n"
        " * The engine in it is under the BSD-3-Clause licence of jousto. */\n"
    )
    head = "#define JO_ONE_FILE\n#include <math.h>\n"
    return f"{about}{head}{sources.join_files(_code(made), _headers(made))}"


def public_header(made: Plan) -> str:
    """Return the header for users of `one_file`."""
    body = sources.join_files({f"{made.name}_h": f'#include "{made.name}.h"\n'}, _headers(made))
    guard = f"{made.name.upper()}_TWIN_H"
    return f"#ifndef {guard}\n#define {guard}\n{body}\n#endif\n"


def project(made: Plan) -> dict[str, str]:
    """Return the files of a project by name: sources, a main program, build files."""
    inner = {*ENGINE, *ENGINE_HEADERS}
    files = {
        (f"engine/{name}" if name in inner else name): text
        for name, text in {**_headers(made), **_code(made)}.items()
    }
    cmake = CMAKE.replace(
        "NAME_machine STATIC machine.c", "NAME_machine STATIC gauged_twin.c bands.c"
    )
    return files | {
        "Makefile": RECIPE.replace("NAME", made.name),
        "CMakeLists.txt": cmake.replace("main.c", "watch.c").replace("NAME", made.name),
        "README.txt": _readme(made),
    }


def _readme(made: Plan) -> str:
    lines = [
        f"a twin of gauges in C99, written by jousto {__version__}",
        "",
        f"memory    {made.bytes} bytes for one twin, given by the caller; nothing is allocated",
        "build     make, or cmake -B build && cmake --build build",
        f"run       ./{made.name} samples.csv [memory] prints stress, bands and damage as a table",
        f"use       gauged_twin.h has the functions, {made.name}.h the names of inputs and outputs",
        "",
    ]
    for title, found in (("inputs", made.inputs), ("outputs", made.outputs)):
        lines.append(f"{title}: {len(found)}")
        lines += [f"  {x.name} ({x.unit}): {x.about}" for x in found]
    return "\n".join([*lines, ""])


def own_name(name: str) -> str:
    """Return a valid C name that no file of a twin has."""
    made = identifier(name)
    files = {Path(key).stem for key in (*ENGINE, *ENGINE_HEADERS)} | sources.hosted()
    return f"{made}_plan" if made in files | KEYWORDS or made.startswith("jo_") else made


def write_twin(monitor: Monitor, path: str | Path, *, name: str = "") -> Path:
    """Write a monitor as a C99 program without files, allocation or Python.

    Parameters
    ----------
    monitor : Monitor
        Monitor with a `Reconstruction` or an `Observer`; alarms are not included.
    path : path
        ``.c``: one file, and its header ``.h`` beside it; ``.zip``: a project with the sources, a
        main program, a Makefile and a CMakeLists.txt.
    name : str
        Prefix of the names in C; empty is the name of the file.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        If the path cannot be written.
    """
    out = Path(path)
    made = plan_of(monitor, own_name(name or out.stem))
    write_files(
        out,
        made.name,
        project=lambda: project(made),
        header=lambda: public_header(made),
        source=lambda: one_file(made),
    )
    return out
