"""Reduction of a part with a mesh to a few modes, invariants and modal stress."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
