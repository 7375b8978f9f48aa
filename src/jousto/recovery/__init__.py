"""RECOVER: fields over a body from the few coordinates that a run stores."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
