"""Pinocchio's articulated-body algorithm compiled here, from the headers of its package.

Its package is built for any x86-64 processor; with the flags of the engine's fastest build the same
source is what both programs can do on this one.
"""

from __future__ import annotations

import functools
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

HERE = Path(__file__).parent
BUILT = HERE.parent / "build" / "bench"
GENERIC = ("-O3", "-DNDEBUG")
FLAGS = {
    "generic": GENERIC,
    "v3": (*GENERIC, "-march=x86-64-v3", "-ffp-contract=fast", "-fno-math-errno")
    + ("-fno-trapping-math",),
}
"""Flags of each build; "v3" those of the engine with AVX2 and FMA."""
may_compile = True  # the short run does not: a minute and a half
NEEDED = ("-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS")


@dataclass(frozen=True)
class Steps:
    """What steps of classical Runge-Kutta cost, and where the end of the last link is."""

    step: float  # us
    evaluation: float  # us, one call of aba
    places: NDArray[np.float64]  # (n, 3) m


@functools.cache
def program(kind: str = "v3") -> Path:
    """Return the program, compiled where its source or its flags changed.

    Raises
    ------
    ImportError
        If Pinocchio, Eigen or the compiler is missing.
    """
    found = find_spec("pinocchio")
    if found is None or found.origin is None:
        raise ImportError("Pinocchio is not installed")
    prefix = next(p for p in Path(found.origin).parents if p.name == "cmeel.prefix")
    source, target = HERE / "pinocchio_steps.cpp", BUILT / f"pinocchio_steps_{kind}"
    command = ["c++", "-std=c++17", "-w", *FLAGS[kind], *NEEDED, f"-I{prefix}/include"]
    command += ["-isystem", f"{prefix}/include/eigen3", str(source), "-o", str(target)]
    record = target.with_suffix(".txt")
    wanted = "\n".join([*command, source.read_text()])
    if not (target.exists() and record.exists() and record.read_text() == wanted):
        if not may_compile:
            raise ImportError("Pinocchio is not compiled yet; the short run leaves that out")
        BUILT.mkdir(parents=True, exist_ok=True)
        built = subprocess.run(command, capture_output=True, text=True)
        if built.returncode:
            raise ImportError(f"Pinocchio cannot be compiled: {built.stderr[:300]}")
        record.write_text(wanted)
    return target


def steps(
    links: Sequence[Any], step: float, count: int, every: int, repeats: int = 1, kind: str = "v3"
) -> Steps:
    """Return what so many steps of a tree of hinges (links of trees.py) cost and compute."""
    lines = [
        f"{link.parent} {int(np.argmax(link.axis))} {' '.join(map(str, link.at))}" for link in links
    ]
    asked = [str(program(kind)), repr(step), str(count), str(every), str(repeats)]
    done = subprocess.run(asked, input="\n".join(lines), capture_output=True, text=True, check=True)
    first, *rest = done.stdout.splitlines()
    cost, single = map(float, first.split())
    return Steps(cost, single, np.array([list(map(float, line.split())) for line in rest]))
