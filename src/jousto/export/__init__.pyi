# names of jo.export; they are loaded from here when they are first used
from .realtime import StepTimes as StepTimes, realtime as realtime
