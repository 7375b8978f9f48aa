"""COMPILE: a mechanism becomes flat arrays for the C engine."""
