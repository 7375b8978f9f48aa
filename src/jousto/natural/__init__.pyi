# names of jo.natural; they are loaded from here when they are first used
from .comparison import Compared as Compared, Way as Way
from .moving_frame import moving_frame as moving_frame
from .result import NaturalRun as NaturalRun
from .verification import Verification as Verification
