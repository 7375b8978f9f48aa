"""DECLARE: bodies, markers, joints, forces, signals and sensors; a mechanism checks them all."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
