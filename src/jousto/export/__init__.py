"""Compiled models outside of Python: C programs, functional mock-up units, step times."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
