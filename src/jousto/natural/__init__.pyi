# names of jo.natural; they are loaded from here when they are first used
from .moving_frame import moving_frame as moving_frame
from .run import NaturalRun as NaturalRun
from .verification import Compared as Compared, Verification as Verification, Way as Way
