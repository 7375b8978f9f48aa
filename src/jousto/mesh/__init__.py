"""Finite element meshes: cells, quality, and picks of nodes and surfaces."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
