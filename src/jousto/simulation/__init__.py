"""SIMULATE: run a model, stream its results, read them."""

from jousto.simulation.adaptive import DormandPrince
from jousto.simulation.buckling import Buckling, buckling
from jousto.simulation.campbell import Campbell, campbell
from jousto.simulation.connections import Connection
from jousto.simulation.diagnostics import Energy, Residuals, Work
from jousto.simulation.events import Happening
from jousto.simulation.implicit import GeneralizedAlpha, Newmark
from jousto.simulation.kinematics import inverse_dynamics, kinematics
from jousto.simulation.linear import LinearModel, MechanismModes, linearise, modes
from jousto.simulation.paths import ArcLength, CriticalPoint, LoadPath, PathFailed, load_path
from jousto.simulation.records import BodyShape
from jousto.simulation.rotation import steady_rotation
from jousto.simulation.settled import settled
from jousto.simulation.simulate import RunFailed, RunInterrupted, describe, simulate
from jousto.simulation.simulator import Simulator
from jousto.simulation.solution import Solution, load
from jousto.simulation.solver import RK4, ROS2, SOLVERS, Baumgarte, Solver
from jousto.simulation.state import State
from jousto.simulation.statics import equilibrium

__all__ = [
    "RK4",
    "ROS2",
    "SOLVERS",
    "ArcLength",
    "Baumgarte",
    "BodyShape",
    "Connection",
    "Buckling",
    "Campbell",
    "CriticalPoint",
    "DormandPrince",
    "Energy",
    "GeneralizedAlpha",
    "Happening",
    "LinearModel",
    "LoadPath",
    "MechanismModes",
    "Newmark",
    "Residuals",
    "PathFailed",
    "RunFailed",
    "RunInterrupted",
    "Simulator",
    "Solution",
    "Solver",
    "State",
    "Work",
    "describe",
    "buckling",
    "campbell",
    "equilibrium",
    "inverse_dynamics",
    "kinematics",
    "linearise",
    "load",
    "load_path",
    "modes",
    "settled",
    "simulate",
    "steady_rotation",
]
