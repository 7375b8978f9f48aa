"""Contacts: spheres that rest on a plane, beside EXUDYN and MuJoCo at their best settings.

.venv/bin/python benchmarks/contact.py [short]

Microseconds of processor time, least of many runs: an evaluation within RK4 and a step of 1 ms of
GeneralizedAlpha here; an explicit Euler step, which is one evaluation, of EXUDYN's GeneralContact;
a step of MuJoCo's Newton solver. Steel spheres of 50 mm, 0.3 m apart, each with friction.
"""

from __future__ import annotations

import os
import sys
import time
import warnings
from typing import Any

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

import jousto as jo
from jousto.mechanism import Contact, HalfSpace, PowerLaw, Sphere

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


def measure_exudyn(n: int, rounds: int) -> float:
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
        for at in places(n):
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


def measure_mujoco(n: int, rounds: int) -> float:
    """Microseconds of a step of 1 ms with Newton's solver."""
    import mujoco

    ball = f'<freejoint/><geom type="sphere" size="{RADIUS}" mass="{MASS}"/>'
    balls = "".join(f'<body pos="{x} {y} {z}">{ball}</body>' for x, y, z in places(n))
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="0.001" solver="Newton"/><size memory="2G"/>
        <default><geom friction="{FRICTION}" condim="3"/></default>
        <worldbody><geom type="plane" size="50 50 1"/>{balls}</worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=200)
    best = np.inf
    steps = max(5, STEPS // max(1, n // 10))
    for _ in range(rounds):
        begin = time.process_time()
        mujoco.mj_step(model, data, nstep=steps)
        best = min(best, 1e6 * (time.process_time() - begin) / steps)
    assert data.ncon == n
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


if __name__ == "__main__":
    main()
