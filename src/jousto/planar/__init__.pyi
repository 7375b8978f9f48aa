# names of jo.planar; they are loaded from here when they are first used
from .ancf import AncfElement as AncfElement
from .corotational import CorotationalElement as CorotationalElement
from .dynamics import simulate_planar as simulate_planar
from .element import PlanarElement as PlanarElement
from .elimination import (
    ArmCoupling as ArmCoupling,
    BlockCoupling as BlockCoupling,
    ChainCoupling as ChainCoupling,
    CoupledMotion as CoupledMotion,
    Elimination as Elimination,
    FunctionCoupling as FunctionCoupling,
    LinearCoupling as LinearCoupling,
    PlanarCoupling as PlanarCoupling,
)
from .exact import ExactElement as ExactElement
from .frame import PlanarFrame as PlanarFrame
from .items import (
    FunctionLink as FunctionLink,
    LinearLink as LinearLink,
    PlanarBeam as PlanarBeam,
    PlanarDamping as PlanarDamping,
    PlanarLoad as PlanarLoad,
    PlanarMass as PlanarMass,
    PlanarMotion as PlanarMotion,
    PlanarSupport as PlanarSupport,
    RigidLink as RigidLink,
)
from .methods import (
    Convergence as Convergence,
    PlanarGeneralizedAlpha as PlanarGeneralizedAlpha,
    PlanarNewmark as PlanarNewmark,
)
from .results import (
    PlanarPath as PlanarPath,
    PlanarRun as PlanarRun,
    PlanarState as PlanarState,
    planar_rest as planar_rest,
    planar_spinning as planar_spinning,
)
from .section import PlanarSection as PlanarSection
from .statics import (
    arc_length as arc_length,
    load_steps as load_steps,
    planar_frequencies as planar_frequencies,
)
from .system import System as System
from .tangents import inertia_share as inertia_share
