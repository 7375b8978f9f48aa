"""TWIN: what strain gauges tell of the whole body: stress everywhere, loads and life."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
