"""Solid elements: stiffness, mass, stress and geometric stiffness from a mesh."""
