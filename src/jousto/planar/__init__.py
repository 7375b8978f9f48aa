"""Planar frames of geometrically exact beams with any master-slave coupling."""

from jousto.base.rooms import open_room

open_room(__name__)
