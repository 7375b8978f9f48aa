"""Sparse matrices: factors, their backends and the memory they need."""
