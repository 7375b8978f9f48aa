"""SIMULATE: run a model, stream its results, read them."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
