"""Robots: descriptions of other programs, and trees of joints seen from their coordinates."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
