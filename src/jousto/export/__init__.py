"""Compiled models outside of Python: programs of C, mock-up units, times of their steps."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
