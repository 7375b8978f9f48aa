"""Second formulation of mechanisms, in natural coordinates, as a check of the engine."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
