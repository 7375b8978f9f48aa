"""Sensors: quantities that the engine records at every output instant.

Every sensor has a `unit`, the names of its `components`, the `frame` in which they are resolved,
and a `description` for results and plots.
"""
