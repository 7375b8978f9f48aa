"""Shape functions: displacements of a part as functions of position, by Ritz' method."""
