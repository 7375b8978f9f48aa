"""Planar frames of geometrically exact beams with any master-slave coupling."""

from jousto.planar.dynamics import simulate_planar
from jousto.planar.elimination import (
    Arms,
    Blocks,
    Chain,
    Elimination,
    Function,
    Linear,
    Map,
    Slaves,
)
from jousto.planar.frame import PlanarFrame
from jousto.planar.items import (
    FunctionLink,
    LinearLink,
    PlanarBeam,
    PlanarDamping,
    PlanarLoad,
    PlanarMass,
    PlanarSection,
    PlanarSupport,
    RigidLink,
)
from jousto.planar.methods import Convergence, PlanarGeneralizedAlpha, PlanarNewmark
from jousto.planar.results import PlanarPath, PlanarRun, PlanarState, rest, spinning
from jousto.planar.statics import arc_length, load_steps, planar_frequencies
from jousto.planar.system import System
from jousto.planar.tangents import inertia_share

__all__ = [
    "Arms",
    "Blocks",
    "Chain",
    "Convergence",
    "Elimination",
    "Function",
    "FunctionLink",
    "Linear",
    "LinearLink",
    "Map",
    "PlanarBeam",
    "PlanarDamping",
    "PlanarFrame",
    "PlanarGeneralizedAlpha",
    "PlanarLoad",
    "PlanarMass",
    "PlanarNewmark",
    "PlanarPath",
    "PlanarRun",
    "PlanarSection",
    "PlanarState",
    "PlanarSupport",
    "RigidLink",
    "Slaves",
    "System",
    "arc_length",
    "inertia_share",
    "load_steps",
    "planar_frequencies",
    "rest",
    "simulate_planar",
    "spinning",
]
