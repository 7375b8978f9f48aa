"""Rank analysis: redundant constraints, and the motions left free."""
