"""Instruction count of a step by kinds of work, with Callgrind."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from jousto.base.object_repr import described
from jousto.model.model import Model

SECONDS = 120.0  # timeout of a count, s
FEW, MORE = 10, 110  # numbers of timed steps; a tenth more steps precede them
STEPS = (MORE - FEW) * 11 // 10

KINDS = {
    "bodies": "body beam",
    "trees in joint coordinates": "tree",
    "joints, markers, coordinates": "joint marker coordinate coupled relative reaction",
    "forces and signals": "force signal",
    "friction": "friction",
    "sensors and damage": "sensor row damage meter rainflow energy",
    "events": "event",
    "equations of motion": "blocks schur dynamics element planes tangent place",
    "method": "step implicit newton run state data push adaptive dopri machine",
}
"""Kinds of work, with the first words of the names of their engine files."""


@described
@dataclass(frozen=True)
class Work:
    """Instruction count of one step.

    Attributes
    ----------
    kinds : tuple of (str, int, float)
        Kind of work, number of its objects in the model (0 for no objects), and instructions.
    """

    kinds: tuple[tuple[str, int, float], ...]

    @property
    def total(self) -> float:
        """Total number of instructions of a step."""
        return sum(count for _, _, count in self.kinds)

    def __str__(self) -> str:
        lines = [f"work       {self.total:.0f} instructions a step (Callgrind, {STEPS} steps)"]
        for kind, objects, count in self.kinds:
            each = f", {count / objects:.0f} each of {objects}" if objects else ""
            lines.append(f"  {kind:<30} {count:8.0f}, {100 * count / self.total:4.1f} %{each}")
        return "\n".join(lines)


def work_of(model: Model, program: Path, folder: Path) -> Work | None:
    """Return the instruction count of a step of a program with timing.c; None without Valgrind.

    The count is the difference of two runs of different length.

    Parameters
    ----------
    model : Model
        Model of the program.
    program : Path
        Executable with debug information (-g).
    folder : Path
        Folder for the output of Callgrind.
    """
    valgrind = shutil.which("valgrind")
    if valgrind is None:
        return None
    counts = []
    for steps in (FEW, MORE):
        out = folder / f"callgrind.{steps}"
        line = [valgrind, "--tool=callgrind", f"--callgrind-out-file={out}", str(program)]
        try:
            done = subprocess.run([*line, str(steps)], capture_output=True, timeout=SECONDS)
        except (OSError, subprocess.TimeoutExpired):
            return None
        if done.returncode or not out.exists():
            return None
        counts.append(by_file(out.read_text(encoding="utf-8", errors="replace")))
    less, more = counts
    found: dict[str, float] = {}
    for name in more:
        if name.startswith("timing"):
            continue
        kind = kind_of(name)
        found[kind] = found.get(kind, 0.0) + (more[name] - less.get(name, 0)) / STEPS
    objects = {
        "bodies": len(model.bodies) + len(model.beams),
        "trees in joint coordinates": len(model.links),
        "joints, markers, coordinates": len(model.joints),
        "forces and signals": len(model.forces),
        "friction": len(model.frictions),
        "sensors and damage": len(model.sensors),
        "events": len(model.events),
    }
    kept = ((kind, objects.get(kind, 0), count) for kind, count in found.items() if count >= 0.5)
    return Work(tuple(sorted(kept, key=lambda row: -row[2])))


def kind_of(name: str) -> str:
    """Return the kind of work of an engine file.

    Examples
    --------
    >>> kind_of("force_along.c"), kind_of("e_pow.c")
    ('forces and signals', 'library of the compiler')
    """
    for kind, starts in KINDS.items():
        if name.startswith(tuple(starts.split())):
            return kind
    return "library of the compiler"


FILE = re.compile(r"fl=\((\d+)\)(?: (.*))?")


def by_file(text: str) -> dict[str, int]:
    r"""Return the instruction count of each file from the output of Callgrind, without calls.

    Examples
    --------
    >>> by_file("fl=(1) a/body.c\nfn=(1) f\n7 30\ncalls=1 2\n9 500\nfl=(2) step.c\n+1 4\n")
    {'body.c': 30, 'step.c': 4}
    """
    names: dict[str, str] = {}
    found: dict[str, int] = {}
    current, called = "", False
    for line in text.splitlines():
        match = FILE.match(line)
        if match:
            number, name = match.groups()
            if name is not None:
                names[number] = Path(name).name
            current = names.get(number, "")
            continue
        named = re.match(r"(?:f[ie]|cfi|cfl)=\((\d+)\) (.*)", line)
        if named:
            names[named.group(1)] = Path(named.group(2)).name
        elif line.startswith("calls="):
            called = True
        elif line[:1] in "+-*" or line[:1].isdigit():
            cost = line.split()[1:]  # empty if the line has no cost
            if not called and current and cost:
                found[current] = found.get(current, 0) + int(cost[0])
            called = False
    return found
