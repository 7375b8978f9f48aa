"""Studies: outcomes of a model as functions of its parameters, at many points."""
