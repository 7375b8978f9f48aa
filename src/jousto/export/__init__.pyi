# names of jo.export; they are loaded from here when they are first used
from .realtime import StepTimes as StepTimes, realtime as realtime
from .tunable_constants import named_constants as named_constants
