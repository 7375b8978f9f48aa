"""Reduced parts in files, and the cache of reductions."""
