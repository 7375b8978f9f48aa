"""Suffixes of files with reduced parts in the format of other programs."""

from __future__ import annotations

SID = (".sid", ".sid_fem")
"""Endings of standard input data."""
