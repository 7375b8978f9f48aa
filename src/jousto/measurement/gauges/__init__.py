"""Gauges: strain rosettes and measured records."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
