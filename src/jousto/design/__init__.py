"""Design: what to decide from many runs: studies."""

from jousto.base.rooms import open_room

open_room(__name__)
