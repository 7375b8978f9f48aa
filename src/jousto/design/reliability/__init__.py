"""Reliability: how probable it is that a limit state is violated, and design for a target."""
