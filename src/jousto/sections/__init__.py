"""Cross sections of beams: areas, second moments, stiffness, and stress points."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
