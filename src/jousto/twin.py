"""Stress everywhere from a few strain gauges: the public name of `jousto.measurement.twin`."""

import sys
from typing import TYPE_CHECKING

from jousto.measurement import twin as room

if TYPE_CHECKING:
    from jousto.measurement.twin import *  # noqa: F403

sys.modules[__name__] = room
