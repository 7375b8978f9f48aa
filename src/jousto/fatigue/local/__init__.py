"""Strain life: local plasticity at notches."""
