"""Modal stress of all nodes of a body beside EXUDYN's, on the same body in the same run.

    python benchmarks/stress_exudyn.py [--python PYTHON]   a minute and a half

A steel bar of 50,200 nodes (8-node hexahedra), 20 modes, clamped at one end. `PYTHON` is an
interpreter that has exudyn; this one if not given. EXUDYN gets jousto's stress modes as the
outputVariableModeBasis of its ObjectFFRFreducedOrder; before a time is printed its stress must be
jousto's. Processor seconds of one thread, least of several.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

import jousto as jo

HERE = Path(__file__).parent
COUNTS, SIZE = (250, 19, 9), (2.5, 0.19, 0.09)  # elements, m
MODES = 20
FRAMES = 256  # that follow one another in a run


def body() -> jo.ReducedPart:
    """Reduce the bar."""
    axes = [np.linspace(0.0, length, n + 1) for length, n in zip(SIZE, COUNTS, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(nodes)).reshape([n + 1 for n in COUNTS])
    a, b = slice(None, -1), slice(1, None)
    corners = (
        (a, a, a),
        (b, a, a),
        (b, b, a),
        (a, b, a),
        (a, a, b),
        (b, a, b),
        (b, b, b),
        (a, b, b),
    )
    cells = np.stack([number[corner] for corner in corners], axis=-1).reshape(-1, 8)
    part = jo.Part.solid(
        jo.Mesh("bar", nodes, [jo.mesh.Cells("hexahedron", cells)]),
        jo.Material(E=2.1e11, nu=0.3, rho=7850.0),
        interfaces=[jo.Interface("clamp", np.flatnonzero(nodes[:, 0] < 1e-9))],
    )
    return jo.reduce(part, jo.CraigBampton(modes=MODES), cache=True)


def least(work: Callable[[], Any], seconds: float = 4.0) -> float:
    """Processor seconds of one call, the least of those that fit in some seconds."""
    best, begin = np.inf, time.monotonic()
    while time.monotonic() - begin < seconds:
        start = time.process_time()
        work()
        best = min(best, time.process_time() - start)
    return best


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--python", default=sys.executable)
    python = parser.parse_args().python
    modes = body().stress
    assert modes is not None
    ns, _, n = modes.modes.shape
    rng = np.random.default_rng(0)
    p = rng.normal(size=(FRAMES, n)) / np.abs(modes.modes).max() * 1e8
    t = 1e-3 * np.arange(FRAMES)
    with tempfile.TemporaryDirectory() as folder:
        np.savez(Path(folder) / "body.npz", nodes=modes.positions, modes=modes.modes, p=p[0])
        run = subprocess.run(
            [python, str(HERE / "exudyn_stress.py"), folder],
            capture_output=True,
            text=True,
            check=True,
            env={k: v for k, v in os.environ.items() if k != "PYTHONPATH"},
        )
        theirs = json.loads(run.stdout.splitlines()[-1])
        stress = np.load(Path(folder) / "theirs.npy")
    field = jo.recovery.field_from(modes, p, t)
    own = field.at(0.0)
    apart = np.abs(own - stress).max() / np.abs(own).max()
    largest = field.values("von-mises", times=[0.0]).max()
    assert apart < 1e-12, apart
    assert abs(largest / theirs["largest von Mises"] - 1.0) < 1e-12

    one = jo.recovery.field_from(modes, p[:1], t[:1])

    def sweep() -> None:
        for _, _, values in field.blocks("von-mises", along="sites"):
            values.max()

    def components() -> None:
        one.at(0.0)

    long_p = rng.normal(size=(10_000, n))
    long = jo.recovery.field_from(modes, long_p, 1e-3 * np.arange(10_000))
    few = [modes.labels[k] for k in np.linspace(0, ns - 1, 20).astype(int)]
    rows = (
        ("six components, one frame", least(components), theirs["frame, components"]),
        ("  the same by its sensors", least(components), theirs["frame, sensors"]),
        (
            "largest von Mises, one frame",
            least(lambda: one.values().max()),
            theirs["frame, von Mises"],
        ),
        (f"  the same, {FRAMES} frames", least(sweep) / FRAMES, theirs["frame, von Mises"]),
        (
            "history of a node, a sample",
            least(lambda: [long.history(label) for label in few]) / (10_000 * len(few)),
            theirs["history"],
        ),
    )
    print(f"{ns} nodes, {n} modes; EXUDYN {theirs['version']}; stress apart by {apart:.1e}")
    print(f"{'':32}{'jousto, us':>12}{'EXUDYN, us':>12}{'ratio':>8}")
    for name, ours, its in rows:
        print(f"{name:32}{1e6 * ours:12.4g}{1e6 * its:12.4g}{its / ours:8.1f}")


if __name__ == "__main__":
    main()
