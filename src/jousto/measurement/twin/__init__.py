"""Twin: stress everywhere, loads and life of a body from a few strain gauges."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
