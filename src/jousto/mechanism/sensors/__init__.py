"""Sensors: what the engine records while it steps.

Every sensor says its `unit`, the names of its `components`, the `frame` that they are resolved in
and a `description` for results and plots.
"""
