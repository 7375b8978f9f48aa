"""Electric drives: the public name of `jousto.mechanism.electric`."""

import sys
from typing import TYPE_CHECKING

from jousto.mechanism import electric as room

if TYPE_CHECKING:
    from jousto.mechanism.electric import *  # noqa: F403

sys.modules[__name__] = room
