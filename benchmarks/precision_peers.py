"""Runs of EXUDYN, MuJoCo and Pinocchio for the work-precision diagrams.

Each function returns one of the form of `precision_ours.stepper`: settings -> Run.
"""

from __future__ import annotations

import contextlib
import io
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

import pinocchio_native
from cases import LENGTH
from precision_ours import INSTANTS, Run
from trees import Link, mujoco_text, pinocchio as package_of_pinocchio

Stepper = Callable[[dict[str, Any]], Run]


def exudyn(build: Callable[[], tuple[Any, Any]], end: float, dense: bool) -> Stepper:
    """Settings: "step", s; for generalised alpha (no "solver") "tolerance" of Newton, "modified".

    The loop of EXUDYN as `SolveDynamic` calls it, nothing written but the tip at the instants.
    """
    from exudyn_peer import exu

    mbs, tip = build()
    mbs.Assemble()

    def run(setting: dict[str, Any]) -> Run:
        try:
            return attempt(setting)
        except ArithmeticError:
            if not setting.get("modified"):
                raise
            return attempt(setting | {"modified": False})  # full Newton, where modified one fails

    def attempt(setting: dict[str, Any]) -> Run:
        s, solver = exu.SimulationSettings(), setting.get("solver", "GeneralizedAlpha")
        steps = round(end / setting["step"])
        s.timeIntegration.numberOfSteps, s.timeIntegration.endTime = steps, end
        s.timeIntegration.verboseMode = 0
        if "tolerance" in setting:
            s.timeIntegration.newton.relativeTolerance = setting["tolerance"]
            s.timeIntegration.newton.useModifiedNewton = setting["modified"]
        else:
            s.timeIntegration.explicit.useLieGroupIntegration = False
            s.timeIntegration.explicit.computeEndOfStepAccelerations = False
        s.solutionSettings.writeSolutionToFile = False
        s.solutionSettings.sensorsWritePeriod = end / INSTANTS
        s.solutionSettings.solutionWritePeriod = end
        s.parallel.numberOfThreads = 1
        kinds = exu.LinearSolverType
        s.linearSolverType = kinds.EigenDense if dense else kinds.EigenSparse
        kind, begin = getattr(exu.DynamicSolverType, solver), time.process_time()
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                done = mbs.SolveDynamic(s, solverType=kind, storeSolver=True)
        except Exception as error:  # its SolverError, of Newton's iteration
            raise ArithmeticError(str(error)[:60]) from None
        spent = time.process_time() - begin
        places = np.asarray(mbs.GetSensorStoredData(tip))[-INSTANTS:, 1:4]
        if not done or len(places) < INSTANTS or not np.isfinite(places).all():
            raise ArithmeticError("diverged")
        return spent, places.copy()

    return run


def mujoco(links: Sequence[Link], end: float, integrator: str) -> Stepper:
    """Settings: "step", s. Its loop in C; no contacts and constraints."""
    import mujoco as mj

    text = mujoco_text(list(links)).replace('integrator="RK4"', f'integrator="{integrator}"')
    model = mj.MjModel.from_xml_string(text)
    data = mj.MjData(model)

    def run(setting: dict[str, Any]) -> Run:
        mj.mj_resetData(model, data)
        model.opt.timestep = setting["step"]
        places, spent, count = [], 0.0, round(end / setting["step"]) // INSTANTS
        for _ in range(INSTANTS):
            begin = time.process_time()
            mj.mj_step(model, data, nstep=count)
            spent += time.process_time() - begin
            mj.mj_kinematics(model, data)
            places.append(data.xpos[-1] + LENGTH * data.xmat[-1].reshape(3, 3)[:, 0])
        if not np.isfinite(places).all():
            raise ArithmeticError("diverged")
        return spent, np.array(places)

    return run


def pinocchio(links: Sequence[Link], end: float) -> Stepper:
    """Settings: "step", s. Classical Runge-Kutta around its `aba`, compiled with our flags.

    Where four evaluations of its package, in a loop of its own, take less, they are its time.
    """
    package = package_of_pinocchio(list(links), 3)[0]

    def run(setting: dict[str, Any]) -> Run:
        count = round(end / setting["step"])
        found = pinocchio_native.steps(links, setting["step"], count, count // INSTANTS)
        return 1e-6 * min(found.step, package) * count, found.places

    return run
