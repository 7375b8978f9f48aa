"""Materials: elastic constants and density; fatigue strength in `strength`."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
