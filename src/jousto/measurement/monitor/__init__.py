"""Monitoring: stress, damage and remaining life from measured strains in real time."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
