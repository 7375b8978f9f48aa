"""Suffixes of robot files."""

from __future__ import annotations

SUFFIXES = (".urdf", ".mjcf", ".sdf", ".xml")
