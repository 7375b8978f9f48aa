# names of jo.export; they are loaded from here when they are first used
from .named import named_constants as named_constants
from .realtime import StepTimes as StepTimes, realtime as realtime
