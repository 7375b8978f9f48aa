"""Meshes of finite elements: cells, places and surfaces picked on them, their quality."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
