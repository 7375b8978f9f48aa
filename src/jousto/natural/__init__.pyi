# names of jo.natural; they are loaded from here when they are first used
from .compared import Compared as Compared, Way as Way
from .moving_frame import moving_frame as moving_frame
from .run import NaturalRun as NaturalRun
from .verification import Verification as Verification
