"""Readers: meshes from files of other programs."""

from jousto.parts.readers.files import read_mesh
from jousto.parts.readers.step import mesh_step

__all__ = ["mesh_step", "read_mesh"]
