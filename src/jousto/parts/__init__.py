"""Parts: what a flexible body is made of, before it is reduced."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
