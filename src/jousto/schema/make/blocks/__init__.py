"""Objects of the blocks of a model file beside its mechanism, and of the file of a duty cycle."""
