"""Counting cycles: rainflow and duties."""
