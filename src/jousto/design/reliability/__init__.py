"""Reliability: probability that a limit state is violated, and design for a target."""
