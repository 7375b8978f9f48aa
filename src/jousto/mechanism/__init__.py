"""DECLARE: bodies, markers, joints, forces, signals and sensors, checked by a mechanism."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
