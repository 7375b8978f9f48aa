"""Scenes: bodies, symbols and motion of a machine for the browser and for pictures."""
