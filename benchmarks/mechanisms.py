"""Rigid chains and flexible loops side by side with EXUDYN, rigid chains with Pinocchio.

.venv/bin/python benchmarks/mechanisms.py         two minutes, part of `make bench`
.venv/bin/python benchmarks/mechanisms.py quick   without the chains of 1000
.venv/bin/python benchmarks/mechanisms.py short   without those of 100 either: half a minute
"""

from __future__ import annotations

import os
import sys
import time
import warnings
from collections.abc import Callable, Sequence
from typing import Any

# one thread, also in the linear algebra around the engine
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

import exudyn_machines as peer
import exudyn_peer
import jousto as jo
import machines
from cases import PENDULUMS, Case, beam, mechanism
from machines import RIGID_CHAINS, RigidChain

H = 1e-3  # s, step of both codes

SECONDS = 0.4  # of processor time for the repetitions of a run
AGREEMENT = 2e-4  # m, of both codes at the coarse step with jousto at a fine step


def motion(model: jo.Model, solver: Any, times: np.ndarray) -> np.ndarray:
    run = jo.simulate(model, times[-1], solver=solver, output_step=times[0])
    return np.asarray(run["tip"][1:])


def gap(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.linalg.norm(a - b, axis=1).max())


def cost(model: jo.Model, solver: Any, t_end: float) -> float:
    """Microseconds per step of the run that is compared: the least of several, processor time.

    The engine alone, as `simulate` calls it; what Python adds does not depend on the steps.
    """
    engine = jo.model.Engine(model)
    native = engine.native_solver(solver.method, solver.step, solver.projection)
    rows = np.zeros((1, engine.row_size))
    steps, best, begin = round(t_end / solver.step), np.inf, time.process_time()
    for k in range(1000):
        engine.q[:], engine.v[:], engine.time[0] = model.q0, model.v0, 0.0
        start = time.process_time()
        engine.run(native, steps, 10**9, rows)
        best = min(best, time.process_time() - start)
        if k > 3 and time.process_time() - begin > SECONDS:
            break
    return 1e6 * best / steps


def compare(
    name: str, ours: jo.Mechanism, build: Callable[[], tuple[Any, Any]], t_end: float
) -> tuple[float, float, float]:
    """Print one line; return microseconds per step of RK4, ROS2 and the peer."""
    times = np.linspace(0.0, t_end, 6)[1:]
    model = jo.compile(ours)
    solvers = (jo.RK4(step=H), jo.ROS2(step=H))
    rk4, ros2 = (cost(model, solver, t_end) for solver in solvers)
    bodies = len(model.bodies)
    run = peer.runner(*build(), times, dense=bodies <= 3)
    reference = motion(model, jo.RK4(step=H / 8), times)
    tolerance = exudyn_peer.loosest(lambda x: gap(run(H, 1, x).tip, reference))
    theirs = run(H, {1: 3, 3: 5, 10: 5, 100: 2}.get(bodies, 1), tolerance)
    tips = [motion(model, solver, times) for solver in solvers] + [theirs.tip]
    errors = [gap(tip, reference) for tip in tips]
    print(
        f"{name:32s} {rk4:9.2f} {ros2:9.2f} {theirs.microseconds:9.0f} {tolerance:6.0e} "
        f"{theirs.newton:6.1f} {theirs.microseconds / ros2:6.1f} {theirs.microseconds / rk4:6.1f} "
        f"{errors[0]:8.1e} {errors[1]:8.1e} {errors[2]:8.1e}",
        flush=True,
    )
    if not max(errors) < AGREEMENT:
        raise RuntimeError(f"{name}: the codes differ by {max(errors):.1e} m")
    return rk4, ros2, theirs.microseconds


def growth(costs: dict[int, tuple[float, ...]]) -> str:
    """Exponents of N between neighbouring sizes, for every column of costs."""
    sizes = sorted(costs)
    lines = []
    for a, b in zip(sizes, sizes[1:], strict=False):
        powers = [
            f"{np.log(y / x) / np.log(b / a):.2f}" for x, y in zip(costs[a], costs[b], strict=True)
        ]
        lines.append(f"N = {a} to {b}: {', '.join(powers)}")
    return "; ".join(lines)


def trees(chains: list[RigidChain], rk4: dict[int, float]) -> None:
    """Revolute chains in EXUDYN's joint angles with the same Runge-Kutta method."""
    print(
        "\nrevolute chains, classical Runge-Kutta in both; EXUDYN in joint angles (kinematic tree)"
    )
    print(f"{'':32s} {'jousto':>9s} {'EXUDYN':>9s} {'ratio':>7s} {'apart, m':>9s}")
    for case in chains:
        if case.joint != "revolute" or case.bodies > 100:
            continue
        times = np.linspace(0.0, case.t_end, 6)[1:]
        model = jo.compile(machines.rigid_chain(case))
        run = peer.runner(*peer.tree(case), times, dense=True, explicit=True)
        theirs = run(H, 5 if case.bodies <= 10 else 1)
        apart = gap(theirs.tip, motion(model, jo.RK4(step=H), times))
        ours = rk4[case.bodies]
        print(
            f"{case.name:32s} {ours:9.2f} {theirs.microseconds:9.1f} "
            f"{theirs.microseconds / ours:7.1f} {apart:9.1e}",
            flush=True,
        )


def forward_dynamics(sizes: Sequence[int]) -> None:
    """One evaluation of the accelerations against Pinocchio.

    Its workspace holds four arrays of second derivatives of N^3 numbers: 32 GB for 1000 links.
    """
    try:
        import pinocchio_peer
    except ImportError:
        print("\nPinocchio is not installed (pip install pin)")
        return
    print("\naccelerations, us, called from Python: jousto (with reactions), Pinocchio's ABA")
    print(f"{'':32s} {'jousto':>9s} {'Pinocchio':>9s} {'ratio':>7s} {'apart':>9s}")
    for bodies in sizes:
        case = RigidChain("revolute", bodies, 0.0)
        r = pinocchio_peer.compare(case)
        print(
            f"{case.name:32s} {r.ours:9.2f} {r.theirs:9.2f} {r.theirs / r.ours:7.2f} "
            f"{r.apart:9.1e}",
            flush=True,
        )


def main(arguments: list[str]) -> None:
    warnings.simplefilter("ignore", jo.JoustoWarning)
    short = "short" in arguments
    most = 10 if short else 100 if arguments else 1000
    chains = [c for c in RIGID_CHAINS if c.bodies <= most]
    print(f"one core; step {H * 1e3:g} ms; EXUDYN: generalised alpha, modified Newton with the")
    print("loosest relative tolerance (tol.) that keeps its error")
    print("distance: largest one of the sensor from jousto's RK4 at 1/8 of the step\n")
    print(
        f"{'':32s} {'jousto, us/step':>19s} {'EXUDYN':>9s} {'':6s} {'Newton':>6s} {'ratio':>13s} "
        f"{'distance, m':>26s}"
    )
    print(
        f"{'':32s} {'RK4':>9s} {'ROS2':>9s} {'us/step':>9s} {'tol.':>6s} {'/step':>6s} "
        f"{'ROS2':>6s} {'RK4':>6s} {'RK4':>8s} {'ROS2':>8s} {'EXUDYN':>8s}"
    )
    compare("slider-crank, flexible rod", machines.slider_crank(), peer.slider_crank, 1.0)
    compare("four-bar, flexible links", machines.four_bar(), peer.four_bar, 1.0)
    costs: dict[str, dict[int, tuple[float, ...]]] = {}
    for pendulum in PENDULUMS[: 1 if short else None]:
        part = beam(pendulum.modes)
        compare(
            pendulum.name,
            mechanism(pendulum, part),
            lambda case=pendulum, part=part: exudyn_peer.model(case, part),  # type: ignore[misc]
            pendulum.t_end,
        )
    reduced = beam(10)
    for joint in ("spherical", "revolute"):
        found = costs.setdefault(f"{joint}, n = 10", {})
        for bodies, t_end in ((10, 0.5), (100, 0.1))[: 1 if short else 2]:
            flexible = Case(joint, bodies, 10, t_end)
            found[bodies] = compare(
                flexible.name,
                mechanism(flexible, reduced),
                lambda case=flexible: exudyn_peer.model(case, reduced),  # type: ignore[misc]
                t_end,
            )
    for case in chains:
        costs.setdefault(f"{case.joint}, rigid", {})[case.bodies] = compare(
            case.name,
            machines.rigid_chain(case),
            lambda case=case: peer.rigid_chain(case),  # type: ignore[misc]
            case.t_end,
        )
    print("\ncost ~ N^p, p of RK4, ROS2, EXUDYN")
    for kind, found in costs.items():
        print(f"{kind:18s} {growth(found)}")
    trees(chains, {n: c[0] for n, c in costs["revolute, rigid"].items()})
    forward_dynamics((10,) if short else (10, 100, 200))


if __name__ == "__main__":
    main(sys.argv[1:])
