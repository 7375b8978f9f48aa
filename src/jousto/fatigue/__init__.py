"""Fatigue: cycles, damage and life of stress histories."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
