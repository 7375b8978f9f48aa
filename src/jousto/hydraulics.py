"""Hydraulic drives: the public name of `jousto.mechanism.hydraulics`."""

import sys
from typing import TYPE_CHECKING

from jousto.mechanism import hydraulics as room

if TYPE_CHECKING:
    from jousto.mechanism.hydraulics import *  # noqa: F403

sys.modules[__name__] = room
