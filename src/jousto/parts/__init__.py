"""Parts: flexible components with nodes, elements, mass and stiffness, before reduction."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
