"""The same study of 200 points in jousto and by the ParameterVariation of EXUDYN.

A rigid pendulum of 0.5 to 1.5 m, 1 s in 1000 steps of the generalised alpha method, largest x of
its middle. Process time of one thread, best of three.
Run: python benchmarks/exudyn_studies.py jousto|exudyn
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Callable

import numpy as np

POINTS = np.linspace(0.5, 1.5, 200)


def best(work: Callable[[], np.ndarray]) -> str:
    """Return the least process time of three, and what was found at the ends."""
    times = []
    for _ in range(3):
        start = time.process_time()
        found = work()
        times.append(time.process_time() - start)
    return f"{min(times):.3f} s for {len(found)} points, {found[0]:.6f} .. {found[-1]:.6f} m"


def ours() -> None:
    """Print the times of a study and of a loop over `simulate`."""
    import jousto as jo

    run = {"t_end": 1.0, "solver": jo.GeneralizedAlpha(1e-3), "output_step": 1e-2}

    def pendulum(length: float) -> jo.Mechanism:
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

    def loop() -> np.ndarray:
        runs = (jo.simulate(jo.compile(pendulum(length)), **run) for length in POINTS)
        return np.array([run["place"][:, 0].max() for run in runs])

    def study() -> np.ndarray:
        length = jo.Parameter("length", 1.0, unit="m")
        return jo.study(pendulum, length, "max(place.x)", **run)(POINTS[:, None])[:, 0]

    print("a loop over simulate", best(loop))
    print("a study             ", best(study))


def theirs() -> None:
    """Print the time of ParameterVariation."""
    import exudyn as exu
    from exudyn.processing import ParameterVariation
    from exudyn.utilities import RigidBodyInertia, SensorBody

    def pendulum(values: dict[str, float]) -> float:
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

    def variation() -> np.ndarray:
        _, values = ParameterVariation(
            parameterFunction=pendulum,
            parameters={"length": (POINTS[0], POINTS[-1], len(POINTS))},
            useMultiProcessing=False,
            showProgress=False,
        )
        return np.array(values)

    print("ParameterVariation  ", best(variation))


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    theirs() if sys.argv[1:] == ["exudyn"] else ours()
