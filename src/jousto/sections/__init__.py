"""Cross sections of beams: areas, moments, stiffness, and the points where stress is wanted."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
