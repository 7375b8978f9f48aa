"""A second formulation of the same mechanisms, in natural coordinates, to check the engine with."""

from jousto.base.rooms import open_room

open_room(__name__)
