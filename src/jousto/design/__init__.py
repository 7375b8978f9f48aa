"""Design: what to decide: studies of many runs, and how probable a failure is."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
