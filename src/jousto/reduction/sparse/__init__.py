"""Sparse matrices: factorisation, its libraries, and the memory needed."""
