"""Construction of Python objects from validated entries of a model file."""
