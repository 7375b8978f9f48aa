"""Instructions of a step of the engine for 14 machines and three methods, counted by callgrind.

    .venv/bin/python benchmarks/instructions.py [WORDS]
    .venv/bin/python benchmarks/instructions.py --against PYTHON [WORDS]

WORDS choose the machines whose names contain one of them; `short` is the smallest one. PYTHON is
the interpreter of another tree of jousto: both engines step the machines that this file declares,
and the program ends with status 1 if one of them became slower by more than 1 %. A count does not
depend on what else the computer does and repeats to 3e-4 for the smallest machine, to 1e-5 for
most: it finds what a clock cannot. It contains no cache misses and no instructions that wait for
each other.

The Python program runs in valgrind and is counted only while the engine steps, once for few steps
and once for more: the difference contains no Python. Needs cc and valgrind with its header.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

WARM, FEW, MANY = 5, 5, 30  # steps before the counts and of the two counts
SLOWER = 1.01  # times the instructions of the other tree
METHODS = {"RK4": 1e-5, "ROS2": 1e-3, "GeneralizedAlpha": 1e-3}
"""Their steps, s: RK4 is stable for exact beams only in small ones; alpha iterates as in use."""
FILE = Path(__file__).resolve()

Counts = dict[str, dict[str, float]]
"""Instructions per step of each method, for each machine."""

SWITCHES = """
#include <valgrind/callgrind.h>
void begin(void) { CALLGRIND_START_INSTRUMENTATION; CALLGRIND_ZERO_STATS; }
void end(const char *name) { CALLGRIND_DUMP_STATS_AT(name); CALLGRIND_STOP_INSTRUMENTATION; }
"""


def machines() -> dict[str, Callable[[], Any]]:
    """Return the name of each machine and what declares it."""
    import jousto as jo
    import loops
    import machines as linked
    import strips
    import trees
    from cases import Case, beam, mechanism

    def flexible(joint: str, bodies: int, modes: int) -> Callable[[], Any]:
        return lambda: jo.compile(mechanism(Case(joint, bodies, modes), beam(modes)))

    def rigid(joint: str, core: Any = None) -> Callable[[], Any]:
        chain = linked.RigidChain(joint, 100, 0.0)
        more = {} if core is None else {"core": core}
        return lambda: jo.compile(linked.rigid_chain(chain), **more)

    return {
        "pendulum, spherical, n = 2": flexible("spherical", 1, 2),
        "pendulum, spherical, n = 10": flexible("spherical", 1, 10),
        "pendulum, spherical, n = 30": flexible("spherical", 1, 30),
        "chain of 20, spherical, n = 10": flexible("spherical", 20, 10),
        "chain of 20, revolute, n = 10": flexible("revolute", 20, 10),
        "slider-crank, flexible rod": lambda: jo.compile(linked.slider_crank()),
        "four-bar, flexible links": lambda: jo.compile(linked.four_bar()),
        "rigid chain of 100, spherical": rigid("spherical"),
        "rigid chain of 100, revolute": rigid("revolute"),
        "rigid chain of 100, revolute, maximal": rigid("revolute", "maximal"),
        "six-axis arm": lambda: jo.compile(trees.mechanism(trees.arm())),
        "free figure of 30 links": lambda: jo.compile(trees.mechanism(trees.figure())),
        "Stewart platform": lambda: jo.compile(loops.stewart()),
        "exact beam of 100 elements": lambda: jo.compile(strips.mechanism(100, strips.LEANING)),
    }


def step_all(words: list[str], folder: Path) -> None:
    """Step the machines within callgrind, a dump for each machine and method."""
    import numpy as np

    import jousto as jo

    warnings.simplefilter("ignore")
    switch = ctypes.CDLL(str(folder / "switches.so"))
    for machine, make in machines().items():
        if not chosen(machine, words):
            continue
        model = make()
        for method, h in METHODS.items():
            solver = getattr(jo, method)(step=h)
            for steps in (FEW, MANY):
                engine = jo.model.Engine(model)
                native = engine.native_solver(solver.method, h, solver.projection, **solver.options)
                rows = np.zeros((1, engine.row_size))
                engine.run(native, WARM, 10**9, rows)
                switch.begin()
                status, _ = engine.run(native, steps, 10**9, rows)
                switch.end(f"{machine}|{method}|{status}|{steps}".encode())


def chosen(name: str, words: list[str]) -> bool:
    return not words or any(word in name for word in words)


def counted(python: str, words: list[str]) -> Counts:
    """Return the instructions per step that the engine of an interpreter needs."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "switches.c").write_text(SWITCHES)
        flags = ["-O1", "-shared", "-fPIC", "switches.c", "-o", "switches.so"]
        subprocess.run(["cc", *flags], cwd=folder, check=True)
        tool = ["valgrind", "--tool=callgrind", "--instr-atstart=no"]
        tool.append(f"--callgrind-out-file={folder}/out")
        asked = [python, str(FILE), "--step", str(folder), *words]
        # one order of sets and one thread, so that counts repeat; addresses are those of this run
        settings = {"PYTHONHASHSEED": "0", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        done = subprocess.run(
            [*tool, *asked], env=os.environ | settings, capture_output=True, text=True
        )
        if done.returncode:
            raise RuntimeError(f"{python} in callgrind: {done.stderr[-2000:]}")
        return read(folder)


def read(folder: Path) -> Counts:
    """Return the counts of the dumps in a folder; a run that failed has none."""
    totals: dict[tuple[str, str], list[int]] = {}
    for path in sorted(folder.glob("out.*"), key=lambda path: int(path.suffix[1:])):
        text = path.read_text()
        run = re.search(r"^desc: Trigger: Client Request: (.*)\|(.*)\|ok\|\d+$", text, re.M)
        total = re.search(r"^summary: (\d+)$", text, re.M)
        if run and total:
            totals.setdefault((run[1], run[2]), []).append(int(total[1]))
    found: Counts = {}
    for (machine, method), pair in totals.items():
        if len(pair) == 2:
            found.setdefault(machine, {})[method] = (pair[1] - pair[0]) / (MANY - FEW)
    return found


def table(counts: Counts, other: Counts | None = None) -> list[str]:
    """Return the lines of a table in Markdown; with another tree's counts, the ratio to them."""
    lines = [f"| instructions of a step | {' | '.join(METHODS)} |", f"|---|{'---|' * len(METHODS)}"]
    for machine, found in counts.items():
        cells = []
        for method in METHODS:
            count = found.get(method)
            then = (other or {}).get(machine, {}).get(method)
            ratio = f" ({count / then:.4f})" if count and then else ""
            cells.append(f"{count:,.0f}{ratio}" if count else "")
        lines.append(f"| {machine} | {' | '.join(cells)} |")
    return lines


def slower(counts: Counts, other: Counts) -> list[str]:
    """Return what needs more instructions than in the other tree."""
    return [
        f"{machine}, {method}: {count / other[machine][method]:.4f} times"
        for machine, found in counts.items()
        for method, count in found.items()
        if count > SLOWER * other.get(machine, {}).get(method, float("inf"))
    ]


def main() -> None:
    """Count and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("words", nargs="*", help="only machines whose names contain one of them")
    parser.add_argument("--against", metavar="PYTHON", help="interpreter of another tree")
    parser.add_argument("--json", type=Path, help="file for the counts of this tree")
    parser.add_argument("--step", type=Path, help=argparse.SUPPRESS)  # within callgrind
    given = parser.parse_args()
    if given.step:
        step_all(given.words, given.step)
        return
    if not shutil.which("valgrind"):
        sys.exit(0 if given.words == ["short"] else "valgrind is not installed")
    if given.words == ["short"]:
        given.words = ["pendulum, spherical, n = 2"]
    counts = counted(sys.executable, given.words)
    if given.json:
        given.json.write_text(json.dumps(counts, indent=1) + "\n")
    other = counted(given.against, given.words) if given.against else None
    print("\n".join(table(counts, other)))
    if other is not None:
        worse = slower(counts, other)
        print("\n".join(["", *(worse or ["nothing is slower by more than 1 %"])]))
        sys.exit(bool(worse))


if __name__ == "__main__":
    main()
