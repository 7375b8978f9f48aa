"""Solid elements: stiffness, mass, stress and geometric stiffness from a mesh."""

from jousto.parts.solids.model import SolidGroup, SolidModel
from jousto.parts.solids.stress import SolidStress

__all__ = ["SolidGroup", "SolidModel", "SolidStress"]
