"""SHOW: plots, pictures and films of a run. matplotlib is imported with this package only."""
