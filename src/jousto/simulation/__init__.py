"""SIMULATE: run a model, stream its results, read them."""
