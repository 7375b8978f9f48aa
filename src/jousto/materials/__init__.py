"""Materials: elastic constants, density, and in `strength` what they endure."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
