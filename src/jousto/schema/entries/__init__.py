"""Entries of a model file: which keys they have and which values."""
