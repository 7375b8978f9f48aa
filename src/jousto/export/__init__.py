"""Compiled models outside of Python: programs of C, mock-up units, times of their steps."""

from jousto.base.rooms import open_room

open_room(__name__)
