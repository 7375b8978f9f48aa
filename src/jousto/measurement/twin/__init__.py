"""TWIN: what strain gauges tell of the whole body: stress everywhere, loads and life."""

from jousto.base.rooms import open_room

open_room(__name__)
