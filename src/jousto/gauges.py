"""Strain gauges, virtual and measured: the public name of `jousto.measurement.gauges`."""

import sys
from typing import TYPE_CHECKING

from jousto.measurement import gauges as room

if TYPE_CHECKING:
    from jousto.measurement.gauges import *  # noqa: F403

sys.modules[__name__] = room
