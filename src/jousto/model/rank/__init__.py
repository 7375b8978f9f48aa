"""Rank analysis: redundant constraints, and the motions that remain."""
