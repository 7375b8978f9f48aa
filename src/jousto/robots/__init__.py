"""Robots: readers of robot descriptions, and kinematics and dynamics of their joint trees."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
