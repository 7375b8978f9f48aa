"""Runs of jousto for the work-precision diagrams: processor time of the engine, and the motion."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

import jousto as jo
from jousto.model.native.header import places

INSTANTS = 5  # at which motions are compared
Array = NDArray[np.float64]
Run = tuple[float, Array]
"""Processor time of the steps of a run, s; places of the tip (INSTANTS, 3), m."""
METHODS: dict[str, Any] = {
    "RK4": jo.RK4,
    "ROS2": jo.ROS2,
    "ROS3A": jo.simulation.ROS3A,
    "GeneralizedAlpha": jo.GeneralizedAlpha,
}
SHARE = 0.2  # longest step of DormandPrince, of the time between two instants


def stepper(model: jo.Model, end: float, method: str) -> Callable[[dict[str, float]], Run]:
    """Return a function {"step": h} or {"tolerance": x} -> Run of the model's sensor "tip"."""
    at = 1 + model.nq + model.nv + model.nrow + len(places("jo_diagnostics"))

    def run(setting: dict[str, float]) -> Run:
        engine = jo.model.Engine(model)
        if method == "DormandPrince":
            rows, spent = adaptive(engine, end, setting["tolerance"])
        else:
            rows, spent = fixed(engine, METHODS[method](**setting), end)
        tip = rows[:, at : at + 3]
        if not np.isfinite(tip).all():
            raise ArithmeticError("diverged")
        return spent, tip.copy()

    return run


def fixed(engine: Any, solver: Any, end: float) -> tuple[Array, float]:
    """Rows at the instants, and the time of all steps of one length."""
    native = engine.native_solver(solver.method, solver.step, solver.projection, **solver.options)
    steps, rows = round(end / solver.step), np.zeros((INSTANTS, engine.row_size))
    begin = time.process_time()
    status, _ = engine.run(native, steps, steps // INSTANTS, rows)
    spent = time.process_time() - begin
    if status != "ok":
        raise ArithmeticError(status)
    return rows, spent


def adaptive(engine: Any, end: float, tolerance: float) -> tuple[Array, float]:
    """Rows at the instants, and the time of the steps of DormandPrince."""
    solver, between = jo.simulation.DormandPrince(tolerance=tolerance), end / INSTANTS
    options = solver.options | {"largest": SHARE * between}
    native = engine.native_solver(solver.method, between, True, **options)
    rows = np.zeros((INSTANTS + 1, engine.row_size))
    begin = time.process_time()
    status, _ = engine.follow(native, INSTANTS, 10**7, rows)
    spent = time.process_time() - begin
    if status != "ok":
        raise ArithmeticError(status)
    return rows[1:], spent
