"""Shape functions: displacements of a part as functions of position (Ritz method)."""
