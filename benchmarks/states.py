"""First-order states: an arm on a hydraulic cylinder, beside EXUDYN and beside a unit (FMU).

.venv/bin/python benchmarks/states.py [short]

A uniform arm of 2 m and 300 kg stands on its cylinder, one chamber of which is filled through an
edge that is 5 % open, while the other one is emptied. All programs solve the same equations:
constant modulus, flow in proportion to the root of the pressure drop, volumes that change. EXUDYN
has them in C++ (ObjectConnectorHydraulicActuatorSimple), on a body in the plane, its cheapest one,
and on a body in space. The unit is the cylinder alone, exported by jousto, in a process of its own;
length and force are exchanged at each step.

Microseconds of processor time of a step, least of several runs, with the unit that of both
processes without their start. Error: largest one of the angle from DOP853 of scipy on the same
equations, written out by hand in the angle and the two pressures.
"""

from __future__ import annotations

import contextlib
import io
import os
import resource
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from scipy.integrate import solve_ivp

import jousto as jo
from jousto import hydraulics as h
from jousto.export.fmu import write_fmu
from jousto.mechanism import States, StateSensor
from jousto.simulation.solvers.base import prepared
from precision_fronts import front, time_at

LENGTH, MASS, TILT = 2.0, 300.0, np.radians(30.0)  # m, kg, angle at the start
FOOT, EYE = np.array([0.2, -0.6]), 0.7  # of the cylinder on the ground and along the arm, m
BORE, ROD, HOSE, MODULUS, DAMPING = 0.063, 0.036, 1e-4, 1.2e9, 5e3
FLOW, DROP, OPEN, HIGH = 40e-3 / 60, 3.5e6, 0.05, 16e6  # m3/s at Pa, opening, supply in Pa
SHARP = 1.0  # Pa, transition to laminar flow: EXUDYN's edges have none
A1, A2 = np.pi / 4 * BORE**2, np.pi / 4 * (BORE**2 - ROD**2)
KV = FLOW / np.sqrt(DROP)
INERTIA = MASS * LENGTH**2 / 12
T_END = 1.0
TIMES = np.linspace(0.05, T_END, 20)
STEPS = (5e-3, 2.5e-3, 1.25e-3, 6.25e-4, 3.125e-4)
LEAST = 1.25e-3  # s, smallest step at which the unit is measured, which takes long
TOLERANCE = 1e-6  # relative, of Newton's iteration of EXUDYN; its errors are those of 1e-8


def at_start() -> tuple[float, float, float, float]:
    """Closed length and stroke, m, and the pressures that carry the arm, Pa."""
    line = EYE * np.array([np.cos(TILT), np.sin(TILT)]) - FOOT
    length = float(np.linalg.norm(line))
    lever = EYE * (np.cos(TILT) * line[1] - np.sin(TILT) * line[0]) / length
    force = MASS * 9.81 * LENGTH / 2 * np.cos(TILT) / lever
    p2 = 2e6
    return length - 0.2, 0.5, (force + A2 * p2) / A1, p2


CLOSED, STROKE, P1, P2 = at_start()


def reference() -> np.ndarray:
    """Angles at TIMES, rad."""
    J = MASS * LENGTH**2 / 3

    def rule(t: float, y: Any) -> Any:
        q, w, p1, p2 = y
        e, n = np.array([np.cos(q), np.sin(q)]), np.array([-np.sin(q), np.cos(q)])
        line = EYE * e - FOOT
        length = np.linalg.norm(line)
        lever = EYE * n @ line / length
        x, v = length - CLOSED, lever * w
        force = A1 * p1 - A2 * p2 - DAMPING * v
        into, out = (OPEN * KV * np.sqrt(dp) for dp in (HIGH - p1, p2))
        return [
            w,
            (force * lever - MASS * 9.81 * LENGTH / 2 * np.cos(q)) / J,
            MODULUS / (HOSE + A1 * x) * (into - A1 * v),
            MODULUS / (HOSE + A2 * (STROKE - x)) * (A2 * v - out),
        ]

    start = [TILT, 0.0, P1, P2]
    found = solve_ivp(rule, (0, T_END), start, "DOP853", rtol=1e-12, atol=1e-9, t_eval=TIMES)
    return np.asarray(found.y[0])


def arm() -> tuple[list[Any], Any, Any]:
    """The arm with its hinge and weight; and the markers of the cylinder."""
    turn = (np.cos(TILT / 2), 0, 0, np.sin(TILT / 2))
    at = LENGTH / 2 * np.array([np.cos(TILT), np.sin(TILT), 0])
    body = jo.RigidBody(
        *("arm", MASS, (1.0, INERTIA, INERTIA)), position=at, orientation=turn,
        markers={"pin": (-LENGTH / 2, 0, 0), "eye": (EYE - LENGTH / 2, 0, 0)},
    )  # fmt: skip
    hinge = jo.Revolute("hinge", jo.ground["origin"], body["pin"], axis=(0, 0, 1))
    foot = jo.ground.at((*FOOT, 0.0))
    angle = jo.CoordinateSensor("angle", hinge.angle)
    return [body, hinge, angle, jo.Gravity((0, -9.81, 0))], foot, body["eye"]


def ours(core: str) -> jo.Model:
    """The arm with a network of oil."""
    items, foot, eye = arm()
    oil = h.HydraulicNetwork(
        "oil",
        [
            *(h.Supply("high", HIGH), h.Tank("tank"), h.Node("A", start=P1), h.Node("B", start=P2)),
            h.Orifice("in", "high", "A", flow=FLOW, drop=DROP, opening=OPEN),
            h.Orifice("out", "B", "tank", flow=FLOW, drop=DROP, opening=OPEN),
            h.HydraulicCylinder(
                *("lift", foot, eye, "A", "B"), bore=BORE, rod=ROD, closed=CLOSED, stroke=STROKE,
                piston_volume=HOSE, rod_volume=HOSE, damping=DAMPING,
            ),
        ],
        oil=h.Oil(modulus=MODULUS), transition=SHARP,
    )  # fmt: skip
    return jo.compile(jo.Mechanism(*items, oil, core=core))


def measure_ours(core: str, solver: Any, repeats: int) -> tuple[float, np.ndarray]:
    """Seconds of a step, and the angles at TIMES."""
    model, step = ours(core), solver.step
    run = jo.simulate(model, T_END, solver=solver, output_step=TIMES[0])
    least, steps = np.inf, round(T_END / step)
    for _ in range(repeats):
        engine = jo.model.Engine(model)
        engine.assemble()
        native = prepared(engine, solver, step)
        rows = np.zeros((2, engine.row_size))
        begin = time.process_time()
        engine.run(native, steps, steps, rows)
        least = min(least, (time.process_time() - begin) / steps)
    return least, np.asarray(run["angle"][1:, 0]) + TILT


def unit(folder: Path) -> Path:
    """The cylinder as a unit: length and its rate are inputs, the force is its output."""
    body = jo.RigidBody("dummy", 1.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"])
    pressures = {
        "p1": f"{MODULUS}/({HOSE} + {A1}*x)*({OPEN * KV}*sqrt({HIGH} - p1) - {A1}*v)",
        "p2": f"{MODULUS}/({HOSE} + {A2}*({STROKE} - x))*({A2}*v - {OPEN * KV}*sqrt(p2))",
    }
    x = jo.Input("length", initial=CLOSED + 0.2) - CLOSED
    inputs = {"x": x, "v": jo.Input("speed")}
    force = {"F": f"{A1}*p1 - {A2}*p2 - {DAMPING}*v"}
    block = States("oil", {"p1": P1, "p2": P2}, pressures, inputs=inputs, outputs=force)
    sensor = StateSensor("force", block["F"], unit="N")
    model = jo.compile(jo.Mechanism(body, rail, block, sensor, name="cylinder"))
    return write_fmu(model, folder / "cylinder.fmu", jo.RK4(step=6.25e-4), version=2)


def processor_time() -> float:
    """Processor time of this process and of those that it waited for, s."""
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + ended.ru_utime + ended.ru_stime


def measure_unit(file: Path, step: float, repeats: int) -> tuple[float, np.ndarray]:
    """The same of jousto's arm with the cylinder as a unit, exchanged at each step."""
    items, foot, eye = arm()
    line = jo.Distance(foot, eye, name="line")
    length, speed = jo.CoordinateSensor("length", line), jo.RateSensor("speed", line)
    push = jo.Input("push", initial=A1 * P1 - A2 * P2)
    act = jo.mechanism.BlockForce("act", line, push)
    fmu = jo.Fmu(
        file, inputs={"length": length, "speed": speed}, outputs={"force": push}, step=step,
        between="linear",
    )  # fmt: skip
    model = jo.compile(jo.Mechanism(*items, act, length, speed, fmu))
    least = np.inf

    def spent(t_end: float) -> tuple[float, Any]:
        begin = processor_time()
        run = jo.simulate(model, t_end, solver=jo.ROS2(step), output_step=TIMES[0])
        return processor_time() - begin, run

    for _ in range(repeats):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of the energy of the exchange: its error is shown
            start, (whole, run) = spent(TIMES[0])[0], spent(T_END)
        least = min(least, (whole - start) * step / (T_END - TIMES[0]))
    return least, np.asarray(run["angle"][1:, 0]) + TILT


def exudyn_arm(space: bool) -> tuple[Any, Any, Any]:
    """The module, the system and the sensor of the end, on a body in the plane or in space."""
    from exudyn_peer import eii, exu

    mbs = exu.SystemContainer().AddSystem()
    ground = mbs.AddObject(eii.ObjectGround())
    at = LENGTH / 2 * np.array([np.cos(TILT), np.sin(TILT)])
    pin = [-LENGTH / 2, 0, 0]

    def marker(number: Any, place: Any) -> Any:
        return mbs.AddMarker(eii.MarkerBodyPosition(bodyNumber=number, localPosition=place))

    if space:
        c, s = np.cos(TILT), np.sin(TILT)
        turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        inertia = exu.rigidBodyUtilities.RigidBodyInertia(MASS, np.diag([1, INERTIA, INERTIA]))
        body = mbs.CreateRigidBody(
            inertia=inertia, nodeType=exu.NodeType.RotationRotationVector,
            referencePosition=[*at, 0], referenceRotationMatrix=turn, returnDict=True,
        )["bodyNumber"]  # fmt: skip
        frames = [
            mbs.AddMarker(eii.MarkerBodyRigid(bodyNumber=b, localHT=exu.HT(turned, np.array(p))))
            for b, turned, p in ((ground, np.eye(3), [0, 0, 0]), (body, turn.T, pin))
        ]
        mbs.AddObject(eii.ObjectJointRevoluteZ(markerNumbers=frames))
    else:
        node = mbs.AddNode(eii.NodeRigidBody2D(referenceCoordinates=[*at, TILT]))
        body = mbs.AddObject(eii.ObjectRigidBody2D(mass=MASS, inertia=INERTIA, nodeNumber=node))
        both = [marker(ground, [0, 0, 0]), marker(body, pin)]
        mbs.AddObject(eii.ObjectJointRevolute2D(markerNumbers=both))
    mbs.AddLoad(
        eii.LoadForceVector(markerNumber=marker(body, [0, 0, 0]), loadVector=[0, -MASS * 9.81, 0])
    )
    oil = mbs.AddNode(
        eii.NodeGenericODE1(
            referenceCoordinates=[0, 0], initialCoordinates=[P1, P2], numberOfODE1Coordinates=2
        )
    )
    mbs.AddObject(
        eii.ObjectConnectorHydraulicActuatorSimple(
            markerNumbers=[marker(ground, [*FOOT, 0]), marker(body, [EYE - LENGTH / 2, 0, 0])],
            nodeNumbers=[oil], offsetLength=CLOSED, strokeLength=STROKE,
            chamberCrossSection0=A1, chamberCrossSection1=A2, hoseVolume0=HOSE, hoseVolume1=HOSE,
            valveOpening0=OPEN, valveOpening1=-OPEN, actuatorDamping=DAMPING,
            oilBulkModulus=MODULUS, nominalFlow=KV, systemPressure=HIGH, tankPressure=0.0,
            useChamberVolumeChange=True,
        )
    )  # fmt: skip
    sensor = mbs.AddSensor(
        eii.SensorBody(
            bodyNumber=body, localPosition=[LENGTH / 2, 0, 0], storeInternal=True,
            outputVariableType=exu.OutputVariableType.Position,
        )
    )  # fmt: skip
    mbs.Assemble()
    return exu, mbs, sensor


def measure_exudyn(
    step: float, space: bool, tolerance: float, repeats: int
) -> tuple[float, np.ndarray]:
    """The same of EXUDYN: generalised alpha, modified Newton."""
    exu, mbs, sensor = exudyn_arm(space)
    s = exu.SimulationSettings()
    s.timeIntegration.numberOfSteps = round(T_END / step)
    s.timeIntegration.endTime = T_END
    s.timeIntegration.verboseMode = 0
    s.timeIntegration.newton.useModifiedNewton = True
    s.timeIntegration.newton.relativeTolerance = tolerance
    s.timeIntegration.newton.numericalDifferentiation.minimumCoordinateSize = 1
    s.solution.file.write = False
    s.solution.sensors.writePeriod = TIMES[0]
    s.solution.file.writePeriod = T_END
    s.parallel.numberOfThreads = 1
    s.linearSolver.solverType = exu.LinearSolverType.EigenDense
    least = np.inf
    for _ in range(repeats):
        begin = time.process_time()
        with contextlib.redirect_stdout(io.StringIO()):
            mbs.SolveDynamic(s, solverType=exu.DynamicSolverType.GeneralizedAlpha)
        least = min(least, (time.process_time() - begin) * step / T_END)
    end = np.asarray(mbs.GetSensorStoredData(sensor))[1:]
    return least, np.arctan2(end[:, 2], end[:, 1])


def programs(file: Path) -> dict[str, Callable[[float, int], tuple[float, np.ndarray]]]:
    """Measurements over step and number of runs."""
    found: dict[str, Callable[[float, int], tuple[float, np.ndarray]]] = {
        "jousto, ROS2": lambda step, n: measure_ours("joint", jo.ROS2(step), n),
        "jousto, ROS2, all bodies": lambda step, n: measure_ours("maximal", jo.ROS2(step), n),
        "jousto, RK4": lambda step, n: measure_ours("joint", jo.RK4(step), n),
        "unit (FMU) in jousto": lambda step, n: measure_unit(file, step, min(n, 2)),
    }
    for space, name in ((False, "plane"), (True, "space")):
        found[f"EXUDYN, {name}"] = lambda step, n, space=space: measure_exudyn(
            step, space, TOLERANCE, n
        )
    return found


def main() -> None:
    """Measure and print."""
    short = "short" in sys.argv
    repeats, steps = (1, STEPS[:2]) if short else (15, STEPS)
    wanted, points = reference(), []
    print("an arm on a hydraulic cylinder, 1 s; us: a step; error: of the angle, rad")
    print(f"{'step, ms':26s}" + "".join(f"{1e3 * step:>16g}" for step in steps))
    with tempfile.TemporaryDirectory() as folder:
        for name, measure in programs(unit(Path(folder))).items():
            print(f"{name:26s}", end="", flush=True)
            for step in steps:
                if "unit" in name and step < LEAST:
                    break
                seconds, angles = measure(step, repeats)
                error = float(np.abs(angles - wanted).max())
                assert error < 1e-3, "another machine"
                print(f"{1e6 * seconds:8.2f} {error:7.1e}", end="", flush=True)
                points.append(
                    {"program": name, "method": "", "error": error, "seconds": seconds / step}
                )
            print()
    own = front([p | {"program": "jousto"} for p in points if "jousto, " in p["program"]], "jousto")
    print("\ntime of a second at the same error, over that of jousto")
    for name in ("unit (FMU) in jousto", "EXUDYN, plane", "EXUDYN, space"):
        theirs = front(points, name)
        for error in theirs[[0, -1], 0]:
            at = max(min(error, own[0, 0]), own[-1, 0])
            ratio = time_at(theirs, at) / time_at(own, at)
            if np.isfinite(ratio):
                print(f"{name:26s} at {at:.1e} rad: {ratio:.0f}")


if __name__ == "__main__":
    main()
