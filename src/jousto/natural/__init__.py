"""A second formulation of the same mechanisms, in natural coordinates, to check the engine with."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
