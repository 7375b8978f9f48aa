"""Monitoring: measured strains to stress, damage and remaining life while they come."""

from jousto.base.rooms import open_room

open_room(__name__)
