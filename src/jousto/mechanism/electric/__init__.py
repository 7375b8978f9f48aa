"""Electric drives: motors, their thermal load, gears with backlash and losses, brakes."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
