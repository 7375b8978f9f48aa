"""Declaration of a mechanism: bodies, markers, joints, forces, signals and sensors, with checks."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
