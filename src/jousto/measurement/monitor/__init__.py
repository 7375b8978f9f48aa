"""Monitoring: measured strains to stress, damage and remaining life while they come."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
