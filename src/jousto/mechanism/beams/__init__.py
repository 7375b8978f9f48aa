"""Geometrically exact beams as bodies of a mechanism."""
