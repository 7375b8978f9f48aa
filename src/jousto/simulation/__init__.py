"""SIMULATE: run a model, stream its results, read them."""

from jousto.simulation.simulate import RunFailed, RunInterrupted, describe, simulate
from jousto.simulation.solution import BodyShape, Energy, Residuals, Solution, load
from jousto.simulation.solver import RK4, ROS2, SOLVERS, Baumgarte, Solver

__all__ = [
    "RK4",
    "ROS2",
    "SOLVERS",
    "Baumgarte",
    "BodyShape",
    "Energy",
    "Residuals",
    "RunFailed",
    "RunInterrupted",
    "Solution",
    "Solver",
    "describe",
    "load",
    "simulate",
]
