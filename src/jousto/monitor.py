"""Watching a real machine: the public name of `jousto.measurement.monitor`."""

import sys
from typing import TYPE_CHECKING

from jousto.measurement import monitor as room

if TYPE_CHECKING:
    from jousto.measurement.monitor import *  # noqa: F403

sys.modules[__name__] = room
