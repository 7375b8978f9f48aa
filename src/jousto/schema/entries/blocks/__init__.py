"""Entries of the blocks beside the mechanism in a model file."""
