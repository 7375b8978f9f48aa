"""Sparse matrices: factorisation, libraries for it, and the memory needed."""
