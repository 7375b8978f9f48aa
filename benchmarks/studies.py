"""What a study costs beside the engine's steps: 1 s of the flexible pendulum, many times.

Process time of one thread. Run: python benchmarks/studies.py [points]
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

import jousto as jo
from jousto.model.native.native import Engine
from jousto.simulation.solvers.base import prepared

MODEL = (Path(__file__).parent.parent / "examples" / "flexible_pendulum.yaml").read_text()
SOLVER, STEPS, EVERY = jo.RK4(1e-3), 1000, 10
BLOCK = 20  # points
RUN = {"t_end": 1.0, "solver": SOLVER, "output_step": 1e-2}
OUTCOMES = ["max(tip.x)", "last(middle.y)"]


def rod(height: float) -> jo.ReducedPart:
    """Return the reduced rod of the example."""
    part = jo.Part.frame(
        nodes=[[0, 0, 0], [0.5, 0, 0], [1, 0, 0], [1.5, 0, 0], [2, -1e-5, 0]],
        elements=[[0, 1], [1, 2], [2, 3], [3, 4]],
        sections=jo.Rectangle(0.1, height),
        materials=jo.Material(E=207e6, nu=0.3, rho=7850.0),
        lumped=True,
    )
    reduced = jo.reduce(part, jo.CraigBampton(["node1"], 4))
    return reduced.keep(reduced.in_plane("xy"))


def pendulum(height: float = 0.1, g: float = 9.81) -> jo.Mechanism:
    """Return the pendulum with a force at its tip that is an input."""
    return hung(rod(height), g)


def hung(part: jo.ReducedPart, g: float) -> jo.Mechanism:
    """Return the pendulum of a rod that was made before."""
    arm = jo.FlexibleBody("arm", part)
    return jo.Mechanism(
        arm,
        jo.Spherical("pivot", jo.ground["origin"], arm["node1"]),
        jo.Force("push", arm["node5"], (1.0, 0.0, 0.0), signal=jo.Input("load")),
        jo.Gravity((0, -g, 0)),
        jo.PositionSensor("middle", arm["node3"]),
        jo.PositionSensor("tip", arm["node5"]),
    )


def spent(work: Callable[[], object]) -> float:
    """Return the process time of some work, s."""
    start = time.process_time()
    work()
    return time.process_time() - start


def steps_alone(model: jo.Model) -> float:
    """Return the process time of the steps of one point alone."""
    engine = Engine(model)
    native, rows = prepared(engine, SOLVER, 1e-3), np.empty((STEPS // EVERY, engine.row_size))
    return spent(lambda: engine.run(native, STEPS, EVERY, rows))


def compare(name: str, machine: object, parameter: jo.Parameter, count: int) -> None:
    """Print what points cost beside their steps, in blocks that alternate."""
    study = jo.study(machine, parameter, OUTCOMES, **RUN)
    model = study.case().model
    points = jo.design.latin_hypercube(study.parameters, count)
    study(points[:2] + 1e-9)
    whole, steps = [], []
    for block in np.array_split(points, max(1, count // BLOCK)):
        whole.append(spent(lambda b=block: study.run(b)) / len(block))
        steps.append(sum(steps_alone(model) for _ in block) / len(block))
    ratios = np.array(whole) / steps
    print(
        f"{name}: {count} points, {1e3 * min(whole):.3f} ms each at the least, steps alone "
        f"{1e3 * min(steps):.3f} ms; ratio of sums {sum(whole) / sum(steps):.2f}, of blocks "
        f"{np.median(ratios):.2f} ({ratios.min():.2f} to {ratios.max():.2f}); {study.counts}"
    )


def block(x: float) -> jo.Mechanism:
    """Return a machine of which only the mass is asked: a point that costs next to nothing."""
    return jo.Mechanism(jo.RigidBody("block", 1.0 + x, (1, 1, 1)))


def slope(run: Callable[[int], object], few: int, many: int, times: int = 3) -> tuple[float, float]:
    """Return wall time of a further point and what is left at none, s, of the least of some."""
    least = []
    for n in (few, many):
        spans = []
        for _ in range(times):
            start = time.perf_counter()
            run(n)
            spans.append(time.perf_counter() - start)
        least.append(min(spans))
    each = (least[1] - least[0]) / (many - few)
    return each, least[0] - few * each


def scale() -> None:
    """Print wall times of the section in one and two processes, and what Dask takes for a task."""
    height = jo.Parameter("height", 0.1, bounds=(0.09, 0.11), unit="m")
    for workers in (1, 2):

        def run(n: int, workers: int = workers) -> object:
            study = jo.study(pendulum, height, OUTCOMES, **RUN)
            points = jo.design.latin_hypercube(study.parameters, n)
            return study.run(points, workers=workers, how="processes")

        each, first = slope(run, 320, 960, 2)
        print(
            f"the section, {workers} processes: {1e3 * each:.2f} ms a point, {first:.2f} s before"
        )
    from distributed import Client, LocalCluster

    x = jo.Parameter("x", 0.0, bounds=(0.0, 1.0))
    study = jo.study(block, x, "mass")
    with (
        LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        points = np.linspace(0.0, 1.0, 10_000)[:, None]
        client.gather(client.map(abs, range(10)))
        each, _ = slope(lambda n: study.run(points[:n]), 320, 1600)
        dask, _ = slope(lambda n: study.run(points[:n], workers=client), 320, 1600)
        empty, _ = slope(lambda n: client.gather(client.map(abs, range(n), pure=False)), 100, 500)
    print(f"a mass: {1e3 * each:.3f} ms alone, {1e3 * dask:.3f} ms by Dask")
    print(f"an empty task of Dask {1e3 * empty:.2f} ms")


def main() -> None:
    """Print the times."""
    warnings.simplefilter("ignore")
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    model = jo.compile(pendulum())
    load = jo.Parameter("load", 0.0, bounds=(-100.0, 100.0), unit="N")
    g = jo.Parameter("g", 9.81, bounds=(9.0, 10.0), unit="m/s2")
    height = jo.Parameter("height", 0.1, bounds=(0.09, 0.11), unit="m")
    made = rod(0.1)
    compare("an input (runs only)", model, load, count)
    compare("gravity, the part made before (compiles)", partial(hung, made), g, count)
    compare("gravity (makes the part, compiles)", pendulum, g, count // 5)
    compare("the section (reduces, compiles)", pendulum, height, count // 10)
    n = min(200, count)
    loads = jo.design.latin_hypercube([load], n)[:, 0]

    def loop() -> None:
        for value in loads:
            run = jo.simulate(model, inputs={"load": float(value)}, **RUN)
            run["tip"][:, 0].max(), run["middle"][-1, 1]

    study = jo.study(model, load, OUTCOMES, **RUN)
    print(
        f"{n} points of an input: a loop over simulate {min(spent(loop) for _ in range(3)):.3f} s"
    )
    print(f"the same by study {min(spent(lambda: study(loads[:, None])) for _ in range(3)):.3f} s")
    scale()


if __name__ == "__main__":
    main()
