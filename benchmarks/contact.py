"""Contacts: spheres and a quadruped, beside EXUDYN and MuJoCo at their best settings.

.venv/bin/python benchmarks/contact.py [short]

Microseconds of processor time, least of many runs: an evaluation within RK4 and a step of 1 ms of
GeneralizedAlpha here; an explicit Euler step, which is one evaluation, of EXUDYN's GeneralContact;
a step of MuJoCo's Newton solver. Spheres of 50 mm with friction, 0.3 m apart, each with a contact
of its own; then cubes of spheres that touch, in a set whose pairs are found in each step. The
quadruped of examples/ stands. The last lines: steps far above the floor, with and without contacts.
"""

from __future__ import annotations

import os
import sys
import time
import warnings
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

import jousto as jo
from jousto.mechanism import CollisionShape, Contact, Contacts, HalfSpace, PowerLaw, Sphere

RADIUS, MASS, STIFFNESS, FRICTION = 0.05, 1.0, 1e5, 0.3  # m, kg, N/m, 1
APART = 0.3  # m
STEPS = 200


def places(n: int) -> np.ndarray:
    """Centres (n, 3) of spheres at rest on the plane z = 0, m."""
    side = int(np.ceil(np.sqrt(n)))
    k = np.arange(n)
    deep = MASS * 9.81 / STIFFNESS
    return np.stack([APART * (k % side), APART * (k // side), np.full(n, RADIUS - deep)], axis=1)


def ours(n: int, law: Any = None) -> jo.Model:
    """The spheres as bodies of a mechanism."""
    law = law or PowerLaw(STIFFNESS, 1.0, restitution=0.5)
    items: list[Any] = [jo.Gravity((0, 0, -9.81))]
    for k, at in enumerate(places(n)):
        ball = jo.RigidBody.sphere(f"ball {k}", radius=RADIUS, mass=MASS, position=at)
        touch = Contact(
            *(f"touch {k}", jo.ground["origin"], HalfSpace()),
            *(ball["origin"], Sphere(RADIUS), law),
            mu_kinetic=FRICTION,
        )
        items += [ball, touch]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the spheres are free
        return jo.compile(jo.Mechanism(*items))


def measure_ours(n: int, rounds: int) -> tuple[float, float]:
    """Microseconds of an evaluation of RK4, and of a step of GeneralizedAlpha."""
    model = ours(n)
    # the step of RK4 resolves the contact, so that no step is divided
    solvers = jo.RK4(2e-4), jo.GeneralizedAlpha(1e-3)
    best = [np.inf, np.inf]
    for _ in range(rounds):
        for i, solver in enumerate(solvers):
            engine = jo.model.Engine(model)
            engine.assemble()
            native = engine.native_solver(
                solver.method, solver.step, solver.projection, **solver.options
            )
            rows = np.zeros((STEPS // 10, engine.row_size))
            engine.run(native, 10, 10, rows)
            engine.counts.evaluations = 0
            begin = time.process_time()
            status, _ = engine.run(native, STEPS, 10, rows)
            spent = time.process_time() - begin
            count = STEPS if i else int(engine.counts.evaluations)
            best[i] = min(best[i], 1e6 * spent / count)
            assert status == "ok"
    return best[0], best[1]


def measure_exudyn(n: int, rounds: int, centres: np.ndarray | None = None) -> float:
    """Microseconds of a step of explicit Euler with GeneralContact."""
    import exudyn as exu
    import exudyn.utilities as eu

    best = np.inf
    for _ in range(rounds):
        container = exu.SystemContainer()
        system = container.AddSystem()
        contact = system.AddGeneralContact()
        contact.SetFrictionPairings(FRICTION * np.eye(1))
        contact.SetSearchTreeCellSize(numberOfCells=[max(1, int(np.sqrt(n)))] * 2 + [1])
        ground = system.AddObject(eu.ObjectGround())
        plane = system.AddMarker(eu.MarkerBodyRigid(bodyNumber=ground))
        width = APART * (2 + np.sqrt(n))
        corners = [[-width, -width, 0], [width, -width, 0], [width, width, 0], [-width, width, 0]]
        contact.AddTrianglesRigidBodyBased(
            rigidBodyMarkerIndex=plane,
            contactStiffness=2 * STIFFNESS,
            contactDamping=0.0,
            frictionMaterialIndex=0,
            pointList=corners,
            triangleList=[[0, 1, 2], [0, 2, 3]],
        )
        inertia = eu.InertiaSphere(MASS, RADIUS)
        for at in places(n) if centres is None else centres:
            made = system.CreateRigidBody(
                inertia=inertia,
                referencePosition=list(at),
                gravity=[0, 0, -9.81],
                nodeType=exu.NodeType.RotationRotationVector,
                returnDict=True,
            )
            marker = system.AddMarker(eu.MarkerNodeRigid(nodeNumber=made["nodeNumber"]))
            contact.AddSphereWithMarker(
                marker,
                radius=RADIUS,
                contactStiffness=2 * STIFFNESS,
                contactDamping=0.0,
                frictionMaterialIndex=0,
            )
        system.Assemble()
        settings = exu.SimulationSettings()
        settings.timeIntegration.numberOfSteps = STEPS
        settings.timeIntegration.endTime = STEPS * 1e-4
        settings.timeIntegration.verboseMode = 0
        settings.solution.file.write = False
        settings.timeIntegration.explicit.computeEndOfStepAccelerations = False
        settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
        kind = exu.DynamicSolverType.ExplicitEuler

        def solve(s: Any = system, kind: Any = kind, settings: Any = settings) -> None:
            s.SolveDynamic(settings, solverType=kind)

        # twice the steps less once: without the start of a run
        begin = time.process_time()
        solve()
        once = time.process_time() - begin
        settings.timeIntegration.numberOfSteps = 3 * STEPS
        settings.timeIntegration.endTime = 3 * STEPS * 1e-4
        begin = time.process_time()
        solve()
        thrice = time.process_time() - begin
        best = min(best, 1e6 * (thrice - once) / (2 * STEPS))
    return best


def measure_mujoco(
    n: int, rounds: int, centres: np.ndarray | None = None, touching: int = 0
) -> float:
    """Microseconds of a step of 1 ms with Newton's solver."""
    import mujoco

    ball = f'<freejoint/><geom type="sphere" size="{RADIUS}" mass="{MASS}"/>'
    at = places(n) if centres is None else centres
    balls = "".join(f'<body pos="{x} {y} {z}">{ball}</body>' for x, y, z in at)
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="0.001" solver="Newton"/><size memory="2G"/>
        <default><geom friction="{FRICTION}" condim="3"/></default>
        <worldbody><geom type="plane" size="50 50 1"/>{balls}</worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=5 if touching else 200)
    best = np.inf
    steps = max(2, STEPS // max(1, n // (1 if touching else 10)))
    for _ in range(rounds):
        begin = time.process_time()
        mujoco.mj_step(model, data, nstep=steps)
        best = min(best, 1e6 * (time.process_time() - begin) / steps)
    assert data.ncon > 0.9 * touching if touching else data.ncon == n
    return best


def heap(side: int) -> tuple[np.ndarray, int]:
    """Centres of a cube of touching spheres on the plane z = 0, m, and its number of contacts."""
    deep = 1e-4  # m, between two of them, and of the lowest ones in the plane
    k = np.arange(side) * (2 * RADIUS - deep)
    x = np.stack(np.meshgrid(k, k, k, indexing="ij"), axis=-1).reshape(-1, 3)
    return x + (0, 0, RADIUS - deep), 3 * side**2 * (side - 1) + side**2


def measure_heap(side: int, rounds: int) -> tuple[float, float]:
    """Microseconds of an evaluation of a heap, and of one in a run, with search and events."""
    centres, touching = heap(side)
    shapes = [CollisionShape("floor", jo.ground["origin"], HalfSpace())]
    items: list[Any] = [jo.Gravity((0, 0, -9.81))]
    for k, at in enumerate(centres):
        ball = jo.RigidBody.sphere(f"ball {k}", radius=RADIUS, mass=MASS, position=at)
        items.append(ball)
        shapes.append(CollisionShape(ball.name, ball["origin"], Sphere(RADIUS)))
    law = PowerLaw(STIFFNESS, 1.0, restitution=0.5)
    most = touching + len(centres)
    items.append(Contacts("set", shapes, law=law, mu_kinetic=FRICTION, overlap="start", most=most))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = jo.compile(jo.Mechanism(*items))
    steps = max(4, 200 // len(centres))
    within = time_run(model, jo.RK4(2e-4), steps, rounds, evaluations=True)
    engine = jo.model.Engine(model)
    engine.assemble()
    alone, repeats = np.inf, max(2, 4000 // len(centres))
    for _ in range(3 * rounds):
        begin = time.process_time()
        for _ in range(repeats):
            engine.accelerations()
        alone = min(alone, 1e6 * (time.process_time() - begin) / repeats)
    return alone, within


def time_run(model: jo.Model, solver: Any, steps: int, rounds: int, evaluations: bool) -> float:
    """Microseconds of a step, or of the parts into which contacts divide it, or an evaluation."""
    best = np.inf
    for _ in range(rounds):
        engine = jo.model.Engine(model)
        engine.assemble()
        native = engine.native_solver(
            solver.method, solver.step, solver.projection, **solver.options
        )
        rows = np.zeros((1, engine.row_size))
        engine.run(native, 2, 2, rows)
        engine.counts.evaluations = engine.counts.steps = 0
        begin = time.process_time()
        status, _ = engine.run(native, steps, steps, rows)
        spent = time.process_time() - begin
        assert status == "ok"
        count = engine.counts.evaluations if evaluations else engine.counts.steps
        best = min(best, 1e6 * spent / int(count))
    return best


def exudyn_heap(side: int, rounds: int) -> float:
    """The same with EXUDYN."""
    centres, _ = heap(side)
    return measure_exudyn(len(centres), rounds, centres)


def mujoco_heap(side: int, rounds: int) -> float:
    """The same with MuJoCo."""
    centres, touching = heap(side)
    return measure_mujoco(len(centres), rounds, centres, touching)


def quadruped(height: float, contacts: bool = True) -> jo.Model:
    """The standing quadruped of the example, `height` above its floor."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
    import quadruped as example

    return example.quadruped(above=height, contacts=contacts)


def mujoco_quadruped(rounds: int) -> float:
    """Microseconds of a step of the quadruped that stands, 2 ms, with MuJoCo's Newton solver."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(
        str(Path(__file__).parents[1] / "examples" / "data" / "quadruped.xml")
    )
    data = mujoco.MjData(model)
    stance = np.tile(np.radians((25, -50)), 4)
    data.qpos[2] = 0.4 * np.cos(np.radians(25)) + 0.025
    data.qpos[7:] = data.ctrl[:] = stance
    mujoco.mj_step(model, data, nstep=2000)
    best = np.inf
    for _ in range(rounds):
        begin = time.process_time()
        mujoco.mj_step(model, data, nstep=STEPS)
        best = min(best, 1e6 * (time.process_time() - begin) / STEPS)
    assert data.ncon == 4
    return best


def main() -> None:
    """Measure and print."""
    short = "short" in sys.argv
    rounds = 1 if short else 7
    print("spheres at rest on a plane, apart; us: an evaluation, a step of 1 ms, a step, a step")
    print(f"{'':8s}{'RK4':>9s} {'GeneralizedAlpha':>17s} {'EXUDYN':>9s} {'ratio':>6s} ", end="")
    print(f"{'MuJoCo':>9s} {'ratio':>6s}")
    for n in (1, 10) if short else (1, 10, 100, 1000):
        evaluation, step = measure_ours(n, rounds)
        print(f"{n:6d}  {evaluation:9.2f} {step:17.2f}", end="", flush=True)
        for peer, own in ((measure_exudyn, evaluation), (measure_mujoco, step)):
            theirs = peer(n, rounds)
            print(f" {theirs:9.2f} {theirs / own:6.1f}", end="", flush=True)
        print(flush=True)
    print(
        "cubes of spheres that touch; us: an evaluation, the same in a run of RK4, a step, a step"
    )
    for side in (1,) if short else (1, 5, 10):
        alone, within = measure_heap(side, rounds)
        print(f"{heap(side)[1]:6d}  {alone:9.2f} {within:17.2f}", end="", flush=True)
        for peer_heap in (exudyn_heap, mujoco_heap):
            theirs = peer_heap(side, rounds)
            print(f" {theirs:9.2f} {theirs / alone:6.1f}", end="", flush=True)
        print(flush=True)
    print("quadruped that stands on four contacts; us a step: 2 ms, RK4 in parts")
    standing = quadruped(0.0)
    theirs = mujoco_quadruped(rounds)
    for solver in (jo.RK4(1e-4), jo.ROS2(2e-3)):
        own = time_run(standing, solver, 50, rounds, evaluations=False)
        name = type(solver).__name__
        print(f"{name:6s}  {own:9.2f} {theirs:19.2f} {theirs / own:6.1f}", flush=True)
    print("the same 1 m above its floor; us a step: with contacts, without, ratio")
    high, none = quadruped(1.0), quadruped(1.0, contacts=False)
    for solver in (jo.RK4(5e-4), jo.ROS2(2e-3)):
        with_them, without = (time_run(one, solver, 50, 4 * rounds, False) for one in (high, none))
        name = type(solver).__name__
        print(f"{name:6s}  {with_them:9.2f} {without:9.2f} {with_them / without:9.3f}", flush=True)


if __name__ == "__main__":
    main()
