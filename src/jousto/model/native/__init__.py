"""The C engine as Python sees it: its library, structures, kernels and failures."""
