"""Seconds and memory of every stage of a reduction: the link arm from its CAD file.

    python benchmarks/reduction.py                   30, 100 and 290 thousand unknowns
    python benchmarks/reduction.py 740k 1M           larger ones
    python benchmarks/reduction.py 110k --solver ngsolve --repeat 3
    python benchmarks/reduction.py 30k --exudyn PYTHON   beside EXUDYN's FEMinterface

Each run is a child process. Seconds are processor time, the least of the runs, with that of the
process in which Gmsh runs; memory is the peak of the whole process, without Gmsh's, while the stage
runs (Linux). `PYTHON` is an interpreter that has exudyn.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).parent
STEP = HERE.parent / "examples" / "data" / "link_arm.step"

SIZES = {
    "30k": (0.085, 5),
    "110k": (0.0385, 9),
    "300k": (0.0216, 12),
    "740k": (0.0143, 18),
    "1M": (0.0128, 20),
}
"""Element size in m and elements around a circle."""

USUAL = ("30k", "110k", "300k")
"""Sizes of a run without arguments."""

MODES = 20


def memory(name: str) -> float:
    """MiB of this process: VmRSS is now, VmHWM the peak since `reset_peak`."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(name):
            return int(line.split()[1]) / 1024.0
    return float("nan")


def processor_time() -> float:
    """Seconds of this process and of its finished children, such as that of Gmsh."""
    children = os.times()
    return time.process_time() + children.children_user + children.children_system


def reset_peak() -> None:
    Path("/proc/self/clear_refs").write_text("5")


class Stages:
    """Processor seconds and peak MiB of stages, in their order."""

    def __init__(self) -> None:
        self.rows: dict[str, tuple[float, float]] = {}
        self._start: dict[str, float] = {}

    def __call__(self, stage: str, done: float) -> None:
        if stage not in self._start:
            reset_peak()
            self._start[stage] = processor_time()
        elif done == 1.0:
            # the last report of a stage counts
            self.rows[stage] = (processor_time() - self._start[stage], memory("VmHWM"))


def link_arm(size: str, kind: str) -> tuple[Any, Any]:
    """Return the mesh and the part with its two bores tied, and stress at all surface nodes."""
    import jousto as jo

    length, circle = SIZES[size]
    mesh = jo.mesh_cad(STEP, size=length, per_circle=circle)
    return mesh, part_of(mesh, kind)


def part_of(mesh: Any, kind: str) -> Any:
    from dataclasses import replace

    import jousto as jo

    holes = sorted(mesh.holes(), key=lambda hole: float(hole.point[0]))
    ties = [
        jo.Interface(name, hole.nodes, kind=kind)
        for name, hole in (("big", holes[0]), ("small", holes[-1]))
    ]
    part = jo.Part.solid(mesh, jo.material("S355"), interfaces=ties)
    return replace(part, stress=part.stress.at(np.unique(mesh.triangles)))


def child(size: str, solver: str | None, kind: str) -> dict[str, Any]:
    import jousto as jo

    stages = Stages()
    stages("imports", 0.0)
    jo.mesh_cad, jo.reduce, jo.Part, jo.Interface, jo.material  # noqa: B018
    stages("imports", 1.0)
    length, circle = SIZES[size]
    stages("mesh", 0.0)
    mesh = jo.mesh_cad(STEP, size=length, per_circle=circle)
    stages("mesh", 1.0)
    stages("matrices", 0.0)
    part = part_of(mesh, kind)
    stages("matrices", 1.0)
    wall = time.perf_counter()
    reduced = jo.reduce(
        part,
        jo.CraigBampton(interfaces=("big", "small"), modes=MODES),
        solver=solver,
        cache=False,
        progress=stages,
    )
    wall = time.perf_counter() - wall
    stages("save", 0.0)
    with tempfile.TemporaryDirectory() as folder:
        reduced.save(Path(folder) / "arm.h5")
    stages("save", 1.0)
    return {
        "unknowns": part.K.shape[0],
        "entries": part.K.nnz,
        "surface": len(part.stress.sites),
        "solver": reduced.provenance["solver"],
        "modes": reduced.n,
        "frequencies": reduced.frequencies[:3].tolist(),
        "wall": wall,
        "stages": stages.rows,
    }


def best(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the first run with the least seconds and the largest peak of every stage."""
    one = dict(runs[0])
    one["stages"] = {
        stage: (min(r["stages"][stage][0] for r in runs), max(r["stages"][stage][1] for r in runs))
        for stage in one["stages"]
    }
    return one


def show(results: list[dict[str, Any]]) -> None:
    """Print a table for the documentation."""
    head = [f"{r['unknowns']:,} dof" for r in results]
    print(f"| stage | {' | '.join(head)} |")
    print("|---" * (len(head) + 1) + "|")
    names = list(dict.fromkeys(stage for r in results for stage in r["stages"]))
    total = [0.0] * len(results)
    for name in names:
        cells = []
        for k, r in enumerate(results):
            seconds, peak = r["stages"].get(name, (0.0, 0.0))
            total[k] += seconds
            cells.append(f"{seconds:.2f} / {peak:.0f}")
        print(f"| {name} | {' | '.join(cells)} |")
    most = [max(peak for _, peak in r["stages"].values()) for r in results]
    cells = [f"{t:.1f} / {m:.0f}" for t, m in zip(total, most, strict=True)]
    print(f"| all | {' | '.join(cells)} |")
    for r in results:
        print(
            f"{r['unknowns']} unknowns, {r['entries']} entries of K, {r['surface']} surface nodes, "
            f"{r['modes']} modes, {r['solver']}, first {np.round(r['frequencies'], 3)} Hz, "
            f"reduce {r['wall']:.1f} s of wall time"
        )


def beam(cells: tuple[int, int, int] = (40, 4, 4)) -> tuple[Any, Any, Any, float]:
    """A clamped beam of 10-node tetrahedra with a force at its end.

    Returns the part, its displacements, the corners of elements along the middle of its upper
    face that are away from both ends, and the force.
    """
    import skfem

    import jousto as jo
    from jousto.reduction.sparse.factor import factorise

    grid = skfem.MeshTet.init_tensor(*(np.linspace(0.0, 1.0, n + 1) for n in cells))
    corners, tets = grid.p.T * [1.0, 0.1, 0.1], grid.t.T
    pairs = tets[:, [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]]]
    edges, which = np.unique(np.sort(pairs, axis=-1).reshape(-1, 2), axis=0, return_inverse=True)
    nodes = np.vstack([corners, corners[edges].mean(axis=1)])
    ten = np.hstack([tets, len(corners) + which.reshape(-1, 6)])
    a, b, c, d = corners[tets].transpose(1, 0, 2)
    inside_out = np.einsum("ei,ei->e", np.cross(b - a, c - a), d - a) < 0.0
    ten[inside_out] = ten[inside_out][:, [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]]
    mesh = jo.Mesh("beam", nodes, jo.mesh.Cells("tetra10", ten))
    part = jo.Part.solid(mesh, jo.material("S355"))
    free = np.repeat(nodes[:, 0] > 1e-9, 3).nonzero()[0]
    force = np.zeros((len(nodes), 3))
    tip = nodes[:, 0] > 1.0 - 1e-9
    force[tip, 1] = 1000.0 / tip.sum()
    u = np.zeros(3 * len(nodes))
    solve = factorise(part.K[free][:, free], "beam", str)
    u[free] = solve(force.ravel()[free])
    top = np.abs(corners - [0.5, 0.1, 0.05]) < [0.21, 1e-9, 1e-9]
    return part, u, np.flatnonzero(top.all(axis=1)), 1000.0


def peer(size: str, python: str) -> None:
    """Run jousto and EXUDYN on the same matrices, one after the other."""
    import scipy.sparse as sp

    import jousto as jo

    _, part = link_arm(size, "rigid")
    steel = jo.material("S355")
    part_b, u, sites, force = beam()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        for name, matrix in (("K", part.K), ("M", part.M)):
            sp.save_npz(path / f"{name}.npz", sp.csr_matrix(matrix))
        elements = [
            np.concatenate([g.nodes for g in p.stress.model.groups]) for p in (part, part_b)
        ]
        np.savez(
            path / "mesh.npz",
            nodes=part.nodes,
            elements=elements[0],
            material=[steel.E, steel.nu, steel.rho],
            **{tie.name: np.asarray(tie.nodes) for tie in part.ties},
        )
        np.savez(
            path / "beam.npz",
            nodes=part_b.nodes,
            elements=elements[1],
            displacement=u[:, None],
            sites=sites,
        )
        run = [python, str(HERE / "exudyn_reduction.py"), folder, str(MODES)]
        theirs = json.loads(subprocess.run(run, stdout=subprocess.PIPE, check=True).stdout)

    # all nodes, as EXUDYN does, and with each library
    ours: dict[str, dict[str, tuple[float, float]]] = {}
    for solver in ("superlu", "best"):
        stages = Stages()
        reduced = jo.reduce(
            link_all(part),
            jo.CraigBampton(interfaces=("big", "small"), modes=MODES),
            solver=None if solver == "best" else solver,
            cache=False,
            progress=stages,
        )
        ours[solver] = stages.rows
    apart = np.max(np.abs(reduced.frequencies / np.array(theirs["frequencies"]) - 1.0)[:20])
    print(f"{part.K.shape[0]} dof, {len(elements[0])} tetrahedra, {reduced.n} modes, "
          f"EXUDYN {theirs['version']}; first 20 frequencies within {apart:.1e}")  # fmt: skip
    for solver, rows in ours.items():
        seconds = sum(s for stage, (s, _) in rows.items() if stage != "stress modes")
        stress = rows["stress modes"][0]
        print(
            f"jousto ({solver}): modes and invariants {seconds:.2f} s, stress modes {stress:.2f} s"
        )
        print(
            f"EXUDYN: modes {theirs['modes'][0]:.2f} s ({theirs['modes'][0] / seconds:.1f} times), "
            f"stress modes {theirs['stress modes'][0]:.2f} s "
            f"({theirs['stress modes'][0] / stress:.0f} times), "
            f"peaks {theirs['modes'][1]:.0f} and {theirs['stress modes'][1]:.0f} MiB"
        )
    # bending stress at the upper face, F (L - x) c / I
    x = part_b.nodes[sites, 0]
    exact = force * (1.0 - x) * 0.05 / (0.1**4 / 12.0)
    sign = np.sign(part_b.stress.at(sites).evaluate(u)[0, 0])
    mine = sign * part_b.stress.at(sites).evaluate(u)[:, 0] / exact - 1.0
    other = sign * np.array(theirs["beam"]) / exact - 1.0
    print(f"surface stress of the beam: jousto {100 * mine.min():+.2f} .. {100 * mine.max():+.2f} "
          f"%, EXUDYN {100 * other.min():+.2f} .. {100 * other.max():+.2f} %")  # fmt: skip


def link_all(part: Any) -> Any:
    """Return the part with stress at all nodes."""
    from dataclasses import replace

    from jousto.parts.solids.stress import SolidStress

    return replace(part, stress=SolidStress.everywhere(part.stress.model))


def main() -> None:
    """Run what the arguments ask for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sizes", nargs="*", default=USUAL)
    parser.add_argument("--solver")
    parser.add_argument("--kind", default="rigid", choices=("rigid", "average"))
    parser.add_argument("--repeat", type=int, default=1)
    parser.add_argument("--exudyn", metavar="PYTHON")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        print(json.dumps(child(given.sizes[0], given.solver, given.kind)))
        return
    if given.exudyn:
        for size in given.sizes:
            peer(size, given.exudyn)
        return
    results = []
    for size in given.sizes:
        run = [sys.executable, __file__, size, "--child", "--kind", given.kind]
        run += ["--solver", given.solver] if given.solver else []
        runs = [
            json.loads(subprocess.run(run, stdout=subprocess.PIPE, check=True).stdout)
            for _ in range(given.repeat)
        ]
        results.append(best(runs))
    show(results)


if __name__ == "__main__":
    main()
