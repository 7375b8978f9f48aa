"""Solid elements: stiffness, mass, stress and geometric stiffness from a mesh."""

from jousto.parts.solids.model import SolidGroup, SolidModel

__all__ = ["SolidGroup", "SolidModel"]
