"""Simulation: run a model, write its results, read them."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
