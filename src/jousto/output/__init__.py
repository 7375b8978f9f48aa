"""Output: plots, pictures and films of a run. Only this package imports matplotlib."""
