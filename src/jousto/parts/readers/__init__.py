"""Readers: meshes from files of other programs."""

from jousto.parts.readers.files import read_mesh

__all__ = ["read_mesh"]
