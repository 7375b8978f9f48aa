"""Section forces and stress of geometrically exact beams."""

from jousto.recovery.beams.forces import RESULTANTS, SectionForces, find_beam, section_forces

__all__ = ["RESULTANTS", "SectionForces", "find_beam", "section_forces"]
