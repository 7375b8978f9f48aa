"""The C engine in Python: its library, structures, kernels and failures."""
