"""Packing of the objects of a mechanism into the arrays of the engine."""
