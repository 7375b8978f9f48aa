"""What friction adds to an evaluation of the accelerations, against the same machine without it.

.venv/bin/python benchmarks/friction.py [short]
"""

from __future__ import annotations

import os
import sys
import time
import warnings

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

import jousto as jo
from machines import Link, body, slider_crank_links

H, STEPS, ROUNDS = 1e-4, 2000, 15
LAWS: dict[str, jo.mechanism.Regularised | jo.mechanism.StickSlip] = {
    "smooth": jo.mechanism.Regularised(0.01),
    "stick-slip": jo.mechanism.StickSlip(),
}


def pendulum(
    links: int, law: jo.mechanism.Regularised | jo.mechanism.StickSlip | None
) -> jo.Mechanism:
    """Rigid links in a row, friction in every hinge."""
    items: list[object] = [jo.Gravity((0.1, 0.3, -9.81))]
    before = jo.ground["origin"]
    for k in range(links):
        link = jo.RigidBody(
            f"link{k}",
            2.0,
            (0.01, 0.2, 0.2),
            center=(0.5, 0, 0),
            markers={"start": (0, 0, 0), "end": (1, 0, 0)},
            position=(k, 0, 0),
        )
        hinge = jo.Revolute(f"hinge{k}", before, link["start"], (0, 1, 0))
        items += [link, hinge]
        if law is not None:
            rub = jo.Friction(f"rub{k}", hinge, 0.1, 0.12, radius=0.05, bearing_length=0.1, law=law)
            items.append(rub)
        before = link["end"]
    return jo.Mechanism(*items)


def slider_crank(law: jo.mechanism.Regularised | jo.mechanism.StickSlip | None) -> jo.Mechanism:
    """Rigid spatial slider-crank, friction in the rail."""
    crank, rod = (body(Link(link.name, link.start, link.end)) for link in slider_crank_links())
    start = slider_crank_links()[1].end
    slider = jo.RigidBody("slider", 2.0, (0.01, 0.01, 0.01), position=start)
    rail = jo.Prismatic("rail", jo.ground.at(start), slider["origin"], (1, 0, 0))
    rub = () if law is None else (jo.Friction("rub", rail, 0.1, 0.12, bearing_length=0.1, law=law),)
    return jo.Mechanism(
        crank,
        rod,
        slider,
        jo.Revolute("bearing", jo.ground["origin"], crank["start"], (0, 0, 1)),
        jo.Spherical("crank pin", crank["end"], rod["start"]),
        jo.Spherical("slider pin", rod["end"], slider["origin"]),
        rail,
        *rub,
        jo.Gravity((0.0, 0.0, -9.81)),
    )


def evaluation(machine: jo.Mechanism, rounds: int) -> float:
    """Microseconds of an evaluation within steps of RK4, least of many."""
    model, best = jo.compile(machine), np.inf
    for _ in range(rounds):
        engine = jo.model.Engine(model)
        engine.assemble()
        solver = engine.native_solver("rk4", H, True)
        rows = np.zeros((STEPS // 10, engine.row_size))
        engine.run(solver, 10, 10, rows)
        engine.counts.evaluations = 0
        start = time.process_time()
        status, _ = engine.run(solver, STEPS, STEPS, rows)
        best = min(best, (time.process_time() - start) / int(engine.counts.evaluations))
        assert status == "ok"
    return 1e6 * best


def main() -> None:
    """Measure and print."""
    warnings.simplefilter("ignore")
    rounds = 1 if "short" in sys.argv else ROUNDS
    cases = {f"{n} links, {n} frictions": lambda law, n=n: pendulum(n, law) for n in (1, 5, 50)}
    cases["slider-crank, 1 friction"] = slider_crank
    print(f"{'microseconds an evaluation':28s} {'without':>9s}", end="")
    print("".join(f"{law:>12s} {'ratio':>6s}" for law in LAWS))
    for name, make in cases.items():
        without = evaluation(make(None), rounds)
        print(f"{name:28s} {without:9.2f}", end="")
        for law in LAWS.values():
            rubbed = evaluation(make(law), rounds)
            print(f"{rubbed:12.2f} {rubbed / without:6.2f}", end="")
        print(flush=True)


if __name__ == "__main__":
    main()
