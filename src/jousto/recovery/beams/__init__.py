"""Section forces and stress of geometrically exact beams."""
