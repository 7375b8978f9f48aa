"""Conversion of a mechanism to flat arrays for the C engine."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
