"""Gauges: what rosettes say, and measured records."""

from jousto.base.rooms import open_room

open_room(__name__)
