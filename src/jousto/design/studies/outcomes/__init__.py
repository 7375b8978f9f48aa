"""Outcomes: numbers from a run, a function or a structure, and requirements on them."""
