"""Readers: meshes from files of other programs."""
