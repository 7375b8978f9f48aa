"""Flexibility: what the readings of a machine lose with a body rigid or with modes left out."""
