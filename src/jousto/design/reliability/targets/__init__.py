"""Reliability-based design: least cost for target indices."""
