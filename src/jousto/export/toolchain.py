"""Compilers and their options for the binaries of each platform."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from jousto.base.errors import InputError, Problem, suggest
from jousto.export import objects
from jousto.export.sources import INCLUDE

FLAGS = ("-std=c99", "-O3", "-DNDEBUG", "-fno-math-errno", "-fno-trapping-math")
"""Options of the engine in Python; results are equal on processors without fused multiply-add."""
SECONDS = 600.0  # timeout of a compiler, s
OBJECTS: dict[str, bytes] = {}
"""Objects compiled in this process by their key, since all machines contain the engine."""
MOST = 500  # maximum number of these objects


@dataclass(frozen=True)
class Platform:
    """Platform of a binary.

    Attributes
    ----------
    name : str
        Name on the command line, ``x86_64-linux``.
    target : str
        Target of the cross compiler.
    suffix : str
        Suffix of shared libraries.
    fmi2, fmi3 : str
        Folder of binaries in functional mock-up units.
    """

    name: str
    target: str
    suffix: str
    fmi2: str
    fmi3: str


PLATFORMS = {
    p.name: p
    for p in (
        Platform("x86_64-linux", "x86_64-linux-gnu.2.17", ".so", "linux64", "x86_64-linux"),
        Platform(
            "aarch64-linux", "aarch64-linux-gnu.2.17", ".so", "aarch64-linux", "aarch64-linux"
        ),
        Platform("x86_64-windows", "x86_64-windows-gnu", ".dll", "win64", "x86_64-windows"),
        Platform("x86_64-darwin", "x86_64-macos", ".dylib", "darwin64", "x86_64-darwin"),
        Platform("aarch64-darwin", "aarch64-macos", ".dylib", "aarch64-darwin", "aarch64-darwin"),
    )
}


WEB = Platform("wasm32", "wasm32-wasi", ".wasm", "", "")
"""Platform of web pages."""


def here() -> str:
    """Return the name of the platform of this computer."""
    import platform

    machine = platform.machine().lower()
    cpu = {"amd64": "x86_64", "x86_64": "x86_64", "arm64": "aarch64", "aarch64": "aarch64"}
    system = {"linux": "linux", "win32": "windows", "darwin": "darwin"}
    return f"{cpu.get(machine, machine)}-{system.get(sys.platform, sys.platform)}"


def platforms(names: Iterable[str]) -> tuple[Platform, ...]:
    """Return platforms by name; "here" is that of this computer.

    Raises
    ------
    InputError
        For unknown names.
    """
    found, problems = [], []
    for name in names:
        asked = here() if name == "here" else name
        if asked in PLATFORMS:
            found.append(PLATFORMS[asked])
        else:
            hint = suggest(name, ("here", *PLATFORMS))
            problems.append(Problem("platform", f"no {name!r}{hint}"))
    if problems:
        raise InputError(problems)
    return tuple(dict.fromkeys(found))


@cache
def compiler(platform: Platform) -> tuple[str, ...]:
    """Return the command of a compiler for a platform: that of this computer, or Zig.

    Raises
    ------
    InputError
        If there is no compiler.
    """
    if platform.name == here() and sys.platform != "win32":
        for name in (os.environ.get("CC", ""), "cc", "gcc", "clang"):
            path = shutil.which(name.split()[0]) if name else None
            if path:
                return (path, *name.split()[1:])
    if find_spec("ziglang") is not None:
        return (sys.executable, "-m", "ziglang", "cc", "-target", platform.target)
    if platform is WEB:
        message = (
            "a machine in a web page needs the package ziglang, which is not installed; pip "
            "install ziglang"
        )
        raise InputError(Problem("export", message))
    raise InputError(
        Problem(
            "export",
            f"there is no compiler for {platform.name}; install the package ziglang "
            "(pip install ziglang), which compiles for all of them, or write the sources (.zip)",
        )
    )


def build(
    sources: Mapping[str, str],
    platform: Platform,
    out: Path,
    *,
    flags: Sequence[str] = (),
    shared: bool = False,
) -> None:
    """Compile C files into a program or a shared library, on all cores.

    Parameters
    ----------
    sources : mapping of str to str
        Texts by name; names may have folders.
    platform : Platform
        Platform of the binary.
    out : Path
        Path of the binary.
    flags : sequence of str
        Further options of the compiler; those with ``-Wl,`` go to the linker.
    shared : bool
        Whether to build a shared library.

    Raises
    ------
    InputError
        If there is no compiler, or the compiler fails; with its output.
    """
    command = compiler(platform)
    windows = platform.suffix == ".dll"
    web = platform is WEB
    options = [*FLAGS, *(flag for flag in flags if not flag.startswith("-Wl,")), "-I."]
    link = [flag for flag in flags if flag.startswith("-Wl,")]
    if web or shared:
        options += ["-fvisibility=hidden"]
    if web:
        link += ["-mexec-model=reactor"]  # library without a main function
    elif shared:
        link += ["-shared"]
        options += [] if windows else ["-fPIC"]
    if command[1:3] == ("-m", "ziglang"):
        link += ["-s"]  # no symbol table, a quarter of the size
    link += [] if windows else ["-lm"]
    with tempfile.TemporaryDirectory(prefix="jousto-build-") as folder:
        place = Path(folder)
        for name, text in sources.items():
            path = place / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        files = [name for name in sources if name.endswith(".c")]

        def compiled(name: str) -> str:
            made = f"{name}.o"
            line = [*command, *options, "-c", name, "-o", made]
            key = objects.key(line, with_includes(sources, name), command)
            known = OBJECTS.get(key) or objects.find(key)
            if known is None:
                run(line, platform, place, made)
                known = (place / made).read_bytes()
                objects.keep(key, known)
                new.append(key)
            else:
                (place / made).write_bytes(known)
            OBJECTS[key] = known
            return made

        if len(OBJECTS) > MOST:
            OBJECTS.clear()
        new: list[str] = []
        with ThreadPoolExecutor(os.cpu_count()) as threads:
            parts = list(threads.map(compiled, files))
        if new:
            objects.prune()
        made = f"made{platform.suffix if shared else ''}"
        run([*command, *parts, "-o", made, *link], platform, place, made)
        out.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(place / made, out)
        if not shared:
            out.chmod(0o755)


def with_includes(sources: Mapping[str, str], name: str) -> list[str]:
    """Return the names and texts of a file and of all files that it includes."""
    found = {name: sources[name]}
    waiting = [name]
    while waiting:
        for other in INCLUDE.findall(found[waiting.pop()]):
            if other in sources and other not in found:
                found[other] = sources[other]
                waiting.append(other)
    return [word for pair in sorted(found.items()) for word in pair]


def run(line: Sequence[str], platform: Platform, folder: Path, made: str) -> None:
    """Run a compiler in a folder; raise an error if the output file is missing afterwards."""
    try:
        done = subprocess.run(
            line, cwd=folder, capture_output=True, text=True, timeout=SECONDS, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise InputError(Problem("export", f"the compiler failed: {error}")) from None
    if done.returncode or not (folder / made).exists():
        message = f"{Path(line[0]).name} failed for {platform.name}: {done.stderr[-2000:]}"
        raise InputError(Problem("export", message))
