"""Outcomes: numbers of a run, of a function or of a structure, and what is required of them."""
