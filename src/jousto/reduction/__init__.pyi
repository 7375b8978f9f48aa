# names of jo.reduction; they are loaded from here when they are first used
from .certificate.advice import Advice as Advice, advise as advise
from .certificate.certificate import Certificate as Certificate, Check as Check
from .certificate.certify import certify as certify
from .clamp import clamp as clamp
from .files.cache import ReductionCache as ReductionCache
from .modes.relief import InertiaRelief as InertiaRelief, inertia_relief as inertia_relief
from .reducer import from_modes as from_modes
from .sparse.factor import SolverInfo as SolverInfo, solvers as solvers
from .sparse.memory import MemoryEstimate as MemoryEstimate, memory_estimate as memory_estimate
from .superelement import reduce_superelement as reduce_superelement
