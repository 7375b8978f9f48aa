# names of jo.simulation; they are loaded from here when they are first used
from .kinematics import inverse_dynamics as inverse_dynamics, kinematics as kinematics
from .modes.campbell import Campbell as Campbell, campbell as campbell
from .modes.linear import (
    LinearModel as LinearModel,
    MechanismModes as MechanismModes,
    linearise as linearise,
)
from .results.events import Happening as Happening
from .running.simulate import RunFailed as RunFailed, RunInterrupted as RunInterrupted
from .running.simulator import Simulator as Simulator
from .solvers.adaptive import DormandPrince as DormandPrince
from .solvers.base import Baumgarte as Baumgarte
from .solvers.implicit import Newmark as Newmark
from .solvers.rosenbrock import ROS3A as ROS3A
from .solvers.runge_kutta import SSPRK3 as SSPRK3
from .state import State as State
from .statics.buckling import Buckling as Buckling, buckling as buckling
from .statics.load_path import load_path as load_path
from .statics.load_path_result import (
    ArcLength as ArcLength,
    CriticalPoint as CriticalPoint,
    LoadPath as LoadPath,
    PathFailed as PathFailed,
)
from .statics.rotation import steady_rotation as steady_rotation
from .statics.vibration_free import vibration_free_state as vibration_free_state
