"""The conditions of a run of the benchmarks: date, processor, compiler, flags, versions."""

from __future__ import annotations

import datetime
import os
import platform
import re
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = ("jousto", "numpy", "scipy", "exudyn", "mujoco", "pin")
BUILD = Path(__file__).parent.parent / "build" / "engine"


def conditions() -> dict[str, object]:
    """Return what a reader must know to judge or to repeat the figures."""
    return {
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "processor": processor(),
        "cores": os.cpu_count(),
        "load": round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else None,
        "compiler": compiler(),
        "flags": flags(),
        "build": engine_build(),
        "python": platform.python_version(),
        "versions": {name: found for name in PACKAGES if (found := installed(name))},
    }


def processor() -> str:
    """Return the name of the processor as its system gives it."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor() or platform.machine()
    found = re.search(r"^model name\s*: (.*)$", text, re.M)
    return found[1] if found else platform.machine()


def compiler() -> str:
    """Return the first line of what the C compiler says of itself."""
    try:
        done = subprocess.run(["cc", "--version"], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return done.stdout.partition("\n")[0]


def flags() -> str:
    """Return the flags of the engine's fastest build, without those of warnings."""
    try:
        text = (BUILD / "build.ninja").read_text(encoding="utf-8")
    except OSError:
        return "unknown"
    found = re.findall(r"jousto_engine_v3\.dir.*?^  FLAGS = (.*?)$", text, re.M | re.S)
    words = found[0].split() if found else ["unknown"]
    return " ".join(word for word in words if not re.match(r"-W|-pedantic|-fPIC", word))


def engine_build() -> str:
    """Return the name of the build of the engine that this processor runs."""
    from jousto.model.native import library

    asked = os.environ.get("JOUSTO_CPU")
    runs = [name for name in library.BUILDS if library._runs(name)]
    return asked or max(runs, key=lambda name: library.BUILDS[name])


def installed(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
