"""All benchmarks of motions: `make bench`. Writes results/run.json, the pages and the pictures.

.venv/bin/python benchmarks/run.py         ten minutes on one core that does nothing else
.venv/bin/python benchmarks/run.py short   a minute: that every program runs; writes nothing

Each program runs in a process of its own, one after the other. Nothing but the results, the marked
parts of the pages (page.py) and the pictures of precision_figures.py is written, and only if all
programs ended well.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import conditions
import page

HERE = Path(__file__).resolve().parent
PROGRAMS: dict[str, tuple[str, ...]] = {
    "precision": (),
    "instructions": (),
    "pinocchio_builds": (),
    "speed": (),
    "mechanisms": ("quick",),
    "trees": (),
    "beams": ("quick",),
    "implicit": ("quick",),
    "friction": (),
    "contact": (),
    "states": (),
    "loops": ("quick",),
    "ports": ("quick",),
    "coordinates": (),
    "elastic_joints": ("quick",),
    "overhead": (),
    "ensembles": (),
}
"""Programs in their order, and their words in a whole run."""
STRUCTURED = ("precision", "instructions")  # store numbers, not what they print
SETTINGS = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "Agg"}


def ran(name: str, words: tuple[str, ...], kept: Path | None = None) -> str:
    """Run a program and return what it prints, which is shown too."""
    command = [sys.executable, str(HERE / f"{name}.py"), *words]
    if kept is not None:
        command += ["--json", str(kept)]
    begin = spent()
    print(f"== {name} {' '.join(words)}", flush=True)
    done = subprocess.run(command, env=os.environ | SETTINGS, stdout=subprocess.PIPE, text=True)
    print(f"{done.stdout.rstrip()}\n== {spent() - begin:.0f} s of processor time\n", flush=True)
    if done.returncode:
        sys.exit(f"{name}.py ended with status {done.returncode}")
    return done.stdout


def spent() -> float:
    """Processor time of all programs that have ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def whole() -> dict[str, Any]:
    """Run all programs and return what is stored of them."""
    results: dict[str, Any] = {"conditions": conditions.conditions(), "outputs": {}}
    with tempfile.TemporaryDirectory() as folder:
        for name, words in PROGRAMS.items():
            if name in STRUCTURED:
                kept = Path(folder) / f"{name}.json"
                ran(name, words, kept)
                results[name] = json.loads(kept.read_text())
            else:
                results["outputs"][name] = ran(name, words)
    return results


def main() -> None:
    """Run, store, and fill in the pages."""
    if sys.argv[1:] == ["short"]:
        for name in PROGRAMS:
            ran(name, ("short",))
        return
    results = whole()
    page.RESULTS.parent.mkdir(exist_ok=True)
    page.RESULTS.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    page.main()
    import precision_figures

    precision_figures.main()


if __name__ == "__main__":
    main()
