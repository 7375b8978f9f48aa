# names of jo.design; they are loaded from here when they are first used
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
from .optimisation.structure import StructureProblem as StructureProblem
from .reliability.errors import (
    DesignPointError as DesignPointError,
    LimitStateError as LimitStateError,
)
from .reliability.form import FormResult as FormResult, form as form
from .reliability.limit import LimitState as LimitState
from .reliability.pma import (
    PmaResult as PmaResult,
    RiaResult as RiaResult,
    pma as pma,
    ria as ria,
)
from .reliability.random import (
    Conditional as Conditional,
    Random as Random,
    by_moments as by_moments,
)
from .reliability.rbdo import RbdoResult as RbdoResult, rbdo as rbdo
from .reliability.sampling import (
    LinearisationCheck as LinearisationCheck,
    SamplingResult as SamplingResult,
    check_linearisation as check_linearisation,
    importance_sampling as importance_sampling,
    monte_carlo as monte_carlo,
)
from .reliability.sorm import SormResult as SormResult, sorm as sorm
from .reliability.subset import subset_simulation as subset_simulation
from .reliability.transform import Joint as Joint, Nataf as Nataf, Rosenblatt as Rosenblatt
from .studies.case import Case as Case
from .studies.outcomes import Function as Function, Outcome as Outcome, read_outcome as read_outcome
from .studies.samples import (
    grid as grid,
    latin_hypercube as latin_hypercube,
    random_samples as random_samples,
    read_samples as read_samples,
    sobol as sobol,
)
from .studies.study import Study as Study
from .studies.table import StudyTable as StudyTable, read_study as read_study
