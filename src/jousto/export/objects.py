"""Cache of compiled objects in the user's cache folder, for exports of other processes.

The engine, which takes most of the compile time, is equal in all machines. The key is a hash of the
sources, the compiler and its options, so that no outdated object is found. Files are written
atomically, and begin with the hash of their content.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import subprocess
from collections.abc import Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from jousto.base.errors import InputError
from jousto.base.files import written

LIMIT = 200e6  # maximum size of the cache, bytes; the least recently used objects are removed
OBJECT = re.compile(r"[0-9a-f]{64}\.o")
"""Pattern of the file names of cached objects."""
SURROUNDINGS = ("CPATH", "C_INCLUDE_PATH", "SDKROOT", "MACOSX_DEPLOYMENT_TARGET")
"""Environment variables that change the output of a compiler."""
DIGEST = hashlib.sha256().digest_size


def folder() -> Path:
    """Return the folder of the cache, in `JOUSTO_CACHE` or the user's cache folder."""
    if os.environ.get("JOUSTO_CACHE"):
        return Path(os.environ["JOUSTO_CACHE"]) / "objects"
    import platformdirs

    return Path(platformdirs.user_cache_dir("jousto", appauthor=False)) / "objects"


def key(line: Sequence[str], texts: Sequence[str], command: tuple[str, ...]) -> str:
    """Return the key of an object: a hash of options, sources, compiler and its version."""
    around = [f"{name}={os.environ.get(name, '')}" for name in SURROUNDINGS]
    digest = hashlib.sha256()
    for word in (*line, *texts, identity(command), *around):
        digest.update(f"{len(word)}:{word}".encode())
    return digest.hexdigest()


@cache
def identity(command: tuple[str, ...]) -> str:
    """Return the version text of a compiler, with the size and time of its file."""
    if command[1:3] == ("-m", "ziglang"):
        with contextlib.suppress(PackageNotFoundError):
            return f"ziglang {version('ziglang')}"
    try:
        done = subprocess.run(
            [*command, "--version"], capture_output=True, text=True, timeout=60, check=False
        )
        facts = os.stat(os.path.realpath(command[0]))
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return f"{done.stdout}{done.stderr}{facts.st_size}:{facts.st_mtime_ns}"


def find(name: str) -> bytes | None:
    """Return a cached object; None if there is none, or it is damaged."""
    path = folder() / f"{name}.o"
    try:
        with path.open("rb") as file:
            if hasattr(os, "getuid") and os.fstat(file.fileno()).st_uid != os.getuid():
                return None  # file of another user
            digest, found = file.read(DIGEST), file.read()
    except OSError:
        return None
    with contextlib.suppress(OSError):
        if hashlib.sha256(found).digest() == digest:
            os.utime(path)
            return found
        path.unlink()
    return None


def keep(name: str, content: bytes) -> None:
    """Write an object into the cache, if the folder is writable."""
    place = folder()
    with contextlib.suppress(OSError, InputError):
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        with written(place / f"{name}.o") as beside:
            beside.write_bytes(hashlib.sha256(content).digest() + content)


def prune() -> None:
    """Remove the least recently used objects until the cache is below its limit."""
    known = []
    with contextlib.suppress(OSError):
        for entry in os.scandir(folder()):
            if OBJECT.fullmatch(entry.name):
                with contextlib.suppress(OSError):
                    facts = entry.stat(follow_symlinks=False)
                    known.append((facts.st_mtime, facts.st_size, Path(entry.path)))
    total = sum(size for _, size, _ in known)
    for _, size, path in sorted(known):
        if total <= LIMIT:
            return
        with contextlib.suppress(OSError):
            path.unlink()
            total -= size
