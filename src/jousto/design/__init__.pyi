# names of jo.design; they are loaded from here when they are first used
from .reliability.errors import (
    DesignPointError as DesignPointError,
    LimitStateError as LimitStateError,
)
from .reliability.form import FormResult as FormResult, form as form
from .reliability.limit import LimitState as LimitState, Values as Values
from .reliability.random import (
    Conditional as Conditional,
    Random as Random,
    by_moments as by_moments,
)
from .reliability.sorm import SormResult as SormResult, sorm as sorm
from .reliability.transform import Joint as Joint, Nataf as Nataf, Rosenblatt as Rosenblatt
from .studies.distributions import read_distribution as read_distribution
