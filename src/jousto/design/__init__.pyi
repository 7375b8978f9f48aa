# names of jo.design; they are loaded from here when they are first used
from .flexibility.advise_flexibility import advise_flexibility as advise_flexibility
from .flexibility.body_advice import BodyAdvice as BodyAdvice, ReadingAdvice as ReadingAdvice
from .flexibility.flexibility_advice import FlexibilityAdvice as FlexibilityAdvice
from .flexibility.reading_loss import ReadingLoss as ReadingLoss, reading_loss as reading_loss
from .identification.experiment import Experiment as Experiment
from .identification.identified import Identified as Identified
from .identification.identify import identify as identify
from .identification.modal import Modal as Modal, read_modes as read_modes
from .identification.mode_pairs import mac as mac
from .identification.values import Values as Values
from .optimisation.comparison import Comparison as Comparison
from .optimisation.equivalent import equivalent_loads as equivalent_loads
from .optimisation.from_model_file import file_problem as file_problem
from .optimisation.limits import (
    DisplacementLimit as DisplacementLimit,
    FrequencyLimit as FrequencyLimit,
    LifeLimit as LifeLimit,
    StressLimit as StressLimit,
)
from .optimisation.machine import MachineProblem as MachineProblem
from .optimisation.optimise import optimise as optimise
from .optimisation.optimum import Cycle as Cycle, Optimum as Optimum
from .optimisation.problem import Place as Place, Problem as Problem
from .optimisation.rigid_optimum import (
    OuterCycle as OuterCycle,
    Peak as Peak,
    RigidOptimum as RigidOptimum,
)
from .optimisation.rigid_options import RigidMachine as RigidMachine
from .optimisation.structure import StructureProblem as StructureProblem
from .reliability.errors import (
    DesignPointError as DesignPointError,
    LimitStateError as LimitStateError,
)
from .reliability.form import FormResult as FormResult, form as form
from .reliability.from_model_file import file_rbdo as file_rbdo
from .reliability.from_study import limit_state as limit_state
from .reliability.inputs.random import Conditional as Conditional, Random as Random
from .reliability.inputs.transform import (
    JointDistribution as JointDistribution,
    Nataf as Nataf,
    Rosenblatt as Rosenblatt,
)
from .reliability.limit import LimitState as LimitState
from .reliability.pma import (
    PmaResult as PmaResult,
    RiaResult as RiaResult,
    pma as pma,
    ria as ria,
)
from .reliability.sampling import (
    LinearisationCheck as LinearisationCheck,
    SamplingResult as SamplingResult,
    check_linearisation as check_linearisation,
    importance_sampling as importance_sampling,
    monte_carlo as monte_carlo,
)
from .reliability.sorm import SormResult as SormResult, sorm as sorm
from .reliability.subset import subset_simulation as subset_simulation
from .reliability.system import SystemResult as SystemResult, system as system
from .reliability.targets.rbdo import RbdoResult as RbdoResult, rbdo as rbdo
from .studies.case import Case as Case
from .studies.gradient import gradient as gradient
from .studies.gradient_result import GradientResult as GradientResult
from .studies.outcomes.function import Function as Function
from .studies.outcomes.outcome import Outcome as Outcome
from .studies.outcomes.outcomes import Damage as Damage, read_outcome as read_outcome
from .studies.parameters.distributions import distribution_from_moments as distribution_from_moments
from .studies.parameters.samples import (
    grid as grid,
    latin_hypercube as latin_hypercube,
    random_samples as random_samples,
    read_samples as read_samples,
    sobol as sobol,
)
from .studies.study import Study as Study
from .studies.table import StudyTable as StudyTable, read_study as read_study
