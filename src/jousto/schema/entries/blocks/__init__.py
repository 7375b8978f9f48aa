"""Entries of the blocks of a model file beside its mechanism."""
