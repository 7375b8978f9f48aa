# names of jo.reduction; they are loaded from here when they are first used
from .fields.invariants import Invariants as Invariants
from .fields.stress import StressModes as StressModes
from .files.cache import ReductionCache as ReductionCache
from .frames.clamp import clamp as clamp, in_frame as in_frame
from .frames.frame import (
    AsGiven as AsGiven,
    ChordFrame as ChordFrame,
    MeanFrame as MeanFrame,
    NodeFrame as NodeFrame,
)
from .frames.transfer import same_motion as same_motion
from .methods import ShapeFunctions as ShapeFunctions
from .modes.relief import InertiaRelief as InertiaRelief, inertia_relief as inertia_relief
from .reducer import from_modes as from_modes
from .shapes.line import BeamFunctions as BeamFunctions, Splines as Splines
from .shapes.polynomials import Polynomials as Polynomials
from .sparse.factor import SolverInfo as SolverInfo, solvers as solvers
from .sparse.memory import MemoryEstimate as MemoryEstimate, memory_estimate as memory_estimate
from .superelement import reduce_superelement as reduce_superelement
from .supports.support import Clamp as Clamp, SpringSupport as SpringSupport
from .supports.supported import (
    Reaction as Reaction,
    SupportedModes as SupportedModes,
    SupportedPart as SupportedPart,
    SupportedState as SupportedState,
)
