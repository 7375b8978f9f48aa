"""Machines of one structure side by side in the lanes of a vector, against one after the other.

.venv/bin/python benchmarks/ensembles.py [short]

Each figure is the least processor time of several runs; both kinds take turns.
"""

from __future__ import annotations

import os
import sys
import time
import warnings
from dataclasses import replace
from typing import Any

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

import jousto as jo
import trees
from cases import Case, beam, mechanism
from jousto.model.native import library
from jousto.model.native.ensemble import Ensemble, machines
from machines import RIGID_CHAINS, rigid_chain

H, STEPS, EVERY, ROUNDS = 1e-4, 2000, 200, 8


def varied(model: jo.Model, k: int) -> jo.Model:
    """Return the machine with other masses, stiffnesses and gravity."""
    f = 1.0 + 0.01 * k
    bodies = tuple(
        replace(b, mass=b.mass * f, S0=b.S0 * f, J0=b.J0 * f, K=b.K * f) for b in model.bodies
    )
    return replace(model, bodies=bodies, gravity=model.gravity * f).keeping_tree(model)


def one_by_one(models: list[jo.Model], solver: Any) -> tuple[float, np.ndarray]:
    """Return seconds, and the rows of all."""
    found, spent = [], 0.0
    for model in models:
        engine = jo.model.Engine(model)
        native = engine.native_solver(solver.method, H, solver.projection)
        rows = np.zeros((STEPS // EVERY, engine.row_size))
        start = time.process_time()
        engine.run(native, STEPS, EVERY, rows)
        spent += time.process_time() - start
        found.append(rows)
    return spent, np.array(found)


def together(models: list[jo.Model], solver: Any) -> tuple[float, np.ndarray]:
    """Return the same from lanes."""
    engines = [jo.model.Engine(model) for model in models]
    native = engines[0].native_solver(solver.method, H, solver.projection)
    lanes = Ensemble(engines)
    start = time.process_time()
    rows = lanes.run(native, STEPS, EVERY)
    return time.process_time() - start, rows


def main() -> None:
    """Measure and print."""
    warnings.simplefilter("ignore", jo.JoustoWarning)
    table = {
        f"pendulum of {n} modes": jo.compile(mechanism(Case("spherical", 1, n), beam(n)))
        for n in (4, 10, 30)
    }
    chain = next(c for c in RIGID_CHAINS if c.bodies == 10 and c.joint == "revolute")
    table["10 rigid links, maximal"] = jo.compile(rigid_chain(chain), core="maximal")
    links = {
        "hinge chain of 10": trees.chain("hinge", 10),
        "hinge chain of 100": trees.chain("hinge", 100),
    }
    links |= {"ball chain of 10": trees.chain("ball", 10), "six-axis arm": trees.arm()}
    links["figure of 30"] = trees.figure()
    for name, tree in links.items():
        table[name] = jo.compile(trees.mechanism(tree), core="joint")
    rounds = ROUNDS
    if "short" in sys.argv:
        rounds, table = 1, dict([table.popitem()])
    builds = dict(library.LANES)
    for build, level in builds.items():
        if library._level() < level:
            continue
        library.LANES.clear()
        library.LANES[build] = level
        library.lanes.cache_clear()
        print(f"{build}: {machines()} lanes; us per step of one machine, alone and in lanes")
        for name, model in table.items():
            models = [varied(model, k) for k in range(machines())]
            for solver in (jo.RK4(step=H), jo.ROS2(step=H)):
                least = [np.inf, np.inf]
                for _ in range(rounds):
                    alone, rows = one_by_one(models, solver)
                    shared, same = together(models, solver)
                    least = [min(least[0], alone), min(least[1], shared)]
                state = slice(1, 1 + model.nq + model.nv)
                apart = (
                    np.abs(rows[..., state] - same[..., state]).max()
                    / np.abs(rows[..., state]).max()
                )
                each = [1e6 * x / STEPS / machines() for x in least]
                print(
                    f"{name:24s} {solver.method:5s} {each[0]:7.2f} {each[1]:7.2f}"
                    f"   gain {each[0] / each[1]:5.2f}   apart {apart:.0e}",
                    flush=True,
                )
    alone = trees.ours(jo.compile(trees.mechanism(trees.chain("hinge", 10))), "rk4", rounds)
    print(f"10 rigid links, RK4, alone in joint coordinates {alone:.2f}")
    print(f"10 rigid links, RK4, MuJoCo's rollout on one thread {rollout(rounds):.2f}")


def rollout(rounds: int, count: int = 8) -> float:
    """Microseconds of a step of one of MuJoCo's machines in a batch, each at another speed."""
    import mujoco as mj
    from mujoco.rollout import rollout as run

    model = mj.MjModel.from_xml_string(trees.mujoco_text(trees.chain("hinge", 10)))
    model.opt.timestep = H
    data, kind, states = mj.MjData(model), mj.mjtState.mjSTATE_FULLPHYSICS, []
    for k in range(count):
        data.qvel[:] = 0.01 * k
        state = np.zeros(mj.mj_stateSize(model, kind))
        mj.mj_getState(model, data, state, kind)
        states.append(state)
    best = np.inf
    for _ in range(rounds):
        start = time.process_time()
        run(model, data, np.array(states), nstep=STEPS)
        best = min(best, time.process_time() - start)
    return 1e6 * float(best) / (STEPS * count)


if __name__ == "__main__":
    main()
