"""studies: a model as a function of its parameters, at many points."""
