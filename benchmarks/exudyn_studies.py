"""The same study of 200 points in jousto and by the ParameterVariation of EXUDYN.

A rigid pendulum of 0.5 to 1.5 m, 1 s in 1000 steps of the generalised alpha method, largest x of
its middle. Process time of this process and wall time, least of three.
Run: python benchmarks/exudyn_studies.py jousto|exudyn
"""

from __future__ import annotations

import os
import sys
import time
import warnings
from collections.abc import Callable

import numpy as np

POINTS = np.linspace(0.5, 1.5, 200)


RUN = {"t_end": 1.0, "output_step": 1e-2}


def best(work: Callable[[], np.ndarray]) -> str:
    """Return the least process time and wall time of three, and what was found at the ends."""
    times = []
    for _ in range(3):
        start, begin = os.times(), time.perf_counter()
        found = work()
        used = sum(os.times()[:4]) - sum(start[:4])  # with processes that have ended
        times.append((used, time.perf_counter() - begin))
    least = np.min(times, axis=0)
    ends = f"{found[0]:.6f} .. {found[-1]:.6f} m"
    return f"process {least[0]:.3f} s, wall {least[1]:.3f} s for {len(found)} points, {ends}"


def pendulum(length: float) -> object:
    """Return the pendulum of jousto."""
    import jousto as jo

    body = jo.RigidBody(
        "body",
        1.0,
        (1e-4, 1e-4, 1e-4),
        position=(0, -length, 0),
        velocity=(1, 0, 0),
        angular_velocity=(0, 0, 1 / length),
        markers={"top": (0, length, 0)},
    )
    pivot = jo.Spherical("pivot", jo.ground["origin"], body["top"])
    place = jo.PositionSensor("place", body["origin"])
    return jo.Mechanism(body, pivot, jo.Gravity((0, -9.81, 0)), place)


def ours() -> None:
    """Print the times of a study and of a loop over `simulate`."""
    import jousto as jo

    solver = jo.GeneralizedAlpha(1e-3)

    def loop() -> np.ndarray:
        runs = (jo.simulate(jo.compile(pendulum(x)), solver=solver, **RUN) for x in POINTS)
        return np.array([run["place"][:, 0].max() for run in runs])

    def study(**ways: object) -> np.ndarray:
        length = jo.Parameter("length", 1.0, unit="m")
        made = jo.study(pendulum, length, "max(place.x)", solver=solver, **RUN)
        return made.run(POINTS[:, None], **ways).y[:, 0]

    print("a loop over simulate     ", best(loop))
    print("a study                  ", best(study))
    print("a study, 2 threads       ", best(lambda: study(workers=2)))
    print("a study, 2 processes     ", best(lambda: study(workers=2, how="processes")))


def swing(values: dict[str, float]) -> float:
    """Return what EXUDYN's pendulum reaches."""
    import exudyn as exu
    from exudyn.utilities import RigidBodyInertia, SensorBody

    length = values["length"]
    system = exu.SystemContainer().AddSystem()
    ground = system.CreateGround()
    body = system.CreateRigidBody(
        inertia=RigidBodyInertia(1.0, 1e-4 * np.eye(3), com=[0, 0, 0]),
        referencePosition=[0, -length, 0],
        initialVelocity=[1.0, 0, 0],
        initialAngularVelocity=[0, 0, 1.0 / length],
        gravity=[0, -9.81, 0],
    )
    system.CreateSphericalJoint(bodyNumbers=[ground, body], position=[0, 0, 0])
    place = exu.OutputVariableType.Position
    sensor = system.AddSensor(
        SensorBody(bodyNumber=body, storeInternal=True, outputVariableType=place)
    )
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = 1000
    settings.timeIntegration.endTime = 1.0
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = 1e-2
    system.SolveDynamic(settings)
    return float(system.GetSensorStoredData(sensor)[:, 1].max())


def theirs() -> None:
    """Print the times of ParameterVariation, in one process and in two."""
    from exudyn.processing import ParameterVariation

    def variation(**ways: object) -> np.ndarray:
        _, values = ParameterVariation(
            parameterFunction=swing,
            parameters={"length": (POINTS[0], POINTS[-1], len(POINTS))},
            showProgress=False,
            **ways,
        )
        return np.array(values)

    print("ParameterVariation       ", best(lambda: variation(useMultiProcessing=False)))
    two = {"useMultiProcessing": True, "numberOfThreads": 2}
    print("ParameterVariation, 2 processes", best(lambda: variation(**two)))


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    theirs() if sys.argv[1:] == ["exudyn"] else ours()
