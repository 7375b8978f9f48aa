"""Scenes: bodies, symbols and surfaces of a machine as pictures and films."""
