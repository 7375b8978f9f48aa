"""Planar frames of geometrically exact beams with any master-slave coupling."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
