"""Entities of a mechanism, packed into the arrays of the engine."""
