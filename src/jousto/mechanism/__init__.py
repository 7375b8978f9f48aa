"""DECLARE: bodies, markers, joints, forces, signals and sensors; a mechanism checks them all."""
